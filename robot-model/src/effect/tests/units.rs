//! Units: does every effect do the same when measured in other units?
//!
//! Metre, second and kilogram are made smaller by powers of two, so that every product, quotient and
//! exponential is exact to the last bit. Every result then has to scale by exactly the power of its own unit: any
//! difference is a number with a hidden unit, or a wrong unit in an effect's facts.
//!
//! A hidden factor in a linear formula (60 seconds a minute) has no unit and is not found here; the figures of the
//! tests of signs find it.

use super::*;
use crate::effect::composition::Increment;
use crate::effect::custom::dimensions;

/// How many of the new unit make one of the old: metre, second, kilogram.
type Scale = [f64; 3];

/// Each by itself, so that nothing cancels, and all at once.
const SCALES: [Scale; 4] = [[8.0, 1.0, 1.0], [1.0, 32.0, 1.0], [1.0, 1.0, 4.0], [0.25, 16.0, 0.5]];

const METRE: [f64; 3] = [1.0, 0.0, 0.0];
const SECOND: [f64; 3] = [0.0, 1.0, 0.0];
const PER_SECOND: [f64; 3] = [0.0, -1.0, 0.0];
const ONE: [f64; 3] = [0.0; 3];

/// The factor by which a quantity with these powers of metre, second and kilogram grows.
fn growth(scale: Scale, powers: [f64; 3]) -> f64 {
    scale.iter().zip(powers).map(|(factor, power)| factor.powi(power as i32)).product()
}

/// The same step in other units. Every field is named here, so that none is forgotten.
fn step_in(scale: Scale, step: &Step) -> Step {
    let [m, s, kg] = scale;
    Step {
        t_s: step.t_s * s,
        dt_s: step.dt_s * s,
        clock_s: step.clock_s * s,
        phi_rad: step.phi_rad,
        dphi_rad: step.dphi_rad,
        wheel_speed_mps: step.wheel_speed_mps.map(|speed| speed * (m / s)),
        wheel_accel_mps2: step.wheel_accel_mps2.map(|accel| accel * (m / (s * s))),
        path_m: step.path_m * m,
        since_reversal_m: step.since_reversal_m.map(|path_m| path_m * m),
        payload_kg: step.payload_kg * kg,
        wheel_radius_m: step.wheel_radius_m * m,
        track_width_m: step.track_width_m * m,
        gear_reduction: step.gear_reduction,
        heading_rad: step.heading_rad,
        place_m: step.place_m.map(|metres| metres * m),
    }
}

/// Everything that an effect does, with the powers of its unit.
fn all_it_does(effect: &dyn Effect, scale: Scale) -> Vec<(Jet, [f64; 3])> {
    let powers = parameter_powers(effect);
    let values: Vec<f64> =
        typical(effect).iter().zip(&powers).map(|(value, p)| value * growth(scale, *p)).collect();
    let p = Jet::parameters(&values);
    let mut memory = Memory::default();
    let mut all = Vec::new();
    for step in steps() {
        let step = step_in(scale, &step);
        let change = effect.act(&p, &step, &mut memory);
        let Change { angle_rad, travel, turning, turn_rad, .. } = change;
        let Change { turn_by_heading, sideways_m, drift_m, .. } = change;
        all.push((Jet::constant(turn_by_heading), ONE));
        let plain = [angle_rad.left, angle_rad.right, travel.left, travel.right, turning, turn_rad];
        all.extend(plain.map(|jet| (jet, ONE)));
        all.extend([sideways_m, drift_m[0], drift_m[1]].map(|jet| (jet, METRE)));
        all.push((effect.sense_rate(&p, step.turn_rate_rad_s()), PER_SECOND));
    }
    let View { offset_m, delay_s, heading_drift_rad_s } = effect.observe(&p);
    all.extend(offset_m.map(|jet| (jet, METRE)));
    all.push((delay_s, SECOND));
    all.push((heading_drift_rad_s, PER_SECOND));
    all
}

