//! From quantities to text with as many digits as have meaning.

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

/// `0.9919 ± 0.0041`: both with as many decimals as the sigma has meaning.
pub fn plus_minus(value: f64, sigma: f64) -> String {
    let decimals = decimals(sigma);
    format!("{value:.decimals$} ± {sigma:.decimals$}")
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
    /// The unit in which a length reads best: mm below 10 cm, m from 1 m on.
    pub fn of(value_m: f64) -> Self {
        match value_m.abs() {
            m if m < 0.1 => Self::Mm,
            m if m < 1.0 => Self::Cm,
            _ => Self::M,
        }
    }

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

    /// `3.571 ± 0.015 cm`.
    pub fn format_plus_minus(self, value_m: f64, sigma_m: f64) -> String {
        let text = plus_minus(value_m * self.per_m(), sigma_m * self.per_m());
        format!("{text} {}", self.name())
    }
}
