//! What is left of a sound robot, with each part of the plant and without: which part does the model of the motors not describe?
//! `cargo xtask bench remainder [--seed S] [--case N]`; seed 1 and robot 4 of `bench drivetrain` by default.

use std::process::ExitCode;

use beeline_tests::drivetrain::case::{Case, Kind};
use beeline_tests::parallel::in_order;
use robot_model::drivetrain::{Experiment, baseline_errors};
use sim_target::plant::PlantParameters;

type Change = fn(&mut PlantParameters);

/// No load on the caster.
fn no_caster(plant: &mut PlantParameters) {
    plant.body.center_of_mass_forward_m = 0.0;
    plant.body.center_of_mass_height_m = 0.0;
    plant.caster.swivel_friction_nm = 0.0;
}

fn stiff_tyres(plant: &mut PlantParameters) {
    plant.tyre.longitudinal_stiffness_n_per_m *= 30.0;
    plant.tyre.lateral_stiffness_n_per_m *= 30.0;
    plant.substep_us = 50;
}

fn no_rolling_resistance(plant: &mut PlantParameters) {
    plant.tyre.rolling_resistance = 0.0;
    plant.caster.rolling_resistance = 0.0;
}

fn fine_counts(plant: &mut PlantParameters) {
    for encoder in [&mut plant.encoder.left, &mut plant.encoder.right] {
        encoder.counts_per_rev *= 50.0;
    }
}

fn quiet_stiff_supply(plant: &mut PlantParameters) {
    plant.supply.noise_sigma_v = 0.0;
    plant.supply.resistance_ohm = 0.0;
}

fn equal_radii(plant: &mut PlantParameters) {
    plant.geometry.wheel_radius_m.right = plant.geometry.wheel_radius_m.left;
}

/// What is taken out of the plant.
const WITHOUT: [(&str, &[Change]); 10] = [
    ("nothing", &[]),
    ("caster", &[no_caster]),
    ("soft tyres", &[stiff_tyres]),
    ("rolling resistance", &[no_rolling_resistance]),
    ("coarse counts", &[fine_counts]),
    ("noise and sag of the supply", &[quiet_stiff_supply]),
    ("unequal radii", &[equal_radii]),
    ("caster, coarse counts", &[no_caster, fine_counts]),
    ("caster, coarse counts, supply", &[no_caster, fine_counts, quiet_stiff_supply]),
    (
        "caster, coarse counts, supply, soft tyres",
        &[no_caster, fine_counts, quiet_stiff_supply, stiff_tyres],
    ),
];

fn main() -> ExitCode {
    let (mut seed, mut number) = (1, 4);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let value = words.next().and_then(|value| value.parse().ok());
        match (word.as_str(), value) {
            ("--seed", Some(value)) => seed = value,
            ("--case", Some(value)) => number = value,
            _ => {
                eprintln!("usage: bench_remainder [--seed S] [--case N]");
                return ExitCode::from(2);
            }
        }
    }
    println!("{:<46}{:>9}{:>12}{:>12}", "without", "left [mm]", "counts [mm]", "kA + kC");
    for line in in_order(&WITHOUT, |(what, changes)| line(seed, number, what, changes)) {
        println!("{line}");
    }
    ExitCode::SUCCESS
}

fn line(seed: u64, number: u64, what: &str, changes: &[Change]) -> String {
    let mut case = Case::with(seed, number, Kind::Nothing, Vec::new(), 0.0);
    changes.iter().for_each(|change| case.change(change));
    let folder = tempfile::tempdir().expect("there is a folder for temporary files");
    let found = match case.record(&folder.path().join("motors")) {
        Ok(found) => found,
        Err(why) => return format!("{what:<46}{why}"),
    };
    let experiments: Vec<Experiment> = found.runs.into_iter().map(|run| run.experiment).collect();
    match baseline_errors(&found.robot, &experiments) {
        Ok(found) => format!(
            "{what:<46}{:9.3}{:12.3}{:12.4}",
            found.errors.cross_validated_m * 1e3,
            found.resolution_m * 1e3,
            found.constants[2].value + found.constants[3].value,
        ),
        Err(why) => format!("{what:<46}{why:?}"),
    }
}
