//! Wheels from odometry that was computed of them: each step between two messages is inverted with the numbers that the
//! odometry used.
//!
//! With (dx, dy) from one position to the next, and theta the headings:
//!
//! ```text
//! dtheta = theta' - theta,   m = theta + dtheta / 2
//! chord = dx cos m + dy sin m,   sideways = dy cos m - dx sin m        two wheels never go sideways
//! travel = chord (dtheta / 2) / sin(dtheta / 2)                        (1): a step is an arc
//! ```
//!
//! Poses are taken, as they add up every step of the wheels, and speeds only where poses say nothing: where there are none,
//! and where the odometry was set back.

use std::f64::consts::PI;
use std::path::Path;

use campaign::CampaignError;

use crate::angle::wrapped;
use crate::bag::{of_stamps, of_topic, stamp_s};
use crate::geometry::Geometry;
use crate::log::{Note, WheelLog, ordered};
use crate::message::Message;

/// A message of odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    t_s: f64,
    position_m: [f64; 2],
    heading_rad: f64,
    /// Forwards, and to the left \[m/s, rad/s\].
    speeds: [f64; 2],
}

/// A step this much longer than its speeds say is none of the wheels: somebody set the odometry back \[m, rad\].
const JUMP: [f64; 2] = [0.2, 0.5];
/// No robot of this kind is faster; for odometry without speeds \[m/s, rad/s\].
const FASTEST: [f64; 2] = [5.0, 20.0];
/// More of the way goes sideways only if something else than two wheels had its say.
const SIDEWAYS_MAX: f64 = 0.05;

/// Reads a topic of odometry as the wheels that it was computed of.
pub fn wheels(
    files: &[&Path],
    topic: &str,
    geometry: &Geometry,
) -> Result<(WheelLog, Vec<Note>), CampaignError> {
    let mut steps: Vec<Step> = Vec::new();
    let mut unstamped = 0;
    let mut notes = of_topic(files, topic, |message, log_time_s| {
        let Message::Poses(framed) = message else { return };
        for framed in framed {
            let (t_s, is_unstamped) = stamp_s(framed.pose.t_s, log_time_s);
            unstamped += usize::from(is_unstamped);
            let [x_m, y_m, _] = framed.pose.position_m;
            let [x, y, z, w] = framed.pose.orientation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
            let heading_rad = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
            let speeds = framed.speeds.unwrap_or_default();
            steps.push(Step { t_s, position_m: [x_m, y_m], heading_rad, speeds });
        }
    })?;
    let file = files.first().copied().unwrap_or(Path::new(""));
    let finite = |step: &Step| {
        let numbers = [step.position_m, step.speeds, [step.heading_rad; 2]];
        numbers.iter().flatten().all(|number| number.is_finite())
    };
    let mut said = ordered(&mut steps, |step| step.t_s, finite);
    let (turned, of_steps) = turned(&steps, geometry);
    said.extend(of_steps);
    notes.extend(said.into_iter().map(|said| Note::new(file, format!("{topic}: {said}"))));
    notes.extend(of_stamps(file, topic, unstamped));
    let t_s = steps.iter().map(|step| step.t_s).collect();
    let what = format!("{topic}, turned back into wheels");
    Ok((WheelLog { file: file.into(), what, t_s, turned, ..WheelLog::default() }, notes))
}

/// The angles of both wheels \[rad\], and what a user should know.
fn turned(steps: &[Step], geometry: &Geometry) -> (Vec<[f64; 2]>, Vec<String>) {
    let has_speeds = steps.iter().any(|step| step.speeds != [0.0; 2]);
    let has_poses = steps.windows(2).any(|pair| {
        pair[0].position_m != pair[1].position_m || pair[0].heading_rad != pair[1].heading_rad
    });
    let mut said = vec![
        "the wheels are computed back from the odometry: what they did between two of its messages is lost, and so is which \
         wheel it was if the odometry took its turns from a gyro"
            .to_owned(),
    ];
    if !has_poses && has_speeds {
        said.push("it has no poses: the speeds were added up, which is less exact".into());
    }
    let (mut phi_rad, mut resets) = ([0.0; 2], 0);
    let (mut gone_m, mut sideways_m) = (0.0, 0.0);
    let mut turned: Vec<[f64; 2]> = steps.first().map(|_| phi_rad).into_iter().collect();
    for pair in steps.windows(2) {
        let dt_s = pair[1].t_s - pair[0].t_s;
        // Of speeds, a trapezium.
        let by_speeds =
            [0, 1].map(|axis| (pair[0].speeds[axis] + pair[1].speeds[axis]) / 2.0 * dt_s);
        let (by_poses, aside_m) = arc(&pair[0], &pair[1]);
        let most = match has_speeds {
            true => by_speeds,
            false => FASTEST.map(|fastest| fastest * dt_s),
        };
        // Within a gap in the log nobody knows how fast the robot was.
        let is_reset = dt_s < 0.5
            && (by_poses[0].hypot(aside_m) > JUMP[0] + 2.0 * most[0].abs()
                || by_poses[1].abs() > JUMP[1] + 2.0 * most[1].abs());
        resets += usize::from(is_reset);
        let [travel_m, turn_rad] = if has_poses && !is_reset { by_poses } else { by_speeds };
        if !is_reset {
            gone_m += by_poses[0].abs();
            sideways_m += aside_m.abs();
        }
        let step_rad = geometry.wheels_turned_rad(travel_m, turn_rad);
        phi_rad = [phi_rad[0] + step_rad[0], phi_rad[1] + step_rad[1]];
        turned.push(phi_rad);
    }
    if resets > 0 {
        said.push(format!(
            "it was set back {resets} times: there the wheels were computed from its speeds"
        ));
    }
    if sideways_m > SIDEWAYS_MAX * gone_m {
        said.push(format!(
            "it goes sideways for {:.0} % of its way, as two wheels cannot: if it is the output of a filter, choose the odometry that goes into that",
            100.0 * sideways_m / gone_m.max(f64::MIN_POSITIVE)
        ));
    }
    (turned, said)
}

