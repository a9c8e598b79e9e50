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
//!
//! Whole tracks have so many innovations that s_r/n_r of a single run says whether it stands out: without anything missing,
//! it scatters by sqrt(2/n_r). But no noise model is exact, so that alone makes every long run stand out:
//!
//! ```text
//! s_r/n_r > 1.35 m  and  s_r/n_r > m (1 + 5 sqrt(2/n_r)),   m the median of s_r/n_r over the runs             (2)
//! ```

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
/// (2): how far a run of a whole track stands out at least, and by how many of its standard deviations.
const STANDS_OUT: f64 = 1.35;
const STANDS_OUT_SIGMAS: f64 = 5.0;
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
    /// Whether each of those that are off is so beyond chance.
    pub each_beyond_chance: bool,
}

impl Divided {
    /// What the runs that are off have and the others have not; else the run itself.
    pub fn regressor(&self, prepared: &Prepared) -> Regressor {
        let [loud, quiet] = [&self.loud, &self.quiet]
            .map(|side| side.iter().map(|run| &prepared.runs[*run]).collect::<Vec<_>>());
        common(&loud, &quiet)
    }
}

/// Whether some runs are off by far more than others, and which; enough are not off to be explained by themselves.
pub(crate) fn set_apart(prepared: &Prepared, fitted: &Fitted<'_>) -> Option<Divided> {
    let runs = mean_squares(prepared, fitted);
    if are_tracks(&runs) { standing_out(&runs) } else { Some(divided(runs, RUNS_MIN)?.0) }
}

/// Whether so many numbers are measured that each run shows by itself whether it stands out.
fn are_tracks(runs: &[MeanSquare]) -> bool {
    runs.iter().map(|run| run.rows).sum::<f64>() >= ROWS_MAX as f64
}

/// What the widest gap divides, if (1) says that the runs are unequal, with its p-value; at least so many are quiet.
fn divided(mut runs: Vec<MeanSquare>, quiet_min: usize) -> Option<(Divided, f64)> {
    if runs.len() < RUNS_MIN {
        return None;
    }
    let rows: f64 = runs.iter().map(|run| run.rows).sum();
    let mean = runs.iter().map(|run| run.mean * run.rows).sum::<f64>() / rows;
    runs.iter_mut().for_each(|run| run.mean = run.mean.max(QUIETEST * mean));
    let p_value = unequal(&runs);
    let split = (quiet_min..runs.len()).max_by(|a, b| {
        let gap = |run: usize| runs[run].mean / runs[run - 1].mean;
        gap(*a).total_cmp(&gap(*b))
    })?;
    let (quiet, loud) = runs.split_at(split);
    let mean_of =
        |side: &[MeanSquare]| side.iter().map(|run| run.mean).sum::<f64>() / side.len() as f64;
    let differs = p_value < P_MAX && mean_of(loud) > TIMES_MIN * mean_of(quiet);
    let (loud, quiet, each_beyond_chance) = (places(loud), places(quiet), false);
    differs.then_some((Divided { loud, quiet, each_beyond_chance }, p_value))
}

/// The runs that stand out by (2), if enough do not.
fn standing_out(runs: &[MeanSquare]) -> Option<Divided> {
    let median = runs.get(runs.len() / 2)?.mean;
    let (loud, quiet): (Vec<_>, Vec<_>) =
        runs.iter().copied().partition(|run| stands_out(run, median));
    (!loud.is_empty() && quiet.len() >= RUNS_MIN).then(|| Divided {
        loud: places(&loud),
        quiet: places(&quiet),
        each_beyond_chance: true,
    })
}

/// (2).
fn stands_out(run: &MeanSquare, median: f64) -> bool {
    let by_chance = 1.0 + STANDS_OUT_SIGMAS * (2.0 / run.rows).sqrt();
    run.mean > median * by_chance.max(STANDS_OUT)
}

/// The mean squared innovation of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MeanSquare {
    /// The run's place.
    run: usize,
    mean: f64,
    rows: f64,
}

fn places(runs: &[MeanSquare]) -> Vec<usize> {
    runs.iter().map(|run| run.run).collect()
}

/// Those of the runs that were measured, quietest first.
fn mean_squares(prepared: &Prepared, fitted: &Fitted<'_>) -> Vec<MeanSquare> {
    let fixed = Terms::Fixed(&fitted.terms);
    let squares = parallel::map(&prepared.runs, |run| {
        let mut squares = Squares::default();
        whiten(&run.motion, &run.recording.measured_poses, fixed, &fitted.noise, &mut squares);
        squares
    });
    let measured = squares.iter().enumerate().filter(|(_, squares)| squares.rows > 0.0);
    let mut runs: Vec<MeanSquare> = measured
        .map(|(run, Squares { sum, rows })| MeanSquare { run, mean: sum / rows, rows: *rows })
        .collect();
    runs.sort_by(|a, b| a.mean.total_cmp(&b.mean));
    runs
}

/// Whether some runs are off by far more than others, and what they have in common.
pub(crate) fn uneven_runs(prepared: &Prepared, fitted: &Fitted<'_>) -> Option<UnevenRuns> {
    let runs = mean_squares(prepared, fitted);
    let (divided, p_value) = if are_tracks(&runs) { None } else { divided(runs, 1) }?;
    Some(UnevenRuns { regressor: divided.regressor(prepared), p_value })
}

/// The p-value of (1).
fn unequal(runs: &[MeanSquare]) -> f64 {
    let rows: f64 = runs.iter().map(|run| run.rows).sum();
    let sum: f64 = runs.iter().map(|run| run.mean * run.rows).sum();
    let each: f64 = runs.iter().map(|run| run.rows * run.mean.ln()).sum();
    let freedom = runs.len() - 1;
    let inverse: f64 = runs.iter().map(|run| run.rows.recip()).sum();
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
        let of = |mean: f64| MeanSquare { run: 0, mean, rows: 3.0 };
        let equal: Vec<MeanSquare> = [0.4, 0.7, 0.9, 1.0, 1.2, 1.5, 1.9].map(of).to_vec();
        assert!(unequal(&equal) > 0.5, "{}", unequal(&equal));
        let mut loud = equal;
        loud[3].mean = 100.0;
        assert!(unequal(&loud) < P_MAX, "{}", unequal(&loud));
    }

    #[test]
    fn a_run_stands_out_by_its_size_and_beyond_chance() {
        let of = |mean: f64, rows: f64| MeanSquare { run: 0, mean, rows };
        assert!(stands_out(&of(1.4, 1000.0), 1.0));
        assert!(
            !stands_out(&of(1.3, 10_000.0), 1.0),
            "beyond chance, but the noise model is not exact"
        );
        assert!(!stands_out(&of(1.6, 100.0), 1.0), "four sigma of chance");
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
