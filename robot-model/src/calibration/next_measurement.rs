//! Which measurement would make W_T surer, and how sure would it be then?

use super::wheel_weight::arc::Arc;
use super::wheel_weight::error::WheelWeightError;
use super::wheel_weight::experiment::{Deviation, Experiment};
use super::wheel_weight::uncertainty::Source;
use super::wheel_weight::weight::{Action, Advice, WheelWeight};
use crate::kinematics::wheel_pair::WheelPair;

/// A ruler's uncertainty when nothing else is known: half a millimetre \[m\].
const RULER_SIGMA_M: f64 = 0.0005;

impl Experiment {
    /// W_T and how sure it is.
    pub fn wheel_weight(&self) -> Result<WheelWeight, WheelWeightError> {
        let bare = self.propagate()?;
        let advice = Advice::for_experiment(self, &bare);
        Ok(WheelWeight { advice, ..bare })
    }
}

impl Advice {
    /// Advice for a reading at the end of a run: the best of all candidates.
    pub(crate) fn for_experiment(experiment: &Experiment, weight: &WheelWeight) -> Self {
        let (dominating, share) = weight.dominating();
        let candidates = match dominating {
            Source::Reading => match experiment.deviation {
                Deviation::Tangent { dx_m, dy_m, sigma_m } => vec![
                    (Action::OffsetInsteadOfTangent, with_offset(experiment, weight, sigma_m)),
                    (
                        Action::LongerBase { dx_m: 4.0 * dx_m },
                        sigma_of(&Experiment {
                            deviation: Deviation::Tangent {
                                dx_m: 4.0 * dx_m,
                                dy_m: 4.0 * dy_m,
                                sigma_m,
                            },
                            ..*experiment
                        }),
                    ),
                ],
                Deviation::Heading { .. } => vec![
                    (
                        Action::OffsetInsteadOfHeading { sigma_m: RULER_SIGMA_M },
                        with_offset(experiment, weight, RULER_SIGMA_M),
                    ),
                    twice_as_far(experiment, weight),
                ],
                Deviation::LateralOffset { .. } => vec![twice_as_far(experiment, weight)],
            },
            Source::StartHeading => {
                vec![half_way_too(experiment, weight), twice_as_far(experiment, weight)]
            }
            Source::TrackWidth | Source::WheelRadius => vec![once_more(weight)],
            _ => vec![twice_as_far(experiment, weight)],
        };
        Self::best(dominating, share, candidates)
    }

    /// Advice for a fitted track.
    pub(crate) fn for_track(weight: &WheelWeight) -> Self {
        let (dominating, share) = weight.dominating();
        let candidate = match dominating {
            Source::TrackWidth | Source::WheelRadius => once_more(weight),
            Source::Wander => {
                let others = weight.sigma_without(|source| source == Source::Wander);
                let wander = part(weight, Source::Wander);
                (Action::FourRuns, (wander / 2.0).hypot(others))
            }
            _ => {
                // With twice the length the noise of a point turns the track half as much, and
                // alpha is twice as large; wandering grows with the root of the length.
                let others = weight
                    .sigma_without(|source| matches!(source, Source::TrackNoise | Source::Wander));
                let noise = part(weight, Source::TrackNoise) / 4.0;
                let wander = part(weight, Source::Wander) / 2_f64.sqrt();
                (Action::DriveTwiceAsFar, noise.hypot(wander).hypot(others))
            }
        };
        Self::best(dominating, share, vec![candidate])
    }

    fn best(dominating: Source, share: f64, candidates: Vec<(Action, f64)>) -> Self {
        let best = candidates.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let (action, sigma_then) = best.expect("there is always a candidate");
        Self { dominating, share, action, sigma_then }
    }
}

fn part(weight: &WheelWeight, source: Source) -> f64 {
    weight.contributions.iter().find(|part| part.source == source).map_or(0.0, |part| part.sigma)
}

/// The sigma that an experiment would give; infinite if it is impossible.
fn sigma_of(experiment: &Experiment) -> f64 {
    experiment.propagate().map_or(f64::INFINITY, |weight| weight.sigma)
}

/// The same run, read by its lateral offset.
fn with_offset(experiment: &Experiment, weight: &WheelWeight, sigma_m: f64) -> f64 {
    let arc = Arc {
        travel_left_m: experiment.geometry.wheel_radius_m * experiment.turns.left,
        track_width_m: experiment.geometry.track_width_m,
    };
    let y_m = arc.offset_m(weight.alpha_rad);
    sigma_of(&Experiment { deviation: Deviation::LateralOffset { y_m, sigma_m }, ..*experiment })
}

/// A run of twice the length, read in the same way: alpha doubles.
fn twice_as_far(experiment: &Experiment, weight: &WheelWeight) -> (Action, f64) {
    let turns =
        WheelPair { left: 2.0 * experiment.turns.left, right: 2.0 * experiment.turns.right };
    let alpha_rad = 2.0 * weight.alpha_rad;
    let longer = Experiment { turns, ..*experiment };
    let sigma = match experiment.deviation {
        Deviation::LateralOffset { sigma_m, .. } => {
            let there = WheelWeight { alpha_rad, ..weight.clone() };
            with_offset(&longer, &there, sigma_m)
        }
        Deviation::Heading { sigma_rad, .. } => {
            let deviation = Deviation::Heading { heading_rad: -alpha_rad, sigma_rad };
            sigma_of(&Experiment { deviation, ..longer })
        }
        Deviation::Tangent { dx_m, sigma_m, .. } => {
            let deviation = Deviation::Tangent { dx_m, dy_m: dx_m * alpha_rad.tan(), sigma_m };
            sigma_of(&Experiment { deviation, ..longer })
        }
    };
    (Action::DriveTwiceAsFar, sigma)
}

