//! In which parameters is an expression linear, does it grow without bound, and which values are plausible?
//!
//! All of this is found by evaluating it at a few steps; units are left to `dimensions.rs`.

use super::error::UnboundedWhen;
use super::evaluate::evaluate;
use super::target::{Per, Target};
use super::tree::Tree;
use super::unit::Unit;
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

/// The largest set of parameters in which the expression is linear and without which it vanishes.
pub(super) fn amplitudes(tree: &Tree, count: usize) -> Option<Vec<usize>> {
    let subsets = (1_u32..1 << count)
        .map(|bits| -> Vec<usize> { (0..count).filter(|j| bits & (1 << j) != 0).collect() });
    let mut subsets: Vec<_> = subsets.collect();
    subsets.sort_by_key(|set| core::cmp::Reverse(set.len()));
    let others = [0.83, 1.31, 0.57, 1.71];
    let (a, b) = ([0.41, -0.77, 1.23, 0.29], [-1.1, 0.63, 0.37, -0.91]);
    subsets.into_iter().find(|set| {
        let value = |step: &Step, of: &dyn Fn(usize) -> f64| {
            let at: Vec<f64> =
                (0..count).map(|j| if set.contains(&j) { of(j) } else { others[j] }).collect();
            evaluate(tree, &Jet::parameters(&at), step).value
        };
        let mut finite = 0;
        let linear = sample_steps().iter().all(|step| {
            let (of_a, of_b) = (value(step, &|j| a[j]), value(step, &|j| b[j]));
            let both = value(step, &|j| 2.0 * a[j] + b[j]);
            if !(of_a.is_finite() && of_b.is_finite() && both.is_finite()) {
                return true;
            }
            finite += 1;
            // The rounding errors of sums of such numbers.
            (both - 2.0 * of_a - of_b).abs() <= 1e-9 * (of_a.abs() + of_b.abs() + both.abs())
        });
        linear && finite > 0
    })
}

/// In which motion an expression grows without bound, per second. Every run contains such motions, and they would
/// dominate a fit.
pub(super) fn without_bound(tree: &Tree, per: Per, count: usize) -> Option<UnboundedWhen> {
    // The motion is slowed down to these shares; unbounded growth gives this factor from the first to the second.
    const SLOWER: [f64; 2] = [1e-3, 1e-6];
    const GROWS: f64 = 100.0;
    let amount = |step: &Step| {
        let at = Jet::parameters(&[0.83, 1.31, 0.57, 1.71][..count]);
        let rate = evaluate(tree, &at, step).value;
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
        let at = Jet::parameters(&[0.83, 1.31, 0.57, 1.71]);
        evaluate(tree, &at, &step).by[index].abs()
    });
    let slope = slopes.into_iter().filter(|slope| slope.is_finite()).fold(0.0, f64::max);
    if slope > 0.0 { most / slope } else { most }
}

/// A typical value of this unit for a small robot: 0.3 m, 1 s, 2 kg.
pub(super) fn typical_of(unit: Unit) -> f64 {
    let [m, s, kg] = unit.0;
    0.3_f64.powf(m) * 1.0_f64.powf(s) * 2.0_f64.powf(kg)
}
