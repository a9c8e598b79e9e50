//! What did the wheels do in a run, step by step? Turns, speeds, accelerations, reversals.
//!
//! Wheel angles are known in whole counts only, so speeds are differences over a window.

use crate::kinematics::wheel_pair::WheelPair;
use crate::recording::run::{Recording, Robot};

/// Half of the window of a speed \[s\]; wider where the samples are far apart.
const SPEED_HALF_WINDOW_S: f64 = 0.1;
/// The same for accelerations: one count of 0.25 mm in 0.2 s is 1.2 mm/s, so that differences
/// of speeds need a longer lever.
const ACCEL_HALF_WINDOW_S: f64 = 0.15;
/// A reversal of travel shorter than this is dither at rest \[m\].
const REVERSAL_M: f64 = 0.003;

/// One step between two samples of the encoders; nominal, by the encoders alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// Middle of the step, from the run's first sample \[s\].
    pub t_s: f64,
    /// Duration, dt \[s\].
    pub dt_s: f64,
    /// The same middle on the campaign's clock, zero at its first run; zero throughout if it is not known
    /// when the runs began \[s\].
    pub clock_s: f64,
    /// Wheel angles before the step \[rad\].
    pub phi_rad: WheelPair<f64>,
    /// Turned in the step, dphi \[rad\].
    pub dphi_rad: WheelPair<f64>,
    /// Speed of each wheel, R dphi/dt, smoothed \[m/s\].
    pub wheel_speed_mps: WheelPair<f64>,
    /// Acceleration of each wheel's rim, smoothed \[m/s^2\].
    pub wheel_accel_mps2: WheelPair<f64>,
    /// Path travelled before the step, forward or backward \[m\].
    pub path_m: f64,
    /// Path travelled since the last reversal of travel, before the step; `None` before the first \[m\].
    pub since_reversal_m: Option<f64>,
    /// Load on board \[kg\].
    pub payload_kg: f64,
    /// Nominal wheel radius \[m\].
    pub wheel_radius_m: f64,
    /// Nominal track width \[m\].
    pub track_width_m: f64,
    /// Encoder revolutions per wheel revolution.
    pub gear_reduction: f64,
    /// Heading in the middle of the step, as far as it is known \[rad\].
    pub heading_rad: f64,
    /// Place in the middle of the step, as far as it is known \[m\].
    pub place_m: [f64; 2],
}

impl Step {
    /// Nominal travel of each wheel, ds_i = R dphi_i \[m\].
    pub fn wheel_travel_m(&self) -> WheelPair<f64> {
        self.dphi_rad.map(|dphi| self.wheel_radius_m * dphi)
    }

    /// Nominal travel, ds \[m\].
    pub fn travel_m(&self) -> f64 {
        self.wheel_travel_m().mean()
    }

    /// Nominal turn, dtheta \[rad\].
    pub fn turn_rad(&self) -> f64 {
        self.wheel_travel_m().difference() / self.track_width_m
    }

    /// How far the rims rolled, whichever way: the mean of both wheels \[m\].
    pub fn rolled_m(&self) -> f64 {
        let rolled = self.wheel_travel_m().map(f64::abs);
        rolled.mean()
    }

    /// Speed, v \[m/s\].
    pub fn speed_mps(&self) -> f64 {
        self.wheel_speed_mps.mean()
    }

    /// Turn rate, omega \[rad/s\].
    pub fn turn_rate_rad_s(&self) -> f64 {
        self.wheel_speed_mps.difference() / self.track_width_m
    }

    /// Sharpness of the turn, chi = |omega| b / (2 |v| + |omega| b): 0 on a straight, 1 in a spin; at rest, where it is
    /// neither, 0.
    pub fn turn_sharpness(&self) -> f64 {
        let rim_mps = self.turn_rate_rad_s().abs() * self.track_width_m;
        let both_mps = 2.0 * self.speed_mps().abs() + rim_mps;
        if both_mps > 0.0 { rim_mps / both_mps } else { 0.0 }
    }
}

/// A run as steps.
#[derive(Clone, Debug, Default)]
pub(crate) struct Motion {
    /// Time of the first sample \[s\].
    pub start_s: f64,
    pub steps: Vec<Step>,
}

