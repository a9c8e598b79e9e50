//! The most likely noise of a campaign, by Fisher's scoring.
//!
//! The innovations for a given noise come from [`crate::estimation::noise_segments`]; what the numbers of the noise mean
//! is in [`OdometryNoise`].

use nalgebra::{DMatrix, DVector};

use crate::estimation::noise_segments::NoiseSegments;
use crate::estimation::state::Variances;
use crate::numeric::lanes::{LANES, Lanes, Number};
use crate::numeric::parallel;
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
///
/// With many runs, a share of them leads near the place, and all of them decide.
pub(crate) fn most_likely(
    runs: &[NoiseSegments],
    start: OdometryNoise,
    given: Given,
    search: Search,
) -> OdometryNoise {
    let starts = match search {
        Search::Near => vec![start],
        Search::Wide => vec![start, fading(start)],
    };
    if runs.len() <= MANY_RUNS {
        return likeliest(starts.into_iter().map(|start| score(runs, start, &given)));
    }
    let some: Vec<NoiseSegments> =
        runs.iter().step_by(runs.len().div_ceil(SOME_RUNS)).cloned().collect();
    let ends = starts.into_iter().map(|start| {
        let (near, _) = score(&some, start, &given);
        (near, cost(&near.to_array(), minus_two_log(runs, &near.to_array()), &free(&given)))
    });
    score(runs, likeliest(ends), &given).0
}

/// More runs than this are searched in two stages.
const MANY_RUNS: usize = 300;
/// At most so many runs, evenly spread, are searched in the first stage.
const SOME_RUNS: usize = 100;

/// A start of the search at which errors fade.
fn fading(start: OdometryNoise) -> OdometryNoise {
    OdometryNoise { position_wobble_m: 2e-3, heading_wobble_rad: 1e-2, wobble_s: 2.0, ..start }
}

/// Of noises with their costs, the one with the least; the first of equals.
fn likeliest(ends: impl Iterator<Item = (OdometryNoise, f64)>) -> OdometryNoise {
    let better = |a: (OdometryNoise, f64), b: (OdometryNoise, f64)| if b.1 < a.1 { b } else { a };
    ends.reduce(better).expect("a search has a start").0
}

/// A difference of logarithms that gives a derivative.
const DIFFERENCE: f64 = 0.002;
/// Most iterations of scoring.
const ROUNDS_MAX: usize = 12;
/// The search has converged if -2 log likelihood falls by less than this.
const FALL_MIN: f64 = 0.3;
/// Most steps tried in an iteration.
const TRIALS_MAX: usize = 4;
/// Longest step of the time in one iteration, in e-folds.
const EFOLDS_MAX: f64 = 1.5;
/// A variance shrinks to this share at most in one iteration.
const SHRINKS_MAX: f64 = 0.05;

/// Iterates (5) and (6) to convergence; the noise and its -2 log likelihood, prior included.
fn score(runs: &[NoiseSegments], start: OdometryNoise, given: &Given) -> (OdometryNoise, f64) {
    let free = free(given);
    let n = free.len();
    let mut best = start.to_array();
    let mut least = f64::INFINITY;
    let mut share = 1.0;
    for _ in 0..ROUNDS_MAX {
        let sums = Sums::around(runs, &best, &free);
        let before = cost(&best, sums.minus_two_log, &free);
        least = before;
        let mut gradient = DVector::from_fn(n, |i, _| sums.gradient(i));
        let mut curvature = DMatrix::from_fn(n, n, |i, j| sums.curvature(i, j));
        for i in 0..n {
            gradient[i] += 2.0 * prior(&best, free[i]) / PRIOR_EFOLDS;
            curvature[(i, i)] += 2.0 / (PRIOR_EFOLDS * PRIOR_EFOLDS);
        }
        let newton = |gradient: &DVector<f64>, curvature: &DMatrix<f64>| {
            curvature.clone().cholesky().map(|factor| -factor.solve(gradient))
        };
        let Some(mut step) = newton(&gradient, &curvature) else { break };
        let at_end = |i: &usize| moved(free[*i], best[free[*i]], step[*i]) == best[free[*i]];
        if let Some(held) = (0..n).find(at_end) {
            // It is at the end of its range, and stays there: the others step without it.
            gradient[held] = 0.0;
            curvature.row_mut(held).fill(0.0);
            curvature.column_mut(held).fill(0.0);
            curvature[(held, held)] = 1.0;
            let Some(others) = newton(&gradient, &curvature) else { break };
            step = others;
        }
        let slope = step.dot(&gradient);
        for _ in 0..TRIALS_MAX {
            // A parabola falls by half of what its slope promises.
            if -slope * share / 2.0 < FALL_MIN {
                break;
            }
            let mut there = best;
            for (i, step) in free.iter().zip(step.iter()) {
                there[*i] = moved(*i, best[*i], share * step);
            }
            let value = cost(&there, minus_two_log(runs, &there), &free);
            if value < before - FALL_MIN {
                (best, least) = (there, value);
                break;
            }
            let lowest = -slope * share / (2.0 * (value - before - slope * share));
            share *= lowest.clamp(0.1, 0.5);
        }
        if before - least < FALL_MIN {
            break;
        }
        share = (2.0 * share).min(1.0);
    }
    (OdometryNoise::from_array(best), least)
}

