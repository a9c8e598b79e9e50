//! Reads the files of a campaign: files only, and of a size in proportion.
//!
//! A folder may come from somebody else. A pipe would be waited for without end, and a device may never end.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// The largest file of keys: some hundred thousand runs \[bytes\].
pub const KEYS_BYTES_MAX: u64 = 16 << 20;

/// The largest table: an hour at a thousand rows per second \[bytes\].
pub const TABLE_BYTES_MAX: u64 = 512 << 20;

/// Opens a file of at most this size; more is not read even if it grows.
pub fn open(file: &Path, bytes_max: u64) -> io::Result<impl Read> {
    // Opening a pipe would wait for its writer.
    let there = fs::metadata(file)?;
    if !there.is_file() {
        let what = if there.is_dir() { "a folder" } else { "a pipe or a device" };
        return Err(io::Error::new(ErrorKind::InvalidInput, format!("it is {what}, not a file")));
    }
    if there.len() > bytes_max {
        let problem = format!("it has {} bytes; at most {bytes_max} are read", there.len());
        return Err(io::Error::new(ErrorKind::FileTooLarge, problem));
    }
    Ok(File::open(file)?.take(bytes_max))
}

/// Reads a file of keys as text.
pub fn read_keys(file: &Path) -> io::Result<String> {
    read_text(file, KEYS_BYTES_MAX)
}

/// Reads a file of at most this size as text.
pub fn read_text(file: &Path, bytes_max: u64) -> io::Result<String> {
    let mut text = String::new();
    open(file, bytes_max)?.read_to_string(&mut text)?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn pipes_devices_and_folders_are_refused_and_nothing_waits() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let zero = folder.path().join("zero");
        std::os::unix::fs::symlink("/dev/zero", &zero).unwrap();
        for file in [pipe.as_path(), zero.as_path(), folder.path()] {
            let error = read_keys(file).unwrap_err();
            assert!(error.to_string().ends_with("not a file"), "{error}");
        }
    }

    #[test]
    fn a_file_beyond_its_limit_is_refused_before_it_is_read() {
        let file = tempfile::NamedTempFile::new().unwrap();
        // A hole: it takes no room.
        file.as_file().set_len(KEYS_BYTES_MAX + 1).unwrap();
        let error = read_keys(file.path()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
        assert!(error.to_string().contains("16777217 bytes; at most 16777216"), "{error}");
    }
}
