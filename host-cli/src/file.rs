//! Files that appear whole or not at all.

use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// Makes sure that a file can be written, and leaves nothing behind.
pub fn check_writable(file: &Path) -> Result<(), WriteError> {
    beside(&target(file)).map(drop).map_err(WriteError)
}

/// Writes a file whole or not at all, over the one that is there.
pub fn write_whole(file: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let file = target(file);
    let write = || Ok(with_bytes(&file, bytes)?.persist(&file)?);
    write().map(drop).map_err(WriteError)
}

/// Writes a file that must not be there yet, whole or not at all; false if it is there.
pub fn write_new(file: &Path, bytes: &[u8]) -> Result<bool, WriteError> {
    let written = with_bytes(file, bytes).map_err(WriteError)?;
    match written.persist_noclobber(file) {
        Ok(_) => Ok(true),
        Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => Ok(false),
        Err(error) => Err(WriteError(error.error)),
    }
}

/// Where a link leads to: it stays a link, and what it names is replaced.
fn target(file: &Path) -> PathBuf {
    file.canonicalize().unwrap_or_else(|_| file.into())
}

/// A temporary file beside it with these bytes, on the disk before its name is.
fn with_bytes(file: &Path, bytes: &[u8]) -> io::Result<NamedTempFile> {
    let mut beside = beside(file)?;
    beside.write_all(bytes)?;
    beside.as_file().sync_all()?;
    Ok(beside)
}

/// A temporary file in the same folder, so that renaming it is one step; readable like any other.
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
    /// The system's error without the name of the temporary file, which nobody has asked for.
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
    fn a_new_file_overwrites_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        assert!(write_new(&file, b"first").unwrap());
        assert!(!write_new(&file, b"second").unwrap());
        assert_eq!(std::fs::read(&file).unwrap(), b"first");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing beside it");
    }
}