/// The numbers that are not given.
fn free(given: &Given) -> Vec<usize> {
    (0..NUMBERS).filter(|i| !given[*i]).collect()
}

/// How far a number is from what is typical, in widths of the prior.
fn prior(noise: &[f64; NUMBERS], number: usize) -> f64 {
    let typical = OdometryNoise::TYPICAL.to_array();
    (noise[number] / typical[number]).ln() / PRIOR_EFOLDS
}

/// -2 log likelihood with the prior of the free numbers.
fn cost(noise: &[f64; NUMBERS], minus_two_log: f64, free: &[usize]) -> f64 {
    minus_two_log + free.iter().map(|i| prior(noise, *i).powi(2)).sum::<f64>()
}

/// A number of the noise, moved by a step of its logarithm.
///
/// The variances s are linear in the squares of the sigmas, so these take the step: the exponential of a long one would
/// be far too much.
fn moved(number: usize, from: f64, step: f64) -> f64 {
    if number == WOBBLE_S {
        let to = from * step.clamp(-EFOLDS_MAX, EFOLDS_MAX).exp();
        return to.clamp(WOBBLE_S_MIN, WOBBLE_S_MAX);
    }
    from * (1.0 + 2.0 * step).max(SHRINKS_MAX).sqrt()
}

/// -2 log likelihood with this noise.
fn minus_two_log(runs: &[NoiseSegments], noise: &[f64; NUMBERS]) -> f64 {
    let noise = Variances::from_sigmas(*noise);
    let each = parallel::map(runs, |run| {
        let mut sum = 0.0;
        run.innovations(&noise, |nu, s| sum += s.ln() + nu * nu / s);
        sum
    });
    each.iter().sum()
}

/// -2 log likelihood at a noise, (5) and (6) there, a number by its lane.
#[derive(Clone, Debug)]
struct Sums {
    minus_two_log: f64,
    gradient: Lanes,
    curvature: [Lanes; NUMBERS],
}

impl Sums {
    /// Over all runs, by the logarithms of the free numbers.
    fn around(runs: &[NoiseSegments], noise: &[f64; NUMBERS], free: &[usize]) -> Self {
        let noises = lanes(noise, free);
        let each = parallel::map(runs, |run| {
            let mut sums = Self::zeros();
            run.innovations(&noises, |nu, s| sums.add_row(nu, s, free.len()));
            sums
        });
        each.iter().fold(Self::zeros(), Self::plus)
    }

    fn zeros() -> Self {
        let zeros = Lanes::of(0.0);
        Self { minus_two_log: 0.0, gradient: zeros, curvature: [zeros; NUMBERS] }
    }

    fn plus(mut self, other: &Self) -> Self {
        self.minus_two_log += other.minus_two_log;
        self.gradient += other.gradient;
        for (row, other) in self.curvature.iter_mut().zip(&other.curvature) {
            *row += *other;
        }
        self
    }

    /// Adds an innovation and its variance, in all lanes.
    fn add_row(&mut self, nu: Lanes, s: Lanes, free: usize) {
        let (here, wide) = (nu.0[0], s.0[0]);
        let weight = 1.0 / wide.sqrt();
        let z = here * weight;
        self.minus_two_log += wide.ln() + z * z;
        // dnu / sqrt(s) and dln s.
        let dnu = (nu - Lanes::of(here)) * Lanes::of(weight / DIFFERENCE);
        let dln = log_of_ratio(s, Lanes::of(wide)) * Lanes::of(1.0 / DIFFERENCE);
        self.gradient += Lanes::of(1.0 - z * z) * dln + Lanes::of(2.0 * z) * dnu;
        for (i, row) in self.curvature[..free].iter_mut().enumerate() {
            *row += Lanes::of(dln.0[i + 1]) * dln + Lanes::of(2.0 * dnu.0[i + 1]) * dnu;
        }
    }

    fn gradient(&self, i: usize) -> f64 {
        self.gradient.0[i + 1]
    }

    fn curvature(&self, i: usize, j: usize) -> f64 {
        self.curvature[i].0[j + 1]
    }
}

const _: () = assert!(LANES > NUMBERS, "a lane for the noise, and one for each of its numbers");

