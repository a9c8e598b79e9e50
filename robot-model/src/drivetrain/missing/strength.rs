//! Is an effect that is weak, or that shows in few experiments, more than chance?
//!
//! Friction at rest shows where a voltage rises slowly, and a warm winding in the experiments after a pause: signs of four gains
//! are alike by chance once in sixteen times, however large they are. A delay of 2 ms is so little beside what a caster leaves
//! that half of the experiments lose. Such an effect is judged by its strength: all its amplitudes times one number, which is 1
//! in the fit and 0 without the effect, and whose scatter over the experiments is known:
//!
//! ```text
//! s^2 = s_each s_jackknife                     variance of the strength                                        (1)
//! t^2 = min(1, S_fell / S_linear) / s^2        against k F(k, df), k amplitudes                                (2)
//! ```
//!
//! (1): errors of an experiment that tells the share h of the strength look (1 - h) times too small among what is left, and
//! 1 / (1 - h) times too large to the jackknife; their mean is right (Bell and McCaffrey, Survey Methodology 28 (2002), 169,
//! section 3). (2): no sum of k amplitudes is beyond chance by less than Scheffe's bound. A squared error that fell by less than
//! half of what the strength promised is no evidence, and play, which acts in steps, is not judged so at all. The number of
//! shapes that were tried multiplies the chance, and an amplitude that is never negative halves it.

use nalgebra::{DMatrix, DVector};

use super::experiment::excitation;
use super::least_squares::{Fitted, Problem};
use crate::drivetrain::effect::{MotorEffect, MotorParameter, MotorRole};
use crate::drivetrain::intervals::{Intervals, Share};
use crate::numeric::distributions::fisher;

/// An effect whose squared error falls by less than this share of what its strength promises is far from linear, and cannot be
/// judged by its strength.
const LINEAR_MIN: f64 = 0.5;

/// Whether an effect has one amplitude, which is never negative: it can resemble chance in one way only.
pub(super) fn is_of_one_sign(effect: &dyn MotorEffect) -> bool {
    let mut amplitudes = amplitudes(effect);
    amplitudes.next().is_some_and(|first| first.low == 0.0) && amplitudes.next().is_none()
}

fn amplitudes(effect: &dyn MotorEffect) -> impl Iterator<Item = &MotorParameter> {
    effect.facts().parameters.iter().filter(|parameter| parameter.role == MotorRole::Amplitude)
}

/// How often chance gives an effect of a model this strength or more. `before` is the model without it.
pub(super) fn chance(problem: &Problem<'_>, before: &Fitted, fitted: &Fitted, index: usize) -> f64 {
    let effect = &*fitted.model.effects[index];
    let Some((squared_t, degrees)) = squared_t(problem, before, fitted, index) else { return 1.0 };
    let tried = effect.starts(&excitation(problem.robot, &problem.experiments)).len() as f64;
    let ways = if is_of_one_sign(effect) { 0.5 * tried } else { tried };
    (ways * fisher(amplitudes(effect).count(), degrees, squared_t)).min(1.0)
}

