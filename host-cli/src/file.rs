//! Files that appear whole or not at all.

use std::fmt;
use std::io::{self, Write};
use std::path::Path;

use tempfile::NamedTempFile;

/// Makes sure that a file can be written, and leaves nothing behind.
pub fn check_writable(file: &Path) -> Result<(), impl fmt::Display> {
    beside(file).map(drop).map_err(Cause)
}

/// Writes a file whole or not at all.
pub fn write_whole(file: &Path, bytes: &[u8]) -> Result<(), impl fmt::Display> {
    let write = || {
        let mut beside = beside(file)?;
        beside.write_all(bytes)?;
        beside.persist(file)?;
        Ok(())
    };
    write().map_err(Cause)
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
    builder.prefix(".beeline-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    builder.tempfile_in(folder)
}

/// The system's error without the name of the temporary file, which nobody has asked for.
struct Cause(io::Error);

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.0.to_string();
        f.write_str(text.split(" at path ").next().unwrap_or(&text))
    }
}
