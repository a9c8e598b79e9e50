//! Can wheels and poses be of one robot? They cannot if a radius, a gear or a track width is off by a factor, if a
//! sign is wrong, or if two encoders are exchanged.
//!
//! This compares all runs of a campaign together, in the right units; units are tested in `units.rs`.

use crate::numeric::angle::wrap;
use crate::recording::run::{PoseMeasurement, Recording, Robot};

use super::dead_reckoning::{FAR_M, Reckoned, TURNED_RAD, at, median};

/// Why wheels and poses cannot be of one robot, by the median of all runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mismatch {
    /// On straight paths the robot went this many times as far as its wheels rolled.
    Travel {
        /// How many times.
        times: f64,
    },
    /// It went backwards where its wheels rolled forwards, and the other way round.
    Backwards,
    /// It turned this many times as far as its wheels turned it; negative if the other way round.
    Turns {
        /// How many times.
        times: f64,
    },
}

/// A robot that is merely inaccurate stays well within this factor. A diameter for a radius, or half the edges
/// of an encoder, is beyond it.
const FACTOR: f64 = 1.5;
/// A path is straight if it is at most this many times as long as the distance between its ends, and if both
/// wheels and poses turned by less than this \[rad\].
const STRAIGHT: (f64, f64) = (1.1, 0.5);
/// After a larger turn between two poses, a wrapped heading may stand for another number of turns \[rad\].
const TURNED_MAX_RAD: f64 = 2.0;
/// If the wheels turned it by less, they did not turn it at all \[rad\].
const TURNED_MIN_RAD: f64 = 1e-5;

/// What is wrong with a campaign as a whole. Its runs must be valid, and none of them suspicious.
pub fn mismatch(robot: &Robot, runs: &[Recording]) -> Option<Mismatch> {
    let (mut travels, mut turns) = (Vec::new(), Vec::new());
    for run in runs {
        let reckoned = Reckoned::of(robot, run);
        travels.extend(median(reckoned.travels()));
        turns.extend(median(reckoned.turns()));
    }
    if let Some(times) = median(travels).filter(|times| !plausible(*times)) {
        return Some(match plausible(-times) {
            true => Mismatch::Backwards,
            false => Mismatch::Travel { times: times.abs() },
        });
    }
    let times = median(turns).filter(|times| !plausible(*times))?;
    Some(Mismatch::Turns { times })
}

fn plausible(times: f64) -> bool {
    (1.0 / FACTOR..=FACTOR).contains(&times)
}

impl Reckoned<'_> {
    /// On straight paths from the first measured pose: the measured distance over the distance by the wheels;
    /// negative where they go opposite ways.
    fn travels(&self) -> Vec<f64> {
        let poses = self.run.measured_poses.iter();
        let mut measured = poses.filter_map(|pose| Some((pose, pose.position_m?)));
        let Some((first, from_m)) = measured.next() else { return Vec::new() };
        let from = at(self.run, &self.poses, first.t_s);
        let ratio = |(measurement, to_m): (&PoseMeasurement, [f64; 2])| {
            let by_wheels = at(self.run, &self.poses, measurement.t_s).seen_from(from);
            let wheels_m = by_wheels.x_m.hypot(by_wheels.y_m);
            let path_m = self.rolled(first.t_s, measurement.t_s).0;
            let went_m = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
            let far = wheels_m.max(went_m[0].hypot(went_m[1])) > FAR_M && wheels_m > 0.0;
            let turned = by_wheels.heading_rad.abs() > STRAIGHT.1;
            if !far || turned || path_m > STRAIGHT.0 * wheels_m {
                return None;
            }
            let times = went_m[0].hypot(went_m[1]) / wheels_m;
            let ahead_m = first.heading_rad.map_or(1.0, |heading_rad| {
                let along_m = went_m[0] * heading_rad.cos() + went_m[1] * heading_rad.sin();
                along_m * by_wheels.x_m.signum()
            });
            // Sideways, as with a wrong heading, counts as forwards.
            Some(if ahead_m < -0.5 * times * wheels_m { -times } else { times })
        };
        let straight = |(pose, _): &(&PoseMeasurement, _)| {
            let turned_rad = first.heading_rad.zip(pose.heading_rad).map(|(a, b)| wrap(b - a));
            turned_rad.is_none_or(|turned_rad| turned_rad.abs() < STRAIGHT.1)
        };
        // After a turn it may face forwards again, but on another line.
        measured.take_while(straight).filter_map(ratio).collect()
    }

    /// The measured turn over the turn by the wheels, piece by piece.
    fn turns(&self) -> Vec<f64> {
        let heading = |pose: &PoseMeasurement| {
            Some((pose.heading_rad?, at(self.run, &self.poses, pose.t_s).heading_rad))
        };
        let headings: Vec<(f64, f64)> =
            self.run.measured_poses.iter().filter_map(heading).collect();
        let (mut measured_rad, mut wheels_rad) = (0.0_f64, 0.0_f64);
        let mut ratios = Vec::new();
        for pair in headings.windows(2) {
            let by_wheels = pair[1].1 - pair[0].1;
            if by_wheels.abs() < TURNED_MAX_RAD {
                measured_rad += wrap(pair[1].0 - pair[0].0);
                wheels_rad += by_wheels;
                if measured_rad.abs().max(wheels_rad.abs()) < TURNED_RAD {
                    continue;
                }
                // Wheels that did not turn the robot at all give no factor.
                if wheels_rad.abs() > TURNED_MIN_RAD {
                    ratios.push(measured_rad / wheels_rad);
                }
            }
            (measured_rad, wheels_rad) = (0.0, 0.0);
        }
        ratios
    }
}