/// A noise in the first lane, and beside it with each free number larger by [`DIFFERENCE`].
fn lanes(noise: &[f64; NUMBERS], free: &[usize]) -> Variances<Lanes> {
    let mut sigmas = noise.map(Lanes::of);
    for (i, number) in free.iter().enumerate() {
        sigmas[*number].0[i + 1] *= DIFFERENCE.exp();
    }
    Variances::from_sigmas(sigmas)
}

/// ln(a / b) of numbers that are nearly the same: 2 artanh((a - b) / (a + b)).
fn log_of_ratio(a: Lanes, b: Lanes) -> Lanes {
    let x = (a - b) / (a + b);
    let square = x * x;
    // For a ratio of up to e^0.04, the first term left out is under 1e-15 of the sum.
    let [one, third, fifth, seventh] = [1.0, 3.0, 5.0, 7.0].map(|n| Lanes::of(1.0 / n));
    (x + x) * (one + square * (third + square * (fifth + square * seventh)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::composition::Terms;
    use crate::estimation::ekf::whiten;
    use crate::estimation::fit::minus_two_log_likelihood;
    use crate::recording::campaign::Prepared;
    use crate::tests::synthetic::{NOISE, campaign, full_plan};

    fn prepared() -> Prepared {
        campaign(&full_plan(), &[], 4).prepare().unwrap()
    }

    fn runs(prepared: &Prepared) -> Vec<NoiseSegments> {
        let segments = |run: &crate::recording::campaign::PreparedRun| {
            let mut segments = NoiseSegments::new([0.0; 2], Vec::new());
            let poses = &run.recording.measured_poses;
            whiten(&run.motion, poses, Terms::Fixed(&[]), &NOISE, &mut segments);
            segments
        };
        prepared.runs.iter().map(segments).collect()
    }

    #[test]
    fn the_slopes_in_the_lanes_are_those_of_the_likelihood() {
        let runs = runs(&prepared());
        // Not at the most likely noise, where they are zero.
        let noise = NOISE.times(1.3).to_array();
        let free: Vec<usize> = (0..NUMBERS).filter(|i| *i != 7).collect();
        let sums = Sums::around(&runs, &noise, &free);
        assert!((sums.minus_two_log - minus_two_log(&runs, &noise)).abs() < 1e-6);
        for (i, number) in free.iter().enumerate() {
            let at = |by: f64| {
                let mut there = noise;
                there[*number] *= f64::exp(by);
                minus_two_log(&runs, &there)
            };
            let slope = (at(0.01) - at(-0.01)) / 0.02;
            // A difference to one side is that of a point half of it away.
            let allowed = 0.02 * slope.abs() + DIFFERENCE * sums.curvature(i, i) + 0.01;
            let found = sums.gradient(i);
            assert!((found - slope).abs() < allowed, "number {number}: {found} is not {slope}");
        }
    }

    #[test]
    fn the_noise_found_is_more_likely_than_its_neighbours_whatever_the_start() {
        let prepared = prepared();
        let segments = runs(&prepared);
        let mut given = [false; NUMBERS];
        given[7] = true;
        let all: Vec<_> = prepared.runs.iter().collect();
        let likelihood = |noise: &OdometryNoise| minus_two_log_likelihood(&all, &[], noise);
        let typical = OdometryNoise::TYPICAL;
        let starts = [1.0, 4.0, 0.4]
            .map(|size| OdometryNoise { gyro_walk: typical.gyro_walk, ..typical.times(size) });
        let found = starts.map(|start| most_likely(&segments, start, given, Search::Wide));
        for noise in found {
            let least = likelihood(&noise);
            assert!((least - likelihood(&found[0])).abs() < 2.0, "{found:?}");
            for number in 0..4 {
                for factor in [0.85, 1.15] {
                    let mut there = noise.to_array();
                    there[number] *= factor;
                    let beside = likelihood(&OdometryNoise::from_array(there));
                    assert!(
                        beside > least - 0.5,
                        "number {number} times {factor}: {beside} {least}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_share_of_many_runs_leads_to_the_noise_of_all() {
        let campaigns = (0..17).map(|seed| campaign(&full_plan(), &[], seed).prepare().unwrap());
        let many: Vec<NoiseSegments> = campaigns.flat_map(|prepared| runs(&prepared)).collect();
        assert!(many.len() > MANY_RUNS, "{} runs", many.len());
        let mut given = [false; NUMBERS];
        given[7] = true;
        let start = OdometryNoise::TYPICAL.times(3.0);
        let found = most_likely(&many, start, given, Search::Wide).to_array();
        let (directly, _) = score(&many, start, &given);
        let least = minus_two_log(&many, &directly.to_array());
        assert!(minus_two_log(&many, &found) < least + 1.0, "{found:?} is not {directly:?}");
    }
}
