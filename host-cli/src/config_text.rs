//! The robot's configuration as text: single fields by their names, and the file that `beeline config export` writes.

use std::path::Path;

use campaign::Place;
use shared_proto::{AtFault, Config, ConfigError, Driver};
use toml::Value;
use toml::de::{DeTable, DeValue};

use crate::error::{Context, Error, Result};

/// Reads the text of a configuration file; errors call it `file`.
///
/// # Errors
/// If it is no TOML, lacks a field or has one too many, or a value is out of its range.
pub fn parse(file: &Path, text: &str) -> Result<Config> {
    let config: Config = toml::from_str(text).map_err(|error| {
        let place = Place::of_byte(file, text, error.span().map_or(0, |span| span.start));
        let problem = error.message().replace('\n', " ");
        Error::new(format_args!("{place}: {problem}"))
            .hint("`beeline config export` writes a file with every field")
    })?;
    config.validate().map_err(|error| {
        let place = place_of(file, text, field_of(&error));
        out_of_range(format_args!("{place}: {error}"), &error)
    })?;
    if config.name.as_str().chars().any(char::is_control) {
        let (place, name) = (place_of(file, text, "name"), config.name.as_str());
        let problem = format_args!("{place}: name = {name:?}: must not hold control characters");
        return Err(Error::new(problem).hint("a name has letters, digits, spaces and signs"));
    }
    Ok(config)
}

/// The field that an error is about, or the first of several.
fn field_of(error: &ConfigError) -> &'static str {
    match error {
        ConfigError::OutOfRange { field, .. } => {
            Config::FIELDS.get(usize::from(*field)).map_or("", |field| field.path)
        }
        ConfigError::DistancePerCount { .. } => "geometry.wheel_radius_m",
        ConfigError::PwmFrequency { .. } => "driver.pwm_hz",
        ConfigError::AtFault { .. } => "driver.at_fault",
    }
}

/// Where a file has the field of this name, or the innermost table on the way to it.
fn place_of(file: &Path, text: &str, field: &str) -> Place {
    let mut found = Place::whole(file);
    let Ok(document) = DeTable::parse(text) else { return found };
    let mut table = document.get_ref();
    for name in field.split('.') {
        let Some(value) = table.get(name) else { break };
        found = Place::of_byte(file, text, value.span().start);
        let DeValue::Table(inner) = value.get_ref() else { break };
        table = inner;
    }
    found
}

fn out_of_range(what: impl std::fmt::Display, error: &ConfigError) -> Error {
    Error::new(what).hint(match error {
        ConfigError::OutOfRange { .. } => range_hint(field_of(error)),
        ConfigError::DistancePerCount { .. } => {
            "change the three together, with `beeline config import`"
        }
        ConfigError::PwmFrequency { .. } => {
            "choose a lower driver.pwm_hz; for another driver, change both together with `beeline config import`"
        }
        ConfigError::AtFault { .. } => {
            "with `beeline config set driver.at_fault off` the driver does what it does when it is off"
        }
    })
}

/// What somebody may have meant whose value of this field is out of its range.
fn range_hint(path: &str) -> &'static str {
    let last = path.rsplit('.').next().unwrap_or(path);
    let unit =
        Config::FIELDS.iter().find(|field| field.path == path).map_or("", |field| field.unit);
    match (last, unit) {
        ("counts_per_rev", _) => {
            "count every edge of both lines per turn of the encoder's own shaft: four times the pulses (PPR) of its data sheet; the gear goes into gear_reduction"
        }
        ("gear_reduction", _) => "turns of the motor's shaft for one of the wheel: 43.7 for 43.7:1",
        ("duty_max" | "probe_duty_max", _) => "a share of full duty: 0.25 is a quarter",
        (_, "") => "a plain number, without a unit",
        _ => "values are in SI units: metres, seconds, volts",
    }
}

/// The configuration as a tree of tables.
pub fn to_value(config: &Config) -> Result<Value> {
    Value::try_from(config).context("the configuration")
}

/// Every field by its whole name.
pub fn flatten(config: &Config) -> Result<Vec<(String, Value)>> {
    Ok(leaves(&to_value(config)?))
}

/// Every value below this one by its name from here.
pub fn leaves(value: &Value) -> Vec<(String, Value)> {
    match value {
        Value::Table(table) => table
            .iter()
            .flat_map(|(name, value)| {
                leaves(value).into_iter().map(move |(path, leaf)| match path.as_str() {
                    "" => (name.clone(), leaf),
                    _ => (format!("{name}.{path}"), leaf),
                })
            })
            .collect(),
        leaf => vec![(String::new(), leaf.clone())],
    }
}

/// The value of a field, or the table of a group of fields.
///
/// # Errors
/// If there is none of this name, with similar names.
pub fn get<'a>(value: &'a Value, field: &str) -> Result<&'a Value> {
    field
        .split('.')
        .try_fold(value, |value, name| value.get(name))
        .ok_or_else(|| no_such_field(value, field))
}