/// Offsets y_h half way and y at the end: y - 2 y_h = -s alpha / 4 whatever the start heading was.
fn half_way_too(experiment: &Experiment, weight: &WheelWeight) -> (Action, f64) {
    let geometry = &experiment.geometry;
    let sigma_m = match experiment.deviation {
        Deviation::Tangent { sigma_m, .. } | Deviation::LateralOffset { sigma_m, .. } => sigma_m,
        Deviation::Heading { .. } => RULER_SIGMA_M,
    };
    let right_m = geometry.wheel_radius_m * experiment.turns.right;
    let alpha_sigma_rad = 4.0 * 5_f64.sqrt() * sigma_m / right_m.abs();
    let reading = geometry.track_width_m / right_m.abs() * alpha_sigma_rad;
    let others =
        weight.sigma_without(|source| matches!(source, Source::Reading | Source::StartHeading));
    (Action::OffsetHalfWayToo, reading.hypot(others))
}

/// Tolerances of b and R act in proportion to alpha, which is nearly zero in the next run.
fn once_more(weight: &WheelWeight) -> (Action, f64) {
    let tolerance = |source| matches!(source, Source::TrackWidth | Source::WheelRadius);
    (Action::CalibrateOnceMore, weight.sigma_without(tolerance))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::geometry::Geometry;
    use core::f64::consts::TAU;

    fn advice(deviation: Deviation, change: impl Fn(&mut Experiment)) -> (Advice, f64) {
        let mut experiment = Experiment {
            deviation,
            turns: WheelPair::both(8.0 * TAU),
            geometry: Geometry::PAPER,
            start_heading_sigma_rad: 0.0,
        };
        change(&mut experiment);
        let weight = experiment.wheel_weight().unwrap();
        (weight.advice, weight.sigma)
    }

    const TANGENT: Deviation = Deviation::Tangent { dx_m: 0.025_25, dy_m: 0.001, sigma_m: 0.0005 };
    const HEADING: Deviation = Deviation::Heading { heading_rad: -0.04, sigma_rad: 0.0001 };
    const OFFSET: Deviation = Deviation::LateralOffset { y_m: -0.036, sigma_m: 0.0005 };

    #[test]
    fn the_papers_tangent_should_become_a_lateral_offset() {
        let (advice, sigma) = advice(TANGENT, |_| ());
        assert_eq!(advice.dominating, Source::Reading);
        assert!(advice.share > 0.99, "{advice:?}");
        assert_eq!(advice.action, Action::OffsetInsteadOfTangent);
        // b / s x 2 sigma / s = 0.372 / 1.81 x 2 x 0.5 mm / 1.81 m = 1.14e-4; the encoders add 0.80e-4.
        assert!((1.37e-4..1.43e-4).contains(&advice.sigma_then), "{advice:?}");
        assert!(advice.sigma_then < sigma / 25.0);
    }

    #[test]
    fn a_crooked_start_is_cancelled_by_a_second_reading() {
        let (advice, sigma) =
            advice(OFFSET, |experiment| experiment.start_heading_sigma_rad = 0.01);
        assert_eq!(advice.dominating, Source::StartHeading);
        assert_eq!(advice.action, Action::OffsetHalfWayToo);
        assert!(advice.sigma_then < sigma / 5.0, "{advice:?} instead of {sigma}");
    }

    #[test]
    fn advice_never_makes_it_worse() {
        for start in [0.0, 0.0003, 0.0005, 0.001, 0.01] {
            for deviation in [TANGENT, OFFSET, HEADING] {
                let (advice, sigma) =
                    advice(deviation, |experiment| experiment.start_heading_sigma_rad = start);
                assert!(advice.sigma_then < sigma, "{start} {deviation:?}: {advice:?}");
            }
        }
    }

    #[test]
    fn the_tolerance_of_the_track_width_cancels_in_a_second_calibration() {
        let (advice, sigma) =
            advice(OFFSET, |experiment| experiment.geometry.track_width_sigma_m = 0.02);
        assert_eq!(advice.dominating, Source::TrackWidth);
        assert_eq!(advice.action, Action::CalibrateOnceMore);
        assert!(advice.sigma_then < sigma / 2.0, "{advice:?} instead of {sigma}");
    }

    #[test]
    fn twice_the_run_makes_an_offset_count_four_times_and_the_encoders_twice() {
        for (counts_per_wheel_rev, factor) in [(1e9, 4.0), (30.0, 2.0)] {
            let (advice, sigma) = advice(OFFSET, |experiment| {
                experiment.geometry.counts_per_wheel_rev = counts_per_wheel_rev
            });
            assert_eq!(advice.action, Action::DriveTwiceAsFar);
            // An arc twice as long leaves the line a little slower than in proportion: 1 % at 0.08 rad.
            let gain = sigma / advice.sigma_then;
            assert!((gain / factor - 1.0).abs() < 0.02, "{counts_per_wheel_rev}: {gain}");
        }
    }
}
