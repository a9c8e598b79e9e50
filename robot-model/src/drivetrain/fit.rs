//! The constants that explain the travel best: output error, not regression on differences.
//!
//! The model is driven by the measured voltage alone, and its travel is compared with the counts'. So neither the encoder
//! nor a difference comes between the data and the constants.

use nalgebra::{DMatrix, DVector};

use super::intervals::{Intervals, Share};
use super::model::{Couple, Drivetrain, WheelMotor};
use super::recording::VoltageRecording;
use super::regression::regress;
use crate::kinematics::WheelPair;
use crate::numeric::lanes::{LANES, Lanes};
use crate::numeric::parallel;

/// How many constants there are.
const LEN: usize = 11;
/// Which of them is the delay.
const DELAY: usize = 9;
/// Rounds of the search.
const ROUNDS_MAX: usize = 60;
/// The search ends when a round removes less than this share of the cost: of thousands of samples, a hundredth of sigma
/// squared.
const GAIN_MIN: f64 = 1e-6;
/// Longest delay that is believed \[s\].
const DELAY_S_MAX: f64 = 0.05;
/// Delays that drivers and controllers have: about so long \[s\]. Coarse counts hardly tell a delay from inertia.
const DELAY_S: (f64, f64) = (0.003, 0.003);
/// As good as so many samples with the noise of the fit.
const DELAY_WEIGHT: f64 = 30.0;

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
    /// Measured less modelled travel, root mean square over all samples and both wheels \[m\].
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
    let residual_m = (search.cost / search.samples as f64).sqrt();
    Ok(DrivetrainFit { constants: Constants { value, half_widths_95 }, residual_m, regression })
}

fn to_vector(model: &Drivetrain) -> DVector<f64> {
    let WheelPair { left, right } = model.wheels;
    let of = |motor: WheelMotor| {
        [motor.ks_forward_v, motor.ks_backward_v, motor.kv_v_s_per_m, motor.ka_v_s2_per_m]
    };
    let both = of(left).into_iter().chain(of(right));
    DVector::from_iterator(
        LEN,
        both.chain([model.kc_v_s2_per_m, model.delay_s, model.kw_v_s2_per_m2]),
    )
}

fn from_vector(at: &DVector<f64>) -> Drivetrain {
    let Couple { wheels, kc, kw } = couple(|constant| at[constant]);
    Drivetrain { wheels, kc_v_s2_per_m: kc, delay_s: at[DELAY], kw_v_s2_per_m2: kw }
}

/// The constants but the delay, each by its number.
fn couple<T>(at: impl Fn(usize) -> T) -> Couple<T> {
    let wheel = |first: usize| WheelMotor {
        ks_forward_v: at(first),
        ks_backward_v: at(first + 1),
        kv_v_s_per_m: at(first + 2),
        ka_v_s2_per_m: at(first + 3),
    };
    Couple { wheels: WheelPair::new(wheel(0), wheel(4)), kc: at(8), kw: at(10) }
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
}

impl<'a> Search<'a> {
    fn new(recordings: &'a [VoltageRecording], at: DVector<f64>) -> Self {
        let samples = recordings.iter().map(|recording| 2 * recording.samples().len()).sum();
        Self { recordings, at, shares: Vec::new(), cost: f64::INFINITY, samples, noise: 0.0 }
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
            residuals(&model, recording).map(|residual| residual * residual).sum::<f64>()
        });
        let cost: f64 = costs.into_iter().sum::<f64>() + self.delay_cost(at);
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    /// What speaks against a delay that no driver has \[m^2\].
    fn delay_cost(&self, at: &DVector<f64>) -> f64 {
        let off = (at[DELAY] - DELAY_S.0) / DELAY_S.1;
        DELAY_WEIGHT * self.noise * off * off
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
            let base: Vec<f64> = residuals(&model, recording).collect();
            let shifted = residuals_of_each(&shifted, recording);
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
        let weight = DELAY_WEIGHT * self.noise / (DELAY_S.1 * DELAY_S.1);
        gram[(DELAY, DELAY)] += weight;
        gradient[DELAY] -= weight * (self.at[DELAY] - DELAY_S.0);
        (gram, gradient)
    }

    fn half_widths_95(&self) -> Option<WheelPair<HalfWidths>> {
        let intervals = Intervals::new(&self.sums().0, &self.shares)?;
        let of = |terms: &[(usize, f64)]| {
            let mut weights = DVector::zeros(LEN);
            terms.iter().for_each(|(at, weight)| weights[*at] = *weight);
            intervals.half_width_95(&weights)
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

/// Measured less modelled travel, both wheels, sample by sample \[m\].
fn residuals<'a>(
    model: &Drivetrain,
    recording: &'a VoltageRecording,
) -> impl Iterator<Item = f64> + use<'a> {
    measured_less(recording, model.travel_m(recording))
}

