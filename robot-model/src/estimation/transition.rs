//! Where does one increment lead the pose, and with which derivatives? And which measurements fall within a run?

use crate::effect::composition::Increment;
use crate::kinematics::pose::Pose;
use crate::numeric::angle::{sinc, sinc_slope};
use crate::recording::motion::Motion;
use crate::recording::run::PoseMeasurement;

/// A move by a share of an increment: where it leads, and its derivatives by the start's heading
/// and by the increment.
pub(crate) struct Transition {
    pub pose: Pose,
    /// Derivative of x and y by the heading.
    pub by_heading: [f64; 2],
    /// Derivative of x and y by the turn.
    by_turn: [f64; 2],
    /// sinc(turn/2) times the unit vector ahead.
    ahead: [f64; 2],
}

impl Transition {
    pub fn new(pose: Pose, increment: &Increment, share: f64) -> Self {
        let turn = increment.turn_rad * share;
        let (travel_m, sideways_m) = (increment.travel_m * share, increment.sideways_m * share);
        let half = turn / 2.0;
        let (sin, cos) = (pose.heading_rad + half).sin_cos();
        let shorter = sinc(half);
        let slope = sinc_slope(half, shorter);
        let chord = [travel_m * cos - sideways_m * sin, travel_m * sin + sideways_m * cos];
        let moved = [shorter * chord[0], shorter * chord[1]];
        Self {
            pose: Pose {
                x_m: pose.x_m + moved[0] + increment.drift_m[0] * share,
                y_m: pose.y_m + moved[1] + increment.drift_m[1] * share,
                heading_rad: pose.heading_rad + turn,
            },
            by_heading: [-moved[1], moved[0]],
            by_turn: [0.5 * (slope * chord[0] - moved[1]), 0.5 * (slope * chord[1] + moved[0])],
            ahead: [shorter * cos, shorter * sin],
        }
    }

    /// The change of the pose by a small change of the increment.
    pub fn differential(&self, change: &Increment, share: f64) -> [f64; 3] {
        let [cos, sin] = self.ahead;
        let ahead = change.travel_m * cos - change.sideways_m * sin;
        let left = change.travel_m * sin + change.sideways_m * cos;
        [
            share * (ahead + self.by_turn[0] * change.turn_rad + change.drift_m[0]),
            share * (left + self.by_turn[1] * change.turn_rad + change.drift_m[1]),
            share * change.turn_rad,
        ]
    }
}

/// The poses measured while the encoders were recorded. They do not depend on a model's delay, as models are
/// compared on the same measurements.
pub(crate) fn within<'s>(
    motion: &Motion,
    measurements: &'s [PoseMeasurement],
) -> impl Iterator<Item = &'s PoseMeasurement> {
    let start_s = motion.start_s;
    let end_s = start_s + motion.steps.iter().map(|step| step.dt_s).sum::<f64>();
    let during = start_s - TIME_ROUNDING_S..=end_s + TIME_ROUNDING_S;
    measurements.iter().filter(move |pose| during.contains(&pose.t_s))
}

/// Times that differ by less are the same \[s\]: sums of steps are rounded.
pub(crate) const TIME_ROUNDING_S: f64 = 1e-7;
