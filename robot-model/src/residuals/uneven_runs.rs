//! Are some runs off by far more than others?
//!
//! Where only the ends of runs are measured, the noise is learnt from few numbers, and a mechanism that touches only some
//! of the runs passes for noise of all. But noise is the same in all runs. With s_r the sum of the n_r squared whitened
//! innovations of a run (Bartlett's test of equal variances):
//!
//! ```text
//! T = N ln(sum s_r / N) - sum n_r ln(s_r / n_r),  N = sum n_r,   T / C ~ chi squared of R - 1   (1)
//! C = 1 + (sum 1/n_r - 1/N) / (3 (R - 1))
//! ```
//!
//! The runs are divided where s_r/n_r has its widest gap; what all runs on one side have, and none on the other, is
//! what the error depends on.

use std::collections::BTreeSet;

use super::regressor::Regressor;
use crate::effect::composition::Terms;
use crate::estimation::ekf::{FilterObserver, Innovation, whiten};
use crate::estimation::fit::Fitted;
use crate::numeric::distributions::chi_squared;
use crate::numeric::parallel;
use crate::recording::campaign::{Prepared, PreparedRun};

/// Longer recordings show heavy tails number by number.
const ROWS_MAX: usize = 500;
/// Fewer runs do not tell what is usual.
pub(crate) const RUNS_MIN: usize = 6;
/// Significance level of (1).
const P_MAX: f64 = 1e-3;
/// On both sides of the gap the mean square differs by this factor at least.
const TIMES_MIN: f64 = 9.0;
/// A run is never quieter than this share of the mean: few numbers may all be near zero.
const QUIETEST: f64 = 0.02;
/// Spacing of the grid on which runs are said to come to the same place \[m\].
const CELL_M: f64 = 0.3;

/// Some runs are off by far more than others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct UnevenRuns {
    /// What they have and the others have not; else the run itself.
    pub regressor: Regressor,
    /// Probability of runs as unequal by chance.
    pub p_value: f64,
}

/// The squared innovations of one run.
#[derive(Default)]
struct Squares {
    sum: f64,
    rows: f64,
}

impl FilterObserver for Squares {
    fn row(&mut self, innovation: Innovation, _: &[f64]) {
        self.sum += innovation.value * innovation.value / innovation.variance;
        self.rows += 1.0;
    }
}

/// Runs that are off by far more than the others, and these.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Divided {
    /// The places of the runs that are off.
    pub loud: Vec<usize>,
    /// Those of the others.
    pub quiet: Vec<usize>,
    /// Probability of runs as unequal by chance.
    pub p_value: f64,
}

/// Whether some runs are off by far more than others, and which; at least so many are not off.
pub(crate) fn divided(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    quiet_min: usize,
) -> Option<Divided> {
    let fixed = Terms::Fixed(&fitted.terms);
    let squares = parallel::map(&prepared.runs, |run| {
        let mut squares = Squares::default();
        whiten(&run.motion, &run.recording.measured_poses, fixed, &fitted.noise, &mut squares);
        squares
    });
    let rows: f64 = squares.iter().map(|squares| squares.rows).sum();
    let measured = || squares.iter().enumerate().filter(|(_, squares)| squares.rows > 0.0);
    if rows >= ROWS_MAX as f64 || measured().count() < RUNS_MIN {
        return None;
    }
    let mean = squares.iter().map(|squares| squares.sum).sum::<f64>() / rows;
    let mut runs: Vec<(usize, f64, f64)> = measured()
        .map(|(run, squares)| {
            (run, (squares.sum / squares.rows).max(QUIETEST * mean), squares.rows)
        })
        .collect();
    runs.sort_by(|a, b| a.1.total_cmp(&b.1));
    let p_value =
        unequal(&runs.iter().map(|(_, square, rows)| (*square, *rows)).collect::<Vec<_>>());
    let split = (quiet_min..runs.len())
        .max_by(|a, b| (runs[*a].1 / runs[a - 1].1).total_cmp(&(runs[*b].1 / runs[b - 1].1)))?;
    let (quiet, loud) = runs.split_at(split);
    let mean_of = |side: &[(usize, f64, f64)]| {
        side.iter().map(|(_, square, _)| square).sum::<f64>() / side.len() as f64
    };
    let differs = p_value < P_MAX && mean_of(loud) > TIMES_MIN * mean_of(quiet);
    let runs_of = |side: &[(usize, f64, f64)]| side.iter().map(|(run, _, _)| *run).collect();
    differs.then(|| Divided { loud: runs_of(loud), quiet: runs_of(quiet), p_value })
}