/// The same of several models. Those with one delay move beside each other, one in each lane: a step waits for the step
/// before, and alone a processor would mostly wait.
fn residuals_of_each(models: &[DVector<f64>], recording: &VoltageRecording) -> Vec<Vec<f64>> {
    let mut residuals = vec![Vec::new(); models.len()];
    let mut left: Vec<usize> = (0..models.len()).collect();
    while let Some(&first) = left.first() {
        let delay_s = models[first][DELAY];
        let mut together = left.clone();
        // By their bits: what is no number equals itself as well, and is not waited for without end.
        together.retain(|&index| models[index][DELAY].to_bits() == delay_s.to_bits());
        together.truncate(LANES);
        left.retain(|index| !together.contains(index));
        if together.len() == 1 {
            residuals[first] = self::residuals(&from_vector(&models[first]), recording).collect();
            continue;
        }
        // Lanes that are left over move as the first one does.
        let model = |lane: usize| &models[together.get(lane).copied().unwrap_or(first)];
        let lanes = couple(|constant| Lanes(core::array::from_fn(|lane| model(lane)[constant])));
        let travel_m = lanes.travel_m(delay_s, recording);
        for (lane, &index) in together.iter().enumerate() {
            let alone = travel_m.iter().map(|both| both.map(|lanes| lanes.0[lane]));
            residuals[index] = measured_less(recording, alone).collect();
        }
    }
    residuals
}

/// Measured less modelled travel, both wheels, sample by sample \[m\].
fn measured_less<'a, T: IntoIterator<Item = WheelPair<f64>>>(
    recording: &'a VoltageRecording,
    modelled: T,
) -> impl Iterator<Item = f64> + use<'a, T> {
    let start = recording.samples()[0].travel_m;
    recording.samples().iter().zip(modelled).flat_map(move |(sample, modelled)| {
        let measured = sample.travel_m.since(start);
        [measured.left - modelled.left, measured.right - modelled.right]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drivetrain::recording::Sample;

    #[test]
    fn models_that_move_beside_each_other_move_as_each_does_alone() {
        let samples = (0..200).map(|index| {
            let t_s = f64::from(index) * 0.01;
            let swing_vs = 3.0 * (1.0 - (4.0 * t_s).cos()) / 4.0;
            let applied_vs = WheelPair::new(swing_vs, 0.6 * swing_vs);
            Sample { t_s, travel_m: applied_vs.map(|vs| 0.04 * vs), applied_vs }
        });
        let recording = VoltageRecording::new(samples).unwrap();
        let models: Vec<DVector<f64>> = (0..2 * LANES + 3)
            .map(|index| {
                let usual = [0.3, 0.4, 24.0, 0.7, 0.35, 0.3, 23.0, 0.8, 0.1, 0.004, 2.0];
                let mut at = DVector::from_row_slice(&usual) * (1.0 + 0.1 * index as f64);
                at[DELAY] = if index % 5 == 3 { 0.001 } else { 0.004 };
                at
            })
            .collect();
        let alone = |at| residuals(&from_vector(at), &recording).collect::<Vec<f64>>();
        let alone: Vec<_> = models.iter().map(alone).collect();
        assert_eq!(residuals_of_each(&models, &recording), alone);
    }
}
