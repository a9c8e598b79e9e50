//! Do the residuals have heavier tails than a normal distribution, and do these depend on the motion?
//!
//! Wrong time stamps, frames that come twice, motion blur: none of them moves the track to one side, so no
//! effect, known or auxiliary, finds them. They give the whitened innovations z heavy tails, and heavier ones where the
//! robot is fast:
//!
//! ```text
//! kappa = mean z^4 / (mean z^2)^2 - 3,   for normal z 0 +- sqrt(24/n)                      (1)
//! w     = min(z^2, 9),  E w = mean w (1 + beta (x - mean x)),  x = |v| / max |v|,
//!                                                           or |omega| / max |omega|      (2)
//! ```

use super::regressor::Regressor;
use crate::effect::composition::Terms;
use crate::estimation::ekf::{FilterObserver, Innovation, whiten};
use crate::estimation::fit::Fitted;
use crate::numeric::distributions::chi_squared;
use crate::numeric::parallel;
use crate::recording::campaign::{Prepared, PreparedRun};

/// No sound sensor has tails as heavy as this kappa of (1). A two-sided exponential distribution has 3.
const KURTOSIS_MIN: f64 = 1.5;
/// Tails as heavy as this outweigh whatever else is found.
const KURTOSIS_DOMINATES: f64 = 3.0;
/// The noise depends on speed if w of (2) grows from rest to top speed by this share of its mean, beta.
const GROWTH_MIN: f64 = 0.3;
/// z^2 is clipped at three sigma: larger values are too rare for their mean to mean anything.
const CLIP: f64 = 9.0;
/// Fewer numbers do not show tails.
const ROWS_MIN: usize = 500;

/// Heavy tails, and what they depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HeavyTails {
    pub regressor: Regressor,
    /// Probability of tails as heavy by chance.
    pub p_value: f64,
    /// The tails are so heavy that they may well cause whatever else is found in the residuals.
    pub dominates: bool,
}

/// z^2 of each measured number, with |v| and |omega|.
struct Squares<'r> {
    run: &'r PreparedRun,
    rows: Vec<(f64, [f64; 2])>,
}

impl FilterObserver for Squares<'_> {
    fn row(&mut self, innovation: Innovation, _: &[f64]) {
        let step = &self.run.motion.steps[innovation.step];
        let squared = innovation.value * innovation.value / innovation.variance;
        let motion = [step.speed_mps().abs(), step.turn_rate_rad_s().abs()];
        self.rows.push((squared, motion));
    }
}

/// The heavy tails of the residuals, if they have any.
pub(crate) fn heavy_tails(prepared: &Prepared, fitted: &Fitted<'_>) -> Option<HeavyTails> {
    let fixed = Terms::Fixed(&fitted.terms);
    let runs = parallel::map(&prepared.runs, |run| {
        let mut squares = Squares { run, rows: Vec::new() };
        whiten(&run.motion, &run.recording.measured_poses, fixed, &fitted.noise, &mut squares);
        squares.rows
    });
    let rows = runs.concat();
    if rows.len() < ROWS_MIN {
        return None;
    }
    let count = rows.len() as f64;
    let mean = rows.iter().map(|(squared, _)| squared).sum::<f64>() / count;
    let fourth = rows.iter().map(|(squared, _)| squared * squared).sum::<f64>() / count;
    let kurtosis = fourth / (mean * mean) - 3.0;
    if kurtosis < KURTOSIS_MIN {
        return None;
    }
    let regressors = [Regressor::Speed, Regressor::TurnRate].into_iter().enumerate();
    let grows = regressors
        .filter_map(|(index, regressor)| Some((growth(&rows, index)?, regressor)))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(grows, _)| *grows > GROWTH_MIN);
    let p_value = chi_squared(1, kurtosis * kurtosis * count / 24.0) / 2.0;
    // Heavy tails that do not depend on the motion come at certain times.
    let regressor = grows.map_or(Regressor::TimeInRun, |(_, regressor)| regressor);
    Some(HeavyTails { regressor, p_value, dominates: kurtosis > KURTOSIS_DOMINATES })
}

/// beta of (2); `None` if the regressor is the same throughout.
fn growth(rows: &[(f64, [f64; 2])], regressor: usize) -> Option<f64> {
    let count = rows.len() as f64;
    let most = rows.iter().map(|(_, motion)| motion[regressor]).fold(0.0, f64::max);
    let middle = rows.iter().map(|(_, motion)| motion[regressor]).sum::<f64>() / (count * most);
    let centred = |motion: &[f64; 2]| motion[regressor] / most - middle;
    let spread: f64 = rows.iter().map(|(_, motion)| centred(motion).powi(2)).sum();
    let mean = rows.iter().map(|(squared, _)| squared.min(CLIP)).sum::<f64>() / count;
    let covariance =
        |(squared, motion): &(f64, [f64; 2])| (squared.min(CLIP) - mean) * centred(motion);
    let sum: f64 = rows.iter().map(covariance).sum();
    let growth = sum / (spread * mean);
    growth.is_finite().then_some(growth)
}
