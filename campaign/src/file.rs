//! Files that appear whole or not at all.
//!
//! A device or a pipe is written in place: it stays a device or a pipe.

use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::NamedTempFile;

use crate::disk::{Disk, SystemDisk, of_writing};
use crate::os_error::without_os_numbers;

/// How many links are followed one after the other; operating systems follow 40.
const LINKS_MAX: usize = 40;

/// Checks that a file can be written, and leaves nothing behind.
pub fn check_writable(file: &Path) -> Result<(), WriteError> {
    // Opening a pipe would wait for its reader.
    if is_special(file) {
        return Ok(());
    }
    beside(&target(file), READABLE).map(drop).map_err(WriteError)
}

/// Writes a file whole or not at all, and replaces the one that exists. A device or a pipe is
/// written in place.
pub fn write_whole(file: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let write = || -> io::Result<()> {
        if is_special(file) {
            return write_in_place(file, bytes);
        }
        replace(&SystemDisk, &target(file), bytes)
    };
    write().map_err(WriteError)
}

/// Writes a file of a campaign folder, whole or not at all. A link is refused: who made the folder
/// may have linked to a file that is no part of it.
pub fn write_own(file: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_own_on(&SystemDisk, file, bytes)
}

/// The same, on this disk.
pub(crate) fn write_own_on(disk: &dyn Disk, file: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    match fs::symlink_metadata(file) {
        Ok(there) if !there.is_file() => Err(WriteError(not_own(&there))),
        _ => replace(disk, file, bytes).map_err(WriteError),
    }
}

/// Checks that [`write_own`] can write a file, and leaves nothing behind.
pub(crate) fn check_own(file: &Path) -> Result<(), WriteError> {
    match fs::symlink_metadata(file) {
        Ok(there) if !there.is_file() => Err(WriteError(not_own(&there))),
        _ => beside(file, READABLE).map(drop).map_err(WriteError),
    }
}

fn not_own(there: &fs::Metadata) -> io::Error {
    let what = if there.is_symlink() { "a link" } else { "no file" };
    io::Error::new(ErrorKind::InvalidInput, format!("it is {what}"))
}

fn replace(disk: &dyn Disk, file: &Path, bytes: &[u8]) -> io::Result<()> {
    with_bytes(disk, file, bytes, READABLE)?.persist(file)?;
    sync_folder(file)
}

/// Makes a new name survive a power failure: the list of names of its folder is synced as well.
pub(crate) fn sync_folder(file: &Path) -> io::Result<()> {
    // Elsewhere a folder cannot be opened.
    if cfg!(unix) {
        match File::open(folder_of(file)).and_then(|folder| folder.sync_all()) {
            // A file system without it.
            Err(error)
                if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => {}
            // The file can be written, its folder not be listed: it was renamed all the same.
            Err(error) if error.kind() == ErrorKind::PermissionDenied => {}
            synced => return synced,
        }
    }
    Ok(())
}

/// Whether this is, or links to, something that exists and is neither a file nor a folder.
pub fn is_special(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

fn write_in_place(file: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut there = OpenOptions::new().write(true).open(file)?;
    there.write_all(bytes).map_err(of_writing)?;
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
    write_new_on(&SystemDisk, file, bytes)
}

/// The same, on this disk.
pub(crate) fn write_new_on(disk: &dyn Disk, file: &Path, bytes: &[u8]) -> Result<bool, WriteError> {
    write_new_as(disk, file, bytes, READABLE)
}

/// The same, of one of many files in a folder: what killed processes left there was removed before the first.
pub(crate) fn write_next_on(
    disk: &dyn Disk,
    file: &Path,
    bytes: &[u8],
) -> Result<bool, WriteError> {
    let written = temporary(file, READABLE).and_then(|beside| kept(disk, beside, bytes));
    persist_new(written.map_err(WriteError)?, file)
}

/// The same, of a file that only its owner may read.
pub fn write_new_private(file: &Path, bytes: &[u8]) -> Result<bool, WriteError> {
    write_new_as(&SystemDisk, file, bytes, PRIVATE)
}

fn write_new_as(disk: &dyn Disk, file: &Path, bytes: &[u8], mode: u32) -> Result<bool, WriteError> {
    persist_new(with_bytes(disk, file, bytes, mode).map_err(WriteError)?, file)
}

fn persist_new(written: NamedTempFile, file: &Path) -> Result<bool, WriteError> {
    match written.persist_noclobber(file) {
        Ok(_) => sync_folder(file).map(|()| true).map_err(WriteError),
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
fn with_bytes(disk: &dyn Disk, file: &Path, bytes: &[u8], mode: u32) -> io::Result<NamedTempFile> {
    kept(disk, beside(file, mode)?, bytes)
}

fn kept(disk: &dyn Disk, mut beside: NamedTempFile, bytes: &[u8]) -> io::Result<NamedTempFile> {
    disk.keep(beside.as_file_mut(), bytes)?;
    Ok(beside)
}

/// Permissions of a file: as any other, and for its owner alone.
const READABLE: u32 = 0o644;
const PRIVATE: u32 = 0o600;

/// A temporary file in the same folder, so that it can be renamed in one step, with these permissions.
fn beside(file: &Path, mode: u32) -> io::Result<NamedTempFile> {
    if file.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    remove_leftovers(folder_of(file));
    temporary(file, mode)
}

fn temporary(file: &Path, mode: u32) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(mode));
    #[cfg(not(unix))]
    let _ = mode;
    let beside = builder.tempfile_in(folder_of(file))?;
    // The lock tells others that its process lives. A file system may have none.
    let _ = beside.as_file().try_lock();
    Ok(beside)
}

pub(crate) fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// How the names of files and folders that are not whole yet begin and end.
pub(crate) const PREFIX: &str = ".beeline-";
pub(crate) const SUFFIX: &str = ".part";

/// A temporary file is locked within this time after it is made.
const LEFT_AFTER: Duration = Duration::from_secs(60);

/// Removes the temporary files and folders of processes that were killed while they wrote. What cannot be
/// removed harms nobody.
pub(crate) fn remove_leftovers(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_part =
            name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX));
        if is_part && is_left(&entry) {
            let path = entry.path();
            let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        }
    }
}

