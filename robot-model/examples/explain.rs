//! Explains recordings that were made in memory: a robot whose right wheel is 1 % too large.
//!
//! cargo run --example explain -p robot-model

use robot_model::explain::explain;
use robot_model::kinematics::{Geometry, Pose, dead_reckon};
use robot_model::recording::{Campaign, Piece, Robot, Sampling, nominal_run};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = Robot {
        wheel_radius_m: 0.036,
        track_width_m: 0.372,
        gear_reduction: 1.0,
        rad_per_count: Geometry::PAPER.rad_per_count(),
        position_sigma_m: None,
        heading_sigma_rad: None,
    };
    let straight = |travel_m| Piece::Straight { travel_m, speed_mps: 0.2 };
    let spin = |turn_rad| Piece::Spin { turn_rad, speed_mps: 0.1 };
    let runs = [straight(2.0), straight(-2.0), spin(12.0), spin(-12.0)].map(|piece| {
        let mut run = nominal_run(&robot, &format!("{piece:?}"), &[piece], &Sampling::USUAL);
        // What your encoders and your camera measured goes here: times, wheel angles, poses.
        let turns = run.wheels.iter().map(|sample| sample.phi_rad);
        let poses = dead_reckon(Pose::ORIGIN, &Geometry::PAPER, 1.01, turns);
        let seen = poses.iter().step_by(Sampling::USUAL.samples_per_pose);
        let to_thousandths = |value: f64| (1e3 * value).round() / 1e3;
        for (measured, pose) in run.measured_poses.iter_mut().zip(seen) {
            measured.position_m = Some([pose.x_m, pose.y_m].map(to_thousandths));
            measured.heading_rad = Some(to_thousandths(pose.heading_rad));
        }
        run
    });
    let answer = explain(&Campaign { robot, runs: runs.into() })?;
    for (step, found) in answer.steps.iter().map(|step| (step, &step.parameters[0])) {
        let (name, low, high) = (&found.name, found.low95, found.high95);
        println!("{}: {name} = {:.5}, 95 % from {low:.5} to {high:.5}", step.effect, found.value);
    }
    println!("anything left unexplained: {}", answer.unexplained.structure);
    Ok(())
}