impl Motion {
    /// The steps of a recording that began `clock_s` after the campaign; if that is not known, the
    /// campaign's clock stands still.
    pub fn new(robot: &Robot, recording: &Recording, clock_s: Option<f64>) -> Self {
        let radius_m = robot.wheel_radius_m;
        let start_s = recording.wheels[0].t_s;
        let spacing_s = recording.duration_s() / (recording.wheels.len() - 1) as f64;
        // At least three samples lie within a window.
        let speed_half_s = SPEED_HALF_WINDOW_S.max(1.5 * spacing_s);
        let accel_half_s = ACCEL_HALF_WINDOW_S.max(1.5 * spacing_s);
        // At the ends of the run the window is cut off: a recording may begin and end in motion.
        let (first_s, last_s) = (start_s, start_s + recording.duration_s());
        let window = |t_s: f64, half_s: f64| {
            let (from_s, to_s) = ((t_s - half_s).max(first_s), (t_s + half_s).min(last_s));
            (from_s, to_s, to_s - from_s)
        };
        let speed = |t_s: f64| {
            let (from_s, to_s, span_s) = window(t_s, speed_half_s);
            let (before, after) = (recording.phi_at(from_s), recording.phi_at(to_s));
            before.zip(after).map(|(a, b)| radius_m * (b - a) / span_s)
        };
        let travels: Vec<f64> =
            recording.wheels.iter().map(|sample| radius_m * sample.phi_rad.mean()).collect();
        let since_reversal = since_reversal_m(&travels);
        let mut path_m = 0.0;
        let mut steps = Vec::with_capacity(recording.wheels.len() - 1);
        for (k, pair) in recording.wheels.windows(2).enumerate() {
            let (before, after) = (pair[0], pair[1]);
            let middle_s = (before.t_s + after.t_s) / 2.0;
            let (from_s, to_s, span_s) = window(middle_s, accel_half_s);
            let accel = speed(from_s).zip(speed(to_s));
            let step = Step {
                t_s: middle_s - start_s,
                dt_s: after.t_s - before.t_s,
                clock_s: clock_s.map_or(0.0, |began_s| began_s + middle_s - start_s),
                phi_rad: before.phi_rad,
                dphi_rad: before.phi_rad.zip(after.phi_rad).map(|(a, b)| b - a),
                wheel_speed_mps: speed(middle_s),
                wheel_accel_mps2: accel.map(|(a, b)| (b - a) / span_s),
                path_m,
                since_reversal_m: since_reversal[k],
                payload_kg: recording.payload_kg,
                wheel_radius_m: radius_m,
                track_width_m: robot.track_width_m,
                gear_reduction: robot.gear_reduction,
                ..Step::default()
            };
            path_m += step.travel_m().abs();
            steps.push(step);
        }
        Self { start_s, steps }
    }
}

/// For each sample, the travel since the last reversal, if there was one.
///
/// A reversal counts from the turning point, once the travel has come back by [`REVERSAL_M`].
fn since_reversal_m(travels_m: &[f64]) -> Vec<Option<f64>> {
    let mut since = vec![None; travels_m.len()];
    let mut direction = 0.0;
    let mut furthest = 0;
    for (k, travel_m) in travels_m.iter().enumerate() {
        let beyond_m = travel_m - travels_m[furthest];
        if direction == 0.0 {
            // The run has not yet left its start.
            if beyond_m.abs() > REVERSAL_M {
                direction = beyond_m.signum();
                furthest = k;
            }
        } else if beyond_m * direction >= 0.0 {
            furthest = k;
        } else if beyond_m.abs() > REVERSAL_M {
            // From the turning point on, the distance counts from there.
            for (j, slot) in since.iter_mut().enumerate().skip(furthest) {
                *slot = Some((travels_m[j] - travels_m[furthest]).abs());
            }
            direction = -direction;
            furthest = k;
        }
    }
    since
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reversal_is_counted_from_the_turning_point_and_dither_is_not_one() {
        // Forward 30 mm with a dither of 1 mm, back 20 mm.
        let travels = [0.0, 0.010, 0.009, 0.020, 0.030, 0.029, 0.020, 0.010];
        let since = since_reversal_m(&travels);
        assert_eq!(since[..4], [None; 4]);
        let expected = [0.0, 0.001, 0.010, 0.020];
        for (got, want) in since[4..].iter().zip(expected) {
            // Differences of numbers below one.
            assert!((got.unwrap() - want).abs() < 1e-16, "{since:?}");
        }
    }
}
