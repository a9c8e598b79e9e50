//! Numbers with units: read as people type them, and written as people read them.
//!
//! A number without a unit is refused: `--dx 2.5` could mean anything, `--dx 2.5cm` cannot. Which
//! values make sense is left to the caller.

mod error;
mod parse;
mod print;
mod readable_unit;
#[cfg(test)]
mod tests;
mod units;

use std::f64::consts::TAU;

pub use error::QuantityError;
pub use parse::join_units;
pub use print::{LengthUnit, decimals, plus_minus};
pub use readable_unit::{
    interval_in_unit, p_value, probability, scaled_unit, value_in_unit, value_with_sigma,
};

/// A length \[m\].
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Length {
    /// In metres.
    pub m: f64,
}

/// An angle \[rad\].
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Angle {
    /// In radians.
    pub rad: f64,
}

/// How fast the robot turns \[rad/s\].
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct TurnRate {
    /// In radians per second, to the left positive.
    pub rad_s: f64,
}

/// A time \[s\].
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Time {
    /// In seconds.
    pub s: f64,
}

/// How far to drive: over ground, or in turns of a wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distance {
    /// Over ground \[m\].
    Ground(f64),
    /// Angle of a wheel \[rad\].
    Wheel(f64),
}

/// How fast: over ground, or of a wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// Over ground \[m/s\].
    Ground(f64),
    /// Of a wheel \[rad/s\].
    Wheel(f64),
}

/// How fast the speed changes: over ground, or of a wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Acceleration {
    /// Over ground \[m/s^2\].
    Ground(f64),
    /// Of a wheel \[rad/s^2\].
    Wheel(f64),
}

macro_rules! ground_or_wheel {
    ($type:ident, $ground:ident, $ground_doc:literal, $rev:ident, $rev_doc:literal) => {
        impl $type {
            #[doc = $ground_doc]
            pub fn $ground(self, wheel_radius_m: f64) -> f64 {
                match self {
                    Self::Ground(ground) => ground,
                    Self::Wheel(wheel) => wheel * wheel_radius_m,
                }
            }

            #[doc = $rev_doc]
            pub fn $rev(self, wheel_radius_m: f64) -> f64 {
                match self {
                    Self::Ground(ground) => ground / wheel_radius_m / TAU,
                    Self::Wheel(wheel) => wheel / TAU,
                }
            }
        }
    };
}

ground_or_wheel!(
    Distance,
    m,
    "Over ground, for a wheel of this radius \\[m\\].",
    rev,
    "In turns of a wheel of this radius."
);
ground_or_wheel!(
    Speed,
    mps,
    "Over ground, for a wheel of this radius \\[m/s\\].",
    rev_per_s,
    "Of a wheel of this radius, in turns \\[1/s\\]."
);
ground_or_wheel!(
    Acceleration,
    mps2,
    "Over ground, for a wheel of this radius \\[m/s^2\\].",
    rev_per_s2,
    "Of a wheel of this radius, in turns \\[1/s^2\\]."
);
