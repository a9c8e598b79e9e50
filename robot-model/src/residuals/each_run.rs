//! Do most runs show it, each by itself? For what cannot be compared between runs, as wheel angles where counts start anew.

use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::normal_equations::Sums;
use crate::numeric::distributions::chi_squared;

/// Probability by chance of as much gain as these columns have with values of their own in every run. It takes
/// the gain of the median run, so most runs have to show it.
pub(super) fn each_run_by_itself(
    equations: &CampaignEquations,
    (model, asked): (&[usize], &[usize]),
    scatter: f64,
) -> f64 {
    if asked.is_empty() {
        return 1.0;
    }
    let best = equations.best(&equations.total, model);
    let mut gains: Vec<f64> = equations
        .folds
        .iter()
        .map(|fold| {
            let mut sums = fold.sums.clone();
            for (column, delta) in model.iter().zip(&best) {
                sums.right -= sums.gram.column(*column) * *delta;
            }
            let delta = equations.best(&sums, asked);
            sums.squares = 0.0;
            -sums.chi_squared(asked, &delta)
        })
        .collect();
    gains.sort_by(f64::total_cmp);
    // Half of the runs gain more than the median: a binomial probability, each one of chi^2.
    let median = gains[gains.len() / 2];
    let alone = chi_squared(asked.len(), median / scatter);
    at_least_half(gains.len(), alone)
}

/// Upper bound on the probability that at least half of n independent events occur, each of which has the
/// probability `alone`.
fn at_least_half(n: usize, alone: f64) -> f64 {
    // C(n, k) < 2^n.
    let half = n.div_ceil(2) as f64;
    (2.0_f64.powi(n as i32) * alone.powf(half)).min(1.0)
}
