//! The constants that explain the travel best: output error, not regression on differences.
//!
//! The model is driven by the measured voltage alone, and its travel is compared with the counts'. So neither the encoder
//! nor a difference comes between the data and the constants.

use nalgebra::{DMatrix, DVector};

use super::constants_vector::{DELAY, LEN, from_vector, to_vector};
use super::intervals::{Intervals, Share};
use super::model::Drivetrain;
use super::recording::VoltageRecording;
use super::regression::regress;
use super::residuals::{residuals, residuals_of_each, samples_per_count};
use crate::kinematics::WheelPair;
use crate::numeric::parallel;

/// Rounds of the search.
const ROUNDS_MAX: usize = 60;
/// The search ends when a round removes less than this share of the cost: of thousands of samples, a hundredth of sigma
/// squared.
const GAIN_MIN: f64 = 1e-6;
/// Longest delay that is believed \[s\].
const DELAY_S_MAX: f64 = 0.05;
/// Delays that drivers and controllers have: about so long \[s\]. Coarse counts hardly tell a delay from inertia.
const DELAY_S: (f64, f64) = (0.003, 0.003);
/// As good as so many observations with the noise of the fit.
const DELAY_WEIGHT: f64 = 30.0;
/// Of a normal distribution, 95 % are within so many standard deviations.
const NORMAL_95: f64 = 1.96;

/// The constants, and how sure they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {
    /// The values.
    pub value: Drivetrain,
    /// Half the widths of their 95 % intervals.
    pub half_widths_95: WheelPair<HalfWidths>,
}

/// Half the widths of the intervals of one wheel's constants.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HalfWidths {
    /// Of kS+ \[V\].
    pub ks_forward_v: f64,
    /// Of kS- \[V\].
    pub ks_backward_v: f64,
    /// Of kV \[V s/m\].
    pub kv_v_s_per_m: f64,
    /// Of kA + kC, straight on \[V s^2/m\].
    pub ka_straight_v_s2_per_m: f64,
    /// Of kA - kC, on the spot \[V s^2/m\].
    pub ka_spin_v_s2_per_m: f64,
}

/// What a fit found.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivetrainFit {
    /// The constants.
    pub constants: Constants,
    /// Measured less modelled travel, root mean square over all samples and both wheels, without where within its first count
    /// each wheel began \[m\].
    pub residual_m: f64,
    /// The regression that the search began from.
    pub regression: Drivetrain,
}

/// Why nothing could be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitError {
    /// Fewer than three experiments.
    TooFew,
    /// The recordings do not turn both wheels forwards and backwards by their motors.
    NoMotion,
    /// The search found no constants above zero.
    NoConstants,
    /// The motors answer as late as is looked for, or later.
    Delay,
}

/// Fits (1) to experiments.
pub fn fit(recordings: &[VoltageRecording]) -> Result<DrivetrainFit, FitError> {
    if recordings.len() < 3 {
        return Err(FitError::TooFew);
    }
    let regression = regress(recordings).ok_or(FitError::NoMotion)?;
    // Regression takes a delay for inertia. Both beginnings lead somewhere; the better end counts.
    let search = [0.0, 0.004]
        .map(|delay_s| {
            let mut begin = Drivetrain { delay_s, ..regression };
            for motor in [&mut begin.wheels.left, &mut begin.wheels.right] {
                let less = motor.ka_v_s2_per_m - delay_s * motor.kv_v_s_per_m;
                motor.ka_v_s2_per_m = less.max(0.3 * motor.ka_v_s2_per_m);
            }
            let mut search = Search::new(recordings, to_vector(&begin));
            search.run();
            search
        })
        .into_iter()
        .min_by(|a, b| a.cost.total_cmp(&b.cost))
        .ok_or(FitError::NoConstants)?;
    let half_widths_95 = search.half_widths_95().ok_or(FitError::NoConstants)?;
    let value = from_vector(&search.at);
    if [value.wheels.left, value.wheels.right]
        .iter()
        .any(|motor| motor.kv_v_s_per_m <= 0.0 || motor.ka_v_s2_per_m <= 0.0)
    {
        return Err(FitError::NoConstants);
    }
    if value.delay_s > 0.99 * DELAY_S_MAX {
        return Err(FitError::Delay);
    }
    let residual_m = (search.cost / search.samples as f64).sqrt();
    Ok(DrivetrainFit { constants: Constants { value, half_widths_95 }, residual_m, regression })
}