/// (2), and its degrees of freedom; None where the effect cannot be judged so.
fn squared_t(
    problem: &Problem<'_>,
    before: &Fitted,
    fitted: &Fitted,
    index: usize,
) -> Option<(f64, f64)> {
    let facts = fitted.model.effects[index].facts();
    let first = fitted.model.first_of(index);
    if fitted.model.effects[index].play(&fitted.model.at[first..]).is_some() {
        return None;
    }
    let len = facts.parameters.len();
    let count = fitted.model.at.len();
    // The others as they are; of the effect's own only this: how the travel changes with its strength.
    let mut to_strength = DMatrix::zeros(count, count - len + 1);
    let others = (0..count).filter(|i| !(first..first + len).contains(i));
    others.enumerate().for_each(|(column, i)| to_strength[(i, column)] = 1.0);
    for (i, parameter) in facts.parameters.iter().enumerate() {
        if parameter.role == MotorRole::Amplitude {
            to_strength[(first + i, count - len)] = fitted.model.at[first + i];
        }
    }
    let narrowed = |gram: &DMatrix<f64>| to_strength.tr_mul(&(gram * &to_strength));
    let shares: Vec<Share> = fitted
        .shares()
        .into_iter()
        .map(|share| Share {
            gram: narrowed(&share.gram),
            gradient: to_strength.tr_mul(&share.gradient),
        })
        .collect();
    let mut strength = DVector::zeros(count - len + 1);
    strength[count - len] = 1.0;
    let gram = narrowed(&fitted.sums(problem).0);
    let towards = gram.clone().cholesky()?.solve(&strength);
    let fell = problem.weighted(&before.costs) - problem.weighted(&fitted.costs);
    // The strength is 1: so much a straight line promises.
    let promised = 1.0 / towards.dot(&strength);
    if fell < LINEAR_MIN * promised {
        return None;
    }
    let (jackknife, degrees) = Intervals::new(&gram, &shares)?.standard_error(&strength);
    let each = shares.iter().map(|share| share.gradient.dot(&towards).powi(2)).sum::<f64>().sqrt();
    Some(((fell / promised).min(1.0) / (jackknife * each), degrees))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drivetrain::effect::KnownMotorEffect;
    use crate::drivetrain::missing::experiment::{Experiment, KnownRobot};
    use crate::drivetrain::missing::least_squares::Model;
    use crate::drivetrain::missing::modes::Modes;
    use crate::drivetrain::missing::selection::{Judged, P_MAX, gain, gain_by};
    use crate::drivetrain::recording::{Sample, VoltageRecording};
    use crate::kinematics::WheelPair;

    const ROBOT: KnownRobot = KnownRobot {
        wheel_radius_m: 0.036,
        track_width_m: 0.372,
        gear_reduction: 1.0,
        meters_per_count: 1e-6,
    };
    /// So many experiments, of which the first ones show friction at rest.
    const EXPERIMENTS: usize = 24;
    const SHOW: usize = 4;

    fn experiment() -> Experiment {
        let zero = WheelPair::both(0.0);
        let samples =
            (0..3).map(|i| Sample { t_s: f64::from(i), travel_m: zero, applied_vs: zero });
        let recording = VoltageRecording::new(samples).unwrap();
        Experiment { recording, started_s: 0.0, heading_rad: 0.0, held_out: false }
    }

    fn problem(experiments: &[Experiment]) -> Problem<'_> {
        Problem {
            robot: &ROBOT,
            experiments: experiments.iter().collect(),
            weights: Modes::EQUAL,
            pause_end_s: f64::INFINITY,
            full_v: 12.0,
        }
    }

    /// An effect at these parameters, which moves the travel of the experiments that show it by `moved_m` per unit of the first
    /// one; each of them is off by this share of it, to and fro.
    fn fitted(id: &str, p: &[f64], moved_m: f64, off: f64) -> Fitted {
        let mut at = vec![0.5, 24.0, 0.6, 0.1, 0.0, 0.0];
        at.extend_from_slice(p);
        let model = Model { effects: vec![KnownMotorEffect::find(id, &[]).unwrap()], at };
        let len = model.at.len();
        let columns = (0..EXPERIMENTS).map(|i| {
            let mut columns = DMatrix::zeros(6, len);
            columns.column_mut(if i < SHOW { 6 } else { 0 }).fill(moved_m);
            columns
        });
        let residuals = (0..EXPERIMENTS).map(|i| {
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            DVector::from_element(6, sign * off * p[0] * moved_m)
        });
        let costs = (0..EXPERIMENTS).map(|i| Modes::both(if i % 2 == 0 { 0.9e-8 } else { 1.1e-8 }));
        Fitted {
            model,
            costs: costs.collect(),
            residuals: residuals.collect(),
            columns: columns.collect(),
        }
    }

    /// The same without the effect: the experiments that show it left so much, and of the others half gains what half loses.
    fn without(after: &Fitted, left_m2: f64) -> Fitted {
        let each = (0..EXPERIMENTS).map(|i| Modes::both(if i < SHOW { left_m2 } else { 1e-8 }));
        Fitted { costs: each.collect(), ..after.clone() }
    }

    fn judged(fitted: Fitted) -> Judged {
        Judged { costs: fitted.costs.clone(), fitted }
    }

    #[test]
    fn four_large_gains_that_agree_in_strength_matter_and_their_signs_do_not_tell() {
        let experiments = vec![experiment(); EXPERIMENTS];
        let problem = problem(&experiments);
        let friction = |off: f64| fitted("static_friction", &[0.3], 1e-3, off);
        let before = judged(without(&friction(0.03), 1e-6));
        let agree = judged(friction(0.03));
        let by_signs = gain(&problem, &before.costs, &agree.costs);
        assert!(by_signs.p_value > P_MAX && by_signs.less > 0.2, "{by_signs:?}");
        let by_strength = gain_by(&problem, &before, &agree, 0);
        assert!(by_strength.matters(&problem), "{by_strength:?}");
        // As large, and of both signs.
        let scattered = gain_by(&problem, &before, &judged(friction(3.0)), 0);
        assert!(!scattered.matters(&problem), "{scattered:?}");
    }

    /// Six hundredths of the error and 0.02 mm, as of a delay of 2 ms: much less than a slope that bends to a caster.
    #[test]
    fn a_weak_effect_of_one_sign_matters_by_its_strength_and_one_of_two_amplitudes_does_not() {
        let experiments = vec![experiment(); EXPERIMENTS];
        let problem = problem(&experiments);
        let of = |id: &str, p: &[f64]| {
            let after = fitted(id, p, 5e-5 / p[0], 0.4);
            gain_by(&problem, &judged(without(&after, 1.8e-8)), &judged(after), 0)
        };
        let delay = of("transport_delay", &[2e-3]);
        assert!(delay.p_value > P_MAX && (0.05..0.07).contains(&delay.less), "{delay:?}");
        assert!(delay.matters(&problem), "{delay:?}");
        let slope = of("load_torque", &[0.3, 0.0]);
        assert!(!slope.matters(&problem), "{slope:?}");
    }

    #[test]
    fn the_chance_counts_signs_and_shapes_and_amplitudes() {
        let experiments = vec![experiment(); EXPERIMENTS];
        let problem = problem(&experiments);
        let of = |id: &str, p: &[f64]| {
            let after = fitted(id, p, 1e-3, 0.3);
            chance(&problem, &without(&after, 1e-6), &after, 0)
        };
        let one_sign = of("static_friction", &[0.3]);
        // Three shapes of friction that falls with speed.
        let shapes = of("stribeck", &[0.3, 0.1, 1.2]) / one_sign;
        assert!((shapes - 3.0).abs() < 1e-3, "{shapes} {one_sign}");
        // Two amplitudes of either sign: twice, and Scheffe's bound.
        let amplitudes = of("load_torque", &[0.3, 0.0]) / one_sign;
        assert!(amplitudes > 2.5, "{amplitudes} {one_sign}");
    }

    #[test]
    fn an_error_that_falls_by_less_than_half_of_what_the_strength_promises_is_no_evidence() {
        let experiments = vec![experiment(); EXPERIMENTS];
        let problem = problem(&experiments);
        let after = fitted("static_friction", &[0.3], 1e-3, 0.03);
        // 24 residuals of 0.3 mm are promised: 2.2e-6 m^2.
        let of = |left_m2: f64| chance(&problem, &without(&after, left_m2), &after, 0);
        let (promised, two_thirds, third) = (of(2.9e-7), of(2.0e-7), of(1.0e-7));
        assert!(promised < two_thirds && two_thirds < 0.01, "{promised} {two_thirds}");
        assert_eq!(third, 1.0);
        let play = fitted("backlash", &[0.3, 0.3], 1e-3, 0.03);
        assert_eq!(chance(&problem, &without(&play, 2.9e-7), &play, 0), 1.0);
    }
}
