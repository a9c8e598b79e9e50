//! Which file of a crate uses which other file of it, and for which names.
//!
//! File A uses file B if A's code names something that is defined in B: by `use`, by a path such as
//! `crate::b::f`, or by a name that a re-export put into A. A re-export is followed to the file that
//! defines the item, so `pub use child::Item` is no use of `child`, and whoever names `Item` through
//! it uses `child`. `mod child;` alone is none either. Code under `#[cfg(test)]` is left out.
//!
//! [`read`] builds the tree of modules, [`names`] finds the paths in code, [`resolve`] the file that a
//! path leads to. What only the compiler knows is not seen: methods called on a value, and names that
//! a macro makes up.

mod names;
mod read;
mod resolve;
mod use_tree;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The names that one file takes from another, by (from, to); files as the root sees them.
pub type Uses = BTreeMap<(PathBuf, PathBuf), BTreeSet<String>>;

/// One module: a file, or a block `mod name { }` in a file.
#[derive(Debug, Default)]
struct Module {
    /// Where it is written.
    file: PathBuf,
    /// Where the files of its child modules are.
    folder: PathBuf,
    /// Only compiled for tests: its uses do not count.
    is_test: bool,
    parent: Option<usize>,
    children: BTreeMap<String, usize>,
    /// What it defines.
    items: BTreeSet<String>,
    /// What `use` brings in, by its name here, and the path to it.
    imports: BTreeMap<String, Vec<String>>,
    /// Modules or enums of which `use` brings in everything.
    globs: Vec<Vec<String>>,
    /// Paths that its code names; `name!` for a macro that is called.
    mentions: BTreeSet<Vec<String>>,
}

/// A crate's modules; the first is its root.
#[derive(Debug, Default)]
pub struct Crate {
    modules: Vec<Module>,
}

impl Crate {
    /// The files that it consists of, those for tests included.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.modules.iter().map(|module| module.file.as_path())
    }

    /// The paths that its code names or brings in by `use`, each with the file; tests are left out. A macro that is
    /// called is there by its name and `!`.
    pub fn mentions(&self) -> impl Iterator<Item = (&Path, &[String])> {
        self.modules.iter().filter(|module| !module.is_test).flat_map(|module| {
            let brought_in = module.imports.values().chain(&module.globs);
            let all = module.mentions.iter().chain(brought_in);
            all.map(|path| (module.file.as_path(), path.as_slice()))
        })
    }

    /// Which file uses which.
    pub fn uses(&self) -> Uses {
        let mut uses = Uses::new();
        for (index, module) in self.modules.iter().enumerate().filter(|(_, one)| !one.is_test) {
            for path in &module.mentions {
                let Some((file, name)) = self.definition(index, path) else { continue };
                if file != module.file {
                    let arrow = (module.file.clone(), file.to_path_buf());
                    uses.entry(arrow).or_default().insert(name);
                }
            }
        }
        uses
    }
}

/// The root modules of all crates in these files: libraries, programs, examples and test programs.
pub fn crate_roots(base: &Path, files: &[PathBuf]) -> Result<Vec<PathBuf>, String> {
    let mut roots = BTreeSet::new();
    for manifest in files.iter().filter(|file| file.ends_with("Cargo.toml")) {
        let folder = manifest.parent().unwrap_or(Path::new(""));
        // The workspace's own manifest has no crate.
        if folder == Path::new("") {
            continue;
        }
        let text = std::fs::read_to_string(base.join(manifest))
            .map_err(|error| format!("{}: {error}", manifest.display()))?;
        // Dependencies have paths as well, but not to a `.rs` file.
        let named =
            text.lines().filter_map(|line| line.strip_prefix("path = \"")?.strip_suffix('"'));
        let named = named.filter(|path| path.ends_with(".rs")).map(|path| tidy(&folder.join(path)));
        roots.extend(named.filter(|root| files.contains(root)));
        for file in files {
            let Ok(inner) = file.strip_prefix(folder) else { continue };
            let parts: Vec<&str> = inner.iter().filter_map(|part| part.to_str()).collect();
            let is_root = match parts[..] {
                ["build.rs"] | ["src", "lib.rs" | "main.rs"] => true,
                ["src", "bin", name] | ["tests" | "examples" | "benches", name] => {
                    name.ends_with(".rs")
                }
                ["src", "bin", _, "main.rs"] => true,
                ["tests" | "examples" | "benches", _, "main.rs"] => true,
                _ => false,
            };
            if is_root {
                roots.insert(file.clone());
            }
        }
    }
    Ok(roots.into_iter().collect())
}

/// A path without `..`.
fn tidy(path: &Path) -> PathBuf {
    let mut tidy = PathBuf::new();
    for part in path.components() {
        match part {
            std::path::Component::ParentDir => {
                tidy.pop();
            }
            std::path::Component::CurDir => {}
            part => tidy.push(part),
        }
    }
    tidy
}
