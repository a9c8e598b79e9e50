//! Are poses that were misread found, and none in a robot that is merely inaccurate?

use crate::checks::{DataFault, data_hypotheses, implausible_end_pose};
use crate::kinematics::Pose;
use crate::recording::campaign::Campaign;
use crate::recording::{PoseMeasurement, Robot};
use crate::tests::synthetic::{self, ROBOT, end_poses_only};

/// A sound robot; with ends only, its runs out and back end where they turn.
pub(super) fn sound(ends_only: bool) -> Campaign {
    let mut campaign = synthetic::sound().clone();
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

/// The last poses that are told, by the index of their runs: how far they are off.
fn last_poses(robot: &Robot, campaign: &Campaign) -> Vec<(usize, Option<f64>, Option<f64>)> {
    let found = data_hypotheses(robot, &campaign.runs).into_iter().map(|found| {
        let DataFault::LastPose { position_m, heading_rad, .. } = found.what else {
            panic!("{found:?}")
        };
        let run = campaign.runs.iter().position(|run| Some(&run.name) == found.run.as_ref());
        (run.unwrap(), position_m, heading_rad)
    });
    found.collect()
}

fn misread(campaign: &mut Campaign, name: &str, off_m: f64, off_rad: f64) -> usize {
    let index = campaign.runs.iter().position(|run| run.name.starts_with(name)).unwrap();
    let last = campaign.runs[index].measured_poses.last_mut().unwrap();
    last.heading_rad = last.heading_rad.map(|rad| rad + off_rad);
    last.position_m = last.position_m.map(|[x, y]| [x, y + off_m]);
    index
}

#[test]
fn a_misread_pose_is_found() {
    let near = |found: Option<f64>, off: f64| match found {
        Some(found) => (found - off).abs() < 0.05,
        None => off == 0.0,
    };
    for ends_only in [false, true] {
        for (name, off_m, off_rad) in [
            ("arc", 0.0, 1.57),
            ("out_and_back", 1.0, 0.0),
            ("out_and_back", 0.0, 1.57),
            ("spin", 0.0, 1.57),
            ("spin", 0.0, -1.57),
            ("spin", 0.0, 3.0),
        ] {
            let mut campaign = sound(ends_only);
            let index = misread(&mut campaign, name, off_m, off_rad);
            let found = last_poses(&ROBOT, &campaign);
            let [(run, position_m, heading_rad)] = found[..] else {
                panic!("{name}, {ends_only}: {found:?}");
            };
            assert_eq!(run, index, "{name}, {ends_only}");
            assert!(near(position_m, off_m) && near(heading_rad, off_rad), "{name}: {found:?}");
        }
    }
}

#[test]
fn a_wrong_track_width_makes_no_end_pose_wrong_and_hides_none() {
    let robot = Robot { track_width_m: 1.12 * ROBOT.track_width_m, ..ROBOT };
    let mut campaign = sound(true);
    assert_eq!(last_poses(&robot, &campaign), []);
    let index = misread(&mut campaign, "spin", 0.0, 1.57);
    let found = last_poses(&robot, &campaign);
    assert!(found.len() == 1 && found[0].0 == index, "{found:?}");
}

#[test]
fn a_reading_is_doubtful_if_the_wheels_led_elsewhere() {
    let at = |t_s: f64, x_m: f64, heading_rad: Option<f64>| PoseMeasurement {
        t_s,
        position_m: Some([x_m, 0.0]),
        heading_rad,
    };
    let ahead: Vec<Pose> = (0..=18).map(|k| Pose::new(0.1 * f64::from(k), 0.0, 0.0)).collect();
    let spin: Vec<Pose> = (0..=18).map(|k| Pose::new(0.0, 0.0, 0.7 * f64::from(k))).collect();
    let turned_rad = Some(0.7 * 18.0);
    let start = at(0.0, 0.0, Some(0.0));
    for (wheels, good, bad) in [
        (&ahead, at(9.0, 1.75, Some(0.1)), at(9.0, 1.2, Some(0.1))),
        (&ahead, at(9.0, 1.75, None), at(9.0, 1.75, Some(1.57))),
        (&spin, at(9.0, 0.02, turned_rad), at(9.0, 0.02, turned_rad.map(|rad| rad + 1.57))),
        (&spin, at(9.0, 0.02, None), at(9.0, 0.3, None)),
    ] {
        assert_eq!(implausible_end_pose(&start, &good, wheels), None);
        assert!(implausible_end_pose(&start, &bad, wheels).is_some(), "{bad:?}");
    }
}

#[test]
fn an_end_pose_that_is_misread_by_a_little_is_an_outlier_among_others_that_agree() {
    for (name, off_m, off_rad) in
        [("arc", 0.0, 0.2), ("arc", 0.3, 0.0), ("out_and_back", 0.2, 0.0), ("spin", 0.0, -0.3)]
    {
        let mut campaign = sound(true);
        let index = misread(&mut campaign, name, off_m, off_rad);
        let found = last_poses(&ROBOT, &campaign);
        assert!(found.len() == 1 && found[0].0 == index, "{name}: {found:?}");
        // A run with a load may well differ from all others.
        campaign.runs[index].payload_kg = 2.0;
        assert_eq!(last_poses(&ROBOT, &campaign), [], "{name}");
    }
}
