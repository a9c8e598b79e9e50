//! The most likely noise of a campaign, by Fisher's scoring.
//!
//! The innovations for a given noise come from [`crate::estimation::noise_segments`]; what the numbers of the noise mean
//! is in [`OdometryNoise`].

use nalgebra::{DMatrix, DVector};

use crate::recording::odometry_noise::{NUMBERS, OdometryNoise, WOBBLE_S};

/// Which of them are given, in the order of [`OdometryNoise::to_array`].
pub(crate) type Given = [bool; NUMBERS];

/// Width of what is plausible before any data, in e-folds: a factor of four either way.
const PRIOR_EFOLDS: f64 = 1.4;

/// What fades faster is white at any usual rate of a camera \[s\].
const WOBBLE_S_MIN: f64 = 0.02;
/// What fades slower would be an effect, and is to be found as one \[s\].
const WOBBLE_S_MAX: f64 = 5.0;

/// How far to search for the noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Search {
    /// From two starts: errors that grow along the path, and errors that fade.
    Wide,
    /// Near the start given.
    Near,
}

/// A whitened number: its innovation nu and the innovation's variance s.
pub(crate) type Whitened = (f64, f64);

/// The noise that makes -2 log likelihood, sum ln s + nu^2 / s, least, starting at `start`.
///
/// Fisher's scoring in the logarithms of the numbers: with the derivatives of every ln s and nu,
///
/// ```text
/// g_i  = sum (1 - nu^2/s) dln s/di + 2 nu/s dnu/di                                    (5)
/// H_ij = sum dln s/di dln s/dj + 2/s dnu/di dnu/dj                                    (6)
/// ```
///
/// The prior has the weight of one measurement, so that four poses in all do not give a noise of zero.
pub(crate) fn most_likely(
    start: OdometryNoise,
    given: Given,
    search: Search,
    whitened: impl Fn(&OdometryNoise) -> Vec<Whitened>,
) -> OdometryNoise {
    let near = score(start, &given, &whitened);
    if search == Search::Near {
        return near.0;
    }
    let fading =
        OdometryNoise { position_wobble_m: 2e-3, heading_wobble_rad: 1e-2, wobble_s: 2.0, ..start };
    let fades = score(fading, &given, &whitened);
    if fades.1 < near.1 { fades.0 } else { near.0 }
}

/// A difference of logarithms that gives a derivative.
const DIFFERENCE: f64 = 0.02;
/// Most iterations of scoring.
const ROUNDS_MAX: usize = 12;
/// The search has converged if -2 log likelihood falls by less than this.
const FALL_MIN: f64 = 0.3;

/// Iterates (5) and (6) to convergence; the noise and its -2 log likelihood, prior included.
fn score(
    start: OdometryNoise,
    given: &Given,
    whitened: &impl Fn(&OdometryNoise) -> Vec<Whitened>,
) -> (OdometryNoise, f64) {
    let typical = OdometryNoise::TYPICAL.to_array();
    let free: Vec<usize> = (0..NUMBERS).filter(|i| !given[*i]).collect();
    let prior = |noise: &[f64; NUMBERS], i: usize| (noise[i] / typical[i]).ln() / PRIOR_EFOLDS;
    let cost = |noise: &[f64; NUMBERS], rows: &[Whitened]| -> f64 {
        let data: f64 = rows.iter().map(|(nu, s)| s.ln() + nu * nu / s).sum();
        data + free.iter().map(|i| prior(noise, *i).powi(2)).sum::<f64>()
    };
    let mut best = start.to_array();
    let mut rows = whitened(&start);
    let mut least = cost(&best, &rows);
    let mut damping = 1e-3;
    for _ in 0..ROUNDS_MAX {
        let slopes: Vec<Vec<Whitened>> =
            free.iter().map(|i| slopes(&best, *i, &rows, whitened)).collect();
        let n = free.len();
        let mut gradient = DVector::zeros(n);
        let mut curvature = DMatrix::zeros(n, n);
        for (i, a) in slopes.iter().enumerate() {
            for ((nu, s), (dnu, dln)) in rows.iter().zip(a) {
                let z = nu / s.sqrt();
                gradient[i] += (1.0 - z * z) * dln + 2.0 * z * dnu;
            }
            for (j, b) in slopes[..=i].iter().enumerate() {
                let sum: f64 = a.iter().zip(b).map(|(a, b)| a.1 * b.1 + 2.0 * a.0 * b.0).sum();
                curvature[(i, j)] = sum;
                curvature[(j, i)] = sum;
            }
            gradient[i] += 2.0 * prior(&best, free[i]) / PRIOR_EFOLDS;
            curvature[(i, i)] += 2.0 / (PRIOR_EFOLDS * PRIOR_EFOLDS);
        }
        let before = least;
        // More damping until the cost falls.
        for _ in 0..4 {
            let mut damped = curvature.clone();
            for i in 0..n {
                damped[(i, i)] *= 1.0 + damping;
            }
            let Some(factor) = damped.cholesky() else { break };
            let step = factor.solve(&gradient);
            let mut there = best;
            for (i, step) in free.iter().zip(step.iter()) {
                there[*i] *= (-step).clamp(-EFOLDS_MAX, EFOLDS_MAX).exp();
            }
            there[WOBBLE_S] = there[WOBBLE_S].clamp(WOBBLE_S_MIN, WOBBLE_S_MAX);
            let moved = whitened(&OdometryNoise::from_array(there));
            let value = cost(&there, &moved);
            if value < least {
                (best, rows, least) = (there, moved, value);
                damping *= 0.1;
                break;
            }
            damping = (damping * 10.0).max(0.01);
        }
        if before - least < FALL_MIN {
            break;
        }
    }
    (OdometryNoise::from_array(best), least)
}

/// Derivatives of nu / sqrt(s) and of ln s by the logarithm of one number of the noise, for each row.
fn slopes(
    noise: &[f64; NUMBERS],
    number: usize,
    rows: &[Whitened],
    whitened: &impl Fn(&OdometryNoise) -> Vec<Whitened>,
) -> Vec<Whitened> {
    let mut there = *noise;
    there[number] *= DIFFERENCE.exp();
    let mut slopes = whitened(&OdometryNoise::from_array(there));
    for (slope, here) in slopes.iter_mut().zip(rows) {
        *slope = (
            (slope.0 - here.0) / (DIFFERENCE * here.1.sqrt()),
            (slope.1 / here.1).ln() / DIFFERENCE,
        );
    }
    slopes
}

/// Longest step of one iteration, in e-folds.
const EFOLDS_MAX: f64 = 1.5;
