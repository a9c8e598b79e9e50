//! What does a simulator without noise make of us? Students and other people's tests have no camera noise.

use crate::explain::{Answer, explain};
use crate::kinematics::{Geometry, Pose, dead_reckon};
use crate::recording::{Campaign, Piece, Robot, Sampling, nominal_run};

/// Six perfect runs of a robot with this W_T; of whole counts, if asked for.
fn answer(robot: Robot, w_t: f64, whole_counts: bool) -> Answer {
    let straight = |travel_m| Piece::Straight { travel_m, speed_mps: 0.2 };
    let spin = |turn_rad| Piece::Spin { turn_rad, speed_mps: 0.1 };
    let arc = |turn_rad| Piece::Arc { radius_m: 0.5, turn_rad, speed_mps: 0.2 };
    let pieces = [straight(2.0), straight(-2.0), spin(12.0), spin(-12.0), arc(6.0), arc(-6.0)];
    let runs = pieces.map(|piece| {
        let mut run = nominal_run(&robot, &format!("{piece:?}"), &[piece], &Sampling::USUAL);
        let turns = run.wheels.iter().map(|sample| sample.phi_rad);
        let poses = dead_reckon(Pose::ORIGIN, &Geometry::PAPER, w_t, turns);
        let seen = poses.iter().step_by(Sampling::USUAL.samples_per_pose);
        for (measured, pose) in run.measured_poses.iter_mut().zip(seen) {
            measured.position_m = Some([pose.x_m, pose.y_m]);
            measured.heading_rad = Some(pose.heading_rad);
        }
        for sample in run.wheels.iter_mut().filter(|_| whole_counts) {
            sample.phi_rad =
                sample.phi_rad.map(|phi| (phi / robot.rad_per_count).floor() * robot.rad_per_count);
        }
        run
    });
    explain(&Campaign { robot, runs: runs.into() }).unwrap()
}

#[test]
fn perfect_recordings_name_what_is_there_and_leave_nothing() {
    let told =
        Robot { position_sigma_m: Some(1e-3), heading_sigma_rad: Some(2e-3), ..Robot::PAPER };
    for (robot, whole_counts) in
        [(told, false), (told, true), (Robot::PAPER, false), (Robot::PAPER, true)]
    {
        for w_t in [1.0, 1.01] {
            let answer = answer(robot, w_t, whole_counts);
            let step = |id: &str| answer.steps.iter().find(|step| step.effect == id);
            assert!(!answer.unexplained.structure, "{w_t}: {:?}", answer.unexplained);
            match step("wheel_radius_ratio") {
                // Right over left: (1 + rho/2) / (1 - rho/2) = W_T.
                Some(ratio) => {
                    let rho = ratio.parameters[0].value;
                    let found = (1.0 + rho / 2.0) / (1.0 - rho / 2.0);
                    assert!(w_t > 1.0 && (found - w_t).abs() < 1e-5, "{w_t}: {found}");
                }
                None => assert!(w_t == 1.0, "{answer:?}"),
            }
        }
    }
}
