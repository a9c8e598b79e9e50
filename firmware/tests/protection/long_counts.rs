//! Encoders with few counts a turn, whose counts are millimetres long.

use shared_proto::{Config, Fault, Wheel};

use super::wheel_bench::{MOTOR, Mishap, Motor, run, run_and_measure, run_from, run_motor};
use super::{NEVER, metres};

pub fn with_counts(counts_per_rev: f64) -> Config {
    let mut config = Config::default();
    config.encoder.left.counts_per_rev = counts_per_rev;
    config.encoder.right.counts_per_rev = counts_per_rev;
    config
}

#[test]
fn a_coarse_encoder_that_dies_in_a_slow_drive_does_not_let_its_wheel_run() {
    // While the setpoint takes its time for four counts, the loop would push a wheel half a metre and more.
    for (counts, most_mm) in
        [(48.0, 46.0), (64.0, 39.0), (100.0, 31.0), (200.0, 24.0), (360.0, 18.0)]
    {
        let config = with_counts(counts);
        let mut farthest_mm = 0.0_f64;
        for speed in [0.005, 0.01, 0.02, 0.03, 0.06] {
            let drive = metres(1.0, 1.0, speed, 2.0 * speed);
            // At six places between two counts.
            for place in 0..6 {
                let mishap_ms = 1000 + ((0.1 + 0.0011 * f64::from(place)) / speed * 1e3) as u32;
                let mishap = Mishap::EncoderUnplugged;
                let found = run_and_measure(MOTOR, &config, &[drive], mishap, mishap_ms, 0);
                let (fault, after_ms, rolled_m) = found.unwrap();
                let left = Wheel::Left;
                assert!(
                    [Fault::NoResponse(left), Fault::EncoderDead(left)].contains(&fault),
                    "{counts} {speed}: {fault} after {after_ms} ms"
                );
                farthest_mm = farthest_mm.max(rolled_m * 1000.0);
            }
        }
        println!("{counts} counts a turn: {farthest_mm:.0} mm");
        assert!(farthest_mm < most_mm, "{counts}: {farthest_mm} mm");
    }
}

#[test]
fn a_sound_robot_with_a_coarse_encoder_and_other_motors_drives_slowly() {
    // What takes twice the friction, half as much voltage again, and turns late.
    let motors = [0.01, 0.04, 0.08].into_iter().flat_map(|friction| {
        [1.0, 1.85, 3.0].into_iter().flat_map(move |duty_per_mps| {
            [0.03, 0.06, 0.15].map(|time_constant_s| Motor {
                friction,
                duty_per_mps,
                time_constant_s,
            })
        })
    });
    for motor in motors {
        for counts in [48.0, 64.0, 100.0] {
            for speed in [0.005, 0.01, 0.03] {
                let drives = [
                    metres(0.1, 0.1, speed, 2.0 * speed),
                    metres(-0.05, 0.03, speed, speed),
                    metres(0.05, 0.01, speed, 1.0),
                    metres(-0.05, -0.05, speed, 0.5),
                ];
                let found =
                    run_motor(motor, &with_counts(counts), &drives, Mishap::None, NEVER, 700);
                assert_eq!(found, None, "{motor:?}, {counts} counts, {speed} m/s");
            }
        }
    }
}

#[test]
fn an_encoder_reversed_with_few_counts_is_named_before_the_following_error_is_used_up() {
    let (mut named, mut unnamed) = (0, 0);
    for counts in [64.0, 100.0, 200.0] {
        for speed in [0.02, 0.05, 0.118, 0.3] {
            let drive = metres(1.0, 1.0, speed, 2.0 * speed);
            for mishap_ms in (1500..1800).step_by(17) {
                let mishap = Mishap::EncoderReversed;
                match run(&with_counts(counts), &[drive], mishap, mishap_ms, 0) {
                    Some((Fault::EncoderReversed(Wheel::Left), _)) => named += 1,
                    // Three counts come too late where the setpoint hardly moves.
                    Some((Fault::FollowingError(Wheel::Left), _)) if speed < 0.1 => unnamed += 1,
                    found => panic!("{found:?}: {counts} {speed} {mishap_ms}"),
                }
            }
        }
    }
    println!("{named} named, {unnamed} only by how far they were off");
    assert!(named > 200 && unnamed <= named / 15);
}

#[test]
fn without_a_feedforward_nothing_is_known_of_a_push() {
    let mut config = with_counts(100.0);
    for wheel in [&mut config.feedforward.left, &mut config.feedforward.right] {
        (wheel.kv_v_s_per_m, wheel.ka_v_s2_per_m) = (0.0, 0.0);
    }
    let drives = [metres(0.1, 0.1, 0.02, 0.05)];
    assert_eq!(run(&config, &drives, Mishap::None, NEVER, 700), None);
}

#[test]
fn a_line_that_sticks_while_the_wheel_is_driven_back_to_its_setpoint_is_no_reversed_encoder() {
    // The encoder check leaves a wheel some counts ahead. One count back it is driven, and two more the line takes it.
    let mut faults = 0;
    for counts in [48.0, 65.0, 80.0, 100.0, 150.0] {
        for ahead in [1.6, 1.9, 2.1, 2.4, 2.6] {
            for mishap_ms in (0..240).step_by(3) {
                for high in [false, true] {
                    let drive = metres(1.0, 1.0, 0.3, 0.8);
                    let mishap = (Mishap::LineStuck(high), mishap_ms);
                    let config = with_counts(counts);
                    let found = run_from(ahead, MOTOR, &config, &[drive], mishap, 250);
                    let (fault, after_ms, _) = found.unwrap();
                    faults += 1;
                    assert_ne!(
                        fault,
                        Fault::EncoderReversed(Wheel::Left),
                        "{counts} counts, {ahead} ahead, stuck at {mishap_ms}, {high}: after {after_ms} ms"
                    );
                }
            }
        }
    }
    assert_eq!(faults, 4000);
}

#[test]
fn a_line_that_sticks_as_a_motion_starts_does_not_let_its_wheel_run() {
    for counts in [48.0, 64.0, 80.0, 100.0, 134.0, 200.0] {
        let count_mm = std::f64::consts::TAU * 36.0 / counts;
        let mut most_mm = 0.0_f64;
        for (way, cruise, acceleration) in [(1.0, 0.33, 0.51), (-1.0, 0.33, 0.51), (1.0, 0.2, 0.98)]
        {
            let drive = metres(way, way, cruise, acceleration);
            for mishap_ms in (0..60).step_by(5) {
                for high in [false, true] {
                    let (config, mishap) = (with_counts(counts), Mishap::LineStuck(high));
                    let found = run_and_measure(MOTOR, &config, &[drive], mishap, mishap_ms, 250);
                    let (fault, _, rolled_m) = found.unwrap();
                    assert_eq!(
                        fault,
                        Fault::EncoderDead(Wheel::Left),
                        "{counts} {mishap_ms} {high}"
                    );
                    most_mm = most_mm.max(rolled_m * 1e3);
                }
            }
        }
        println!("{counts} counts a turn: {most_mm:.1} mm");
        // 46.6 mm with 64 counts: a count to and fro between the same two kept the motor's push from being summed.
        assert!(most_mm < 14.0 + 9.0 * count_mm, "{counts}: {most_mm} mm");
    }
}
