//! The geometry of a robot as its data sheet has it, with tolerances.

use core::f64::consts::TAU;
use core::fmt;

use super::wheel_pair::WheelPair;

/// Nominal geometry, with what is known about its tolerance (one sigma each).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Radius of the left wheel, R_L \[m\]; the right wheel's is W_T times that.
    pub wheel_radius_m: f64,
    /// Tolerance of the radius \[m\].
    pub wheel_radius_sigma_m: f64,
    /// Distance between the wheels' contact points, b \[m\].
    pub track_width_m: f64,
    /// Tolerance of the track width \[m\].
    pub track_width_sigma_m: f64,
    /// Encoder counts per turn of a wheel, N / g; may be fractional.
    pub counts_per_wheel_rev: f64,
}

impl Geometry {
    /// The paper's robot, exactly as printed: R = 3.6 cm, b = 37.2 cm, N = 900, g = 1.
    pub const PAPER: Self = Self {
        wheel_radius_m: 0.036,
        wheel_radius_sigma_m: 0.0,
        track_width_m: 0.372,
        track_width_sigma_m: 0.0,
        counts_per_wheel_rev: 900.0,
    };

    /// Wheel angle of one count \[rad\].
    pub fn rad_per_count(&self) -> f64 {
        TAU / self.counts_per_wheel_rev
    }

    /// Distance per count, (3-1) Q = 2 pi R g / N \[m\].
    pub fn meters_per_count(&self) -> f64 {
        self.wheel_radius_m * self.rad_per_count()
    }

    /// The wheel angles that so many counts stand for \[rad\].
    pub fn turns(&self, counts_left: f64, counts_right: f64) -> WheelPair<f64> {
        WheelPair::new(counts_left, counts_right).map(|counts| counts * self.rad_per_count())
    }

    /// Refuses, by name, a geometry that no robot has.
    pub fn validate(&self) -> Result<(), GeometryError> {
        let positive = [
            ("wheel radius", self.wheel_radius_m),
            ("track width", self.track_width_m),
            ("counts per wheel revolution", self.counts_per_wheel_rev),
        ];
        let not_negative = [
            ("tolerance of the wheel radius", self.wheel_radius_sigma_m),
            ("tolerance of the track width", self.track_width_sigma_m),
        ];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(GeometryError { name, value, limit: Limit::AboveZero });
            }
        }
        for (name, value) in not_negative {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(GeometryError { name, value, limit: Limit::NotNegative });
            }
        }
        Ok(())
    }
}

/// A length or a number that no robot has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeometryError {
    /// What it is.
    pub name: &'static str,
    /// The value refused.
    pub value: f64,
    /// What it must be.
    pub limit: Limit,
}

/// What a number of the geometry must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Above zero.
    AboveZero,
    /// Zero or more.
    NotNegative,
}

impl fmt::Display for GeometryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

impl core::error::Error for GeometryError {}
