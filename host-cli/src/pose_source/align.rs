//! How much a tracker's clock must be shifted to agree with the robot's.
//!
//! The distance from the start and the angle turned depend neither on the tracker's axes nor on the
//! start pose. The shift is the one at which tracker and wheels agree best on both, by least
//! squares:
//!
//! ```text
//! shift = argmin  min over k_d, k_h of
//!         sum ((d_track(t) - k_d d_wheels(t + shift)) / 1 mm)^2 + ((h_track - k_h h_wheels) / 2 mrad)^2
//! ```
//!
//! The factors k absorb a wrong wheel radius or track width.
//!
//! The shift also contains a constant delay of the tracker, which cannot be told from a difference
//! of the clocks. Delays that change within a run are left to `robot-model`.

use robot_model::calibration::TrackSample;
use robot_model::kinematics::Pose;
use robot_model::kinematics::dead_reckon;
use shared_proto::{Config, Telemetry};

use crate::wheel_angles;

/// A pose by dead reckoning, and its time.
#[derive(Clone, Copy, Debug)]
pub struct Reckoned {
    /// Time on the robot's clock \[s\].
    pub t_s: f64,
    /// The pose, from an arbitrary start.
    pub pose: Pose,
}

/// Dead reckoning with the configuration in use, from an arbitrary start.
pub fn reckoned(config: &Config, telemetry: &[Telemetry]) -> Vec<Reckoned> {
    let turns = telemetry.iter().map(|frame| wheel_angles::turns(frame, config));
    let geometry = wheel_angles::geometry(config, 0.0);
    let poses = dead_reckon(Pose::ORIGIN, &geometry, config.geometry.wheel_weight, turns);
    let times = telemetry.iter().map(|frame| frame.t_us as f64 * 1e-6);
    times.zip(poses).map(|(t_s, pose)| Reckoned { t_s, pose }).collect()
}

/// A track with its times shifted to the robot's clock; `None` if it has no motion in common with
/// the wheels.
///
/// If the robot stood still, the first sample is put at the first telemetry: there is no motion to
/// align by, and an exact shift is not needed.
pub fn on_robot_clock(
    mut samples: Vec<TrackSample>,
    reckoned: &[Reckoned],
) -> Option<Vec<TrackSample>> {
    let moved = |poses: &[Reckoned]| {
        poses.iter().any(|reckoned| {
            let (a, b) = (reckoned.pose, poses[0].pose);
            (a.x_m - b.x_m).hypot(a.y_m - b.y_m) > 0.02
                || (a.heading_rad - b.heading_rad).abs() > 0.05
        })
    };
    let shift_s = if moved(reckoned) {
        shift_s(&samples, reckoned)?
    } else {
        reckoned.first()?.t_s - samples.first()?.t_s
    };
    samples.iter_mut().for_each(|sample| sample.t_s += shift_s);
    Some(samples)
}

/// The robot has moved: far above tracking noise, and early in the first ramp \[m, rad\].
const MOVED: (f64, f64) = (0.02, 0.05);
/// Distance and angle of equal weight in the sum \[m, rad\].
const SCALE: (f64, f64) = (0.001, 0.002);
/// The first guess is at most this wrong \[s\].
const NEAR_S: f64 = 0.5;

/// What to add to the track's times to get the robot's \[s\]; `None` if the robot did not move by
/// the track or by the wheels.
pub fn shift_s(track: &[TrackSample], reckoned: &[Reckoned]) -> Option<f64> {
    let by_track = travels(
        track.iter().map(|sample| (sample.t_s, sample.x_m, sample.y_m, sample.heading_rad)),
    );
    let by_wheels = travels(
        reckoned
            .iter()
            .map(|&Reckoned { t_s, pose }| (t_s, pose.x_m, pose.y_m, Some(pose.heading_rad))),
    );
    let first_s = |travels: &[Travel]| {
        let moved = |travel: &&Travel| {
            travel.distance_m > MOVED.0
                || travel.turned_rad.is_some_and(|turned_rad| turned_rad.abs() > MOVED.1)
        };
        travels.iter().find(moved).map(|travel| travel.t_s)
    };
    let guess_s = first_s(&by_wheels)? - first_s(&by_track)?;
    let cost = |shift_s: f64| {
        let (mut distances, mut turns) = (Products::default(), Products::default());
        for travel in &by_track {
            let (distance_m, turned_rad) = at(&by_wheels, travel.t_s + shift_s);
            distances.add(travel.distance_m / SCALE.0, distance_m / SCALE.0);
            if let Some(measured_rad) = travel.turned_rad {
                turns.add(measured_rad / SCALE.1, turned_rad / SCALE.1);
            }
        }
        distances.residual() + turns.residual()
    };
    let mut best_s = guess_s;
    let mut step_s = NEAR_S / 4.0;
    // Down to a tenth of a millisecond.
    while step_s > 1e-4 {
        let tries = (-4..=4).map(|k| best_s + f64::from(k) * step_s);
        best_s = tries.min_by(|a, b| cost(*a).total_cmp(&cost(*b)))?;
        step_s /= 3.0;
    }
    Some(best_s)
}

