//! Do errors persist, as those of noise do not?
//!
//! Noise is learnt from residuals. What no effect explains passes for a random walk, and its size fits by construction. But the
//! steps of a random walk are independent, and so are its innovations: without anything missing, and with z_k the normalised
//! innovations of one quantity over half of a run (n of them), or over all runs,
//!
//! ```text
//! m = sum z_k / sqrt(n) ~ N(0, 1),   sum of m^2 over all halves ~ chi squared             (1)
//! r_l = sum z_k z_(k+l) / sum z_k^2 = 0 +- 1 / sqrt(N)                                    (2)
//! ```
//!
//! A pull that is another in each run, or changes over minutes, shows in (1); what takes some seconds, in (2). The quantities are
//! the heading, and the position ahead. No noise model is exact, so both have to be large as well as significant. Where a tracker's
//! own error lasts for seconds, its innovations are white only as far as that error is known: such a quantity is not asked, nor is one
//! whose error the user gave, as nobody said how fast that changes.

use super::innovations::{Innovations, innovations};
use super::regressor::Regressor;
use crate::estimation::fit::Fitted;
use crate::numeric::distributions::chi_squared;
use crate::recording::campaign::Prepared;
use crate::recording::odometry_noise::OdometryNoise;

/// Fewer innovations in half of a run do not show what persists.
const HALF_MIN: usize = 20;
/// (1): the mean of m^2 at least, and its significance level.
const MEAN_MIN: f64 = 3.0;
const P_MAX: f64 = 1e-6;
/// (2): the lags, the correlation at least, and its size in standard deviations.
const LAGS: [usize; 4] = [2, 3, 5, 10];
const CORRELATION_MIN: f64 = 0.25;
const SIGMAS_MIN: f64 = 6.0;
/// A quantity whose slow error exceeds this share of its white noise is not asked, and neither is if that of one is so many times as
/// large: then the tracker wobbles.
const SLOW_MAX: f64 = 0.7;
const WOBBLES: f64 = 3.0;
/// Halves of runs agree with each other if they correlate by more than this: then runs differ.
const HALVES_AGREE: f64 = 0.5;

/// Errors that persist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Persisting {
    /// What they depend on: the run, if both halves of runs err alike, else the time in the run.
    pub regressor: Regressor,
    /// Probability of as much by chance.
    pub p_value: f64,
}

/// Errors that persist, if any do.
pub(crate) fn persisting(prepared: &Prepared, fitted: &Fitted<'_>) -> Option<Persisting> {
    let runs = innovations(prepared, fitted);
    let OdometryNoise { heading_sigma_rad, heading_wobble_rad, .. } = fitted.noise;
    let OdometryNoise { position_sigma_m, position_wobble_m, .. } = fitted.noise;
    let ratios = [heading_wobble_rad / heading_sigma_rad, position_wobble_m / position_sigma_m];
    let is_given = [prepared.robot.heading_sigma_rad, prepared.robot.position_sigma_m];
    let wobbles = ratios.iter().any(|ratio| *ratio > WOBBLES);
    let is_asked = [0, 1].map(|quantity: usize| {
        !wobbles && ratios[quantity] < SLOW_MAX && is_given[quantity].is_none()
    });
    let found = (0..2_usize).filter(|quantity| is_asked[*quantity]).filter_map(|quantity| {
        let of = |run: &Innovations| -> Vec<f64> {
            let seen = if quantity == 0 { &run.heading } else { &run.along };
            seen.iter().map(|innovation| innovation.z).collect()
        };
        let of: Vec<Vec<f64>> = runs.iter().map(of).collect();
        let of: Vec<&[f64]> = of.iter().map(Vec::as_slice).collect();
        over_halves(&of).or_else(|| over_seconds(&of))
    });
    found.min_by(|a, b| a.p_value.total_cmp(&b.p_value))
}

/// m of both halves of a run.
fn halves(run: &[f64]) -> Option<[f64; 2]> {
    let middle = run.len() / 2;
    let m = |half: &[f64]| half.iter().sum::<f64>() / (half.len() as f64).sqrt();
    (middle >= HALF_MIN).then(|| [m(&run[..middle]), m(&run[middle..])])
}

/// How the halves of runs correlate.
fn halves_correlation(halves: &[[f64; 2]]) -> f64 {
    let sum = |of: fn(&[f64; 2]) -> f64| halves.iter().map(of).sum::<f64>();
    sum(|[a, b]| a * b) / (sum(|[a, _]| a * a) * sum(|[_, b]| b * b)).sqrt()
}

