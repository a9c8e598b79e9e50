//! Noise that depends on the motion: poses that are far off now and then, the more so the faster the robot.
//!
//! Time stamps that are off, pictures that come twice, a shutter that smears: none of them moves the track
//! to one side, so no effect and no probe finds them. They give the whitened innovations z tails that no
//! normal distribution has, and make them greater where the robot is fast:
//!
//! ```text
//! kappa = mean z^4 / (mean z^2)^2 - 3,   by chance 0 +- sqrt(24/n)                        (1)
//! w     = min(z^2, 9),  E w = mean w (1 + beta (x - mean x)),  x = |v| / max |v|,
//!                                                           or |omega| / max |omega|      (2)
//! ```

use super::regressor::Regressor;
use crate::effect::composition::Terms;
use crate::estimation::ekf::{Innovation, Sink, whiten};
use crate::estimation::fit::Fitted;
use crate::numeric::distributions::chi_squared;
use crate::numeric::parallel;
use crate::recording::campaign::{Prepared, PreparedRun};

/// Tails as heavy as these, kappa of (1), are no sound sensor's; an exponential distribution has 3.
const TAILS_MIN: f64 = 1.5;
/// Tails as heavy as these outweigh whatever else is found.
const TAILS_RULE: f64 = 3.0;
/// From rest to top speed w is to grow by this much of its mean, beta of (2).
const GROWTH_MIN: f64 = 0.3;
/// Of three sigma and more it is known that they are rare, not how large.
const CLIP: f64 = 9.0;
/// So many numbers it takes to see tails.
const ROWS_MIN: usize = 500;

/// What the noise depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unevenness {
    pub regressor: Regressor,
    /// By chance tails as heavy.
    pub p_value: f64,
    /// The tails are so heavy that what else is found in the residuals may well be theirs.
    pub rules: bool,
}

/// z^2 of each number measured, with |v| and |omega|.
struct Squares<'r> {
    run: &'r PreparedRun,
    rows: Vec<(f64, [f64; 2])>,
}

impl Sink for Squares<'_> {
    fn row(&mut self, innovation: Innovation, _: &[f64]) {
        let step = &self.run.motion.steps[innovation.step];
        let squared = innovation.value * innovation.value / innovation.variance;
        let motion = [step.speed_mps().abs(), step.turn_rate_rad_s().abs()];
        self.rows.push((squared, motion));
    }
}

/// What the noise depends on, if its tails are heavy.
pub(crate) fn unevenness(prepared: &Prepared, fitted: &Fitted<'_>) -> Option<Unevenness> {
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
    let mean = rows.iter().map(|it| it.0).sum::<f64>() / count;
    let fourth = rows.iter().map(|it| it.0 * it.0).sum::<f64>() / count;
    let tails = fourth / (mean * mean) - 3.0;
    if tails < TAILS_MIN {
        return None;
    }
    let regressors = [Regressor::Speed, Regressor::TurnRate].into_iter().enumerate();
    let grows = regressors
        .filter_map(|(index, regressor)| Some((growth(&rows, index)?, regressor)))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(grows, _)| *grows > GROWTH_MIN);
    let p_value = chi_squared(1, tails * tails * count / 24.0) / 2.0;
    // What happens now and then without regard to the motion happens at times.
    let regressor = grows.map_or(Regressor::TimeInRun, |(_, regressor)| regressor);
    Some(Unevenness { regressor, p_value, rules: tails > TAILS_RULE })
}

/// beta of (2); `None` if the regressor is the same throughout.
fn growth(rows: &[(f64, [f64; 2])], regressor: usize) -> Option<f64> {
    let count = rows.len() as f64;
    let most = rows.iter().map(|it| it.1[regressor]).fold(0.0, f64::max);
    let middle = rows.iter().map(|it| it.1[regressor]).sum::<f64>() / (count * most);
    let about = |it: &(f64, [f64; 2])| it.1[regressor] / most - middle;
    let spread: f64 = rows.iter().map(|it| about(it).powi(2)).sum();
    let mean = rows.iter().map(|it| it.0.min(CLIP)).sum::<f64>() / count;
    let sum: f64 = rows.iter().map(|it| (it.0.min(CLIP) - mean) * about(it)).sum();
    let growth = sum / (spread * mean);
    growth.is_finite().then_some(growth)
}