/// Sums of the products of measured and reckoned values.
#[derive(Default)]
struct Products {
    measured: f64,
    both: f64,
    reckoned: f64,
}

impl Products {
    fn add(&mut self, measured: f64, reckoned: f64) {
        self.measured += measured * measured;
        self.both += measured * reckoned;
        self.reckoned += reckoned * reckoned;
    }

    /// min over k of sum (measured - k reckoned)^2.
    fn residual(&self) -> f64 {
        self.measured - self.both * self.both / self.reckoned.max(f64::MIN_POSITIVE)
    }
}

/// Distance from the start, and angle turned.
struct Travel {
    t_s: f64,
    distance_m: f64,
    turned_rad: Option<f64>,
}

fn travels(poses: impl Iterator<Item = (f64, f64, f64, Option<f64>)>) -> Vec<Travel> {
    let mut start = None;
    let (mut last_rad, mut turned_rad) = (None, 0.0);
    poses
        .map(|(t_s, x_m, y_m, heading_rad)| {
            let (x0_m, y0_m) = *start.get_or_insert((x_m, y_m));
            let turned_rad = heading_rad.map(|now| {
                let step = now - last_rad.replace(now).unwrap_or(now);
                // The shorter way round, whether headings are wrapped or not.
                turned_rad += step - std::f64::consts::TAU * (step / std::f64::consts::TAU).round();
                turned_rad
            });
            Travel { t_s, distance_m: (x_m - x0_m).hypot(y_m - y0_m), turned_rad }
        })
        .collect()
}

/// Distance and turn at a time, linear between samples, constant outside.
fn at(travels: &[Travel], t_s: f64) -> (f64, f64) {
    let value = |travel: &Travel| (travel.distance_m, travel.turned_rad.unwrap_or(0.0));
    let after = travels.partition_point(|travel| travel.t_s <= t_s);
    match (after.checked_sub(1).map(|i| &travels[i]), travels.get(after)) {
        (Some(a), Some(b)) => {
            let share = (t_s - a.t_s) / (b.t_s - a.t_s);
            let ((da, ha), (db, hb)) = (value(a), value(b));
            (da + share * (db - da), ha + share * (hb - ha))
        }
        (Some(travel), None) | (None, Some(travel)) => value(travel),
        (None, None) => (0.0, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp, a cruise and a ramp of 2 s each at 0.2, in metres or radians.
    fn profile(t_s: f64) -> f64 {
        let (up, t) = (2.0, t_s.clamp(0.0, 6.0));
        if t < up {
            0.05 * t * t
        } else if t < 4.0 {
            0.2 + 0.2 * (t - up)
        } else {
            0.8 - 0.05 * (6.0 - t) * (6.0 - t)
        }
    }

    fn shift_of(pose_at: impl Fn(f64) -> (f64, f64, f64)) -> f64 {
        let reckoned: Vec<_> = (0..800)
            .map(|k| {
                let t_s = f64::from(k) * 0.01;
                let (x_m, y_m, heading_rad) = pose_at(t_s - 1.0);
                Reckoned { t_s: 100.0 + t_s, pose: Pose::new(x_m, y_m, heading_rad) }
            })
            .collect();
        // In other axes, 7.1234 s earlier by another clock, with wheels 1 % too small and headings
        // wrapped.
        let track: Vec<_> = (0..240)
            .map(|k| {
                let t_s = f64::from(k) / 30.0;
                let (x_m, y_m, heading_rad) = pose_at(t_s - 1.0);
                TrackSample {
                    t_s: 100.0 + t_s - 7.1234,
                    x_m: 3.0 - 1.01 * y_m,
                    y_m: 5.0 + 1.01 * x_m,
                    heading_rad: Some((heading_rad + 3.0).sin().atan2((heading_rad + 3.0).cos())),
                }
            })
            .collect();
        shift_s(&track, &reckoned).unwrap()
    }

    #[test]
    fn straights_and_spins_find_the_shift_whatever_the_axes() {
        // A millisecond at 0.2 m/s is 0.2 mm, far below a camera's noise.
        let straight = shift_of(|t_s| (profile(t_s), 0.0, 0.0));
        assert!((straight - 7.1234).abs() < 1e-3, "{straight}");
        let spin = shift_of(|t_s| (0.0, 0.0, 10.0 * profile(t_s)));
        assert!((spin - 7.1234).abs() < 1e-3, "{spin}");
    }

    #[test]
    fn a_robot_that_stands_still_has_no_clock_shift() {
        let reckoned = [0.0, 1.0].map(|t_s| Reckoned { t_s, pose: Pose::ORIGIN });
        let track =
            [0.0, 1.0].map(|t_s| TrackSample { t_s, x_m: 0.0, y_m: 0.0, heading_rad: None });
        assert_eq!(shift_s(&track, &reckoned), None);
    }
}
