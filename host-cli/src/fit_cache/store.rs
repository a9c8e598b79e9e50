//! The files: `$XDG_CACHE_HOME/beeline`, or `~/.cache/beeline`. Whoever removes them loses only time.
//!
//! A file is the hash of its key and its values, then the values. It is written beside its place and renamed, so processes may read and write it at
//! once: each finds a whole file or none. One that is damaged, or not of its key, is as none.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use campaign::file::write_whole;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use super::key::Key;

/// This many files are kept: those used last.
pub(super) const FILES_MAX: usize = 128;

/// A file of more bytes is neither written nor read; an answer has some 10,000.
const BYTES_MAX: usize = 1 << 20;

/// The bytes of a hash.
const HASH: usize = 32;

const ENDING: &str = "fit";

/// A folder of files.
pub(super) struct Store(PathBuf);

impl Store {
    /// That of the user; none if nobody says where it is.
    pub fn of_user() -> Option<Self> {
        let set = |name: &str| {
            std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from)
        };
        let cache = set("XDG_CACHE_HOME")
            .or_else(|| set("LOCALAPPDATA"))
            .or_else(|| set("HOME").map(|home| home.join(".cache")))?;
        // A folder that depends on where the command runs would be left in many places.
        cache.is_absolute().then(|| Self::at(&cache.join("beeline")))
    }

    pub fn at(folder: &Path) -> Self {
        Self(folder.to_owned())
    }

    /// What is kept under a key.
    pub fn read<T: DeserializeOwned>(&self, key: &Key) -> Option<T> {
        let place = self.place(key);
        // Opening a pipe would wait for its writer.
        if !std::fs::symlink_metadata(&place).ok()?.is_file() {
            return None;
        }
        let mut bytes = Vec::new();
        File::open(&place).ok()?.take(BYTES_MAX as u64).read_to_end(&mut bytes).ok()?;
        let (hash, values) = bytes.split_at_checked(HASH)?;
        if hash != hash_of(key, values) {
            return None;
        }
        let value = postcard::from_bytes(values).ok()?;
        // It was used; a folder that cannot be written keeps its order.
        let _ = File::options()
            .write(true)
            .open(place)
            .and_then(|file| file.set_modified(SystemTime::now()));
        Some(value)
    }

    /// Keeps something under a key, if that can be done.
    pub fn write(&self, key: &Key, value: &impl Serialize) {
        let Ok(values) = postcard::to_stdvec(value) else { return };
        if HASH + values.len() > BYTES_MAX || make_folder(&self.0).is_err() {
            return;
        }
        let bytes = [&hash_of(key, &values)[..], &values].concat();
        if write_whole(&self.place(key), &bytes).is_ok() {
            self.forget_the_oldest();
        }
    }

    fn place(&self, key: &Key) -> PathBuf {
        self.0.join(key.file_name()).with_extension(ENDING)
    }

    fn forget_the_oldest(&self) {
        let Ok(entries) = fs::read_dir(&self.0) else { return };
        let ours = |path: &PathBuf| path.extension().is_some_and(|ending| ending == ENDING);
        let dated = |path: PathBuf| Some((fs::metadata(&path).ok()?.modified().ok()?, path));
        let paths = entries.flatten().map(|entry| entry.path()).filter(ours);
        let mut files: Vec<(SystemTime, PathBuf)> = paths.filter_map(dated).collect();
        files.sort();
        for (_, path) in &files[..files.len().saturating_sub(FILES_MAX)] {
            // Another process may have removed it.
            let _ = fs::remove_file(path);
        }
    }
}

fn hash_of(key: &Key, values: &[u8]) -> [u8; HASH] {
    Sha256::new().chain_update(key.0).chain_update(values).finalize().into()
}

/// What is in it is about the user's robots: nobody else may look.
fn make_folder(folder: &Path) -> std::io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn key(number: u8) -> Key {
        Key([number; 32])
    }

    #[test]
    #[cfg(unix)]
    fn a_pipe_in_place_of_a_file_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path());
        let pipe = store.place(&key(1));
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        assert_eq!(store.read::<f64>(&key(1)), None);
    }

    #[test]
    fn so_many_files_are_kept_and_those_used_last_stay() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(&folder.path().join("new"));
        let old = SystemTime::now() - Duration::from_secs(1000);
        for number in 0..FILES_MAX as u8 {
            store.write(&key(number), &f64::from(number));
            let file = File::options().write(true).open(store.place(&key(number))).unwrap();
            file.set_modified(old + Duration::from_secs(u64::from(number))).unwrap();
        }
        std::fs::write(store.0.join("not ours"), "").unwrap();
        assert_eq!(store.read(&key(0)), Some(0.0));
        store.write(&key(200), &200.0);
        let kept = |number: u8| store.read::<f64>(&key(number));
        assert_eq!(
            (kept(0), kept(1), kept(2), kept(200)),
            (Some(0.0), None, Some(2.0), Some(200.0))
        );
        assert_eq!(fs::read_dir(&store.0).unwrap().count(), FILES_MAX + 1);
    }

    #[test]
    fn a_file_under_the_name_of_another_key_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path());
        store.write(&key(1), &1.0);
        fs::rename(store.place(&key(1)), store.place(&key(2))).unwrap();
        assert_eq!(store.read::<f64>(&key(2)), None);
    }

    #[test]
    fn what_is_too_long_is_not_kept() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path());
        store.write(&key(1), &vec![1_u8; BYTES_MAX]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    #[cfg(unix)]
    fn nobody_else_may_look() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(&folder.path().join("beeline"));
        store.write(&key(1), &1.0);
        assert_eq!(fs::metadata(&store.0).unwrap().permissions().mode() & 0o777, 0o700);
    }
}
