//! Which unit is meant? Units as powers of metre, second, kilogram and volt; a radian is 1, as in the SI.

use core::fmt;

use super::error::ExpressionProblem;

/// Exponents of metre, second, kilogram and volt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit(pub [f64; 4]);

impl Unit {
    pub const ONE: Self = Self([0.0; 4]);

    /// Reads `m/s^2`, `rad/m`, `1/(kg m)` and the like.
    pub fn parse(text: &str) -> Result<Self, ExpressionProblem> {
        let bad = |what: &str| Err(ExpressionProblem::NotAUnit(what.to_owned()));
        let mut unit = Self::ONE;
        let (above, below) = match text.split_once('/') {
            Some((above, below)) => (above, Some(below)),
            None => (text, None),
        };
        let below = below.map(|text| text.trim().trim_start_matches('(').trim_end_matches(')'));
        if below.is_some_and(|text| text.contains('/') || text.trim().is_empty())
            || text.trim().is_empty()
        {
            return bad(text.trim());
        }
        for (part, sign) in [(above, 1.0), (below.unwrap_or("1"), -1.0)] {
            for factor in part.split(['*', ' ', '\u{b7}']).filter(|factor| !factor.is_empty()) {
                let (name, power) = match factor.split_once('^') {
                    Some((name, power)) => (name, exponent(power)),
                    None => (factor, Some(1.0)),
                };
                let Some(power) = power else { return bad(factor) };
                let index = match name {
                    "1" | "rad" => continue,
                    "m" => 0,
                    "s" => 1,
                    "kg" => 2,
                    "V" => 3,
                    "mm" | "cm" | "km" | "ms" | "min" | "h" | "g" | "mV" | "deg" | "mrad" | "%" => {
                        return Err(ExpressionProblem::NotAnSiBaseUnit(name.to_owned()));
                    }
                    _ => return bad(factor),
                };
                unit.0[index] += sign * power;
            }
        }
        Ok(unit)
    }

    /// A typical value of this unit for a small robot: 0.3 m, 1 s, 2 kg, 1 V.
    pub fn typical(self) -> f64 {
        let [m, s, kg, volt] = self.0;
        0.3_f64.powf(m) * 1.0_f64.powf(s) * 2.0_f64.powf(kg) * 1.0_f64.powf(volt)
    }

    /// Whether [`Unit::parse`] takes its exponents.
    pub fn can_be_declared(self) -> bool {
        self.0.iter().all(|power| power.abs() <= EXPONENT_MAX)
    }
}

/// Largest exponent: no quantity has a larger one.
pub(super) const EXPONENT_MAX: f64 = 100.0;

/// An exponent: whole, or the fraction that a root gives.
fn exponent(text: &str) -> Option<f64> {
    // No `inf`, `nan` or 1e3.
    let plain = |byte: u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+');
    let plain = text.bytes().all(plain);
    text.parse().ok().filter(|power: &f64| plain && power.abs() <= EXPONENT_MAX)
}

/// [`Unit::parse`] reads this back; exponents are rounded to 1e-9.
impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = |sign: f64| -> Vec<String> {
            let rounded = self.0.map(|power| (power * 1e9).round() / 1e9);
            // The volt first: V s/m.
            let names = [("V", 3), ("m", 0), ("s", 1), ("kg", 2)];
            let names = names.map(|(name, index)| (name, rounded[index])).into_iter();
            let there = names.filter(|(_, power)| sign * power > 0.0);
            there
                .map(|(name, power)| match power.abs() {
                    1.0 => name.to_owned(),
                    power => format!("{name}^{power}"),
                })
                .collect()
        };
        let (above, below) = (side(1.0), side(-1.0));
        let above = if above.is_empty() { "1".to_owned() } else { above.join(" ") };
        match below.len() {
            0 => f.write_str(&above),
            1 => write!(f, "{above}/{}", below[0]),
            _ => write!(f, "{above}/({})", below.join(" ")),
        }
    }
}
