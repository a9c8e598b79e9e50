//! The file of a pre-shared key: one line of 32 hexadecimal digits, for its owner's eyes alone.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use shared_proto::Key;

use crate::error::{Error, Result};
pub use crate::key_file_problem::KeyFileProblem;

/// No key's file is longer \[bytes\].
const BYTES_MAX: u64 = 64;

/// Reads a key. On Unix, nobody but the file's owner may have access to it.
pub fn read(path: &Path) -> Result<Key> {
    read_checked(path).map_err(|problem| failed(path, problem))
}

/// Makes a new key, of the system's random numbers, in a new file that only its owner may read.
pub fn create(path: &Path) -> Result<Key> {
    let key = random()?;
    write_new(path, &key).map_err(|problem| failed(path, problem))?;
    Ok(key)
}

/// A key of the system's random numbers, for what [`Session::use_key`](crate::Session::use_key) needs beside the
/// pre-shared one.
pub fn random() -> Result<Key> {
    let mut bytes = [0; Key::LEN];
    getrandom::fill(&mut bytes).map_err(|error| Error::NoRandomNumbers(error.to_string()))?;
    Ok(Key::new(bytes))
}

/// 32 random bytes of the system.
pub fn random_seed() -> Result<[u8; 32]> {
    let (first, second) = (random()?, random()?);
    let halves = [*first.expose(), *second.expose()];
    Ok(std::array::from_fn(|i| halves[i / Key::LEN][i % Key::LEN]))
}

fn failed(path: &Path, problem: KeyFileProblem) -> Error {
    Error::KeyFile { path: PathBuf::from(path), problem }
}

fn read_checked(path: &Path) -> std::result::Result<Key, KeyFileProblem> {
    // Opening a pipe would wait for its writer.
    let there = std::fs::metadata(path).map_err(KeyFileProblem::Unreadable)?;
    if !there.is_file() {
        return Err(KeyFileProblem::NotAFile);
    }
    let file = File::open(path).map_err(KeyFileProblem::Unreadable)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Of what was opened, not of what has the name now.
        let mode = file.metadata().map_err(KeyFileProblem::Unreadable)?.permissions().mode();
        if mode & 0o077 != 0 {
            return Err(KeyFileProblem::Shared(mode & 0o777));
        }
    }
    let mut text = String::new();
    match file.take(BYTES_MAX).read_to_string(&mut text) {
        Ok(_) => Key::from_hex(text.trim_ascii_end()).ok_or(KeyFileProblem::NotAKey),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => Err(KeyFileProblem::NotAKey),
        Err(error) => Err(KeyFileProblem::Unreadable(error)),
    }
}

fn write_new(path: &Path, key: &Key) -> std::result::Result<(), KeyFileProblem> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let mut file = options.open(path).map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => KeyFileProblem::Exists,
        _ => KeyFileProblem::Unwritable(error),
    })?;
    let line: String =
        key.expose().iter().map(|byte| format!("{byte:02x}")).chain(["\n".into()]).collect();
    let written = file.write_all(line.as_bytes()).and_then(|()| file.sync_all());
    written.map_err(|error| {
        // Half a key is none.
        let _ = std::fs::remove_file(path);
        KeyFileProblem::Unwritable(error)
    })
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    fn problem(path: &Path) -> String {
        read(path).expect_err("no key").to_string()
    }

    #[test]
    fn a_new_key_is_its_owners_alone_is_read_back_and_overwrites_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.key");
        let key = create(&path).unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        assert_eq!(read(&path).unwrap(), key);
        assert!(create(&path).unwrap_err().to_string().contains("is not overwritten"));
        assert_ne!(create(&folder.path().join("other.key")).unwrap(), key);
        assert!(!format!("{key:?}").contains(|c: char| c.is_ascii_digit()), "{key:?}");
    }

    #[test]
    fn what_others_may_read_or_is_no_key_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.key");
        assert!(problem(&path).contains("robot.key: it cannot be read"));
        assert!(problem(folder.path()).contains("it is not a file"));
        create(&path).unwrap();
        for mode in [0o640, 0o604, 0o660, 0o644, 0o602] {
            std::fs::set_permissions(&path, PermissionsExt::from_mode(mode)).unwrap();
            assert!(problem(&path).contains(&format!("mode {mode:03o}")), "{mode:o}");
        }
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o600)).unwrap();
        for text in
            ["", "secret", "0123456789abcdef0123456789abcde", "0123456789abcdef0123456789abcdeg\n"]
        {
            std::fs::write(&path, text).unwrap();
            assert!(problem(&path).contains("32 hexadecimal digits"), "{text:?}");
        }
        std::fs::write(&path, [0xFF; 4096]).unwrap();
        let message = problem(&path);
        assert!(message.contains("32 hexadecimal digits"), "{message}");
    }
}
