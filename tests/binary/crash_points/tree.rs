//! What is in a folder: all files below it with their bytes.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// All files below a folder with their bytes, without locks and what a process is still writing.
///
/// Any whole `new.key` counts as one and the same: it is random. So does a flash that counts one start more.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tree(pub BTreeMap<PathBuf, Vec<u8>>);

impl Tree {
    pub fn of(folder: &Path) -> Self {
        let files = files(folder).into_iter().filter(|file| !is_passing(file));
        let named = |file: PathBuf| (file.strip_prefix(folder).unwrap().into(), read(&file));
        Self(files.map(named).collect())
    }

    /// Writes all of it into a folder.
    pub fn write(&self, folder: &Path) {
        for (name, bytes) in &self.0 {
            let file = folder.join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(&file, bytes).unwrap();
            if is_key(&file) {
                fs::set_permissions(&file, PermissionsExt::from_mode(0o600)).unwrap();
            }
        }
    }

    /// The names of files that differ from those of another tree.
    pub fn differing<'a>(&'a self, other: &'a Self) -> Vec<&'a Path> {
        let all = self.0.keys().chain(other.0.keys());
        let mut names: Vec<&Path> = all
            .filter(|name| self.0.get(*name) != other.0.get(*name))
            .map(|name| &**name)
            .collect();
        names.sort();
        names.dedup();
        names
    }
}

/// Makes what a killed process left look two minutes old: what is younger may still be written.
pub fn age(folder: &Path) {
    let then = SystemTime::now() - Duration::from_secs(120);
    for file in files(folder).into_iter().filter(|file| is_passing(file)) {
        File::open(file).unwrap().set_modified(then).unwrap();
    }
}

/// What a process leaves beside the files it writes, if it is killed.
pub fn leftovers(folder: &Path) -> Vec<PathBuf> {
    files(folder).into_iter().filter(|file| is_passing(file)).collect()
}

fn is_passing(file: &Path) -> bool {
    let name = file.file_name().unwrap().to_string_lossy();
    name.ends_with(".part") || name.ends_with(".beeline-part") || name == campaign::lock::NAME
}

fn read(file: &Path) -> Vec<u8> {
    let bytes = fs::read(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    if is_key(file) {
        let mode = file.metadata().unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600, "{}", file.display());
    }
    if file.ends_with("new.key") && bytes.len() == KEYS[0].len() {
        return KEYS[0].into();
    }
    if file.ends_with("flash") { without_count(bytes) } else { bytes }
}

/// The flash of a simulated robot as it would be at its first start.
fn without_count(flash: Vec<u8>) -> Vec<u8> {
    const BEFORE: &str = "\n# link ";
    let text = String::from_utf8(flash).expect("the flash is text");
    let Some((before, link)) = text.split_once(BEFORE) else { return text.into_bytes() };
    let after = link.trim_start_matches(|c: char| c.is_ascii_digit());
    format!("{before}{BEFORE}0{after}").into_bytes()
}

/// Two keys as their files hold them.
pub const KEYS: [&str; 2] =
    ["00112233445566778899aabbccddeeff\n", "ffeeddccbbaa99887766554433221100\n"];

fn is_key(file: &Path) -> bool {
    file.extension().is_some_and(|end| end == "key")
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !is_passing(&path) { all.extend(files(&path)) } else { all.push(path) }
    }
    all
}
