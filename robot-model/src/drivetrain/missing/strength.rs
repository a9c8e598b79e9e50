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