/// Keeps the constants where a motor can have them.
fn admissible(at: &mut DVector<f64>) {
    for wheel in [0, 4] {
        at[wheel] = at[wheel].max(0.0);
        at[wheel + 1] = at[wheel + 1].max(0.0);
        at[wheel + 2] = at[wheel + 2].max(1e-6);
        at[wheel + 3] = at[wheel + 3].max(1e-3 * at[wheel + 2]);
    }
    let coupling_max = 0.95 * at[3].min(at[7]);
    at[8] = at[8].clamp(-coupling_max, coupling_max);
    at[DELAY] = at[DELAY].clamp(0.0, DELAY_S_MAX);
}

/// Levenberg's search.
struct Search<'a> {
    recordings: &'a [VoltageRecording],
    at: DVector<f64>,
    shares: Vec<Share>,
    cost: f64,
    samples: usize,
    /// Square of a residual, on average, as the search found it halfway \[m^2\].
    noise: f64,
    /// So many samples see the same count, on average, and are one observation; at least 1.
    samples_per_count: f64,
}

impl<'a> Search<'a> {
    fn new(recordings: &'a [VoltageRecording], at: DVector<f64>) -> Self {
        let samples = recordings.iter().map(|recording| 2 * recording.samples().len()).sum();
        let samples_per_count = samples_per_count(recordings);
        let (shares, cost) = (Vec::new(), f64::INFINITY);
        Self { recordings, at, shares, cost, samples, noise: 0.0, samples_per_count }
    }

    /// Without a prior for the delay first, which tells the noise; then with it.
    fn run(&mut self) {
        self.descend();
        self.noise = self.cost / self.samples as f64;
        self.descend();
    }

    fn descend(&mut self) {
        admissible(&mut self.at);
        self.cost = self.cost_at(&self.at);
        let mut damping = 1e-3;
        for _ in 0..ROUNDS_MAX {
            self.linearise();
            let (gram, gradient) = self.sums();
            let mut gained = 0.0;
            while damping < 1e9 {
                let mut damped = gram.clone();
                for i in 0..LEN {
                    damped[(i, i)] += damping * gram[(i, i)].max(1e-30);
                }
                let Some(factor) = damped.cholesky() else {
                    damping *= 10.0;
                    continue;
                };
                let mut next = &self.at + factor.solve(&gradient);
                admissible(&mut next);
                let cost = self.cost_at(&next);
                if cost < self.cost {
                    gained = 1.0 - cost / self.cost;
                    (self.at, self.cost) = (next, cost);
                    damping = (0.2 * damping).max(1e-9);
                    break;
                }
                damping *= 5.0;
            }
            if gained < GAIN_MIN {
                break;
            }
        }
        self.linearise();
    }

