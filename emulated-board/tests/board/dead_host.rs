//! A subset of `cargo xtask bench dead-hosts`: a host dies with anything held back on the way, and a stop under flood.

use emulated_board::dead_host::{Held, run};

use super::image;

#[test]
fn a_dead_host_drives_no_further_whatever_is_held_back_and_a_stop_overtakes_a_flood() {
    let found = run(&image(), 16, 5).expect("an image that runs");
    for found in &found {
        println!("{found:?}");
        // Too soon would be another stop than that of a lease that ends.
        let sound = found.held == Held::Flood || found.after_us > 100_000;
        assert!(found.holds() && sound, "{found:?}");
    }
}
