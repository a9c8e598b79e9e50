//! What holds for every effect of the catalogue: identity at zero, derivatives, ids and texts; signs and units.

mod signs;
mod speed_linear;
mod units;

use super::*;
use crate::effect::composition::{Composer, Increment, PlacedTerm, Term, Terms};
use crate::effect::slopes::Slopes;
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::excitation::Excitation;
use crate::recording::motion::Step;
use crate::tests::synthetic::ROBOT;

#[test]
fn the_page_on_adding_an_effect_shows_a_file_that_works() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |path: &str| std::fs::read_to_string(root.join(path)).unwrap();
    let code = read("robot-model/src/effect/tests/speed_linear.rs");
    assert!(read("docs/adding-an-effect.md").contains(&format!("```rust\n{code}```")));
    let step = Step { wheel_speed_mps: WheelPair::both(-0.5), ..steps()[0] };
    let change =
        speed_linear::SpeedLinear.act(&Jet::parameters(&[0.02]), &step, &mut Memory::default());
    // 1 + 0.02 |-0.5|, whichever way it drives.
    assert!((change.travel.left.value - 0.01).abs() < 1e-15, "{change:?}");
    assert_eq!(change.travel.left, change.travel.right);
}

/// Steps of some motion: forward, back, in curves, on the spot, at rest.
fn steps() -> Vec<Step> {
    let wheels = [
        (0.12, 0.10, 0.5),
        (0.2, 0.25, -0.3),
        (-0.15, -0.1, 0.4),
        (-0.2, 0.2, 0.0),
        (0.0, 0.0, 0.0),
        (0.3, -0.28, 0.2),
        (-0.2, -0.25, -0.6),
        (0.4, 0.41, 0.1),
    ];
    let mut phi_rad = WheelPair::new(0.3, -0.8);
    let mut path_m = 0.0;
    let mut steps = Vec::new();
    for (k, (left, right, accel)) in wheels.into_iter().enumerate() {
        let dt_s = 0.02;
        let speed = WheelPair::new(left, right);
        let dphi_rad = speed.map(|speed| speed * dt_s / ROBOT.wheel_radius_m);
        let step = Step {
            t_s: k as f64 * dt_s,
            dt_s,
            clock_s: 100.0 + k as f64,
            phi_rad,
            dphi_rad,
            wheel_speed_mps: speed,
            wheel_accel_mps2: WheelPair::new(accel, 0.7 * accel),
            path_m,
            since_reversal_m: (k > 2).then_some(0.01 * k as f64),
            payload_kg: 2.0,
            wheel_radius_m: ROBOT.wheel_radius_m,
            track_width_m: ROBOT.track_width_m,
            gear_reduction: 3.0,
            heading_rad: 0.4 * k as f64,
            place_m: [0.1, 0.2],
        };
        path_m += step.travel_m().abs();
        phi_rad = phi_rad.zip(dphi_rad).map(|(a, b)| a + b);
        steps.push(step);
    }
    steps
}

/// All numbers by which an effect changes these steps, a measured pose and the yaw rate sensor.
fn everything(effect: &dyn Effect, values: &[f64]) -> Vec<Jet> {
    let p = Jet::parameters(values);
    let mut memory = Memory::default();
    let mut all = Vec::new();
    for step in steps() {
        let change = effect.act(&p, &step, &mut memory);
        all.extend([
            change.angle_rad.left,
            change.angle_rad.right,
            change.travel.left,
            change.travel.right,
        ]);
        all.extend([
            change.turning,
            change.turn_rad,
            change.sideways_m,
            change.drift_m[0],
            change.drift_m[1],
        ]);
        all.push(effect.sense_rate(&p, step.turn_rate_rad_s()));
    }
    let view = effect.observe(&p);
    all.extend([view.offset_m[0], view.offset_m[1], view.delay_s, view.heading_drift_rad_s]);
    all
}

/// A value well within the range, different for each parameter.
fn typical(effect: &dyn Effect) -> Vec<f64> {
    let parameters = effect.facts().parameters.iter().enumerate();
    parameters
        .map(|(j, parameter)| match parameter.role {
            Role::Amplitude => (0.3 + 0.1 * j as f64) * parameter.high,
            // Within what the steps reach: 5 rad/s of a wheel, centimetres after a reversal.
            Role::Shape if parameter.name == "w0" => 5.0,
            // So that a wheel is still between its flanks after the step to rest.
            Role::Shape if parameter.name == "d" => 9.0,
            Role::Shape => parameter.low + 0.3 * (parameter.high - parameter.low),
        })
        .collect()
}

#[test]
fn every_effect_is_the_exact_identity_at_zero() {
    for effect in CATALOGUE {
        let mut values = typical(effect);
        for (value, parameter) in values.iter_mut().zip(effect.facts().parameters) {
            if parameter.role == Role::Amplitude {
                *value = 0.0;
            }
        }
        for jet in everything(effect, &values) {
            assert_eq!(jet.value, 0.0, "{}", effect.facts().id);
        }
        let terms = [Term::new(effect, values)];
        let (mut with, mut without) =
            (Composer::new(Terms::Fixed(&terms)), Composer::new(Terms::Fixed(&[])));
        for step in steps() {
            assert_eq!(with.step(&step), without.step(&step), "{}", effect.facts().id);
        }
    }
}

