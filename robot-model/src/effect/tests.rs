//! What holds for every effect of the catalogue, checked for every effect of the catalogue.

use super::*;
use crate::increment::{Composer, Term};
use crate::synthetic::ROBOT;

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
    let mut phi_rad = Sides::new(0.3, -0.8);
    let mut path_m = 0.0;
    let mut steps = Vec::new();
    for (k, (left, right, accel)) in wheels.into_iter().enumerate() {
        let dt_s = 0.02;
        let speed = Sides::new(left, right);
        let dphi_rad = speed.map(|it| it * dt_s / ROBOT.wheel_radius_m);
        let step = Step {
            t_s: k as f64 * dt_s,
            dt_s,
            clock_s: 100.0 + k as f64,
            phi_rad,
            dphi_rad,
            wheel_speed_mps: speed,
            wheel_accel_mps2: Sides::new(accel, 0.7 * accel),
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

/// All numbers of what an effect does in these steps, and to a sight, and to the sensor.
fn everything(effect: &dyn Effect, values: &[f64]) -> Vec<Jet> {
    let p = Jet::parameters(values);
    let mut memory = Memory::default();
    let mut all = Vec::new();
    for step in steps() {
        let it = effect.act(&p, &step, &mut memory);
        all.extend([it.angle_rad.left, it.angle_rad.right, it.travel.left, it.travel.right]);
        all.extend([it.turning, it.turn_rad, it.sideways_m, it.drift_m[0], it.drift_m[1]]);
        all.push(effect.sense_rate(&p, step.turn_rate_rad_s()));
    }
    let view = effect.observe(&p);
    all.extend([view.offset_m[0], view.offset_m[1], view.delay_s]);
    all
}

/// A value well within the range, different for each parameter.
fn typical(effect: &dyn Effect) -> Vec<f64> {
    let parameters = effect.facts().parameters.iter().enumerate();
    parameters
        .map(|(j, it)| match it.role {
            Role::Amplitude => (0.3 + 0.1 * j as f64) * it.high,
            // Within what the steps reach: 5 rad/s of a wheel, centimetres after a reversal.
            Role::Shape if it.name == "w0" => 5.0,
            Role::Shape => it.low + 0.3 * (it.high - it.low),
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
        let terms = [Term { effect, values, column: None }];
        let (mut with, mut without) = (Composer::new(&terms, 0), Composer::new(&[], 0));
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
            assert!(all.iter().any(|it| it.by[j] != 0.0), "{id} {}", parameter.name);
        }
        assert!(all.iter().any(|it| it.value != 0.0), "{}", effect.facts().id);
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

#[test]
fn the_derivatives_of_all_effects_together_are_those_of_high_order_differences() {
    let mut terms: Vec<Term<'_>> = CATALOGUE
        .iter()
        .map(|it| Term { effect: *it, values: typical(*it), column: None })
        .collect();
    let columns = crate::evidence::number_columns(&mut terms);
    let numbers = |terms: &[Term<'_>]| -> Vec<[f64; 5]> {
        let mut composer = Composer::new(terms, columns);
        let steps = steps();
        let each = steps.iter().map(|step| composer.step(step));
        each.map(|it| [it.travel_m, it.sideways_m, it.turn_rad, it.drift_m[0], it.drift_m[1]])
            .collect()
    };
    let mut composer = Composer::new(&terms, columns);
    let steps = steps();
    let exact: Vec<Vec<[f64; 5]>> = steps
        .iter()
        .map(|step| {
            composer.step(step);
            let slopes = composer.by_column.iter();
            slopes
                .map(|it| [it.travel_m, it.sideways_m, it.turn_rad, it.drift_m[0], it.drift_m[1]])
                .collect()
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
            let column = term.column.unwrap_or(0) + j;
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
fn ids_are_unique_and_found_and_everything_is_said_about_each() {
    for effect in CATALOGUE {
        let facts = effect.facts();
        assert_eq!(find(facts.id).map(|it| it.facts()), Some(facts));
        assert_eq!(CATALOGUE.iter().filter(|it| it.facts().id == facts.id).count(), 1);
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
        for start in effect.starts(&Survey::default()) {
            assert_eq!(start.len(), facts.parameters.len(), "{}", facts.id);
        }
    }
}

/// The pose that a second of a steady motion leads to, with one effect.
fn after_a_second(id: &str, values: &[f64], left_mps: f64, right_mps: f64) -> crate::path::Pose {
    let terms = [Term { effect: find(id).unwrap(), values: values.into(), column: None }];
    let mut composer = Composer::new(&terms, 0);
    let mut pose = crate::path::Pose::ORIGIN;
    let speed = Sides::new(left_mps, right_mps);
    for k in 0..100 {
        let step = Step {
            dt_s: 0.01,
            dphi_rad: speed.map(|it| 0.01 * it / ROBOT.wheel_radius_m),
            wheel_speed_mps: speed,
            wheel_accel_mps2: Sides::both(0.5),
            since_reversal_m: Some(0.0001 * f64::from(k)),
            clock_s: 1000.0,
            payload_kg: 2.0,
            heading_rad: pose.heading_rad,
            wheel_radius_m: ROBOT.wheel_radius_m,
            track_width_m: ROBOT.track_width_m,
            gear_reduction: 1.0,
            ..Step::default()
        };
        pose = crate::whiten::Move::new(pose, &composer.step(&step), 1.0).pose;
    }
    pose
}

#[test]
fn signs_are_those_that_the_descriptions_promise() {
    let v = 0.2;
    let ahead = |id: &str, values: &[f64]| after_a_second(id, values, v, v);
    let back = |id: &str, values: &[f64]| after_a_second(id, values, -v, -v);
    // Left is positive: a larger right wheel curves left ahead, right when reversing.
    assert!(ahead("wheel_radius_ratio", &[0.01]).heading_rad > 0.0);
    assert!(back("wheel_radius_ratio", &[0.01]).heading_rad < 0.0);
    // A pull turns the same way both ways, by c times the path: 0.01 rad/m over 0.2 m.
    for pose in [ahead("heading_pull", &[0.01]), back("heading_pull", &[0.01])] {
        assert!((pose.heading_rad - 0.002).abs() < 1e-12);
    }
    assert!((ahead("wheel_radius_scale", &[0.01]).x_m - 0.202).abs() < 1e-12);
    assert!((ahead("speed_growth", &[0.1]).x_m - 0.2 * 1.004).abs() < 1e-12);
    assert!((ahead("traction_slip", &[0.02]).x_m - 0.2 * 0.99).abs() < 1e-12);
    assert!((ahead("payload", &[0.001]).x_m - 0.2 * 0.998).abs() < 1e-12);
    assert!((ahead("thermal_drift", &[1e-6]).x_m - 0.2 * 1.001).abs() < 1e-12);
    assert!((ahead("carpet_drift", &[0.01, -0.02]).x_m - 0.202).abs() < 1e-12);
    assert!((ahead("carpet_drift", &[0.01, -0.02]).y_m + 0.004).abs() < 1e-12);
    assert!(ahead("slope", &[0.0, 0.01, 0.5]).heading_rad > 0.0, "turns towards downhill");
    assert!(ahead("slope", &[0.0, 0.01, 0.5]).y_m > 0.0, "creeps downhill");
    assert!(ahead("caster_kick", &[0.05, 0.01]).heading_rad > 0.0);
    assert!(back("caster_kick", &[0.05, 0.01]).heading_rad < 0.0);
    // Wheels at 5.6 rad/s, 2.6 above w0 = 3: 1 + 0.1 (0.2/0.036 - 3)/3.
    let more = 1.0 + 0.1 * (0.2 / 0.036 - 3.0) / 3.0;
    assert!((ahead("lost_counts", &[0.1, 3.0]).x_m - 0.2 * more).abs() < 1e-12);

    // A spin to the left, 0.4/0.372 rad.
    let nominal = 0.4 / 0.372;
    let spin = |id: &str, values: &[f64]| after_a_second(id, values, -v, v).heading_rad;
    let spin_right = |id: &str, values: &[f64]| after_a_second(id, values, v, -v).heading_rad;
    assert!((spin("track_width", &[0.01]) - nominal / 1.01).abs() < 1e-12);
    // chi of a spin is 1 but for the creeping speed that keeps it from 0/0: 1e-6 of 0.4.
    assert!((spin("scrub", &[0.01]) - nominal / 1.01).abs() < 1e-7);
    assert!((spin("turn_asymmetry", &[0.01]) - nominal * 1.01).abs() < 1e-12);
    assert!((spin_right("turn_asymmetry", &[0.01]) + nominal * 0.99).abs() < 1e-12);

    // An arc to the left: pushed outwards, to the right of where it would be, and turning less.
    let arc = |id: &str, values: &[f64]| after_a_second(id, values, 0.15, 0.25);
    let (slipped, straight) = (arc("side_slip", &[0.05]), arc("side_slip", &[0.0]));
    let seen = slipped.seen_from(straight);
    assert!(seen.y_m < 0.0 && slipped.heading_rad == straight.heading_rad, "{seen:?}");
    let heavy = arc("turn_load_transfer", &[0.1]).heading_rad;
    // 1 - 0.1 v^2 of the turn, v = 0.2.
    assert!((heavy / straight.heading_rad - 0.996).abs() < 1e-9);
}

#[test]
fn backlash_takes_its_play_once_at_each_reversal() {
    let beta = 0.05;
    let effect = find("backlash").unwrap();
    let p = Jet::parameters(&[beta, 0.01]);
    let mut memory = Memory::default();
    let mut lost = |dphi: f64, steps: usize| -> f64 {
        (0..steps)
            .map(|_| {
                let step = Step { dphi_rad: Sides::both(dphi), ..Step::default() };
                effect.act(&p, &step, &mut memory).angle_rad.left.value
            })
            .sum()
    };
    assert_eq!(lost(0.01, 50), 0.0, "the first way is engaged from the start");
    // Sums of fifty numbers of size 0.01.
    assert!((lost(-0.01, 50) - beta).abs() < 1e-14, "backwards the ground stays ahead by the play");
    assert!((lost(0.01, 50) + beta).abs() < 1e-14);
    assert_eq!(lost(0.01, 50), 0.0);
}

#[test]
fn an_eccentric_wheel_is_right_again_after_each_turn() {
    let turn = core::f64::consts::TAU;
    // One turn of the wheel in a hundred steps or in three: the mean over each step is exact.
    for steps in [100_u32, 3] {
        let terms = [Term {
            effect: find("wheel_eccentricity").unwrap(),
            values: vec![0.01, 0.02, 0.0, 0.0],
            column: None,
        }];
        let mut composer = Composer::new(&terms, 0);
        let sum: f64 = (0..steps)
            .map(|k| {
                let dphi = turn / f64::from(steps);
                let step = Step {
                    phi_rad: Sides::both(f64::from(k) * dphi),
                    dphi_rad: Sides::both(dphi),
                    wheel_radius_m: 0.05,
                    track_width_m: 0.3,
                    gear_reduction: 1.0,
                    ..Step::default()
                };
                composer.step(&step).travel_m
            })
            .sum();
        // A hundred roundings of 3 mm.
        assert!((sum - 0.05 * turn).abs() < 1e-14, "{steps}: {sum}");
    }
}

#[test]
fn sensors_and_markers_show_what_their_descriptions_say() {
    let p = Jet::parameters(&[0.02, 0.03]);
    assert_eq!(find("gyro_bias").unwrap().sense_rate(&p, 1.5).value, 0.02);
    assert_eq!(find("gyro_scale").unwrap().sense_rate(&p, 1.5).value, 0.03);
    assert_eq!(find("measurement_delay").unwrap().observe(&p).delay_s.value, 0.02);
    let offset = find("marker_offset").unwrap().observe(&p).offset_m;
    assert_eq!(offset.map(|it| it.value), [0.02, 0.03]);
}
