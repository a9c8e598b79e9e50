//! Writes quantities with their significant digits.

use std::f64::consts::TAU;
use std::fmt;

use super::Distance;

/// A number with more decimals is written with its power of ten.
pub(super) const DECIMALS_MAX: usize = 9;

/// The decimals that show a sigma with two significant digits; six if there is no sigma.
pub fn decimals(sigma: f64) -> usize {
    if !(sigma > 0.0 && sigma.is_finite()) {
        return 6;
    }
    // The power of ten is taken after rounding: a sigma of 0.0996 rounds to 0.10.
    let text = format!("{sigma:.1e}");
    let power: i32 = text.rsplit('e').next().and_then(|power| power.parse().ok()).unwrap_or(0);
    (1 - power).clamp(0, 12) as usize
}

/// `0.9919 ± 0.0041`, with the decimals of the sigma's two significant digits;
/// `1.23e-15 ± 3.01e-16` for very small numbers.
pub fn plus_minus(value: f64, sigma: f64) -> String {
    let decimals = decimals(sigma);
    if decimals > DECIMALS_MAX {
        return format!("{value:.2e} ± {sigma:.2e}");
    }
    format!("{value:.decimals$} ± {sigma:.decimals$}")
}

impl fmt::Display for Distance {
    /// As a person would type it: rounding by the unit (33.3 x 0.01 is not quite 0.333) is not
    /// shown.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (value, unit) = match self {
            Self::Ground(m) => (*m, "m"),
            Self::Wheel(rad) => (rad / TAU, "rev"),
        };
        let rounded = format!("{value:.11e}").parse().unwrap_or(value);
        write!(f, "{rounded} {unit}")
    }
}

/// A unit of length to print in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimetres.
    Mm,
    /// Centimetres.
    Cm,
    /// Metres.
    M,
}

impl LengthUnit {
    /// `"mm"`, `"cm"` or `"m"`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Cm => "cm",
            Self::M => "m",
        }
    }

    /// How many of this unit are a metre.
    pub const fn per_m(self) -> f64 {
        match self {
            Self::Mm => 1000.0,
            Self::Cm => 100.0,
            Self::M => 1.0,
        }
    }

    /// `3.5707 cm`.
    pub fn format(self, value_m: f64, decimals: usize) -> String {
        format!("{:.decimals$} {}", value_m * self.per_m(), self.name())
    }
}