    /// The sum of the squares of measured less modelled travel \[m^2\].
    fn cost_at(&self, at: &DVector<f64>) -> f64 {
        let model = from_vector(at);
        let costs = parallel::map(self.recordings, |recording| {
            let residuals = residuals(&model, recording, self.noise);
            residuals.iter().map(|residual| residual * residual).sum::<f64>()
        });
        let cost: f64 = costs.into_iter().sum::<f64>() + self.delay_cost(at);
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    /// What speaks against a delay that no driver has \[m^2\].
    fn delay_cost(&self, at: &DVector<f64>) -> f64 {
        let off_s = at[DELAY] - DELAY_S.0;
        self.delay_weight() * off_s * off_s
    }

    /// Of the square of what a delay differs by \[m^2/s^2\].
    fn delay_weight(&self) -> f64 {
        DELAY_WEIGHT * self.samples_per_count * self.noise / (DELAY_S.1 * DELAY_S.1)
    }

    fn linearise(&mut self) {
        let (at, model) = (&self.at, from_vector(&self.at));
        let steps = DVector::from_fn(LEN, |i, _| match i {
            DELAY => 2e-4,
            8 | 10 => 1e-3 * at[3].max(at[7]),
            0 | 1 | 4 | 5 => 1e-3 * at[i].max(0.02),
            _ => 1e-3 * at[i],
        });
        let shifted: Vec<DVector<f64>> = (0..LEN)
            .flat_map(|i| [-steps[i], steps[i]].map(|step| (i, step)))
            .map(|(i, step)| {
                let mut moved = at.clone();
                moved[i] += step;
                moved
            })
            .collect();
        self.shares = parallel::map(self.recordings, |recording| {
            let base = residuals(&model, recording, self.noise);
            let shifted = residuals_of_each(&shifted, recording, self.noise);
            // A residual falls as its travel rises.
            let columns: Vec<Vec<f64>> = (0..LEN)
                .map(|i| {
                    let (low, high) = (&shifted[2 * i], &shifted[2 * i + 1]);
                    low.iter()
                        .zip(high)
                        .map(|(low, high)| (low - high) / (2.0 * steps[i]))
                        .collect()
                })
                .collect();
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            Share {
                gram: DMatrix::from_fn(LEN, LEN, |i, j| dot(&columns[i], &columns[j])),
                gradient: DVector::from_fn(LEN, |i, _| dot(&columns[i], &base)),
            }
        });
    }

    fn sums(&self) -> (DMatrix<f64>, DVector<f64>) {
        let mut gram = DMatrix::zeros(LEN, LEN);
        let mut gradient = DVector::zeros(LEN);
        for share in &self.shares {
            gram += &share.gram;
            gradient += &share.gradient;
        }
        // Where nothing turns on the spot, kC and kW are zero: as if one sample of 1 mm said so to half of kA, and to kA in 0.2 m.
        let least = self.at[3].min(self.at[7]);
        for (constant, usual) in [(8, 0.5 * least), (10, 5.0 * least)] {
            let weight = (1e-3 / usual).powi(2);
            gram[(constant, constant)] += weight;
            gradient[constant] -= weight * self.at[constant];
        }
        let weight = self.delay_weight();
        gram[(DELAY, DELAY)] += weight;
        gradient[DELAY] -= weight * (self.at[DELAY] - DELAY_S.0);
        (gram, gradient)
    }

    /// By the jackknife; and by the prior of the delay, which is itself only so sure.
    fn half_widths_95(&self) -> Option<WheelPair<HalfWidths>> {
        let intervals = Intervals::new(&self.sums().0, &self.shares)?;
        let of = |terms: &[(usize, f64)]| {
            let mut weights = DVector::zeros(LEN);
            terms.iter().for_each(|(at, weight)| weights[*at] = *weight);
            let of_prior = self.delay_weight() * DELAY_S.1 * intervals.moved(&weights)[DELAY];
            intervals.half_width_95(&weights).hypot(NORMAL_95 * of_prior)
        };
        let wheel = |first: usize| HalfWidths {
            ks_forward_v: of(&[(first, 1.0)]),
            ks_backward_v: of(&[(first + 1, 1.0)]),
            kv_v_s_per_m: of(&[(first + 2, 1.0)]),
            ka_straight_v_s2_per_m: of(&[(first + 3, 1.0), (8, 1.0)]),
            ka_spin_v_s2_per_m: of(&[(first + 3, 1.0), (8, -1.0)]),
        };
        Some(WheelPair::new(wheel(0), wheel(4)))
    }
}
