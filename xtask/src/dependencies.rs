//! What the project depends on: licences, sources, duplicates, by the rules of `deny.toml`; and which crate must not
//! depend on which, by the table in [`layers`].
//!
//! The first are cargo-deny's rules. It takes minutes to compile, so its parts that need no database are held here, from
//! what cargo itself knows; known vulnerabilities need cargo-deny and its database.

mod layers;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use cargo_metadata::{Metadata, MetadataCommand, Package};
use serde::Deserialize;
use spdx::{Expression, ParseMode};

use crate::repository::root;
use crate::steps::{Outcome, cargo_command, run};

/// The part of `deny.toml` that is held.
#[derive(Deserialize)]
struct Rules {
    licenses: Licenses,
    bans: Bans,
}

#[derive(Deserialize)]
struct Licenses {
    allow: Vec<String>,
}

#[derive(Deserialize)]
struct Bans {
    skip: Vec<Skipped>,
}

#[derive(Deserialize)]
struct Skipped {
    #[serde(rename = "crate")]
    name: String,
    reason: String,
}

impl Rules {
    fn read() -> Result<Self, String> {
        let text =
            fs::read_to_string(root().join("deny.toml")).map_err(|e| format!("deny.toml: {e}"))?;
        toml::from_str(&text).map_err(|error| format!("deny.toml: {error}"))
    }
}

/// Everything in the lock file, with all features, for all systems.
pub fn metadata() -> Result<Metadata, String> {
    MetadataCommand::new()
        .current_dir(root())
        .features(cargo_metadata::CargoOpt::AllFeatures)
        .other_options(["--locked".to_owned()])
        .exec()
        .map_err(|error| format!("cargo metadata: {error}"))
}

/// Folders outside the workspace that have a lock file of their own: nothing that is compiled here would notice that one is old.
const WITH_LOCKS: [&str; 2] = ["pico2", "python"];

/// A command that keeps to its lock file must not fail because one of our crates needs something else since.
pub fn locks() -> Outcome {
    for folder in WITH_LOCKS {
        let mut update = cargo_command(&["update", "--workspace", "--locked", "--quiet"]);
        update.current_dir(root().join(folder));
        run(&mut update, &format!("run `cargo update --workspace` in {folder}/"))?;
    }
    Ok(())
}

/// Holds the dependencies to the rules.
pub fn check() -> Outcome {
    let rules = Rules::read()?;
    let mut findings = Vec::new();
    let metadata = metadata()?;
    let foreign: Vec<&Package> =
        metadata.packages.iter().filter(|package| package.source.is_some()).collect();
    println!("    {} packages", foreign.len());
    findings.extend(licences(&rules, &foreign));
    findings.extend(sources(&foreign));
    findings.extend(duplicates(&rules, &foreign));
    let layers = layers::findings()?;
    let groups = [("of deny.toml", findings), ("in xtask/src/dependencies/layers.rs", layers)];
    let failures: Vec<String> = groups
        .into_iter()
        .filter(|(_, findings)| !findings.is_empty())
        .map(|(place, findings)| format!("against the rules {place}:\n{}", findings.join("\n")))
        .collect();
    if failures.is_empty() { Ok(()) } else { Err(failures.join("\n")) }
}

fn licences(rules: &Rules, packages: &[&Package]) -> Vec<String> {
    let finding = |package: &&&Package| {
        let (name, version) = (&package.name, &package.version);
        let Some(licence) = &package.license else {
            return Some(format!("{name} {version} names no licence"));
        };
        match is_allowed(licence, &rules.licenses.allow) {
            Ok(true) => None,
            Ok(false) => Some(format!("{name} {version} is under {licence}")),
            Err(error) => Some(format!("{name} {version}: {error}")),
        }
    };
    packages.iter().filter_map(|package| finding(&package)).collect()
}

/// Whether some choice among the licences of an expression is allowed.
fn is_allowed(licence: &str, allow: &[String]) -> Result<bool, String> {
    let parsed = Expression::parse_mode(licence, ParseMode::LAX)
        .map_err(|error| format!("`{licence}` is no licence: {}", error.reason))?;
    Ok(parsed.evaluate(|required| allow.contains(&required.to_string())))
}

fn sources(packages: &[&Package]) -> Vec<String> {
    let from_elsewhere =
        packages.iter().filter(|p| p.source.as_ref().is_some_and(|source| !source.is_crates_io()));
    from_elsewhere.map(|p| format!("{} {} is not from crates.io", p.name, p.version)).collect()
}

fn duplicates(rules: &Rules, packages: &[&Package]) -> Vec<String> {
    let mut versions: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for package in packages {
        versions.entry(&package.name).or_default().insert(package.version.to_string());
    }
    let skips = &rules.bans.skip;
    let skipped = |name: &str| skips.iter().any(|skip| skip.name == name);
    let is_twice = |name: &str| versions.get(name).is_some_and(|versions| versions.len() > 1);
    let twice = versions.iter().filter(|(name, versions)| versions.len() > 1 && !skipped(name));
    let twice = twice.map(|(name, versions)| {
        let versions: Vec<&str> = versions.iter().map(String::as_str).collect();
        format!("{name} is there in {}: agree on one, or say why not", versions.join(" and "))
    });
    let idle = skips.iter().filter(|skip| !is_twice(&skip.name) || skip.reason.is_empty());
    let idle = idle
        .map(|skip| format!("`skip` names {}, which is there once, or gives no reason", skip.name));
    twice.chain(idle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_licence_is_allowed_if_one_choice_among_its_parts_is() {
        let allow = ["MIT", "Apache-2.0", "Unicode-3.0"].map(String::from);
        let allowed = |licence| is_allowed(licence, &allow);
        for good in
            ["MIT", "MIT/Apache-2.0", "MIT OR GPL-3.0-only", "(MIT OR Apache-2.0) AND Unicode-3.0"]
        {
            assert_eq!(allowed(good), Ok(true), "{good}");
        }
        for bad in ["GPL-3.0-only", "MIT AND MPL-2.0", "Apache-2.0 WITH LLVM-exception"] {
            assert_eq!(allowed(bad), Ok(false), "{bad}");
        }
        assert!(allowed("Proprietary, ask us").is_err());
    }

    #[test]
    fn the_rules_can_be_read_and_each_exception_has_its_reason() {
        let rules = Rules::read().unwrap();
        assert!(rules.licenses.allow.contains(&"MPL-2.0".to_owned()));
        assert!(rules.bans.skip.iter().all(|skip| skip.reason.len() > 10));
    }
}
