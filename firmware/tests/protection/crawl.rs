//! Encoders that die while a motion starts or crawls.

use shared_proto::{Config, Fault, Wheel};

use super::long_counts::with_counts;
use super::wheel_bench::{MOTOR, Mishap, Motor, assert_rolled_less, run_and_measure, run_motor};
use super::{NEVER, metres};

#[test]
fn an_encoder_that_dies_at_a_crawl_does_not_let_its_wheel_run() {
    // The setpoint takes a second and more for the 2 mm that tell by themselves.
    for (cruise, median_most_mm, most_mm) in
        [(0.003, 8.0, 16.0), (0.005, 7.0, 16.0), (0.0085, 6.0, 16.0), (0.015, 5.0, 16.0)]
    {
        let mut rolled_mm = Vec::new();
        for counts in [900.0, 2797.0, 20_000.0] {
            // From half the configured friction to half as much again.
            for friction in [0.02, 0.044, 0.06] {
                for acceleration in [0.0065, 0.03, 0.3] {
                    for mishap_ms in [0, 50, 150, 300, 1000, 1500, 2000, 2011, 2037, 2050] {
                        let drive = metres(0.05, 0.05, cruise, acceleration);
                        let motor = Motor { friction, ..MOTOR };
                        let (config, mishap) = (with_counts(counts), Mishap::EncoderUnplugged);
                        let found =
                            run_and_measure(motor, &config, &[drive], mishap, mishap_ms, 250);
                        let (fault, _, rolled_m) = found.unwrap();
                        let left = Wheel::Left;
                        // From this speed friction stops a wheel within a few counts.
                        let names =
                            [Fault::NoResponse(left), Fault::EncoderDead(left), Fault::Stall(left)];
                        assert!(names.contains(&fault), "{fault}");
                        rolled_mm.push(rolled_m * 1000.0);
                    }
                }
            }
        }
        assert_rolled_less(&format!("{cruise} m/s"), rolled_mm, (median_most_mm, most_mm));
    }
}

#[test]
fn a_sound_robot_with_other_motors_crawls() {
    for counts in [900.0, 2797.0, 20_000.0] {
        for friction in [0.02, 0.044, 0.06] {
            for time_constant_s in [0.03, 0.06, 0.2] {
                for duty_per_mps in [1.2, 1.85, 2.6] {
                    for cruise in [0.003, 0.005, 0.01, 0.03] {
                        for acceleration in [0.0065, 0.03, 0.5] {
                            let drives = [
                                metres(0.05, 0.05, cruise, acceleration),
                                metres(-0.03, 0.03, cruise, acceleration),
                            ];
                            let motor = Motor { friction, duty_per_mps, time_constant_s };
                            let found = run_motor(
                                motor,
                                &with_counts(counts),
                                &drives,
                                Mishap::None,
                                NEVER,
                                700,
                            );
                            assert_eq!(
                                found, None,
                                "{motor:?}, {counts}, {cruise} m/s, {acceleration} m/s^2"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn a_loop_that_may_hardly_push_is_told_of_a_wheel_that_stands_as_soon() {
    // A motor's push told a wheel that stands from one that is about to start; here no loop pushes so much.
    let change = |change: &dyn Fn(&mut Config)| {
        let mut config = Config::default();
        change(&mut config);
        config
    };
    let configs = [
        ("duty_max", change(&|config| config.limits.duty_max = 0.09)),
        ("gains", change(&|config| (config.pid.kp_per_m, config.pid.ki_per_m_s) = (2.0, 2.0))),
        ("no gains", change(&|config| (config.pid.kp_per_m, config.pid.ki_per_m_s) = (0.0, 0.0))),
        ("ks", change(&|config| config.feedforward.left.ks_backward_v = 4.0)),
    ];
    for (name, mut config) in configs {
        config.protection.following_error_m_max = 0.1;
        for counts in [100.0, 360.0, 900.0, 20_000.0] {
            let one = with_counts(counts).encoder;
            config.encoder = one;
            let count_m = std::f64::consts::TAU * 0.036 / counts;
            for cruise in [0.005, 0.02] {
                let drive = metres(0.3, 0.3, cruise, 0.1);
                for mishap in [Mishap::EncoderUnplugged, Mishap::Blocked(1000.0)] {
                    let found = run_and_measure(MOTOR, &config, &[drive], mishap, 1200, 0);
                    let (fault, after_ms, rolled_m) = found.expect(name);
                    // Half as far again as four counts or 2 mm, a count before, and what the wheel lagged.
                    let most_m = 1.5 * (4.0 * count_m).max(0.002) + 2.0 * count_m + 0.002;
                    let case = format!("{name}, {counts} counts, {cruise} m/s, {mishap:?}");
                    println!("{case}: {fault} after {after_ms} ms, {:.1} mm", rolled_m * 1e3);
                    assert!(
                        f64::from(after_ms) < most_m / cruise * 1e3 + 100.0,
                        "{case}: {after_ms} ms"
                    );
                }
            }
        }
    }
}