/// Whether a temporary file or folder is that of no process any more.
fn is_left(entry: &fs::DirEntry) -> bool {
    let Ok(metadata) = entry.metadata() else { return false };
    let age = metadata.modified().ok().and_then(|made| made.elapsed().ok());
    (metadata.is_file() || metadata.is_dir())
        && age.is_some_and(|age| age > LEFT_AFTER)
        && File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok())
}

/// Why a file could not be written.
#[derive(Debug)]
pub struct WriteError(io::Error);

impl WriteError {
    /// What to try, where the system's error says so much; otherwise `else_`.
    pub fn hint<'a>(&self, else_: &'a str) -> &'a str {
        hint(self.0.kind()).unwrap_or(else_)
    }
}

/// What to try about an error of the system, if that is clear.
pub(crate) fn hint(kind: ErrorKind) -> Option<&'static str> {
    Some(match kind {
        ErrorKind::StorageFull => "make room on the disk; this file is as it was before",
        ErrorKind::QuotaExceeded => {
            "raise the limit (a quota of the disk, `ulimit -f`), or choose another disk; this file is as it was before"
        }
        ErrorKind::ReadOnlyFilesystem => "the disk is read-only: choose a folder on another",
        ErrorKind::PermissionDenied => "check who may read and write there",
        ErrorKind::InvalidInput => "replace it by a file",
        ErrorKind::FileTooLarge => "check that it is the right file",
        _ => return None,
    })
}

/// An error of the system without the name of a temporary file or folder.
pub(crate) fn without_place(error: io::Error) -> io::Error {
    WriteError(error).into()
}

impl From<WriteError> for io::Error {
    fn from(error: WriteError) -> Self {
        Self::new(error.0.kind(), error.to_string())
    }
}

impl std::error::Error for WriteError {}

impl fmt::Display for WriteError {
    /// The system's error without its number and the name of the temporary file, which mean nothing to a user.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = without_os_numbers(&self.0.to_string());
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
    #[cfg(unix)]
    fn a_link_in_a_campaign_folder_is_not_written_through() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("plan.toml"));
        std::fs::write(&file, "precious").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        let error = write_own(&link, b"new").unwrap_err();
        assert_eq!(error.to_string(), "it is a link");
        assert_eq!(check_own(&link).unwrap_err().to_string(), "it is a link");
        assert!(check_own(&file).is_ok());
        assert_eq!(std::fs::read(&file).unwrap(), b"precious");
        std::os::unix::fs::symlink("not-there", folder.path().join("dangling")).unwrap();
        assert!(write_own(&folder.path().join("dangling"), b"new").is_err());
        assert!(!folder.path().join("not-there").exists());
    }

    #[test]
    fn what_a_killed_process_left_is_removed_by_the_next_write_and_what_a_live_one_writes_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let old = std::time::SystemTime::now() - Duration::from_secs(3600);
        let part = |name: &str| {
            let file = File::create(folder.path().join(name)).unwrap();
            file.set_modified(old).unwrap();
            file
        };
        drop(part(".beeline-dead.part"));
        let live = part(".beeline-live.part");
        live.try_lock().unwrap();
        drop(part("beeline.part"));
        // Made just now: its process may not have locked it yet.
        std::fs::write(folder.path().join(".beeline-new.part"), "").unwrap();
        write_whole(&folder.path().join("file"), b"bytes").unwrap();
        let mut names: Vec<_> = std::fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        assert_eq!(names, [".beeline-live.part", ".beeline-new.part", "beeline.part", "file"]);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_said_to_be_full() {
        let error = write_whole(Path::new("/dev/full"), b"bytes").unwrap_err();
        assert_eq!(error.hint("else"), "make room on the disk; this file is as it was before");
        let told = crate::CampaignError::io(Path::new("robot.toml"), "write it", error.into());
        assert!(told.hint.contains("make room on the disk"), "{told}");
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
