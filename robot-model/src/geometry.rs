//! The robot as its data sheet has it, and how far its wheels turned.

use core::f64::consts::TAU;
use core::fmt;

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

    /// The wheel angles that so many counts stand for.
    pub fn turns(&self, counts_left: f64, counts_right: f64) -> Turns {
        let rad = self.rad_per_count();
        Turns { phi_left_rad: counts_left * rad, phi_right_rad: counts_right * rad }
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
                return Err(GeometryError { name, value, rule: "must be above zero" });
            }
        }
        for (name, value) in not_negative {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(GeometryError { name, value, rule: "must not be negative" });
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
    pub rule: &'static str,
}

impl fmt::Display for GeometryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // 1e300, and not a one with three hundred zeros.
        match self.value {
            value if value.abs() >= 1e15 && value.is_finite() => {
                write!(f, "the {} is {value:e}: it {}", self.name, self.rule)
            }
            value => write!(f, "the {} is {value}: it {}", self.name, self.rule),
        }
    }
}

impl core::error::Error for GeometryError {}

/// How far each wheel turned, forward positive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turns {
    /// The left wheel's angle, phi_L \[rad\].
    pub phi_left_rad: f64,
    /// The right wheel's angle, phi_R \[rad\].
    pub phi_right_rad: f64,
}

impl Turns {
    /// The same angle for both wheels.
    pub const fn both(phi_rad: f64) -> Self {
        Self { phi_left_rad: phi_rad, phi_right_rad: phi_rad }
    }

    /// The angles turned since `earlier`.
    pub fn since(self, earlier: Self) -> Self {
        Self {
            phi_left_rad: self.phi_left_rad - earlier.phi_left_rad,
            phi_right_rad: self.phi_right_rad - earlier.phi_right_rad,
        }
    }

    /// The angles at a share of the way to `other`: 0 here, 1 there.
    pub fn toward(self, other: Self, share: f64) -> Self {
        Self {
            phi_left_rad: self.phi_left_rad + share * (other.phi_left_rad - self.phi_left_rad),
            phi_right_rad: self.phi_right_rad + share * (other.phi_right_rad - self.phi_right_rad),
        }
    }
}
