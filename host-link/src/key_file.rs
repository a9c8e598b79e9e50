//! The file of a pre-shared key: one line of 32 hexadecimal digits, for its owner's eyes alone.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use shared_proto::Key;

use crate::error::{Error, Result};
pub use crate::key_file_problem::KeyFileProblem;

/// No key's file is longer \[bytes\].
const BYTES_MAX: u64 = 64;

/// Reads a key. On Unix, the file must be this user's, and nobody else may have access to it.
pub fn read(path: &Path) -> Result<Key> {
    read_checked(path).map_err(|problem| failed(path, problem))
}

/// What the file of a key holds.
pub fn text(key: &Key) -> String {
    key.expose().iter().map(|byte| format!("{byte:02x}")).chain(["\n".into()]).collect()
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
    // Of what was opened, not of what has the name now.
    #[cfg(unix)]
    check_owner(
        &file.metadata().map_err(KeyFileProblem::Unreadable)?,
        rustix::process::geteuid().as_raw(),
    )?;
    let mut text = String::new();
    match file.take(BYTES_MAX).read_to_string(&mut text) {
        Ok(_) => Key::from_hex(text.trim_ascii_end()).ok_or(KeyFileProblem::NotAKey),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => Err(KeyFileProblem::NotAKey),
        Err(error) => Err(KeyFileProblem::Unreadable(error)),
    }
}

/// Only this user has access: whoever else knows the key, or can change it, may drive the robot.
#[cfg(unix)]
fn check_owner(file: &std::fs::Metadata, user: u32) -> std::result::Result<(), KeyFileProblem> {
    use std::os::unix::fs::MetadataExt;
    if file.uid() != user {
        return Err(KeyFileProblem::OfAnother(file.uid()));
    }
    match file.mode() & 0o777 {
        mode if mode & 0o077 != 0 => Err(KeyFileProblem::Shared(mode)),
        _ => Ok(()),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    fn write(path: &Path, bytes: &[u8]) {
        std::fs::write(path, bytes).unwrap();
        std::fs::set_permissions(path, PermissionsExt::from_mode(0o600)).unwrap();
    }

    fn problem(path: &Path) -> String {
        read(path).expect_err("no key").to_string()
    }

    #[test]
    fn a_random_key_is_read_back_and_is_not_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.key");
        let key = random().unwrap();
        write(&path, text(&key).as_bytes());
        assert_eq!(read(&path).unwrap(), key);
        assert_ne!(random().unwrap(), key);
        assert!(!format!("{key:?}").contains(|c: char| c.is_ascii_digit()), "{key:?}");
    }

    /// Root can read it all the same.
    #[test]
    fn the_file_of_another_user_is_refused() {
        let file = tempfile::NamedTempFile::new().unwrap();
        write(file.path(), text(&random().unwrap()).as_bytes());
        let (there, user) = (file.as_file().metadata().unwrap(), rustix::process::geteuid());
        assert!(check_owner(&there, user.as_raw()).is_ok());
        let problem = check_owner(&there, user.as_raw() + 1).unwrap_err().to_string();
        assert_eq!(problem, format!("it belongs to another user (uid {})", user.as_raw()));
        // Only root can give a file away.
        if std::os::unix::fs::chown(file.path(), Some(user.as_raw() + 1), None).is_ok() {
            assert!(read(file.path()).unwrap_err().to_string().contains("another user"));
        }
    }

    #[test]
    fn what_others_may_read_or_is_no_key_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.key");
        assert!(problem(&path).contains("robot.key: it cannot be read"));
        assert!(problem(folder.path()).contains("it is not a file"));
        write(&path, text(&random().unwrap()).as_bytes());
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
