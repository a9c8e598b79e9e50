//! `beeline config`: reads, changes and saves the robot's configuration.

use std::path::Path;

use serde_json::json;
use shared_proto::{AtFault, Config, ConfigError, ConfigOrigin, Driver};
use toml::Value;

use crate::cli::{Common, ConfigCommand};
use crate::error::{Context, Error, Result};
use crate::port::with_robot;
use crate::ui::{note, say, say_text, tell, warn};
use campaign::file::{is_special, write_whole};

pub(super) fn run(common: &Common, command: &ConfigCommand) -> Result<()> {
    match command {
        ConfigCommand::Get { field } => {
            let config = read(common)?;
            show(common, &config, field.as_deref())
        }
        ConfigCommand::Set { field, value, save } => {
            change(common, *save, |config| set(config, field, value))
        }
        ConfigCommand::Save => {
            with_robot(&common.port, &common.sim(), async |session, _| {
                Ok(session.save_config().await?)
            })?;
            warn_if_it_forgets(common);
            tell(common.json, json!({"saved": true}), "saved");
            Ok(())
        }
        ConfigCommand::Restore { factory } => {
            let origin = if *factory { ConfigOrigin::Factory } else { ConfigOrigin::Saved };
            let config = with_robot(&common.port, &common.sim(), async |session, _| {
                Ok(session.restore_config(origin).await?)
            })?;
            show(common, &config, None)
        }
        ConfigCommand::Export { file, force } => {
            let config = read(common)?;
            export(common, &config, file, *force)
        }
        ConfigCommand::Import { file, save } => {
            let config = import(file)?;
            change(common, *save, |_| Ok(config.clone()))
        }
    }
}

fn import(file: &Path) -> Result<Config> {
    let text = std::fs::read_to_string(file).map_err(|error| {
        Error::new(format_args!("cannot read {}: {error}", file.display()))
            .hint("`beeline config export` writes such a file")
    })?;
    let config: Config = toml::from_str(&text).map_err(|error| {
        let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
        let problem = error.message().replace('\n', " ");
        Error::new(format_args!("{}:{line}:{column}: {problem}", file.display()))
            .hint("`beeline config export` writes a file with every field")
    })?;
    config
        .validate()
        .map_err(|error| out_of_range(format_args!("{}: {error}", file.display()), &error))?;
    Ok(config)
}

fn out_of_range(what: impl std::fmt::Display, error: &ConfigError) -> Error {
    Error::new(what).hint(match error {
        ConfigError::OutOfRange { .. } => "values are in SI units: metres, seconds, volts",
        ConfigError::DistancePerCount { .. } => {
            "change the three together, with `beeline config import`"
        }
        ConfigError::PwmFrequency { .. } => {
            "change driver.pwm_hz first, or both together with `beeline config import`"
        }
        ConfigError::AtFault { .. } => {
            "`beeline config set driver.at_fault off` takes what the driver does when it is off"
        }
    })
}

fn read(common: &Common) -> Result<Config> {
    with_robot(&common.port, &common.sim(), async |session, _| Ok(session.read_config().await?))
}

/// Reads the configuration, changes it, writes it, reads it back, and saves it if `save`.
fn change(common: &Common, save: bool, change: impl Fn(&Config) -> Result<Config>) -> Result<()> {
    let (before, after) = with_robot(&common.port, &common.sim(), async |session, _| {
        let before = session.read_config().await?;
        let after = change(&before)?;
        session.write_config(&after).await?;
        if save && let Err(error) = session.save_config().await {
            // What could not be saved is not used either.
            session.write_config(&before).await?;
            return Err(error.into());
        }
        Ok((before, after))
    })?;
    if save {
        warn_if_it_forgets(common);
    } else if common.port.is_sim() {
        warn(
            "a simulated robot and its unsaved changes end with the command; add --save --flash FILE",
        );
    }
    let (before, after) = (flatten(&before)?, flatten(&after)?);
    let changed = || before.iter().zip(&after).filter(|(old, new)| old != new);
    if common.json {
        let changed: serde_json::Map<_, _> = changed()
            .map(|((path, old), (_, new))| (path.clone(), json!({"before": old, "after": new})))
            .collect();
        say(json!({"changed": changed, "saved": save}));
        return Ok(());
    }
    for ((path, old), (_, new)) in changed() {
        say(format_args!("{path}: {old} -> {new}"));
    }
    note(match (changed().count(), save) {
        (0, false) => "nothing to change",
        (_, false) => "written and read back; `beeline config save` keeps it",
        (_, true) => "written, read back and saved",
    });
    Ok(())
}