/// By (1).
fn over_halves(runs: &[&[f64]]) -> Option<Persisting> {
    let halves: Vec<[f64; 2]> = runs.iter().filter_map(|run| halves(run)).collect();
    let squares: f64 = halves.iter().flatten().map(|m| m * m).sum();
    let freedom = 2 * halves.len();
    let p_value = if freedom > 0 { chi_squared(freedom, squares) } else { 1.0 };
    let differ = halves_correlation(&halves) > HALVES_AGREE;
    let regressor = if differ { Regressor::Run } else { Regressor::TimeInRun };
    (squares > MEAN_MIN * freedom as f64 && p_value < P_MAX)
        .then_some(Persisting { regressor, p_value })
}

/// By (2).
fn over_seconds(runs: &[&[f64]]) -> Option<Persisting> {
    let most = LAGS.iter().map(|lag| correlation(runs, *lag)).max_by(|a, b| a.0.total_cmp(&b.0));
    let (correlation, sigmas) = most?;
    let p_value = chi_squared(1, sigmas * sigmas);
    (correlation > CORRELATION_MIN && sigmas > SIGMAS_MIN)
        .then_some(Persisting { regressor: Regressor::TimeInRun, p_value })
}

/// r of (2), and how many of its standard deviations it is from zero.
fn correlation(runs: &[&[f64]], lag: usize) -> (f64, f64) {
    let squares: f64 = runs.iter().flat_map(|run| run.iter()).map(|z| z * z).sum();
    let products = |run: &&[f64]| run.windows(lag + 1).map(|z| z[0] * z[lag]).sum::<f64>();
    let pairs: usize = runs.iter().map(|run| run.len().saturating_sub(lag)).sum();
    let r = runs.iter().map(products).sum::<f64>() / squares.max(f64::MIN_POSITIVE);
    (r, r * (pairs as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::composition::Term;
    use crate::explain::explain;
    use crate::tests::synthetic::{TurnsPerMetre, campaign, full_plan};

    /// A pull that comes and goes in half an hour.
    const SLOW_PULL: TurnsPerMetre =
        TurnsPerMetre(|step| 0.03 * (step.clock_s / 1800.0 * core::f64::consts::TAU).sin());

    #[test]
    fn a_pull_that_changes_over_minutes_is_no_noise_and_the_floor_knows_it() {
        for seed in 0..2 {
            let pulled = campaign(&full_plan(), &[Term::new(&SLOW_PULL, Vec::new())], seed);
            let prepared = pulled.prepare().unwrap();
            let fitted = crate::selection::select::select(&prepared, &[]).fitted;
            let found = persisting(&prepared, &fitted).expect("halves of runs agree");
            assert_eq!(found.regressor, Regressor::Run, "seed {seed}: {found:?}");
            let answer = explain(&pulled).unwrap();
            let over = [Regressor::TimeInCampaign, Regressor::Run];
            let named = &answer.unexplained.depends_on;
            assert!(named.iter().any(|one| over.contains(one)), "seed {seed}: {named:?}");
            let [before_m, floor_m] = [answer.baseline.cross_validated, answer.reachable]
                .map(|errors| errors.position_rms_m);
            assert!(floor_m < 0.5 * before_m, "seed {seed}: {floor_m} of {before_m}");
            let sound = campaign(&full_plan(), &[], seed).prepare().unwrap();
            let fitted = crate::selection::select::select(&sound, &[]).fitted;
            assert_eq!(persisting(&sound, &fitted), None, "seed {seed}");
        }
    }

    #[test]
    fn independent_innovations_do_not_persist_and_those_of_some_seconds_do() {
        // Signs of a linear congruential generator, and each of them held for six poses.
        let mut state = 1_u64;
        let mut sign = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            if state >> 63 == 0 { 1.0 } else { -1.0 }
        };
        let white: Vec<f64> = (0..1200).map(|_| sign()).collect();
        let held: Vec<f64> = (0..200).flat_map(|_| [sign(); 6]).collect();
        let of = |run: &[f64]| over_halves(&[run]).or_else(|| over_seconds(&[run]));
        assert_eq!(of(&white), None);
        let found = over_seconds(&[&held]).unwrap();
        assert_eq!(found.regressor, Regressor::TimeInRun);
    }
}