#[test]
fn every_effect_does_something_and_depends_on_every_parameter() {
    for effect in CATALOGUE {
        let all = everything(effect, &typical(effect));
        for (j, parameter) in effect.facts().parameters.iter().enumerate() {
            let id = effect.facts().id;
            assert!(all.iter().any(|jet| jet.by[j] != 0.0), "{id} {}", parameter.name);
        }
        assert!(all.iter().any(|jet| jet.value != 0.0), "{}", effect.facts().id);
    }
}

#[test]
fn derivatives_are_those_of_high_order_differences() {
    for effect in CATALOGUE {
        let values = typical(effect);
        let exact = everything(effect, &values);
        for j in 0..values.len() {
            let h = 1e-3 * values[j].abs();
            let at = |steps: f64| {
                let mut moved = values.clone();
                moved[j] += steps * h;
                everything(effect, &moved)
            };
            let [m3, m2, m1, p1, p2, p3] = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0].map(at);
            for (k, jet) in exact.iter().enumerate() {
                // The central difference of sixth order: its error goes as h^6.
                let slope = (45.0 * (p1[k].value - m1[k].value)
                    - 9.0 * (p2[k].value - m2[k].value)
                    + (p3[k].value - m3[k].value))
                    / (60.0 * h);
                // Rounding: 1e-16 of a value over h; h is a thousandth of a value.
                let scale = slope.abs() + (jet.value / values[j]).abs() + 1e-9;
                let error = (jet.by[j] - slope).abs() / scale;
                assert!(error < 1e-9, "{} by {j}: {} {slope}", effect.facts().id, jet.by[j]);
            }
        }
    }
}

/// What a step moves, by the order of [`Increment`]'s fields.
fn five(increment: &Increment) -> [f64; 5] {
    [
        increment.travel_m,
        increment.sideways_m,
        increment.turn_rad,
        increment.drift_m[0],
        increment.drift_m[1],
    ]
}

#[test]
fn the_derivatives_of_all_effects_together_are_those_of_high_order_differences() {
    let terms: Vec<Term<'_>> =
        CATALOGUE.iter().map(|effect| Term::new(*effect, typical(*effect))).collect();
    let placed = PlacedTerm::place(&terms);
    let numbers = |terms: &[Term<'_>]| -> Vec<[f64; 5]> {
        let mut composer = Composer::new(Terms::Fixed(terms));
        let steps = steps();
        let each = steps.iter().map(|step| composer.step(step));
        each.map(|increment| five(&increment)).collect()
    };
    let mut composer = Composer::new(Terms::Free(&placed));
    let steps = steps();
    let exact: Vec<Vec<[f64; 5]>> = steps
        .iter()
        .map(|step| {
            composer.step(step);
            let Slopes { travel_m, sideways_m, turn_rad, drift_m, .. } = &composer.slopes;
            let by =
                |c: usize| [travel_m[c], sideways_m[c], turn_rad[c], drift_m[0][c], drift_m[1][c]];
            (0..travel_m.len()).map(by).collect()
        })
        .collect();
    for (index, term) in terms.iter().enumerate() {
        for j in 0..term.values.len() {
            let h = 1e-3 * term.values[j].abs();
            let at = |steps: f64| {
                let mut moved = terms.clone();
                moved[index].values[j] += steps * h;
                numbers(&moved)
            };
            let (m2, m1, p1, p2) = (at(-2.0), at(-1.0), at(1.0), at(2.0));
            let column = placed[index].columns().start + j;
            for k in 0..steps.len() {
                for n in 0..5 {
                    let slope = (8.0 * (p1[k][n] - m1[k][n]) - (p2[k][n] - m2[k][n])) / (12.0 * h);
                    let error = (exact[k][column][n] - slope).abs();
                    // Steps of millimetres and milliradians, rounded to 1e-18, over h; and h^4.
                    let bound = 1e-17 / h + 1e-9 * slope.abs() + 1e-15;
                    let id = term.effect.facts().id;
                    assert!(error < bound, "{id} {j} step {k} number {n}: {error:e} {bound:e}");
                }
            }
        }
    }
}

#[test]
fn ids_are_unique_and_found_and_every_fact_is_given() {
    for effect in CATALOGUE {
        let facts = effect.facts();
        assert_eq!(find(facts.id).map(|effect| effect.facts()), Some(facts));
        assert_eq!(CATALOGUE.iter().filter(|effect| effect.facts().id == facts.id).count(), 1);
        assert!((1..=PARAMETERS_MAX).contains(&facts.parameters.len()), "{}", facts.id);
        for text in
            [facts.name, facts.equation, facts.signature, facts.shown_by, facts.compensation]
        {
            assert!(!text.is_empty(), "{}", facts.id);
        }
        for parameter in facts.parameters {
            assert!(parameter.low < parameter.high, "{} {}", facts.id, parameter.name);
            assert!(parameter.low <= 0.0 || parameter.role == Role::Shape, "{}", facts.id);
        }
        for start in effect.starts(&Excitation::default()) {
            assert_eq!(start.len(), facts.parameters.len(), "{}", facts.id);
        }
    }
}