/// Travel and turn from one pose to the next by (1), and how far it went sideways.
fn arc(from: &Step, to: &Step) -> ([f64; 2], f64) {
    let turn_rad = wrapped(to.heading_rad - from.heading_rad);
    let half_rad = turn_rad / 2.0;
    let (sin, cos) = (from.heading_rad + half_rad).sin_cos();
    let [dx_m, dy_m] = [0, 1].map(|axis| to.position_m[axis] - from.position_m[axis]);
    let chord_m = dx_m * cos + dy_m * sin;
    let longer = if half_rad.abs() < 1e-6 || half_rad.abs() > PI / 2.0 - 1e-6 {
        1.0
    } else {
        half_rad / half_rad.sin()
    };
    ([chord_m * longer, turn_rad], dy_m * cos - dx_m * sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const GEOMETRY: Geometry = Geometry {
        wheel_radius_m: 0.036,
        radius_multipliers: [1.01, 0.98],
        wheel_separation_m: 0.372,
        separation_multiplier: 1.03,
    };

    /// Wheels at changing speeds for 20 s, and the odometry of them by arcs at 50 Hz.
    fn odometry() -> (Vec<Step>, [f64; 2]) {
        let [left_m, right_m] = GEOMETRY.radii_m();
        let (mut position_m, mut heading_rad, mut phi_rad) = ([1.0, -2.0], 3.0_f64, [0.0; 2]);
        let mut steps = Vec::new();
        let speeds_at = |t_s: f64| [4.0 * (0.7 * t_s).sin(), 5.0 * (0.5 * t_s + 1.0).sin()];
        for k in 0..1000 {
            let t_s = f64::from(k) * 0.02;
            let [w_l, w_r] = speeds_at(t_s);
            let speeds = [
                (left_m * w_l + right_m * w_r) / 2.0,
                (right_m * w_r - left_m * w_l) / GEOMETRY.track_width_m(),
            ];
            let wrapped = (heading_rad + PI).rem_euclid(TAU) - PI;
            steps.push(Step { t_s, position_m, heading_rad: wrapped, speeds });
            if k < 999 {
                phi_rad = [phi_rad[0] + 0.02 * w_l, phi_rad[1] + 0.02 * w_r];
                let [travel_m, turn_rad] = speeds.map(|speed| 0.02 * speed);
                let chord_m = travel_m * (turn_rad / 2.0).sin() / (turn_rad / 2.0);
                let (sin, cos) = (heading_rad + turn_rad / 2.0).sin_cos();
                position_m = [position_m[0] + chord_m * cos, position_m[1] + chord_m * sin];
                heading_rad += turn_rad;
            }
        }
        (steps, phi_rad)
    }

    fn last_off_rad(steps: &[Step], expected: [f64; 2]) -> f64 {
        let (turned, _) = turned(steps, &GEOMETRY);
        assert_eq!(turned.len(), steps.len());
        let last = turned[turned.len() - 1];
        (last[0] - expected[0]).abs().max((last[1] - expected[1]).abs())
    }

    #[test]
    fn arcs_are_inverted_exactly_and_speeds_nearly() {
        let (steps, expected) = odometry();
        assert!(last_off_rad(&steps, expected) < 1e-9);
        assert_eq!(turned(&steps, &GEOMETRY).1.len(), 1);
        let mut still = steps;
        still.iter_mut().for_each(|step| (step.position_m, step.heading_rad) = ([0.0; 2], 0.0));
        let off_rad = last_off_rad(&still, expected);
        assert!(off_rad > 1e-6 && off_rad < 0.1, "{off_rad}");
        assert!(turned(&still, &GEOMETRY).1[1].contains("no poses"));
    }

    #[test]
    fn odometry_that_is_set_back_is_no_motion() {
        let (mut steps, expected) = odometry();
        for step in &mut steps[400..] {
            let ([x_m, y_m], (sin, cos)) = (step.position_m, 1.0_f64.sin_cos());
            step.position_m = [7.0 + cos * x_m - sin * y_m, sin * x_m + cos * y_m - 3.0];
            step.heading_rad += 1.0;
        }
        let off_rad = last_off_rad(&steps, expected);
        assert!(off_rad < 0.01, "{off_rad}");
        let (_, said) = turned(&steps, &GEOMETRY);
        assert!(said[1].contains("set back 1 times"), "{said:?}");
        steps.iter_mut().for_each(|step| step.speeds = [0.0; 2]);
        assert!(turned(&steps, &GEOMETRY).1[1].contains("set back 1 times"));
    }

    #[test]
    fn what_goes_sideways_is_no_odometry_of_two_wheels() {
        let (mut steps, _) = odometry();
        for step in &mut steps {
            step.position_m[0] += 0.05 * step.t_s;
        }
        let (_, said) = turned(&steps, &GEOMETRY);
        assert!(said[1].contains("sideways"), "{said:?}");
    }
}
