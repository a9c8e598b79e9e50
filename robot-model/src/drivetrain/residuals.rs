//! Measured less modelled travel.
//!
//! A count is a floor, and where within the first count a wheel began is unknown: each wheel's travel in each experiment may
//! be off by one constant, as a uniform place within a count of q may (its variance is q^2/12). That constant is integrated
//! out. Of n residuals r with mean m and noise s each, what remains is again a sum of squares:
//!
//! ```text
//! r' = r - g m,   (1 - g)^2 = 1 / (1 + n q^2 / (12 s^2))                                                        (1)
//! ```
//!
//! Without it, half a count that is missing in every experiment passes for a delay of the motors.

use nalgebra::DVector;

use super::constants_vector::{DELAY, couple, from_vector};
use super::model::Drivetrain;
use super::recording::VoltageRecording;
use crate::kinematics::WheelPair;
use crate::numeric::lanes::{LANES, Lanes};

/// Samples per count of travel, on average, at least 1.
pub(super) fn samples_per_count(recordings: &[VoltageRecording]) -> f64 {
    let (mut samples, mut counts) = (0.0, 0.0);
    for recording in recordings {
        let WheelPair { left, right } = recording.count_m();
        for pair in recording.samples().windows(2) {
            let moved = pair[1].travel_m.since(pair[0].travel_m);
            samples += 2.0;
            counts += (moved.left / left).abs() + (moved.right / right).abs();
        }
    }
    if counts > 0.0 && counts.is_finite() { (samples / counts).max(1.0) } else { 1.0 }
}

/// Measured less modelled travel, both wheels, sample by sample, as in (1) with this noise squared \[m\].
pub(super) fn residuals(model: &Drivetrain, recording: &VoltageRecording, noise: f64) -> Vec<f64> {
    measured_less(recording, model.travel_m(recording), noise)
}

/// The same of several models. Those with one delay move beside each other, one in each lane: a step waits for the step
/// before, and alone a processor would mostly wait.
pub(super) fn residuals_of_each(
    models: &[DVector<f64>],
    recording: &VoltageRecording,
    noise: f64,
) -> Vec<Vec<f64>> {
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
            residuals[first] = self::residuals(&from_vector(&models[first]), recording, noise);
            continue;
        }
        // Lanes that are left over move as the first one does.
        let model = |lane: usize| &models[together.get(lane).copied().unwrap_or(first)];
        let lanes = couple(|constant| Lanes(core::array::from_fn(|lane| model(lane)[constant])));
        let travel_m = lanes.travel_m(delay_s, recording);
        for (lane, &index) in together.iter().enumerate() {
            let alone = travel_m.iter().map(|both| both.map(|lanes| lanes.0[lane]));
            residuals[index] = measured_less(recording, alone, noise);
        }
    }
    residuals
}

/// Measured less modelled travel, both wheels, sample by sample, as in (1) with this noise squared \[m\].
fn measured_less(
    recording: &VoltageRecording,
    modelled: impl IntoIterator<Item = WheelPair<f64>>,
    noise: f64,
) -> Vec<f64> {
    let samples = recording.samples();
    let start = samples[0].travel_m;
    let left: Vec<WheelPair<f64>> = samples
        .iter()
        .zip(modelled)
        .map(|(sample, modelled)| sample.travel_m.since(start).since(modelled))
        .collect();
    let count = left.len() as f64;
    let sum = left.iter().fold(WheelPair::both(0.0), |sum: WheelPair<f64>, of| {
        WheelPair::new(sum.left + of.left, sum.right + of.right)
    });
    let begun = sum.zip(recording.count_m()).map(|(sum, count_m)| {
        let place = count_m * count_m / 12.0;
        // Before a noise is known it is a count's own.
        let noise = if noise > 0.0 { noise } else { place };
        let known = if place > 0.0 { 1.0 / (1.0 + count * place / noise) } else { 1.0 };
        (1.0 - known.sqrt()) * sum / count
    });
    left.into_iter().flat_map(|of| [of.left - begun.left, of.right - begun.right]).collect()
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
        let recording = recording.with_counts_of(WheelPair::new(1e-3, 2e-3));
        let alone = |at| residuals(&from_vector(at), &recording, 1e-7);
        let alone: Vec<_> = models.iter().map(alone).collect();
        assert_eq!(residuals_of_each(&models, &recording, 1e-7), alone);
    }
}