/// Whether some runs are off by far more than others, and what they have in common.
pub(crate) fn uneven_runs(prepared: &Prepared, fitted: &Fitted<'_>) -> Option<UnevenRuns> {
    let Divided { loud, quiet, p_value } = divided(prepared, fitted, 1)?;
    let runs_of = |side: &[usize]| side.iter().map(|run| &prepared.runs[*run]).collect::<Vec<_>>();
    Some(UnevenRuns { regressor: common(&runs_of(&loud), &runs_of(&quiet)), p_value })
}

/// The p-value of (1), from the mean square and the number of rows of each run.
fn unequal(runs: &[(f64, f64)]) -> f64 {
    let rows: f64 = runs.iter().map(|(_, rows)| rows).sum();
    let sum: f64 = runs.iter().map(|(square, rows)| square * rows).sum();
    let each: f64 = runs.iter().map(|(square, rows)| rows * square.ln()).sum();
    let freedom = runs.len() - 1;
    let inverse: f64 = runs.iter().map(|(_, rows)| rows.recip()).sum();
    let widened = 1.0 + (inverse - rows.recip()) / (3.0 * freedom as f64);
    chi_squared(freedom, (rows * (sum / rows).ln() - each) / widened)
}

/// What all of these runs have, and none of the others.
fn common(these: &[&PreparedRun], others: &[&PreparedRun]) -> Regressor {
    let divides = |has: fn(&PreparedRun) -> bool| {
        these.iter().all(|run| has(run)) && !others.iter().any(|run| has(run))
    };
    let reverses = |run: &PreparedRun| {
        run.motion
            .steps
            .iter()
            .any(|step| step.since_reversal_m.is_some_and(|path_m| path_m > CELL_M))
    };
    if divides(|run| run.recording.payload_kg != 0.0) {
        return Regressor::Load;
    }
    if divides(reverses) {
        return Regressor::TravelDirection;
    }
    let mut shared = these.iter().map(|run| cells(run)).reduce(|a, b| &a & &b).unwrap_or_default();
    others
        .iter()
        .map(|run| cells(run))
        .for_each(|cells| shared.retain(|cell| !cells.contains(cell)));
    if these.len() > 1 && !shared.is_empty() { Regressor::Place } else { Regressor::Run }
}

/// Where a run came by.
fn cells(run: &PreparedRun) -> BTreeSet<[i64; 2]> {
    let places = run.motion.steps.iter().map(|step| step.place_m);
    places.map(|place_m| place_m.map(|m| (m / CELL_M).round() as i64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explain::explain;
    use crate::tests::synthetic::{ends, push_some_aside};

    #[test]
    fn equal_variances_are_usual_and_a_run_ten_times_as_loud_is_not() {
        let equal: Vec<(f64, f64)> = [0.4, 0.7, 0.9, 1.0, 1.2, 1.5, 1.9].map(|s| (s, 3.0)).to_vec();
        assert!(unequal(&equal) > 0.5, "{}", unequal(&equal));
        let mut loud = equal;
        loud[3].0 = 100.0;
        assert!(unequal(&loud) < P_MAX, "{}", unequal(&loud));
    }

    #[test]
    fn runs_pushed_aside_do_not_pass_for_the_noise_of_all() {
        for seed in 0..4 {
            let sound = explain(&ends(seed)).unwrap().unexplained;
            assert!(!sound.structure, "{sound:?}");
            let mut pushed = ends(seed);
            push_some_aside(&mut pushed);
            let found = explain(&pushed).unwrap().unexplained;
            assert!(found.structure, "{found:?}");
            assert_eq!(found.depends_on, [Regressor::Run]);
        }
    }
}
