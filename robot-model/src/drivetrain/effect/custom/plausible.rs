//! Does an expression of motors grow without bound, and which values are plausible?
//!
//! All of this is found by evaluating it at a few moments.

use core::f64::consts::TAU;

use super::target::MotorTarget;
use super::variables::{VARIABLES, value};
use crate::drivetrain::effect::definition::Moment;
use crate::drivetrain::model::WheelMotor;
use crate::expression::{PLACES, Tree, UnboundedWhen, evaluate};
use crate::numeric::jet::Jet;

/// The motor of these moments.
const MOTOR: WheelMotor =
    WheelMotor { ks_forward_v: 0.5, ks_backward_v: 0.5, kv_v_s_per_m: 24.0, ka_v_s2_per_m: 0.7 };

/// The highest voltage.
const FULL_V: f64 = 12.0;

/// Moments at which an expression is evaluated: ordinary values, no two alike.
pub(super) fn sample_moments() -> [Moment; 4] {
    let moment = |v: f64, other: f64, side: f64, t: f64| Moment {
        side,
        speed_mps: (v, other),
        volts: (24.0 * v + 0.7, 21.0 * other + 0.4),
        full_v: FULL_V,
        turns: 0.37 * t,
        t_s: 40.0 * t,
        since_pause_s: f64::INFINITY,
        heading_rad: 0.6 * t,
    };
    [
        moment(0.31, 0.23, 1.0, 3.1),
        moment(0.17, -0.13, -1.0, 1.7),
        moment(-0.23, -0.29, 1.0, 4.3),
        moment(0.27, 0.35, -1.0, 2.3),
    ]
}

/// The values of all variables at the sample moments, and at some near rest.
pub(super) fn samples() -> Vec<Vec<f64>> {
    let values =
        |moment: Moment| (0..VARIABLES.len()).map(|index| value(index, &moment, &MOTOR)).collect();
    sample_moments().into_iter().chain(moments_all_over().step_by(11)).map(values).collect()
}

/// In which motion an expression grows without bound. Every experiment contains such motions, and they would dominate a fit.
pub(super) fn without_bound(tree: &Tree, count: usize) -> Option<UnboundedWhen> {
    // Speeds, or voltages, become these shares; unbounded growth gives this factor from the first to the second.
    const LESS: [f64; 2] = [1e-3, 1e-6];
    const GROWS: f64 = 100.0;
    let at = Jet::parameters(&PLACES[..count]);
    let amount =
        |moment: &Moment| evaluate(tree, &at, &|index| value(index, moment, &MOTOR)).value.abs();
    let grows = |like: &dyn Fn(&Moment, f64) -> Moment| {
        sample_moments().iter().any(|moment| {
            let [less, least] = LESS.map(|share| amount(&like(moment, share)));
            less.is_finite() && least > GROWS * less
        })
    };
    let scaled = |pair: (f64, f64), share: f64| (share * pair.0, share * pair.1);
    if grows(&|moment, share| Moment { speed_mps: scaled(moment.speed_mps, share), ..*moment }) {
        Some(UnboundedWhen::AtRest)
    } else if grows(&|moment, share| Moment { volts: scaled(moment.volts, share), ..*moment }) {
        Some(UnboundedWhen::WithoutVoltage)
    } else {
        None
    }
}

/// Moments all over what motors do, so that an expression that acts near rest, or at one angle, acts in some of them.
fn moments_all_over() -> impl Iterator<Item = Moment> {
    const SPEEDS_MPS: [f64; 8] = [0.001, 0.004, 0.015, 0.04, 0.08, 0.15, 0.22, 0.31];
    const ANGLES: u32 = 48;
    SPEEDS_MPS.into_iter().flat_map(|speed| [speed, -speed]).flat_map(|v| {
        (0..ANGLES).map(move |i| {
            // Each speed at other angles, times and voltages.
            let share = (f64::from(i) + 7.3 * v.abs().ln().fract().abs()) / f64::from(ANGLES);
            let other = v * (1.0 - 2.0 * (5.0 * share).fract());
            Moment {
                side: if i % 2 == 0 { 1.0 } else { -1.0 },
                speed_mps: (v, other),
                volts: (24.0 * v + 0.7 * v.signum() + 2.0 * share, 24.0 * other + share),
                full_v: FULL_V,
                turns: share,
                t_s: 200.0 * share,
                since_pause_s: f64::INFINITY,
                heading_rad: TAU * (3.0 * share).fract(),
            }
        })
    })
}

/// The amplitude that comes to this voltage where it acts most.
pub(super) fn amplitude_of(volts: f64, tree: &Tree, index: usize, target: MotorTarget) -> f64 {
    let at = Jet::parameters(&PLACES);
    let slopes = moments_all_over().map(|moment| {
        let by = evaluate(tree, &at, &|variable| value(variable, &moment, &MOTOR)).by[index];
        by.abs() * target.volts(moment.speed_mps.0)
    });
    let slope = slopes.filter(|slope| slope.is_finite()).fold(0.0, f64::max);
    if slope > 0.0 { volts / slope } else { volts }
}
