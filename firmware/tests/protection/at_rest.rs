//! Encoders that die as a motion ends, or after it, while the motors stay on.

use super::long_counts::with_counts;
use super::metres;
use super::wheel_bench::{MOTOR, Mishap, drive_out};

#[test]
fn an_encoder_that_dies_as_its_wheel_comes_to_rest_does_not_let_it_run() {
    // A wheel that was one to four counts from its place ran 29 m in a minute; later 160 mm, until the push was summed at rest.
    let (mut named_mm, mut unnamed_mm) = (0.0f64, 0.0f64);
    for counts in [360.0, 900.0, 2797.0, 20_000.0] {
        for (cruise, acceleration) in [(0.03, 0.1), (0.12, 0.98), (0.3, 0.5)] {
            let config = with_counts(counts);
            let ends_ms = ((0.2 / cruise + cruise / acceleration) * 1000.0) as u32;
            for mishap_ms in (ends_ms - 120..ends_ms + 250).step_by(17) {
                let drives = [metres(0.2, 0.2, cruise, acceleration)];
                let mishap = (Mishap::EncoderUnplugged, mishap_ms);
                let (fault, rolled_m) = drive_out(0.3, MOTOR, &config, &drives, mishap, 20_000);
                let rolled_mm = if fault.is_some() { &mut named_mm } else { &mut unnamed_mm };
                *rolled_mm = rolled_mm.max(rolled_m * 1000.0);
            }
        }
    }
    println!("named after {named_mm:.0} mm at most, unnamed {unnamed_mm:.1} mm");
    assert!(named_mm < 70.0 && unnamed_mm < 2.0, "{named_mm} {unnamed_mm}");
}