fn parameter_powers(effect: &dyn Effect) -> Vec<[f64; 3]> {
    let facts = effect.facts();
    let powers = |parameter: &Parameter| {
        dimensions(&parameter.unit)
            .unwrap_or_else(|error| panic!("{} {}: {error:?}", facts.id, parameter.name))
    };
    facts.parameters.iter().map(powers).collect()
}

/// The first number that does not come out by the power of its unit.
fn wrong_unit(effect: &dyn Effect) -> Option<String> {
    let parameters = parameter_powers(effect);
    let before = all_it_does(effect, [1.0; 3]);
    for scale in SCALES {
        for (k, ((a, powers), (b, _))) in before.iter().zip(all_it_does(effect, scale)).enumerate()
        {
            let grown = growth(scale, *powers);
            if b.value != a.value * grown {
                let (id, is, was) = (effect.facts().id, b.value / grown, a.value);
                return Some(format!("{id}: number {k} in units of {scale:?}: {is} for {was}"));
            }
            for (j, own) in parameters.iter().enumerate() {
                if b.by[j] != a.by[j] * (grown / growth(scale, *own)) {
                    let id = effect.facts().id;
                    return Some(format!("{id}: derivative {j} of number {k}, {scale:?}"));
                }
            }
        }
    }
    None
}

#[test]
fn every_effect_is_the_same_in_other_units() {
    for effect in CATALOGUE {
        assert_eq!(wrong_unit(effect), None);
    }
}

#[test]
fn what_a_step_does_with_any_effect_is_the_same_in_other_units() {
    for effect in CATALOGUE {
        let powers = parameter_powers(effect);
        for scale in SCALES {
            let grown = |(value, p): (&f64, &[f64; 3])| value * growth(scale, *p);
            let values = typical(effect);
            let other: Vec<f64> = values.iter().zip(&powers).map(grown).collect();
            let a = [Term::new(effect, values)];
            let b = [Term::new(effect, other)];
            let (mut a, mut b) = (Composer::new(Terms::Fixed(&a)), Composer::new(Terms::Fixed(&b)));
            for step in steps() {
                let increment = a.step(&step);
                let m = scale[0];
                let expected = Increment {
                    travel_m: increment.travel_m * m,
                    sideways_m: increment.sideways_m * m,
                    turn_by_heading: increment.turn_by_heading,
                    turn_rad: increment.turn_rad,
                    drift_m: increment.drift_m.map(|drift_m| drift_m * m),
                };
                assert_eq!(b.step(&step_in(scale, &step)), expected, "{}", effect.facts().id);
            }
        }
    }
}

/// Wheels that grow with a time constant of a minute, which is not among the parameters.
#[derive(Debug)]
struct HiddenMinute(Facts<'static>);

impl Effect for HiddenMinute {
    fn facts(&self) -> Facts<'_> {
        self.0
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let share = step.clock_s / (step.clock_s + 60.0);
        Change { travel: WheelPair::both(p[0] * share), ..Change::NONE }
    }
}

#[test]
fn a_hidden_minute_and_a_wrong_unit_are_found() {
    let thermal = find("thermal_drift").unwrap().facts();
    const RATIO: &[Parameter] = &[Parameter::amplitude("k", "1", 0.01)];
    let hidden = HiddenMinute(Facts { parameters: RATIO, ..thermal });
    assert!(wrong_unit(&hidden).is_some());

    /// Slip per second that is declared as a ratio.
    #[derive(Debug)]
    struct Mislabelled;
    impl Effect for Mislabelled {
        fn facts(&self) -> Facts<'_> {
            Facts { parameters: RATIO, ..find("side_slip").unwrap().facts() }
        }
        fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, memory: &mut Memory) -> Change {
            find("side_slip").unwrap().act(p, step, memory)
        }
    }
    assert!(wrong_unit(&Mislabelled).is_some());
}
