//! Where the repository is, and what is in it.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The repository's root.
///
/// Asked at run time: with one build folder for two checkouts, cargo may run the program built in the other.
pub fn root() -> &'static Path {
    static ROOT: OnceLock<PathBuf> = OnceLock::new();
    ROOT.get_or_init(|| {
        let package = std::env::var_os("CARGO_MANIFEST_DIR")
            .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
        package.parent().expect("xtask lies in the root").to_path_buf()
    })
}

/// Where everything is built.
pub fn target_folder() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| root().join("target"), |folder| root().join(folder))
}

/// The files that git tracks, or would track when everything is added; relative to the root.
///
/// A folder of the root in which nothing is tracked is its user's own, as a campaign that was copied there.
pub fn tracked_files() -> Result<Vec<PathBuf>, String> {
    let tracked = listed("--cached")?;
    let others = listed("--others")?;
    let files = with_new(tracked, others);
    Ok(files.into_iter().filter(|file| root().join(file).is_file()).collect())
}

/// The tracked files, and of the others those that are not in a folder of their user.
fn with_new(mut tracked: Vec<PathBuf>, others: Vec<PathBuf>) -> Vec<PathBuf> {
    let top = |file: &PathBuf| file.components().nth(1).and(file.iter().next()).map(OsString::from);
    let known: BTreeSet<Option<OsString>> = tracked.iter().map(top).collect();
    tracked.extend(others.into_iter().filter(|file| {
        let top = top(file);
        top.is_none() || known.contains(&top)
    }));
    tracked
}

fn listed(which: &str) -> Result<Vec<PathBuf>, String> {
    let output = Command::new("git")
        .args(["ls-files", "-z", which, "--exclude-standard"])
        .current_dir(root())
        .output()
        .map_err(|error| format!("cannot run git ({error}): install it"))?;
    if !output.status.success() {
        return Err(format!("git ls-files: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    let list = String::from_utf8(output.stdout).map_err(|_| "a file name is not UTF-8")?;
    Ok(list.split_terminator('\0').map(PathBuf::from).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_files_beside_ours_count_and_those_in_folders_of_a_user_do_not() {
        let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        let tracked = paths(&["README.md", "docs/a.md", "docs/b/c.md"]);
        let others = paths(&["new.md", "docs/new.md", "mystery/README.md", "mine/docs/x.md"]);
        let expected = paths(&["README.md", "docs/a.md", "docs/b/c.md", "new.md", "docs/new.md"]);
        assert_eq!(with_new(tracked, others), expected);
    }

    #[test]
    fn what_is_released_checks_its_arithmetic() {
        let text = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
        let manifest: toml::Table = text.parse().unwrap();
        let release = manifest["profile"]["release"].as_table().unwrap();
        assert_eq!(release["overflow-checks"].as_bool(), Some(true));
        assert!(!release.contains_key("package"), "a package of its own would be without");
    }
}
