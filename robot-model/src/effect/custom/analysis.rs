//! Does an expression grow without bound, and which values are plausible?
//!
//! All of this is found by evaluating it at a few steps.

use super::target::{Per, Target};
use super::variables::{VARIABLES, value};
use crate::expression::{PLACES, Tree, UnboundedWhen, evaluate};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::Jet;
use crate::recording::motion::Step;

/// Steps at which an expression is evaluated: ordinary values, no two alike.
pub(super) fn sample_steps() -> [Step; 3] {
    let step = |v: f64, omega: f64, a: f64, t: f64| Step {
        t_s: 0.4 * t,
        dt_s: 0.1,
        clock_s: 90.0 * t,
        phi_rad: WheelPair::new(0.7 * t, 1.1 * t),
        dphi_rad: WheelPair::new(0.21, 0.34),
        wheel_speed_mps: WheelPair::new(v - 0.186 * omega, v + 0.186 * omega),
        wheel_accel_mps2: WheelPair::new(0.9 * a, 1.2 * a),
        path_m: 0.3 * t,
        since_reversal_m: Some(0.1 * t),
        payload_kg: 0.5 * t,
        wheel_radius_m: 0.036,
        track_width_m: 0.372,
        gear_reduction: 1.0,
        heading_rad: 0.6 * t,
        place_m: [0.2 * t, -0.1 * t],
    };
    [step(0.31, 0.72, 0.23, 3.1), step(0.17, -1.3, -0.41, 1.7), step(-0.23, 0.37, 0.11, 4.3)]
}

/// The values of all variables at the sample steps.
pub(super) fn samples() -> Vec<Vec<f64>> {
    let values = |step: &Step| (0..VARIABLES.len()).map(|index| value(index, step)).collect();
    sample_steps().iter().map(values).collect()
}

/// In which motion an expression grows without bound, per second. Every run contains such motions, and they would
/// dominate a fit.
pub(super) fn without_bound(tree: &Tree, per: Per, count: usize) -> Option<UnboundedWhen> {
    // The motion is slowed down to these shares; unbounded growth gives this factor from the first to the second.
    const SLOWER: [f64; 2] = [1e-3, 1e-6];
    const GROWS: f64 = 100.0;
    let amount = |step: &Step| {
        let at = Jet::parameters(&PLACES[..count]);
        let rate = evaluate(tree, &at, &|index| value(index, step)).value;
        let times = match per {
            Per::Second => 1.0,
            Per::Metre => step.speed_mps(),
            Per::Radian => step.turn_rate_rad_s(),
        };
        (rate * times).abs()
    };
    let slowly = |step: &Step, share: f64| Step {
        dphi_rad: step.dphi_rad.map(|dphi| share * dphi),
        wheel_speed_mps: step.wheel_speed_mps.map(|speed| share * speed),
        ..*step
    };
    let evenly = |step: &Step, share: f64| Step {
        wheel_accel_mps2: step.wheel_accel_mps2.map(|accel| share * accel),
        ..*step
    };
    let grows = |like: &dyn Fn(&Step, f64) -> Step| {
        sample_steps().iter().any(|step| {
            let [slow, slower] = SLOWER.map(|share| amount(&like(step, share)));
            slow.is_finite() && slower > GROWS * slow
        })
    };
    if grows(&slowly) {
        Some(UnboundedWhen::AtRest)
    } else if grows(&evenly) {
        Some(UnboundedWhen::AtConstantSpeed)
    } else {
        None
    }
}

/// The limit of an amplitude. A larger effect is visible to the naked eye: a fifth of the path, or a fifth of a
/// radian per metre or second.
pub(super) fn plausible_limit(tree: &Tree, index: usize, target: Target, per: Per) -> f64 {
    let most: f64 = match (target, per) {
        (Target::Dtheta, _) | (_, Per::Metre) => 0.2,
        (_, Per::Second | Per::Radian) => 0.1,
    };
    let slopes = sample_steps().map(|step| {
        let at = Jet::parameters(&PLACES);
        evaluate(tree, &at, &|variable| value(variable, &step)).by[index].abs()
    });
    let slope = slopes.into_iter().filter(|slope| slope.is_finite()).fold(0.0, f64::max);
    if slope > 0.0 { most / slope } else { most }
}
