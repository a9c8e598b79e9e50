//! `cargo xtask third-party`: the notice of whose code is in the programs, from the lock file.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;

use cargo_metadata::{DependencyKind, Metadata, Package, PackageId};

use crate::dependencies::metadata;
use crate::repository::root;
use crate::steps::Outcome;

const NOTICE: &str = "THIRD-PARTY.txt";

/// The packages of what is distributed: the program `beeline`, and the boards' images.
const PROGRAMS: [&str; 2] = ["host-cli", "firmware"];

const HEAD: &str = "\
Third-party code in Beeline. Written by `cargo xtask third-party`, from Cargo.lock.

Beeline itself is under MIT or Apache-2.0, at your choice: LICENSE-MIT, LICENSE-APACHE. Its programs contain the
packages below, each under its own licence. Where a package offers a choice with MIT or Apache-2.0 in it, that is what
Beeline uses. The source of each package is at https://crates.io/crates/NAME/VERSION.

serialport is under the Mozilla Public License 2.0 (https://mozilla.org/MPL/2.0/). It is used unchanged; its source, at
the version named below, is at https://crates.io/crates/serialport and https://github.com/serialport/serialport-rs, under
that licence. Nothing else of Beeline is.

Lines below a package are its copyright notices.
";

/// Writes the notice.
pub fn run() -> Outcome {
    let text = notice(&metadata()?);
    fs::write(root().join(NOTICE), text).map_err(|error| format!("{NOTICE}: {error}"))
}

/// Holds the notice to the lock file, without asking cargo: packages are not fetched for it.
pub fn check() -> Outcome {
    let read =
        |name: &str| fs::read_to_string(root().join(name)).map_err(|e| format!("{name}: {e}"));
    let (locked, told) = (locked(&read("Cargo.lock")?)?, told(&read(NOTICE)?));
    if locked == told {
        return Ok(());
    }
    let difference: Vec<&str> =
        locked.symmetric_difference(&told).map(String::as_str).take(5).collect();
    Err(format!(
        "{NOTICE} is not that of Cargo.lock ({}): run `cargo xtask third-party`",
        difference.join(", ")
    ))
}

/// The packages of a lock file that are not the project's own, as `name version`.
fn locked(text: &str) -> Result<BTreeSet<String>, String> {
    let lock: toml::Table = toml::from_str(text).map_err(|error| format!("Cargo.lock: {error}"))?;
    let packages = lock.get("package").and_then(toml::Value::as_array).ok_or("no packages")?;
    let word = |package: &toml::Value, key: &str| {
        package.get(key).and_then(toml::Value::as_str).map(str::to_owned)
    };
    let foreign = packages.iter().filter(|package| package.get("source").is_some());
    let named = foreign.filter_map(|package| {
        Some(format!("{} {}", word(package, "name")?, word(package, "version")?))
    });
    Ok(named.collect())
}

/// The packages that the notice names.
fn told(text: &str) -> BTreeSet<String> {
    let lines = text.lines().filter_map(|line| line.strip_prefix("* "));
    lines.map(|line| line.split(", ").next().unwrap_or(line).to_owned()).collect()
}

fn notice(metadata: &Metadata) -> String {
    let mut text = HEAD.to_owned();
    let packages: BTreeMap<&PackageId, &Package> =
        metadata.packages.iter().map(|package| (&package.id, package)).collect();
    let mut list = |title: &str, chosen: &BTreeSet<&PackageId>, copyright: bool| {
        let _ = write!(text, "\n{title}\n\n");
        let mut chosen: Vec<&Package> =
            chosen.iter().filter_map(|id| packages.get(id).copied()).collect();
        chosen.retain(|package| package.source.is_some());
        chosen.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
        for package in chosen {
            let licence = package.license.as_deref().unwrap_or("see its source");
            let _ = writeln!(text, "* {} {}, {licence}", package.name, package.version);
            for line in copyright.then(|| copyrights(package)).into_iter().flatten() {
                let _ = writeln!(text, "    {line}");
            }
        }
    };
    let ours = PROGRAMS.iter().flat_map(|program| closure(metadata, program)).collect();
    list(
        "In the program `beeline` or in the boards' images, or used to build them, on any system",
        &ours,
        true,
    );
    let all: BTreeSet<&PackageId> = metadata.packages.iter().map(|package| &package.id).collect();
    let rest = all.difference(&ours).copied().collect();
    list("For tests, benchmarks and chores alone: in nothing that is distributed", &rest, false);
    text + "\n" + &texts(metadata)
}

/// A package and all that it needs, tests excepted.
fn closure<'a>(metadata: &'a Metadata, program: &str) -> BTreeSet<&'a PackageId> {
    let Some(resolve) = &metadata.resolve else { return BTreeSet::new() };
    let nodes: BTreeMap<&PackageId, _> =
        resolve.nodes.iter().map(|node| (&node.id, node)).collect();
    let root = metadata.packages.iter().find(|package| package.name == program);
    let mut found = BTreeSet::new();
    let mut open: Vec<&PackageId> = root.map(|package| &package.id).into_iter().collect();
    while let Some(id) = open.pop() {
        if !found.insert(id) {
            continue;
        }
        let needed = nodes.get(id).into_iter().flat_map(|node| &node.deps).filter(|dependency| {
            dependency.dep_kinds.iter().any(|kind| kind.kind != DependencyKind::Development)
        });
        open.extend(needed.map(|dependency| &dependency.pkg));
    }
    found
}

