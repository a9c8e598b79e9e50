//! Explains recordings that were made in memory: a robot whose right wheel is 1 % too large.
//!
//! cargo run --example explain -p robot-model

use robot_model::explain::explain;
use robot_model::kinematics::{Geometry, Pose, dead_reckon};
use robot_model::recording::{Campaign, Piece, Robot, Sampling, nominal_run};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot =
        Robot { position_sigma_m: Some(0.001), heading_sigma_rad: Some(0.002), ..Robot::PAPER };
    let straight = |travel_m| Piece::Straight { travel_m, speed_mps: 0.2 };
    let spin = |turn_rad| Piece::Spin { turn_rad, speed_mps: 0.1 };
    let arc = |turn_rad| Piece::Arc { radius_m: 0.5, turn_rad, speed_mps: 0.2 };
    let pieces = [straight(2.0), straight(-2.0), spin(12.0), spin(-12.0), arc(6.0), arc(-6.0)];
    let runs = pieces.map(|piece| {
        let mut run = nominal_run(&robot, &format!("{piece:?}"), &[piece], &Sampling::USUAL);
        // What your encoders and your camera say goes here: times, wheel angles, measured poses.
        let turns = run.wheels.iter().map(|sample| sample.phi_rad);
        let poses = dead_reckon(Pose::ORIGIN, &Geometry::PAPER, 1.01, turns);
        for (k, measured) in run.measured_poses.iter_mut().enumerate() {
            let noise = |salt: usize| ((k * 7919 + salt * 104_729) % 2001) as f64 / 1000.0 - 1.0;
            let pose = poses[k * Sampling::USUAL.samples_per_pose];
            measured.position_m =
                Some([pose.x_m + 0.0017 * noise(1), pose.y_m + 0.0017 * noise(2)]);
            measured.heading_rad = Some(pose.heading_rad + 0.0035 * noise(3));
        }
        run
    });
    let answer = explain(&Campaign { robot, runs: runs.into() })?;
    for step in &answer.steps {
        for found in &step.parameters {
            let range = format!("95 % from {:.5} to {:.5}", found.low95, found.high95);
            println!("{}: {} = {:.5}, {range}", step.effect, found.name, found.value);
        }
    }
    println!("anything left unexplained: {}", answer.unexplained.structure);
    Ok(())
}
