//! Is an impossible radius, gear or sign found?

use crate::checks::{Mismatch, mismatch};
use crate::kinematics::wheel_pair::WheelPair;
use crate::recording::campaign::Campaign;
use crate::recording::{Recording, Robot};
use crate::tests::synthetic::{ALONE, ROBOT, campaign, end_poses_only, full_plan, term};

/// What is found when `robot` and `change` do not agree with the robot that drove.
fn found(robot: &Robot, ends_only: bool, change: impl Fn(&mut Recording)) -> Option<Mismatch> {
    let mut campaign = sound(ends_only);
    campaign.runs.iter_mut().for_each(change);
    mismatch(robot, &campaign.runs)
}

pub(super) fn sound(ends_only: bool) -> Campaign {
    let mut campaign = campaign(&full_plan(), &[], 3);
    if ends_only {
        // Only the way out: a run out and back ends where it began.
        for run in campaign.runs.iter_mut().filter(|run| run.name.starts_with("out_and_back")) {
            let middle = run.wheels[run.wheels.len() / 2].t_s;
            run.wheels.retain(|sample| sample.t_s < middle);
            run.measured_poses.retain(|pose| pose.t_s < middle);
        }
        return end_poses_only(campaign);
    }
    campaign
}

fn nothing(_: &mut Recording) {}

#[test]
fn a_robot_that_is_merely_inaccurate_is_no_mismatch() {
    for ends_only in [false, true] {
        assert_eq!(found(&ROBOT, ends_only, nothing), None);
    }
    for (id, values) in ALONE {
        let campaign = campaign(&full_plan(), &[term(id, values)], 3);
        assert_eq!(mismatch(&ROBOT, &campaign.runs), None, "{id}");
    }
    let other = |radius: f64, track: f64| Robot {
        wheel_radius_m: radius * ROBOT.wheel_radius_m,
        track_width_m: track * ROBOT.track_width_m,
        ..ROBOT
    };
    for (radius, track) in [(1.35, 1.0), (0.75, 1.0), (1.0, 1.3), (1.0, 0.75)] {
        assert_eq!(found(&other(radius, track), false, nothing), None, "{radius}, {track}");
    }
}

#[test]
fn a_radius_or_a_count_off_by_a_factor_is_found() {
    for ends_only in [false, true] {
        for times in [1000.0, 4.0, 2.0, 0.5, 0.25, 0.01] {
            let robot = Robot { wheel_radius_m: ROBOT.wheel_radius_m * times, ..ROBOT };
            let found = found(&robot, ends_only, nothing);
            let Some(Mismatch::Travel { times: other }) = found else {
                panic!("{times}: {found:?}");
            };
            assert!((other * times - 1.0).abs() < 0.1, "{times}: {other}");
        }
    }
}

#[test]
fn a_track_width_off_by_a_factor_is_found() {
    for times in [1000.0, 100.0, 10.0, 2.0, 0.5, 0.3] {
        let robot = Robot { track_width_m: ROBOT.track_width_m * times, ..ROBOT };
        let found = found(&robot, false, nothing);
        let Some(Mismatch::Turns { times: other }) = found else {
            panic!("{times}: {found:?}");
        };
        assert!((other / times - 1.0).abs() < 0.1, "{times}: {other}");
    }
}

#[test]
fn exchanged_encoders_and_signs_are_found() {
    let each = |change: fn(WheelPair<f64>) -> WheelPair<f64>| {
        found(&ROBOT, false, |run| {
            run.wheels.iter_mut().for_each(|sample| sample.phi_rad = change(sample.phi_rad));
        })
    };
    let exchanged = each(|phi| WheelPair::new(phi.right, phi.left));
    assert!(
        matches!(exchanged, Some(Mismatch::Turns { times }) if (times + 1.0).abs() < 0.05),
        "{exchanged:?}"
    );
    assert_eq!(each(|phi| WheelPair::new(-phi.left, -phi.right)), Some(Mismatch::Backwards));
    // Only one exchanged sign: driving straight is a spin to the encoders.
    let one = each(|phi| WheelPair::new(-phi.left, phi.right));
    assert!(matches!(one, Some(Mismatch::Turns { times }) if times.abs() < 0.5), "{one:?}");
}
