//! A tracker's clock brought to the robot's.
//!
//! How far the robot is from its start, and how far it has turned, depend neither on where the tracker's
//! axes lie nor on the start pose. The shift is the one at which both look the same by the tracker and
//! by the wheels, least squares:
//!
//! ```text
//! shift = argmin  min over k_d, k_h of
//!         sum ((d_track(t) - k_d d_wheels(t + shift)) / 1 mm)^2 + ((h_track - k_h h_wheels) / 2 mrad)^2
//! ```
//!
//! The factors k keep a wrong wheel radius or track width out of the clock.
//!
//! A constant lateness of the tracker goes into the shift, too: two clocks that were never compared
//! cannot show it.

use robot_model::calibration::TrackSample;
use robot_model::kinematics::Pose;
use robot_model::kinematics::dead_reckon;
use shared_proto::{Config, Telemetry};

use crate::wheels;

/// The robot by its wheels at one time.
#[derive(Clone, Copy, Debug)]
pub struct Reckoned {
    /// The robot's clock \[s\].
    pub t_s: f64,
    /// Dead reckoning from anywhere.
    pub pose: Pose,
}

/// The robot by its wheels, from anywhere, with the configuration in use.
pub fn reckoned(config: &Config, telemetry: &[Telemetry]) -> Vec<Reckoned> {
    let turns = telemetry.iter().map(|frame| wheels::turns(frame, config));
    let geometry = wheels::geometry(config, 0.0);
    let poses = dead_reckon(Pose::ORIGIN, &geometry, config.geometry.wheel_weight, turns);
    let times = telemetry.iter().map(|frame| frame.t_us as f64 * 1e-6);
    times.zip(poses).map(|(t_s, pose)| Reckoned { t_s, pose }).collect()
}

/// A track by another clock, on the robot's. A track of a robot that stood still is put over the
/// telemetry as it is: there is no motion to go by, and none is needed.
pub fn on_robot_clock(
    mut samples: Vec<TrackSample>,
    reckoned: &[Reckoned],
) -> Option<Vec<TrackSample>> {
    let moved = |poses: &[Reckoned]| {
        poses.iter().any(|it| {
            let (a, b) = (it.pose, poses[0].pose);
            (a.x_m - b.x_m).hypot(a.y_m - b.y_m) > 0.02
                || (a.heading_rad - b.heading_rad).abs() > 0.05
        })
    };
    let shift_s = if moved(reckoned) {
        shift_s(&samples, reckoned)?
    } else {
        reckoned.first()?.t_s - samples.first()?.t_s
    };
    samples.iter_mut().for_each(|it| it.t_s += shift_s);
    Some(samples)
}

/// Beyond any tracking noise, early in the first ramp \[m, rad\].
const MOVED: (f64, f64) = (0.02, 0.05);
/// What counts alike.
const SCALE: (f64, f64) = (0.001, 0.002);
/// The first guess is right to this \[s\].
const NEAR_S: f64 = 0.5;

/// What to add to the track's times to have them on the robot's clock \[s\]; `None` where either of
/// them did not move.
pub fn shift_s(track: &[TrackSample], reckoned: &[Reckoned]) -> Option<f64> {
    let by_track = travels(track.iter().map(|it| (it.t_s, it.x_m, it.y_m, it.heading_rad)));
    let by_wheels = travels(
        reckoned.iter().map(|it| (it.t_s, it.pose.x_m, it.pose.y_m, Some(it.pose.heading_rad))),
    );
    let first_s = |travels: &[Travel]| {
        let moved = |it: &&Travel| {
            it.distance_m > MOVED.0 || it.turned_rad.is_some_and(|it| it.abs() > MOVED.1)
        };
        travels.iter().find(moved).map(|it| it.t_s)
    };
    let guess_s = first_s(&by_wheels)? - first_s(&by_track)?;
    let cost = |shift_s: f64| {
        let (mut along, mut round) = (Products::default(), Products::default());
        for it in &by_track {
            let (distance_m, turned_rad) = at(&by_wheels, it.t_s + shift_s);
            along.add(it.distance_m / SCALE.0, distance_m / SCALE.0);
            if let Some(seen_rad) = it.turned_rad {
                round.add(seen_rad / SCALE.1, turned_rad / SCALE.1);
            }
        }
        along.left_over() + round.left_over()
    };
    let mut best_s = guess_s;
    let mut step_s = NEAR_S / 4.0;
    // To a tenth of a millisecond.
    while step_s > 1e-4 {
        let tries = (-4..=4).map(|k| best_s + f64::from(k) * step_s);
        best_s = tries.min_by(|a, b| cost(*a).total_cmp(&cost(*b)))?;
        step_s /= 3.0;
    }
    Some(best_s)
}

/// Sums of products of what was seen and what was reckoned.
#[derive(Default)]
struct Products {
    seen: f64,
    both: f64,
    reckoned: f64,
}

impl Products {
    fn add(&mut self, seen: f64, reckoned: f64) {
        self.seen += seen * seen;
        self.both += seen * reckoned;
        self.reckoned += reckoned * reckoned;
    }

    /// min over k of sum (seen - k reckoned)^2.
    fn left_over(&self) -> f64 {
        self.seen - self.both * self.both / self.reckoned.max(f64::MIN_POSITIVE)
    }
}

/// How far from the start, how far turned.
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
                // Wrapped or not, the shorter way round.
                turned_rad += step - std::f64::consts::TAU * (step / std::f64::consts::TAU).round();
                turned_rad
            });
            Travel { t_s, distance_m: (x_m - x0_m).hypot(y_m - y0_m), turned_rad }
        })
        .collect()
}

/// Distance and turn at a time, linear between samples, constant outside.
fn at(travels: &[Travel], t_s: f64) -> (f64, f64) {
    let value = |it: &Travel| (it.distance_m, it.turned_rad.unwrap_or(0.0));
    let after = travels.partition_point(|it| it.t_s <= t_s);
    match (after.checked_sub(1).map(|i| &travels[i]), travels.get(after)) {
        (Some(a), Some(b)) => {
            let share = (t_s - a.t_s) / (b.t_s - a.t_s);
            let ((da, ha), (db, hb)) = (value(a), value(b));
            (da + share * (db - da), ha + share * (hb - ha))
        }
        (Some(it), None) | (None, Some(it)) => value(it),
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
        // Seen in other axes, 7.1234 s earlier by another clock, wheels 1 % too small, headings wrapped.
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
        // A millisecond at 0.2 m/s is 0.2 mm, far below what a camera sees.
        let straight = shift_of(|t_s| (profile(t_s), 0.0, 0.0));
        assert!((straight - 7.1234).abs() < 1e-3, "{straight}");
        let spin = shift_of(|t_s| (0.0, 0.0, 10.0 * profile(t_s)));
        assert!((spin - 7.1234).abs() < 1e-3, "{spin}");
    }

    #[test]
    fn a_robot_that_stands_says_nothing_about_clocks() {
        let reckoned = [0.0, 1.0].map(|t_s| Reckoned { t_s, pose: Pose::ORIGIN });
        let track =
            [0.0, 1.0].map(|t_s| TrackSample { t_s, x_m: 0.0, y_m: 0.0, heading_rad: None });
        assert_eq!(shift_s(&track, &reckoned), None);
    }
}
