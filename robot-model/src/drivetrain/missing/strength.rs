//! Is an effect that shows in few experiments more than chance?
//!
//! Friction at rest shows where a voltage rises slowly, and a warm winding in the experiments after a pause: signs of four gains
//! are alike by chance once in sixteen times, however large they are. Such an effect is judged by its strength: all its amplitudes
//! times one number, which is 1 in the fit and 0 without the effect, and whose scatter over the experiments is known.

use nalgebra::{DMatrix, DVector};

use super::least_squares::{Fitted, Problem};
use crate::drivetrain::effect::MotorRole;
use crate::drivetrain::intervals::{Intervals, Share};

/// How often chance gives an effect of a model this strength or more.
pub(super) fn chance(problem: &Problem<'_>, fitted: &Fitted, index: usize) -> f64 {
    let facts = fitted.model.effects[index].facts();
    let (first, len) = (fitted.model.first_of(index), facts.parameters.len());
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
    let intervals = Intervals::new(&narrowed(&fitted.sums(problem).0), &shares);
    intervals.map_or(1.0, |intervals| intervals.chance(&strength, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drivetrain::effect::find;
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

    /// Friction at rest of 0.3 V, each of the experiments that show it off by this share of it, to and fro.
    fn fitted(off: f64) -> Fitted {
        let model = Model {
            effects: vec![find("static_friction").unwrap()],
            at: vec![0.5, 24.0, 0.6, 0.1, 0.0, 0.0, 0.3],
        };
        let columns = (0..EXPERIMENTS).map(|i| {
            let mut columns = DMatrix::zeros(6, 7);
            columns.column_mut(if i < SHOW { 6 } else { 0 }).fill(1e-3);
            columns
        });
        let residuals = (0..EXPERIMENTS).map(|i| {
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            DVector::from_element(6, sign * off * 0.3 * 1e-3)
        });
        let costs = (0..EXPERIMENTS).map(|i| Modes::both(if i % 2 == 0 { 0.9e-8 } else { 1.1e-8 }));
        Fitted {
            model,
            costs: costs.collect(),
            residuals: residuals.collect(),
            columns: columns.collect(),
        }
    }

    /// Four experiments gain a hundredfold, and of the others one half gains what the other half loses.
    #[test]
    fn four_large_gains_that_agree_in_strength_matter_and_their_signs_do_not_tell() {
        let experiments = vec![experiment(); EXPERIMENTS];
        let problem = Problem {
            robot: &ROBOT,
            experiments: experiments.iter().collect(),
            weights: Modes::EQUAL,
            pause_end_s: f64::INFINITY,
        };
        let judged = |off: f64| {
            let fitted = fitted(off);
            Judged { costs: fitted.costs.clone(), fitted }
        };
        let mut before = judged(0.03);
        before.costs =
            (0..EXPERIMENTS).map(|i| Modes::both(if i < SHOW { 1e-6 } else { 1e-8 })).collect();
        let agree = judged(0.03);
        let by_signs = gain(&problem, &before.costs, &agree.costs);
        assert!(by_signs.p_value > P_MAX && by_signs.less > 0.2, "{by_signs:?}");
        let by_strength = gain_by(&problem, &before, &agree, 0);
        assert!(by_strength.matters(&problem), "{by_strength:?}");
        // As large, and of both signs.
        let scattered = gain_by(&problem, &before, &judged(3.0), 0);
        assert!(!scattered.matters(&problem), "{scattered:?}");
    }
}
