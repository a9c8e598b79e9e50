//! Explains recordings that were made in memory: a robot whose right wheel is 1 % too large.
//!
//! cargo run --example explain -p robot-model

use robot_model::explain::explain;
use robot_model::recording::{Campaign, Piece, Robot, Sampling, nominal_run};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot =
        Robot { position_sigma_m: Some(0.001), heading_sigma_rad: Some(0.002), ..Robot::PAPER };
    let straight = |travel_m| Piece::Straight { travel_m, speed_mps: 0.2 };
    let spin = |turn_rad| Piece::Spin { turn_rad, speed_mps: 0.1 };
    let pieces = [straight(2.0), straight(-2.0), spin(12.0), spin(-12.0)];
    let runs = pieces.map(|piece| {
        // What your encoders and your camera say goes here: times, wheel angles, measured poses.
        let mut run = nominal_run(&robot, &format!("{piece:?}"), &[piece], &Sampling::USUAL);
        for sample in &mut run.wheels {
            sample.phi_rad.right /= 1.01;
        }
        run
    });
    let answer = explain(&Campaign { robot, runs: runs.into() })?;
    for step in &answer.steps {
        for found in &step.parameters {
            let (value, low, high) = (found.value, found.low95, found.high95);
            println!(
                "{}: {} = {value:.5}, 95 % from {low:.5} to {high:.5}",
                step.effect, found.name
            );
        }
    }
    println!("anything left unexplained: {}", answer.unexplained.structure);
    Ok(())
}
