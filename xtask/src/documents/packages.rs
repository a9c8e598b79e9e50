//! The packages of the repository, and what cargo builds and runs of each.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use toml::Table;

/// A package's names.
#[derive(Debug, Default)]
pub struct Package {
    pub name: String,
    /// What `--test`, `--example`, `--bin`, `--bench` and `--features` may name.
    names: BTreeSet<(&'static str, String)>,
}

/// What a manifest calls a target, the option that names one, and the folder where cargo looks for them.
const KINDS: [(&str, &str, &str); 4] = [
    ("test", "--test", "tests"),
    ("example", "--example", "examples"),
    ("bin", "--bin", "src/bin"),
    ("bench", "--bench", "benches"),
];

const FEATURES: &str = "--features";

impl Package {
    /// The packages whose manifests are among these files.
    pub fn all(base: &Path, files: &[PathBuf]) -> Vec<Self> {
        let manifests = files.iter().filter(|file| file.ends_with("Cargo.toml"));
        manifests.filter_map(|manifest| Self::read(base, manifest, files)).collect()
    }

    /// `None` for a manifest without a package: that of the workspace.
    fn read(base: &Path, manifest: &Path, files: &[PathBuf]) -> Option<Self> {
        let table: Table = std::fs::read_to_string(base.join(manifest)).ok()?.parse().ok()?;
        let name = table.get("package")?.get("name")?.as_str()?.to_owned();
        let folder = manifest.parent()?;
        let mut names = BTreeSet::new();
        for (kind, option, place) in KINDS {
            let named = table.get(kind).and_then(|list| list.as_array()).into_iter().flatten();
            let named = named.filter_map(|target| target.get("name")?.as_str());
            names.extend(named.map(|name| (option, name.to_owned())));
            let place = folder.join(place);
            let found =
                files.iter().filter_map(|file| target_name(file.strip_prefix(&place).ok()?));
            names.extend(found.map(|name| (option, name)));
        }
        if files.contains(&folder.join("src/main.rs")) {
            names.insert(("--bin", name.clone()));
        }
        let features = table.get("features").and_then(|features| features.as_table());
        let features = features.into_iter().flat_map(|features| features.keys());
        names.extend(features.map(|name| (FEATURES, name.clone())));
        Some(Self { name, names })
    }

    /// Whether the option may name this.
    pub fn has(&self, option: &str, name: &str) -> bool {
        self.names.iter().any(|known| known.0 == option && known.1 == name)
    }
}

/// Whether an option is followed by a name that a package has to have.
pub fn takes_name(option: &str) -> bool {
    option == FEATURES || KINDS.iter().any(|kind| kind.1 == option)
}

/// A target is a file, or a folder with `main.rs`.
fn target_name(file: &Path) -> Option<String> {
    let parts: Vec<&str> = file.iter().filter_map(|part| part.to_str()).collect();
    match parts[..] {
        [name] => name.strip_suffix(".rs").map(String::from),
        [name, "main.rs"] => Some(name.to_owned()),
        _ => None,
    }
}
