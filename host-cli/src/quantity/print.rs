//! From quantities to text with as many digits as have meaning.

use std::f64::consts::TAU;
use std::fmt;

use super::Distance;

/// With more decimals a number is written with its power of ten.
pub(super) const DECIMALS_MAX: usize = 9;

/// Decimals that show a sigma with two significant digits; six at most without one.
pub fn decimals(sigma: f64) -> usize {
    if !(sigma > 0.0 && sigma.is_finite()) {
        return 6;
    }
    // A sigma of 0.0996 rounds to 0.10: the power of ten is taken after rounding.
    let text = format!("{sigma:.1e}");
    let power: i32 = text.rsplit('e').next().and_then(|power| power.parse().ok()).unwrap_or(0);
    (1 - power).clamp(0, 12) as usize
}

/// `0.9919 ± 0.0041`: both with as many decimals as the sigma has meaning; `1.23e-15 ± 3.01e-16`, never a row of zeros.
pub fn plus_minus(value: f64, sigma: f64) -> String {
    let decimals = decimals(sigma);
    if decimals > DECIMALS_MAX {
        return format!("{value:.2e} ± {sigma:.2e}");
    }
    format!("{value:.decimals$} ± {sigma:.decimals$}")
}

impl fmt::Display for Distance {
    /// As a person would have typed it: a unit's rounding (33.3 x 0.01 is not quite 0.333) is not shown.
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

    /// This many to a metre.
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