/// The lines of a package's licence files that name whose it is.
fn copyrights(package: &Package) -> BTreeSet<String> {
    let folder = package.manifest_path.parent();
    let entries =
        folder.and_then(|folder| fs::read_dir(folder).ok()).into_iter().flatten().flatten();
    let is_licence = |name: &str| {
        let name = name.to_uppercase();
        ["LICENSE", "LICENCE", "COPYING", "COPYRIGHT", "NOTICE"]
            .iter()
            .any(|word| name.starts_with(word))
    };
    let files = entries.filter(|entry| entry.file_name().to_str().is_some_and(is_licence));
    let texts = files.filter_map(|entry| fs::read_to_string(entry.path()).ok());
    let is_notice = |line: &str| {
        let lower = line.to_lowercase();
        let begins = lower.starts_with("copyright (c)")
            || lower.starts_with("copyright \u{a9}")
            || lower.starts_with("copyright 1")
            || lower.starts_with("copyright 2");
        begins && !line.contains(['[', '{', '<'])
            || lower.starts_with("copyright (c) ") && line.contains('<')
    };
    let lines: Vec<String> = texts
        .flat_map(|text| text.lines().map(|line| line.trim().to_owned()).collect::<Vec<_>>())
        .filter(|line| is_notice(line))
        .collect();
    lines.into_iter().collect()
}

/// The texts of the licences that are not in the repository already, each as one package has it.
fn texts(metadata: &Metadata) -> String {
    let wanted = [("Unicode-3.0", "unicode-ident", "LICENSE-UNICODE")];
    let mut text = String::new();
    for (licence, package, file) in wanted {
        let found = metadata.packages.iter().find(|known| known.name == package);
        let file = found.and_then(|known| Some(known.manifest_path.parent()?.join(file)));
        let whole = file.and_then(|file| fs::read_to_string(file).ok()).unwrap_or_default();
        let lines: Vec<&str> = whole.lines().map(str::trim_end).collect();
        let _ = write!(text, "The text of {licence}\n\n{}\n", lines.join("\n"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_notice_names_what_is_locked_and_nothing_else() {
        let lock = "[[package]]\nname = \"own\"\nversion = \"1.0.0\"\n[[package]]\nname = \"theirs\"\nversion = \"2.0.0\"\nsource = \"x\"\n";
        let named = locked(lock).unwrap();
        assert_eq!(named, BTreeSet::from(["theirs 2.0.0".to_owned()]));
        assert_eq!(
            told("Third\n\n* theirs 2.0.0, MIT OR Apache-2.0\n    Copyright (c) They, who else\n"),
            named
        );
        assert_ne!(told("* theirs 2.0.1, MIT\n"), named);
        assert!(told("").is_empty());
    }

    #[test]
    fn the_one_package_with_a_duty_to_tell_its_source_is_told() {
        assert!(HEAD.contains("serialport is under the Mozilla Public License 2.0"));
        let text = fs::read_to_string(root().join(NOTICE)).unwrap();
        let others = text.lines().filter(|line| line.starts_with("* ") && line.contains("MPL"));
        let others: Vec<&str> = others.filter(|line| !line.starts_with("* serialport ")).collect();
        assert!(others.is_empty(), "say where their source is: {others:?}");
    }
}
