//! Which values of an argument make sense: parsers that check a range.

use std::ffi::OsString;
use std::path::PathBuf;
use std::str::FromStr;

use campaign::file::is_special;
use clap::builder::{OsStringValueParser, PathBufValueParser, TypedValueParser};

use crate::quantity::{Acceleration, Angle, Distance, Length, QuantityError, Speed, Time};

// The number of a quantity, for the checks below.

pub(super) fn length(length: &Length) -> f64 {
    length.m
}

pub(super) fn angle(angle: &Angle) -> f64 {
    angle.rad
}

pub(super) fn time(time: &Time) -> f64 {
    time.s
}

pub(super) fn distance(distance: &Distance) -> f64 {
    match *distance {
        Distance::Ground(value) | Distance::Wheel(value) => value,
    }
}

pub(super) fn speed(speed: &Speed) -> f64 {
    match *speed {
        Speed::Ground(value) | Speed::Wheel(value) => value,
    }
}

pub(super) fn acceleration(acceleration: &Acceleration) -> f64 {
    match *acceleration {
        Acceleration::Ground(value) | Acceleration::Wheel(value) => value,
    }
}

/// Reads a quantity that must be above zero.
pub(super) fn above_zero<T: FromStr<Err = QuantityError>>(
    value: fn(&T) -> f64,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let quantity: T = text.parse().map_err(|error: QuantityError| error.to_string())?;
        if value(&quantity) > 0.0 { Ok(quantity) } else { Err("must be above zero".into()) }
    }
}

/// Reads how long a robot drives.
pub(super) fn up_to_a_day(text: &str) -> Result<Time, String> {
    let time = above_zero(time)(text)?;
    if time.s <= 86_400.0 { Ok(time) } else { Err("longer than a day".into()) }
}

/// Reads a quantity that must not be negative.
pub(super) fn not_negative<T: FromStr<Err = QuantityError>>(
    value: fn(&T) -> f64,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let quantity: T = text.parse().map_err(|error: QuantityError| error.to_string())?;
        if value(&quantity) >= 0.0 { Ok(quantity) } else { Err("must not be negative".into()) }
    }
}

/// Reads the name of a file or a folder to write. `-` is none: only some commands write to standard output.
pub(super) fn new_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|file| match file.as_os_str() == "-" {
        true => Err("it is written to a file, not to standard output; ./- names a file called so"),
        false => Ok(file),
    })
}

/// The same, of a file whose name has this ending: a slip of the hand overwrites no file of another kind.
pub(super) fn new_file_named(ending: &'static str) -> impl TypedValueParser<Value = PathBuf> {
    new_file().try_map(move |file: PathBuf| {
        let own = file.extension().and_then(|own| own.to_str());
        if is_special(&file) || own.is_some_and(|own| own.eq_ignore_ascii_case(ending)) {
            Ok(file)
        } else {
            Err(format!("its name must end in .{ending}"))
        }
    })
}

/// Reads the name of the key's file. An empty variable is no name, and not the same as none.
pub(super) fn key_file() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(|file: OsString| match file.is_empty() {
        true => Err("it is empty: name the file, or unset BEELINE_KEY_FILE"),
        false => Ok(PathBuf::from(file)),
    })
}

/// Reads a whole number from 1 to `max`.
pub(super) fn count(max: u16) -> impl Fn(&str) -> Result<u16, String> + Clone {
    move |text| match text.parse() {
        Ok(number) if (1..=max).contains(&number) => Ok(number),
        _ => Err(format!("must be a whole number from 1 to {max}")),
    }
}

/// Reads a whole number that is not negative.
pub(super) fn whole(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("must be a whole number from 0 to {}", u64::MAX))
}

/// Reads a number.
pub(super) fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "must be a number".into())
}

/// Reads a rate in 1/s. It must divide 1000, as the telemetry period is in whole milliseconds.
pub(super) fn rate(text: &str) -> Result<u16, String> {
    match text.parse::<u16>() {
        Ok(rate) if (1..=1000).contains(&rate) && 1000 % rate == 0 => Ok(rate),
        Ok(rate) if (1..=1000).contains(&rate) => {
            let divides = |rate: &u16| 1000 % rate == 0;
            let below = (1..rate).rev().find(divides).unwrap_or(1);
            let above = (rate..=1000).find(divides).unwrap_or(1000);
            Err(format!("must divide 1000, as {below} and {above} do"))
        }
        _ => Err("must be a whole number from 1 to 1000".into()),
    }
}

/// The time between two frames at this rate in 1/s \[ms\].
pub fn period_ms(rate: u16) -> u16 {
    1000 / rate.clamp(1, 1000)
}

/// Reads a share of at least a tenth.
pub(super) fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (0.1..=1.0).contains(&share) => Ok(share),
        _ => Err("must be a number from 0.1 to 1".into()),
    }
}

/// Reads a tolerance in percent.
pub(super) fn percent(text: &str) -> Result<f64, String> {
    match text.trim_end_matches('%').trim_end().parse() {
        Ok(percent) if (0.0..=50.0).contains(&percent) => Ok(percent),
        _ => Err("must be a number from 0 to 50".into()),
    }
}
