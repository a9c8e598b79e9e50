//! Reads quantities from text.

use std::str::FromStr;

use super::error::{Problem, QuantityError};
use super::units::{
    ANGLE, GROUND_ACCELERATION, GROUND_SPEED, LENGTH, TIME, Units, WHEEL_ACCELERATION, WHEEL_SPEED,
};
use super::{Acceleration, Angle, Distance, Length, Speed, Time, TurnRate};

impl FromStr for Length {
    type Err = QuantityError;
    fn from_str(text: &str) -> Result<Self, QuantityError> {
        Kind { what: "length", units: &[LENGTH], example: "1mm, 2.525cm or 0.5in" }
            .parse(text)
            .map(|(m, _)| Self { m })
    }
}

impl FromStr for Angle {
    type Err = QuantityError;
    fn from_str(text: &str) -> Result<Self, QuantityError> {
        Kind { what: "angle", units: &[ANGLE], example: "0.04rad, 3deg or 8rev" }
            .parse(text)
            .map(|(rad, _)| Self { rad })
    }
}

impl FromStr for TurnRate {
    type Err = QuantityError;
    fn from_str(text: &str) -> Result<Self, QuantityError> {
        Kind { what: "turn rate", units: &[WHEEL_SPEED], example: "30deg/s or 0.5rad/s" }
            .parse(text)
            .map(|(rad_s, _)| Self { rad_s })
    }
}

impl FromStr for Time {
    type Err = QuantityError;
    fn from_str(text: &str) -> Result<Self, QuantityError> {
        Kind { what: "time", units: &[TIME], example: "20s or 50ms" }
            .parse(text)
            .map(|(s, _)| Self { s })
    }
}

macro_rules! parse_ground_or_wheel {
    ($type:ident, $what:literal, $ground:expr, $wheel:expr, $example:literal) => {
        impl FromStr for $type {
            type Err = QuantityError;
            fn from_str(text: &str) -> Result<Self, QuantityError> {
                let kind = Kind { what: $what, units: &[$ground, $wheel], example: $example };
                Ok(match kind.parse(text)? {
                    (value, 0) => Self::Ground(value),
                    (value, _) => Self::Wheel(value),
                })
            }
        }
    };
}

parse_ground_or_wheel!(Distance, "distance", LENGTH, ANGLE, "8rev or 1.8m");
parse_ground_or_wheel!(Speed, "speed", GROUND_SPEED, WHEEL_SPEED, "0.523rev/s or 0.12m/s");
parse_ground_or_wheel!(
    Acceleration,
    "acceleration",
    GROUND_ACCELERATION,
    WHEEL_ACCELERATION,
    "0.101rev/s^2 or 0.02m/s^2"
);

/// A number in SI units. For a unit that is a power of ten the decimal point moves in the text, so that 37.2 cm are the
/// double next to 0.372; 37.2 times 0.01 is not.
fn in_si(number: &str, value: f64, scale: f64) -> f64 {
    let (digits, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
    let power = scale.log10().round();
    if format!("1e{power}").parse() != Ok(scale) {
        return value * scale;
    }
    let exponent = exponent.parse::<i32>().unwrap_or_default().saturating_add(power as i32);
    format!("{digits}e{exponent}").parse().unwrap_or(value * scale)
}

/// The quantity that is parsed.
struct Kind {
    what: &'static str,
    units: &'static [Units],
    example: &'static str,
}

impl Kind {
    /// The value in SI units, and the index of the list that has its unit.
    fn parse(&self, text: &str) -> Result<(f64, usize), QuantityError> {
        let fail = |problem| QuantityError {
            what: self.what,
            text: text.into(),
            problem,
            example: self.example,
        };
        let trimmed = text.trim();
        let split = number_length(trimmed);
        let (number, unit) = (&trimmed[..split], trimmed[split..].trim());
        let Ok(value) = number.parse::<f64>() else {
            return Err(fail(Problem::NoNumber));
        };
        if !value.is_finite() {
            return Err(fail(Problem::NotFinite));
        }
        if unit.is_empty() {
            return Err(fail(Problem::NoUnit { number: number.into() }));
        }
        for (list, units) in self.units.iter().enumerate() {
            if let Some((_, scale)) = units.iter().find(|(name, _)| *name == unit) {
                let si = in_si(number, value, *scale);
                return if si.is_finite() { Ok((si, list)) } else { Err(fail(Problem::NotFinite)) };
            }
        }
        let known =
            self.units.iter().flat_map(|units| units.iter().map(|(name, _)| *name)).collect();
        Err(fail(Problem::UnknownUnit { unit: unit.into(), column: column_of(text, unit), known }))
    }
}

/// `2.5 cm 1mm` is two lengths, not three.
pub fn join_units(text: &str) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    for word in text.split([' ', ',', ';']).filter(|word| !word.is_empty()) {
        match parts.last_mut() {
            Some(last) if word.starts_with(|c: char| c.is_alphabetic()) => last.push_str(word),
            _ => parts.push(word.into()),
        }
    }
    parts
}

/// Bytes of the number at the start of `text`: sign, digits, point, exponent.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
    let sign = |at: usize| matches!(bytes.get(at), Some(b'+' | b'-'));
    let mut at = usize::from(sign(0));
    while digit(at) || bytes.get(at) == Some(&b'.') {
        at += 1;
    }
    // An exponent needs a digit after it, so that "3e" is a 3 with an unknown unit.
    if matches!(bytes.get(at), Some(b'e' | b'E')) {
        let digits = at + 1 + usize::from(sign(at + 1));
        if digit(digits) {
            at = digits;
            while digit(at) {
                at += 1;
            }
        }
    }
    at
}

/// Where `part` starts in `text`, in characters from 1.
fn column_of(text: &str, part: &str) -> usize {
    text.rfind(part).map_or(1, |byte| text[..byte].chars().count() + 1)
}
