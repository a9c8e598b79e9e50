//! Which experiments are alike?
//!
//! What a model misses, as tyres that bend or a caster that swings round, moves the constants alike in all experiments that go the
//! same way at about the same voltage. Such experiments are no independent observations of a constant, however many there are.

use super::experiment::Experiment;
use crate::drivetrain::intervals::Share;

/// Voltages are alike within so many equal parts of the highest.
const LEVELS: f64 = 3.0;
/// A wheel goes one way if it is driven that way so many times as much as the other.
const ONE_WAY: f64 = 3.0;

/// Which way each wheel is driven, 0 for both ways; and the part of the highest voltage.
type Kind = ([i8; 2], u8);

/// The shares of the normal equations, those of experiments that are alike summed.
pub(super) fn alike_together(experiments: &[&Experiment], shares: Vec<Share>) -> Vec<Share> {
    let mut groups: Vec<(Kind, Share)> = Vec::new();
    for (kind, share) in kinds(experiments).into_iter().zip(shares) {
        match groups.iter_mut().find(|group| group.0 == kind) {
            Some((_, sum)) => {
                sum.gram += share.gram;
                sum.gradient += share.gradient;
            }
            None => groups.push((kind, share)),
        }
    }
    groups.into_iter().map(|group| group.1).collect()
}

fn kinds(experiments: &[&Experiment]) -> Vec<Kind> {
    let driven: Vec<([i8; 2], f64)> = experiments.iter().map(|one| driven(one)).collect();
    let highest_v = driven.iter().fold(1e-9_f64, |highest, one| highest.max(one.1));
    // The highest voltage itself belongs to the last part.
    let level = |volts: f64| (LEVELS * volts / highest_v).min(LEVELS - 1.0) as u8;
    driven.into_iter().map(|(ways, volts)| (ways, level(volts))).collect()
}

/// Which way each wheel is driven, and the highest voltage of either \[V\].
fn driven(experiment: &Experiment) -> ([i8; 2], f64) {
    let mut ways_vs = [[0.0_f64; 2]; 2];
    let mut highest_v = 0.0_f64;
    for pair in experiment.recording.samples().windows(2) {
        let applied = pair[1].applied_vs.since(pair[0].applied_vs);
        let dt_s = pair[1].t_s - pair[0].t_s;
        for (way_vs, vs) in ways_vs.iter_mut().zip([applied.left, applied.right]) {
            way_vs[usize::from(vs < 0.0)] += vs.abs();
            highest_v = highest_v.max(vs.abs() / dt_s);
        }
    }
    let way = |[forwards, backwards]: [f64; 2]| {
        i8::from(forwards > ONE_WAY * backwards) - i8::from(backwards > ONE_WAY * forwards)
    };
    (ways_vs.map(way), highest_v)
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::drivetrain::intervals::Intervals;
    use crate::drivetrain::recording::{Sample, VoltageRecording};
    use crate::kinematics::WheelPair;

    /// Voltages of the left and the right motor, each pair for a second, in rows of half a second.
    fn experiment(volts: &[(f64, f64)]) -> Experiment {
        let mut applied_vs = WheelPair::both(0.0);
        let mut samples = vec![Sample { t_s: 0.0, travel_m: WheelPair::both(0.0), applied_vs }];
        for (left, right) in volts.iter().flat_map(|pair| [pair; 2]) {
            let t_s = 0.5 * samples.len() as f64;
            applied_vs.left += 0.5 * left;
            applied_vs.right += 0.5 * right;
            samples.push(Sample { t_s, travel_m: WheelPair::both(0.0), applied_vs });
        }
        let recording = VoltageRecording::new(samples).unwrap();
        Experiment { recording, started_s: 0.0, heading_rad: 0.0, held_out: false }
    }

    #[test]
    fn the_way_of_each_wheel_and_about_the_voltage_make_experiments_alike() {
        let slow = experiment(&[(2.0, 2.0), (0.0, 0.0)]);
        let about_as_slow = experiment(&[(2.6, 2.6)]);
        let fast = experiment(&[(9.0, 9.0)]);
        let backwards = experiment(&[(-2.0, -2.0)]);
        let spin = experiment(&[(-2.0, 2.0)]);
        let reversal = experiment(&[(2.0, 2.0), (-2.0, -2.0)]);
        let kinds = kinds(&[&slow, &about_as_slow, &fast, &backwards, &spin, &reversal]);
        assert_eq!(kinds[0], kinds[1]);
        for (i, one) in kinds.iter().enumerate().skip(1) {
            assert!(kinds[..i].iter().all(|other| i == 1 || other != one), "{kinds:?}");
        }
    }

    /// Slow and fast experiments disagree by what the model misses; each kind agrees with itself.
    #[test]
    fn what_moves_experiments_alike_shows_in_the_interval() {
        let volts = [2.0, 2.0, 2.0, 2.0, 5.0, 5.0, 5.0, 5.0, 9.0, 9.0, 9.0, 9.0];
        let experiments: Vec<Experiment> = volts.map(|v| experiment(&[(v, v)])).into();
        let experiments: Vec<&Experiment> = experiments.iter().collect();
        let shares = || -> Vec<Share> {
            let error = |(i, v): (usize, f64)| 0.1 * (v - 5.0) + 0.01 * (i % 2) as f64;
            let share = |error| Share {
                gram: DMatrix::from_element(1, 1, 1.0),
                gradient: DVector::from_element(1, error),
            };
            volts.into_iter().enumerate().map(error).map(share).collect()
        };
        let gram = DMatrix::from_element(1, 1, 12.0);
        let one = DVector::from_element(1, 1.0);
        let of = |shares: &[Share]| Intervals::new(&gram, shares).unwrap().half_width_95(&one);
        let together = alike_together(&experiments, shares());
        assert_eq!(together.len(), 3);
        let (each, alike) = (of(&shares()), of(&together));
        assert!(alike > 3.0 * each, "{alike} {each}");
    }
}
