//! Files that appear whole or not at all.
//!
//! A device or a pipe is written in place: it stays a device or a pipe.

use std::fmt;
use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// How many links are followed one after the other; operating systems follow 40.
const LINKS_MAX: usize = 40;

/// Checks that a file can be written, and leaves nothing behind.
pub fn check_writable(file: &Path) -> Result<(), WriteError> {
    // Opening a pipe would wait for its reader.
    if is_special(file) {
        return Ok(());
    }
    beside(&target(file)).map(drop).map_err(WriteError)
}

/// Writes a file whole or not at all, and replaces the one that exists. A device or a pipe is
/// written in place.
pub fn write_whole(file: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let write = || -> io::Result<()> {
        if is_special(file) {
            return write_in_place(file, bytes);
        }
        let file = target(file);
        with_bytes(&file, bytes)?.persist(&file)?;
        Ok(())
    };
    write().map_err(WriteError)
}

/// Whether this is, or links to, something that exists and is neither a file nor a folder.
pub fn is_special(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

fn write_in_place(file: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut there = OpenOptions::new().write(true).open(file)?;
    there.write_all(bytes)?;
    match there.sync_all() {
        // A pipe or a device without storage has nothing to sync.
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => {
            Ok(())
        }
        synced => synced,
    }
}

/// Writes a file that must not exist yet, whole or not at all; false if it exists.
pub fn write_new(file: &Path, bytes: &[u8]) -> Result<bool, WriteError> {
    let written = with_bytes(file, bytes).map_err(WriteError)?;
    match written.persist_noclobber(file) {
        Ok(_) => Ok(true),
        Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => Ok(false),
        Err(error) => Err(WriteError(error.error)),
    }
}

/// The file that a link leads to, whether it exists or not: the link stays, and that file is
/// replaced.
pub fn target(file: &Path) -> PathBuf {
    if let Ok(there) = file.canonicalize() {
        return there;
    }
    let mut file = file.to_owned();
    for _ in 0..LINKS_MAX {
        let Ok(next) = fs::read_link(&file) else { break };
        // A relative link starts from its own folder.
        file = file.parent().unwrap_or(Path::new("")).join(next);
    }
    file
}

/// A temporary file beside `file` with these bytes, synced to the disk before it is renamed.
fn with_bytes(file: &Path, bytes: &[u8]) -> io::Result<NamedTempFile> {
    let mut beside = beside(file)?;
    beside.write_all(bytes)?;
    beside.as_file().sync_all()?;
    Ok(beside)
}

/// A temporary file in the same folder, so that it can be renamed in one step; readable like any
/// other.
fn beside(file: &Path) -> io::Result<NamedTempFile> {
    if file.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    let folder = match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".beeline-").suffix(".part");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    builder.tempfile_in(folder)
}

/// Why a file could not be written.
#[derive(Debug)]
pub struct WriteError(io::Error);

impl From<WriteError> for io::Error {
    fn from(error: WriteError) -> Self {
        Self::new(error.0.kind(), error.to_string())
    }
}

impl std::error::Error for WriteError {}

impl fmt::Display for WriteError {
    /// The system's error without the name of the temporary file, which means nothing to a user.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.0.to_string();
        f.write_str(text.split(" at path ").next().unwrap_or(&text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn a_link_stays_a_link_and_what_it_names_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        std::fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_whole(&link, b"new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(std::fs::read(&file).unwrap(), b"new");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing beside them");
    }

    #[test]
    #[cfg(unix)]
    fn a_link_to_a_file_that_is_not_there_makes_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("file", &link).unwrap();
        write_whole(&link, b"new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(std::fs::read(folder.path().join("file")).unwrap(), b"new");
    }

    #[test]
    #[cfg(unix)]
    fn a_pipe_stays_a_pipe_and_what_is_written_comes_out_of_it() {
        let folder = tempfile::tempdir().unwrap();
        let (pipe, link) = (folder.path().join("pipe"), folder.path().join("link"));
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        std::os::unix::fs::symlink(&pipe, &link).unwrap();
        check_writable(&link).unwrap();
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read(pipe).unwrap()
        });
        write_whole(&link, b"new").unwrap();
        assert_eq!(reader.join().unwrap(), b"new");
        assert!(is_special(&pipe) && link.is_symlink());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing beside them");
    }

    #[test]
    fn a_new_file_overwrites_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        assert!(write_new(&file, b"first").unwrap());
        assert!(!write_new(&file, b"second").unwrap());
        assert_eq!(std::fs::read(&file).unwrap(), b"first");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing beside it");
    }
}
