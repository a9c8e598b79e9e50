//! One process at a time records into a campaign folder; readers are never kept out.
//!
//! The lock is the operating system's, on a file in the folder. It ends with its process, however that ends, so nobody has
//! to remove it. The file names the process, for the one that is refused.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use crate::disk::of_writing;
use crate::error::{CampaignError, Place};
use crate::file::remove_leftovers;

/// The file that is locked, in the campaign folder.
pub const NAME: &str = ".beeline-lock";

/// How much of the file is read: a command line and two names.
const OWNER_BYTES: u64 = 1000;

/// A folder that only this process writes, until the value is dropped.
#[derive(Debug)]
pub struct FolderLock {
    file: File,
    path: PathBuf,
}

impl FolderLock {
    /// Locks a folder that exists; refused, with the owner's name, while another process has it.
    pub fn take(folder: &Path) -> Result<Self, CampaignError> {
        let path = folder.join(NAME);
        let cannot = |error| CampaignError::io(&path, "lock this folder", error);
        loop {
            let file = open(&path).map_err(cannot)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(taken(folder, &path)),
                // A file system without locks.
                Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {}
                Err(TryLockError::Error(error)) => return Err(cannot(error)),
            }
            // Its last owner may have removed the file between our opening and our locking it.
            if !is_at(&file, &path) {
                continue;
            }
            let lock = Self { file, path: path.clone() };
            lock.sign().map_err(cannot)?;
            let runs = folder.join("runs");
            remove_leftovers(folder);
            if !runs.is_symlink() {
                remove_leftovers(&runs);
            }
            return Ok(lock);
        }
    }

    fn sign(&self) -> io::Result<()> {
        self.file.set_len(0)?;
        (&self.file).write_all(owner().as_bytes()).map_err(of_writing)
    }
}

impl Drop for FolderLock {
    /// Removes the file, so that a folder that nobody writes holds only the campaign. Left behind, it would lock nobody out.
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

fn open(path: &Path) -> io::Result<File> {
    // Who made the folder may have linked to a file that is no part of it.
    if fs::symlink_metadata(path).is_ok_and(|there| !there.is_file()) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a file"));
    }
    OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)
}

/// Whether this open file is still the one with this name.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let id = |metadata: &fs::Metadata| (metadata.dev(), metadata.ino());
    matches!((file.metadata(), fs::symlink_metadata(path)), (Ok(a), Ok(b)) if id(&a) == id(&b))
}

/// Elsewhere an open file cannot be removed.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

/// `beeline record, process 4711 on bench`.
fn owner() -> String {
    let words = std::env::args_os().take(3).enumerate().map(|(index, word)| {
        let word =
            if index == 0 { Path::new(&word).file_name().unwrap_or(&word).into() } else { word };
        word.to_string_lossy().into_owned()
    });
    let command: Vec<String> = words.collect();
    let host = fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let host = host.or_else(|| std::env::var("COMPUTERNAME").ok());
    let on = host.map_or_else(String::new, |host| format!(" on {}", host.trim()));
    format!("`{}`, process {}{on}", command.join(" "), std::process::id())
}

fn taken(folder: &Path, path: &Path) -> CampaignError {
    let mut owner = String::new();
    // Without a name the lock is as good.
    let read = File::open(path).and_then(|file| file.take(OWNER_BYTES).read_to_string(&mut owner));
    let owner = match read {
        Ok(length) if length > 0 => owner.as_str(),
        _ => "another process",
    };
    let problem = format!("{owner} is writing into this folder");
    let hint = "wait until it ends, or end it; reading commands work meanwhile";
    CampaignError::new(Place::whole(folder), problem, hint)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_writer_whose_name_the_second_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let lock = FolderLock::take(folder.path()).unwrap();
        let error = FolderLock::take(folder.path()).unwrap_err().to_string();
        let process = format!("process {}", std::process::id());
        assert!(error.contains(&process) && error.contains("is writing into"), "{error}");
        drop(lock);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left");
        assert!(FolderLock::take(folder.path()).is_ok());
    }

    #[test]
    fn a_lock_file_without_its_process_locks_nobody_out() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(NAME), "`beeline`, process 1").unwrap();
        assert!(FolderLock::take(folder.path()).is_ok());
    }
}
