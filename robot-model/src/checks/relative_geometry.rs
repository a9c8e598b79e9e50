//! A geometry relative to the data sheet, within limits.

use nalgebra::Vector3;

use crate::kinematics::wheel_pair::WheelPair;
use crate::recording::run::Robot;

/// A data sheet may be off by this factor, in radius and in track width; beyond, it is wrong.
pub(super) const OFF_BY: f64 = 1.5;
/// The radii may differ by this share.
const RATIO_MAX: f64 = 0.3;

/// A geometry relative to the data sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RelativeGeometry {
    /// The logarithm of how many times as far the robot goes.
    pub(super) travel: f64,
    /// The logarithm of how many times as far it turns.
    pub(super) turn: f64,
    /// (R_R - R_L) / R.
    pub(super) ratio: f64,
}

impl RelativeGeometry {
    pub(super) const NOMINAL: Self = Self { travel: 0.0, turn: 0.0, ratio: 0.0 };

    /// One that goes and turns so many times as far.
    pub(super) fn times(travel: f64, turn: f64) -> Self {
        Self { travel: travel.ln(), turn: turn.ln(), ratio: 0.0 }
    }

    pub(super) fn radius_m(&self, robot: &Robot) -> WheelPair<f64> {
        let mean_m = robot.wheel_radius_m * self.travel.exp();
        WheelPair::new(mean_m * (1.0 - self.ratio / 2.0), mean_m * (1.0 + self.ratio / 2.0))
    }

    pub(super) fn width_m(&self, robot: &Robot) -> f64 {
        robot.track_width_m * (self.travel - self.turn).exp()
    }

    /// This one, moved, and kept within limits of `center`.
    pub(super) fn moved(&self, by: &Vector3<f64>, center: &Self) -> Self {
        let limit = OFF_BY.ln();
        let travel = (self.travel + by[0] - center.travel).clamp(-limit, limit);
        let width = travel - (self.turn + by[1] - center.turn);
        let width = width.clamp(-limit, limit);
        Self {
            travel: center.travel + travel,
            turn: center.turn + travel - width,
            ratio: (self.ratio + by[2]).clamp(-RATIO_MAX, RATIO_MAX),
        }
    }
}
