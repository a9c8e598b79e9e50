//! `beeline config`: reads, changes and saves the robot's configuration.

use std::path::Path;

use serde_json::json;
use shared_proto::{Config, ConfigOrigin};
use toml::Value;

use crate::cli::{Common, ConfigCommand};
use crate::config_text::{flatten, get, leaves, parse, set, to_value};
use crate::error::{Context, Error, Result};
use crate::port::with_robot;
use crate::tune::longer_count_m;
use crate::ui::{note, say, say_text, tell, warn};
use campaign::bounded_read::read_keys;
use campaign::file::{is_special, write_whole};

/// Six counts of this are a centimetre \[m\].
const LONG_COUNT_M: f64 = 0.01 / 6.0;

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
    // A pipe would be waited for without end, and a device may never end.
    let text = read_keys(file).map_err(|error| {
        Error::new(format_args!("cannot read {}: {error}", file.display()))
            .hint("`beeline config export` writes such a file")
    })?;
    parse(file, &text)
}

fn read(common: &Common) -> Result<Config> {
    with_robot(&common.port, &common.sim(), async |session, _| Ok(session.read_config().await?))
}

/// Reads the configuration, changes it, writes it, reads it back, and saves it if `save`.
fn change(common: &Common, save: bool, change: impl Fn(&Config) -> Result<Config>) -> Result<()> {
    let (before, after) = with_robot(&common.port, &common.sim(), async |session, _| {
        let before = session.read_config().await?;
        let after = change(&before)?;
        refuse_contradiction(&before, &after)?;
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
    warn_if_coarse(&before, &after);
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

/// Each value is in its range, and no supply would be right: said before it is so, and not to somebody who mends it.
fn refuse_contradiction(before: &Config, after: &Config) -> Result<()> {
    let contradicts = |config: &Config| {
        let protection = &config.protection;
        // Zero is no upper limit.
        (protection.supply_v_max > 0.0 && protection.supply_v_min >= protection.supply_v_max)
            .then_some((protection.supply_v_min, protection.supply_v_max))
    };
    match (contradicts(before), contradicts(after)) {
        (None, Some((min, max))) => Err(Error::new(format_args!(
            "protection.supply_v_min ({min} V) would not be below protection.supply_v_max ({max} V): the robot could never be armed"
        ))
        .hint("set the other one first; what the battery has empty and full lies between them")),
        _ => Ok(()),
    }
}

/// Of counts so long that the encoder check and the protection see little: said when they get so.
fn warn_if_coarse(before: &Config, after: &Config) {
    let (before_m, after_m) = (longer_count_m(before), longer_count_m(after));
    if after_m > LONG_COUNT_M && after_m > before_m {
        warn(format_args!(
            "one count is {:.1} mm of travel now: encoder check and protection need up to six of them, so a wheel whose encoder fails turns {:.0} cm or more before it is stopped; is counts_per_rev every edge of both lines, and gear_reduction the gear between encoder and wheel?",
            after_m * 1e3,
            6.0 * after_m * 1e2
        ));
    }
    let max_m = after.protection.following_error_m_max;
    let never =
        |config: &Config| 2.0 * longer_count_m(config) > config.protection.following_error_m_max;
    if never(after) && !never(before) {
        warn(format_args!(
            "two counts are {:.0} mm of travel, more than protection.following_error_m_max ({:.0} mm): drives end with following_error",
            2.0 * after_m * 1e3,
            max_m * 1e3
        ));
    }
}

fn warn_if_it_forgets(common: &Common) {
    if common.port.is_sim() && common.flash.is_none() {
        warn("this simulated robot forgets when the command ends; --flash FILE gives it a memory");
    }
}

fn export(common: &Common, config: &Config, file: &Path, force: bool) -> Result<()> {
    let text = toml::to_string(config).context("the configuration")?;
    if file.as_os_str() == "-" && common.json {
        return Err(Error::new("what `config export -` prints is TOML, no JSON")
            .hint("`beeline config get --json` prints the configuration as JSON"));
    }
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