fn no_such_field(root: &Value, field: &str) -> Error {
    let last = field.trim_end_matches('.').rsplit('.').next().unwrap_or(field);
    let paths: Vec<_> = leaves(root).into_iter().map(|(path, _)| path).collect();
    let is_called = |path: &String| path.rsplit('.').next() == Some(last);
    let is_like = |path: &String| {
        !last.is_empty() && path.contains(last)
            || path.rsplit('.').next().is_some_and(|name| last.contains(name))
    };
    // `wheel_weight` is one field, and the beginning of another.
    let is_there = paths.iter().any(is_called);
    let is_similar = |path: &String| if is_there { is_called(path) } else { is_like(path) };
    let similar: Vec<_> = paths.into_iter().filter(is_similar).take(4).collect();
    let error = Error::new(format_args!("the configuration has no field `{field}`"));
    if similar.is_empty() {
        error.hint("`beeline config get` lists them")
    } else {
        error.hint(format_args!("did you mean {}?", similar.join(" or ")))
    }
}

/// A text that the field does not take.
fn unknown_word(field: &str, text: &str) -> Error {
    let of = |words: &[&str]| {
        Error::new(format_args!("{field} = {text}: must be one of {}", words.join(", ")))
    };
    match field {
        "driver.name" => of(&Driver::ALL.map(Driver::name))
            .hint("docs/drivers.md says which one is yours, and how to wire it"),
        "driver.at_fault" => of(&AtFault::ALL.map(AtFault::name)),
        _ => Error::new(format_args!(
            "{field} = {text}: too long, at most {} bytes",
            shared_proto::NAME_LEN_MAX
        ))
        .hint("choose a shorter one"),
    }
}

/// The configuration with one field changed.
///
/// # Errors
/// If there is no such field, or the text is no value that it may have.
pub fn set(config: &Config, field: &str, text: &str) -> Result<Config> {
    let mut root = to_value(config)?;
    let unknown = no_such_field(&root, field);
    let mut place = &mut root;
    for name in field.split('.') {
        match place.get_mut(name) {
            Some(inner) => place = inner,
            None => return Err(unknown),
        }
    }
    *place = match place {
        Value::Float(_) => Value::Float(text.trim().parse().map_err(|_| {
            Error::new(format_args!("{field} = {text}: must be a number, in SI units"))
                .hint("for example 0.9919")
        })?),
        Value::Boolean(_) => Value::Boolean(text.parse().map_err(|_| {
            Error::new(format_args!("{field} = {text}: must be true or false"))
                .hint(format_args!("`beeline config set {field} true`"))
        })?),
        Value::String(_) if text.chars().any(char::is_control) => {
            return Err(Error::new(format_args!(
                "{field} = {text:?}: must not hold control characters"
            )));
        }
        Value::String(_) => Value::String(text.into()),
        _ => {
            return Err(Error::new(format_args!("{field} is a group of fields"))
                .hint(format_args!("`beeline config get {field}` lists them")));
        }
    };
    let changed: Config = root.try_into().map_err(|_| unknown_word(field, text))?;
    changed.validate().map_err(|error| out_of_range(error, &error))?;
    Ok(changed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_can_be_set_by_the_name_that_get_shows() {
        let config = Config::default();
        for (path, leaf) in flatten(&config).unwrap() {
            let text = leaf.as_str().map_or_else(|| leaf.to_string(), str::to_owned);
            assert_eq!(set(&config, &path, &text).unwrap(), config, "{path}");
        }
    }

    #[test]
    fn a_driver_is_set_by_its_name_and_an_unknown_one_lists_them() {
        for driver in Driver::ALL {
            let config = set(&Config::default(), "driver.name", driver.name()).unwrap();
            assert_eq!(config.driver.name, driver);
        }
        for at_fault in AtFault::ALL {
            let config = set(&Config::default(), "driver.at_fault", at_fault.name()).unwrap();
            assert_eq!(config.driver.at_fault, at_fault);
        }
        let error = set(&Config::default(), "driver.name", "l297").unwrap_err().to_string();
        assert!(error.contains("one of pwm_dir, in1_in2,") && error.contains("l298n"), "{error}");
    }

    #[test]
    fn a_driver_is_refused_what_it_cannot_do() {
        let at = |driver, field, value| {
            let config = set(&Config::default(), "driver.name", driver).unwrap();
            set(&config, field, value).map_err(|error| error.to_string())
        };
        let error = at("md10c", "driver.at_fault", "coast").unwrap_err();
        assert_eq!(error, "driver.at_fault = coast: the driver md10c cannot let the motors coast");
        let error = at("bts7960", "driver.pwm_hz", "26000").unwrap_err();
        assert_eq!(error, "driver.pwm_hz = 26000: the driver bts7960 takes at most 25000 Hz");
        assert!(at("md10c", "driver.at_fault", "brake").is_ok());
        assert!(at("bts7960", "driver.pwm_hz", "25000").is_ok());
    }

    #[test]
    fn a_wrong_name_suggests_the_right_one() {
        let error = set(&Config::default(), "wheel_weight", "1").unwrap_err();
        assert_eq!(error.hint_text(), Some("did you mean geometry.wheel_weight?"));
    }
}
