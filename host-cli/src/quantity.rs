//! Quantities as people type them, with their units, and as people like to read them.
//!
//! A bare number is refused: `--dx 2.5` could be anything, `--dx 2.5cm` cannot.

use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

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

type Units = &'static [(&'static str, f64)];

const LENGTH: Units = &[
    ("m", 1.0),
    ("cm", 0.01),
    ("mm", 0.001),
    ("um", 1e-6),
    ("km", 1e3),
    ("in", 0.0254),
    ("ft", 0.3048),
];
const ANGLE: Units =
    &[("rad", 1.0), ("mrad", 1e-3), ("deg", TAU / 360.0), ("°", TAU / 360.0), ("rev", TAU)];
const TIME: Units = &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("min", 60.0), ("h", 3600.0)];
const GROUND_SPEED: Units = &[("m/s", 1.0), ("cm/s", 0.01), ("mm/s", 0.001), ("km/h", 1.0 / 3.6)];
const WHEEL_SPEED: Units =
    &[("rev/s", TAU), ("rad/s", 1.0), ("deg/s", TAU / 360.0), ("rpm", TAU / 60.0)];
const GROUND_ACCELERATION: Units =
    &[("m/s^2", 1.0), ("m/s2", 1.0), ("m/s²", 1.0), ("cm/s^2", 0.01), ("mm/s^2", 0.001)];
const WHEEL_ACCELERATION: Units = &[
    ("rev/s^2", TAU),
    ("rev/s2", TAU),
    ("rev/s²", TAU),
    ("rad/s^2", 1.0),
    ("rad/s2", 1.0),
    ("rad/s²", 1.0),
    ("deg/s^2", TAU / 360.0),
];

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

/// What is being parsed.
struct Kind {
    what: &'static str,
    units: &'static [Units],
    example: &'static str,
}

impl Kind {
    /// The value in SI units, and which list its unit stood in.
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
                let si = value * scale;
                return if si.is_finite() { Ok((si, list)) } else { Err(fail(Problem::NotFinite)) };
            }
        }
        let known =
            self.units.iter().flat_map(|units| units.iter().map(|(name, _)| *name)).collect();
        Err(fail(Problem::UnknownUnit { unit: unit.into(), column: column_of(text, unit), known }))
    }
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
    // An exponent counts only with a digit behind it, so that "3e" is a 3 with a strange unit.
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

/// Why a text is not the quantity that is wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityError {
    what: &'static str,
    text: String,
    problem: Problem,
    example: &'static str,
}

#[derive(Clone, Debug, PartialEq)]
enum Problem {
    NoNumber,
    NotFinite,
    NoUnit { number: String },
    UnknownUnit { unit: String, column: usize, known: Vec<&'static str> },
}

impl fmt::Display for QuantityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, text, problem, example } = self;
        match problem {
            Problem::NoNumber => {
                write!(f, "no number at the start of `{text}`: write a {what} like {example}")
            }
            Problem::NotFinite => write!(f, "`{text}` is too large: write a {what} like {example}"),
            Problem::NoUnit { number } => {
                write!(f, "`{number}` has no unit: write a {what} with its unit, like {example}")
            }
            Problem::UnknownUnit { unit, column, known } => write!(
                f,
                "`{unit}` (at character {column} of `{text}`) is not a unit of {what}: use one of {}; \
                 for example {example}",
                known.join(", ")
            ),
        }
    }
}

impl std::error::Error for QuantityError {}

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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn close(a: f64, b: f64) -> bool {
        // One rounding in the number and one in the unit.
        (a - b).abs() <= 4.0 * f64::EPSILON * b.abs()
    }

    #[test]
    fn lengths_are_read_in_every_unit_with_or_without_a_space() {
        for (text, m) in [
            ("2.525cm", 0.02525),
            ("1mm", 0.001),
            ("37.2 cm", 0.372),
            ("0.5in", 0.0127),
            ("-3e-2 m", -0.03),
            (" +.5ft ", 0.1524),
            ("1E3um", 0.001),
        ] {
            let length: Length = text.parse().unwrap();
            assert!(close(length.m, m), "{text}: {} instead of {m}", length.m);
        }
    }

    #[test]
    fn wheel_and_ground_are_kept_apart_and_convert_by_the_radius() {
        let turns: Distance = "8rev".parse().unwrap();
        assert_eq!(turns, Distance::Wheel(8.0 * TAU));
        assert!(close(turns.m(0.036), 8.0 * TAU * 0.036));
        assert!(close("1.8m".parse::<Distance>().unwrap().rev(0.036), 1.8 / 0.036 / TAU));
        assert!(close("0.523rev/s".parse::<Speed>().unwrap().rev_per_s(0.036), 0.523));
        assert!(close("60rpm".parse::<Speed>().unwrap().rev_per_s(0.1), 1.0));
        assert!(close("36km/h".parse::<Speed>().unwrap().mps(0.1), 10.0));
        assert!(close("0.101 rev/s^2".parse::<Acceleration>().unwrap().rev_per_s2(0.036), 0.101));
        assert!(close("50ms".parse::<Time>().unwrap().s, 0.05));
        assert!(close("180deg".parse::<Angle>().unwrap().rad, TAU / 2.0));
    }

    #[test]
    fn a_bare_number_is_refused_with_a_hint() {
        let message = "2.5".parse::<Length>().unwrap_err().to_string();
        assert!(message.contains("`2.5` has no unit") && message.contains("1mm"), "{message}");
    }

    #[test]
    fn an_unknown_unit_is_named_with_its_place_and_the_known_ones() {
        let message = "3 parsec".parse::<Length>().unwrap_err().to_string();
        assert!(message.contains("`parsec` (at character 3"), "{message}");
        assert!(message.contains("mm, um"), "{message}");
        let message = "3m".parse::<Speed>().unwrap_err().to_string();
        assert!(message.contains("`m` (at character 2"), "{message}");
    }

    #[test]
    fn text_infinity_and_overflow_are_refused() {
        for text in ["", "mm", "nan m", "inf m", "1e400m", "1e308km", "1.2.3m", "--1m", "e5m"] {
            assert!(text.parse::<Length>().is_err(), "{text} was accepted");
        }
    }

    #[test]
    fn values_show_as_many_digits_as_their_sigma_has_meaning() {
        assert_eq!(plus_minus(0.991_858, 0.004_065), "0.9919 ± 0.0041");
        assert_eq!(plus_minus(1.0, 0.0996), "1.00 ± 0.10");
        assert_eq!(plus_minus(1234.5, 120.0), "1234 ± 120");
        assert_eq!(LengthUnit::Cm.format(0.035_706_9, 4), "3.5707 cm");
        assert_eq!(LengthUnit::Mm.format_plus_minus(0.0361, 0.0005), "36.10 ± 0.50 mm");
    }

    proptest! {
        #[test]
        fn whatever_is_printed_in_millimetres_is_read_back(mm in -1e6_f64..1e6) {
            let length: Length = format!("{mm}mm").parse().unwrap();
            prop_assert!((length.m * 1e3 - mm).abs() <= 1e-12 * mm.abs());
        }

        #[test]
        fn no_text_makes_the_parser_panic(text in ".*") {
            let _ = text.parse::<Length>();
            let _ = text.parse::<Acceleration>();
        }
    }
}