fn warn_if_it_forgets(common: &Common) {
    if common.port.is_sim() && common.flash.is_none() {
        warn("this simulated robot forgets when the command ends; --flash FILE gives it a memory");
    }
}

fn export(common: &Common, config: &Config, file: &Path, force: bool) -> Result<()> {
    let text = toml::to_string(config).context("the configuration")?;
    if file.as_os_str() == "-" {
        say_text(text.trim_end());
        return Ok(());
    }
    if file.is_dir() {
        return Err(Error::new(format_args!("{} is a folder", file.display()))
            .hint("name the file too, for example my-robot.toml in it"));
    }
    if file.exists() && !is_special(file) && !force {
        return Err(
            Error::new(format_args!("{} exists", file.display())).hint("--force overwrites it")
        );
    }
    write_whole(file, text.as_bytes()).map_err(|error| {
        Error::new(format_args!("cannot write {}: {error}", file.display()))
            .hint(error.hint("does its folder exist, and may you write there?"))
    })?;
    tell(common.json, json!({ "file": file }), format_args!("{} written", file.display()));
    Ok(())
}

fn show(common: &Common, config: &Config, field: Option<&str>) -> Result<()> {
    let value = match field {
        None => to_value(config)?,
        Some(field) => get(&to_value(config)?, field)?.clone(),
    };
    if common.json {
        say(serde_json::to_string(&value).context("the configuration")?);
        return Ok(());
    }
    match (&value, field) {
        (Value::Table(_), prefix) => {
            for (path, leaf) in leaves(&value) {
                let path = match prefix {
                    Some(prefix) => format!("{prefix}.{path}"),
                    None => path,
                };
                let unit = Config::FIELDS.iter().find(|f| f.path == path).map_or("", |f| f.unit);
                say(format_args!("{path:<36} {leaf} {unit}").to_string().trim_end());
            }
        }
        (leaf, _) => say(leaf),
    }
    Ok(())
}

fn to_value(config: &Config) -> Result<Value> {
    Value::try_from(config).context("the configuration")
}

fn flatten(config: &Config) -> Result<Vec<(String, Value)>> {
    Ok(leaves(&to_value(config)?))
}

fn leaves(value: &Value) -> Vec<(String, Value)> {
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

fn get<'a>(value: &'a Value, field: &str) -> Result<&'a Value> {
    field
        .split('.')
        .try_fold(value, |value, name| value.get(name))
        .ok_or_else(|| no_such_field(value, field))
}

fn no_such_field(root: &Value, field: &str) -> Error {
    let last = field.trim_end_matches('.').rsplit('.').next().unwrap_or(field);
    let similar: Vec<_> = leaves(root)
        .into_iter()
        .map(|(path, _)| path)
        .filter(|path| {
            !last.is_empty() && path.contains(last)
                || path.rsplit('.').next().is_some_and(|name| last.contains(name))
        })
        .take(4)
        .collect();
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
            .hint("docs/drivers.md tells which one yours is, and how to wire it"),
        "driver.at_fault" => of(&AtFault::ALL.map(AtFault::name)),
        _ => Error::new(format_args!(
            "{field} = {text}: too long, at most {} bytes",
            shared_proto::NAME_LEN_MAX
        ))
        .hint("choose a shorter one"),
    }
}

/// The configuration with one field changed.
fn set(config: &Config, field: &str, text: &str) -> Result<Config> {
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
        assert_eq!(
            error,
            "driver.at_fault = coast: a driver of the kind md10c cannot let the motors coast"
        );
        let error = at("bts7960", "driver.pwm_hz", "26000").unwrap_err();
        assert_eq!(
            error,
            "driver.pwm_hz = 26000: a driver of the kind bts7960 bears at most 25000 Hz"
        );
        assert!(at("md10c", "driver.at_fault", "brake").is_ok());
        assert!(at("bts7960", "driver.pwm_hz", "25000").is_ok());
    }

    #[test]
    fn a_wrong_name_suggests_the_right_one() {
        let error = set(&Config::default(), "wheel_weight", "1").unwrap_err();
        assert_eq!(error.hint_text(), Some("did you mean geometry.wheel_weight?"));
    }
}
