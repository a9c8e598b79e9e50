//! What the flashed image does.

use emulated_board::{Bench, Emulation};
use sim_target::Scenario;

fn emulation() -> Emulation {
    let image = std::env::var_os("BEELINE_IMAGE").expect("`cargo xtask emulate` names the image");
    Emulation { image: image.into(), scenario: Scenario::default(), flash: None }
}

#[test]
fn the_image_says_who_it_is() {
    let ended = emulation()
        .run(|mut bench: Bench| async move {
            bench.session.open().await.unwrap();
            bench.session.identify().await.unwrap()
        })
        .unwrap();
    println!("{:?}", ended.found);
    println!("{} instructions in {} us", ended.instructions, ended.lived_us);
    assert_eq!(ended.found.board.as_str(), "NUCLEO-F429ZI");
    assert!(ended.strange.is_empty(), "{:#?}", ended.strange);
    assert_eq!(ended.resets, 0);
}
