//! Are wrong units found, and inaccurate robots not taken for them?

use crate::checks::{Suspicion, suspicions};
use crate::numeric::angle::wrap;
use crate::recording::Recording;
use crate::tests::synthetic::{ROBOT, campaign, end_poses_only, full_plan, term};

/// A campaign with each of its runs changed.
fn changed(change: impl Fn(&mut Recording)) -> Vec<(String, Vec<Suspicion>)> {
    let mut campaign = campaign(&full_plan(), &[], 5);
    campaign.runs.iter_mut().for_each(change);
    campaign.runs.iter().map(|run| (run.name.clone(), suspicions(&ROBOT, run))).collect()
}

fn nothing(found: Vec<(String, Vec<Suspicion>)>) {
    for (name, found) in found {
        assert!(found.is_empty(), "{name}: {found:?}");
    }
}

fn scaled(run: &mut Recording, times: f64) {
    for measurement in &mut run.measured_poses {
        measurement.position_m = measurement.position_m.map(|position| position.map(|m| m * times));
    }
}

#[test]
fn millimetres_and_centimetres_are_found_in_every_run_that_goes_anywhere() {
    for times in [1000.0, 100.0] {
        for (name, found) in changed(|run| scaled(run, times)) {
            if name.starts_with("spin") {
                continue;
            }
            let [Suspicion::Positions { per_m, measured_m, rolled_m }] = found[..] else {
                panic!("{name}: {found:?}");
            };
            assert_eq!(per_m, times, "{name}");
            assert!((measured_m / rolled_m / times - 1.0).abs() < 0.2, "{name}: {measured_m}");
        }
    }
}

#[test]
fn degrees_are_found_wrapped_or_not_in_every_run_that_turns() {
    let whole = |rad: f64| rad.to_degrees();
    let wrapped = |rad: f64| wrap(rad).to_degrees();
    let compass = |rad: f64| rad.to_degrees().rem_euclid(360.0);
    for degrees in [whole, wrapped, compass] {
        let found = changed(|run| {
            for measurement in &mut run.measured_poses {
                measurement.heading_rad = measurement.heading_rad.map(degrees);
            }
        });
        for (name, found) in found {
            let turns = ["spin", "arc", "square"].iter().any(|kind| name.starts_with(kind));
            let seen = matches!(found[..], [Suspicion::Headings { .. }]);
            assert_eq!(seen, turns, "{name}: {found:?}");
        }
    }
}

#[test]
fn overflows_of_counters_are_found_where_they_are() {
    for bits in [16_u32, 32] {
        let range = 2.0_f64.powi(bits as i32) * ROBOT.rad_per_count;
        let found = changed(|run| {
            // It overflows in the middle of the run.
            let middle = run.wheels[run.wheels.len() / 2].phi_rad.right;
            for sample in &mut run.wheels {
                sample.phi_rad.right = (sample.phi_rad.right - middle).rem_euclid(range);
            }
        });
        for (name, found) in found {
            let [Suspicion::CounterOverflow { right: true, bits: found, t_s }] = found[..] else {
                panic!("{name}: {found:?}");
            };
            assert!(found == bits && t_s > 0.0, "{name}: {found} at {t_s}");
        }
    }
}

#[test]
fn a_clock_in_milliseconds_is_found() {
    let found = changed(|run| {
        run.wheels.iter_mut().for_each(|sample| sample.t_s *= 1e3);
        run.measured_poses.iter_mut().for_each(|pose| pose.t_s *= 1e3);
        run.gyro.iter_mut().for_each(|sample| sample.t_s *= 1e3);
    });
    for (name, found) in found {
        assert!(matches!(found[..], [Suspicion::Clock { .. }]), "{name}: {found:?}");
    }
}

#[test]
fn a_robot_that_is_merely_inaccurate_is_not_suspected() {
    nothing(changed(|_| {}));
    // Counts a fifth too high; then wheels that spin, or a robot that someone holds.
    nothing(changed(|run| {
        for sample in &mut run.wheels {
            sample.phi_rad = sample.phi_rad.map(|phi| 1.2 * phi);
        }
    }));
    nothing(changed(|run| {
        let first = run.measured_poses[0];
        for measurement in &mut run.measured_poses {
            (measurement.position_m, measurement.heading_rad) =
                (first.position_m, first.heading_rad);
        }
    }));
    // Wrapped headings; every seventh position far away, the first among them.
    nothing(changed(|run| {
        for (k, measurement) in run.measured_poses.iter_mut().enumerate() {
            measurement.heading_rad = measurement.heading_rad.map(|rad| wrap(rad + 3.1));
            if k % 7 == 0 {
                measurement.position_m = Some([40.0, -900.0 * (k % 2) as f64]);
            }
        }
    }));
    // A log with few rows, one with its ends only, and one with a gap.
    nothing(changed(|run| run.wheels = run.wheels.iter().copied().step_by(400).collect()));
    nothing(changed(|run| run.wheels = vec![run.wheels[0], run.wheels[run.wheels.len() - 1]]));
    nothing(changed(|run| drop(run.wheels.drain(20..run.wheels.len() - 40))));
}

#[test]
fn a_robot_that_slips_and_kicks_is_not_suspected_even_with_end_poses_only() {
    let truth = [
        term("track_width", &[0.12]),
        term("traction_slip", &[0.2]),
        term("caster_kick", &[0.3, 0.06]),
        term("marker_offset", &[0.05, -0.05]),
    ];
    let odd = campaign(&full_plan(), &truth, 6);
    for campaign in [odd.clone(), end_poses_only(odd)] {
        for run in &campaign.runs {
            assert_eq!(suspicions(&ROBOT, run), [], "{}", run.name);
        }
    }
}
