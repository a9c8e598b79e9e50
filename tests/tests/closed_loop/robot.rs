//! Robots with one fault, and its true parameters by the names of the model.

use beeline_tests::blind::case::Kind;
use beeline_tests::blind::hidden_effects::{Hidden, true_parameters};
use beeline_tests::blind::sim_target_robot::sound;
use sim_target::Scenario;
use sim_target::scenario::HiddenEffect;

/// A sound robot with one effect, at a multiple of its typical strength.
pub fn with(effect: HiddenEffect, strength: f64, seed: u64) -> Scenario {
    let mut scenario = sound(seed, Kind::Nothing, &[effect]);
    Hidden { effect, strength, seed: seed ^ (1 << 40) }.hide(&mut scenario);
    scenario
}

/// A robot that is pulled to one side. Its tyres are about as stiff along their path as the standard robot's, within a
/// factor of two: on a sound robot's tyres, twelve times as stiff, a cable that makes a visible pull stalls a motor.
pub fn pulled(seed: u64) -> Scenario {
    let effect = HiddenEffect::HeadingPull;
    let mut scenario = sound(seed, Kind::Nothing, &[effect]);
    scenario.plant.tyre.longitudinal_stiffness_n_per_m /= 12.0;
    Hidden { effect, strength: 2.0, seed: seed ^ (1 << 40) }.hide(&mut scenario);
    scenario
}

/// A robot with play in one gear, left or right: play in both also holds it back along its path, as no caster does.
pub fn with_one_worn_gear(seed: u64) -> Scenario {
    let mut scenario = with(HiddenEffect::Backlash, 0.7, seed);
    let gear = &mut scenario.plant.gear;
    let sound = if seed.is_multiple_of(2) { &mut gear.left } else { &mut gear.right };
    sound.backlash_rad = 0.0;
    scenario
}

/// The plant's own numbers for an effect's parameters, where it has such numbers.
pub fn truth(effect: &str, scenario: &Scenario) -> Vec<(&'static str, f64)> {
    let plant = &scenario.plant;
    let track_m = plant.geometry.track_width_m;
    match effect {
        // A moment M, carried by the slip of two wheels: 2 M/(b^2 k sigma) rad/m.
        "heading_pull" => {
            let tyre = &plant.tyre;
            let stiffness_n = tyre.longitudinal_stiffness_n_per_m * tyre.relaxation_length_m;
            vec![("c", 2.0 * plant.tether.twist_nm / (track_m * track_m * stiffness_n))]
        }
        "backlash" => vec![
            ("beta_left", plant.gear.left.backlash_rad),
            ("beta_right", plant.gear.right.backlash_rad),
        ],
        // The load that is not on the caster is on two wheels, which yield.
        "payload" => {
            let on_caster = -plant.body.center_of_mass_forward_m / plant.caster.pivot_behind_m;
            let load_n_per_kg = plant.floor.gravity_mps2 * (1.0 - on_caster) / 2.0;
            let given_m = plant.wheel.left.radial_compliance_m_per_n * load_n_per_kg;
            vec![("k", given_m / plant.geometry.wheel_radius_m.left)]
        }
        // The others are parameters of the model alone, or in the benchmark's list.
        effect => true_parameters(effect, scenario),
    }
}
