//! Folders made for files to come: what stays empty, as the file did not come, is removed again. And folders that appear whole,
//! with all that is in them.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use crate::file::{PREFIX, SUFFIX, folder_of, remove_leftovers, sync_folder, without_place};

/// Folders that were made, removed with this value where they are still empty.
#[derive(Debug, Default)]
pub struct NewFolders {
    /// The innermost first.
    made: Vec<PathBuf>,
}

impl NewFolders {
    /// Makes a folder and those around it, as far as they do not exist.
    pub fn make(folder: &Path) -> io::Result<Self> {
        let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
        let made = folder.ancestors().take_while(is_missing).map(Path::to_owned).collect();
        // Before anything is made: what an error leaves is removed as well.
        let made = Self { made };
        fs::create_dir_all(folder)?;
        // A new folder survives a power failure if the one around it has been synced.
        made.made.iter().try_for_each(|folder| sync_folder(folder))?;
        Ok(made)
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        // The system removes no folder that has something in it.
        self.made.iter().all(|folder| fs::remove_dir(folder).is_ok());
    }
}

/// A folder that appears whole, with all that is in it, or not at all.
///
/// Until it is renamed it stands beside its place under a passing name, and is removed with this value.
#[derive(Debug)]
pub struct NewFolder {
    folder: PathBuf,
    beside: tempfile::TempDir,
    /// Tells others that its process lives.
    _lock: Option<File>,
    _around: NewFolders,
}

impl NewFolder {
    /// A folder that is to be at this place, where nothing is yet.
    pub fn make(folder: &Path) -> io::Result<Self> {
        let around = folder_of(folder);
        let made = NewFolders::make(around)?;
        remove_leftovers(around);
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o755));
        let beside = builder.tempdir_in(around).map_err(without_place)?;
        // Elsewhere a folder cannot be opened, and a file system may have no locks.
        let lock = File::open(beside.path()).ok().filter(|folder| folder.try_lock().is_ok());
        Ok(Self { folder: folder.into(), beside, _lock: lock, _around: made })
    }

    /// Where its files are written until it is renamed.
    pub fn path(&self) -> &Path {
        self.beside.path()
    }

    /// Renames it to its place; false if something has come there meanwhile.
    pub fn persist(self) -> io::Result<bool> {
        match fs::rename(self.beside.path(), &self.folder) {
            // Else its passing name would be removed, which somebody else may have by now.
            Ok(()) => self.beside.keep(),
            Err(_) if self.folder.exists() => return Ok(false),
            Err(error) => return Err(error),
        };
        sync_folder(&self.folder).map(|()| true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_that_stay_empty_are_removed_and_no_others() {
        let temp = tempfile::tempdir().unwrap();
        let (outer, inner) = (temp.path().join("a"), temp.path().join("a/b/c"));
        drop(NewFolders::make(&inner).unwrap());
        assert!(!outer.exists());
        let made = NewFolders::make(&inner).unwrap();
        fs::write(outer.join("b/file"), "").unwrap();
        drop(made);
        assert!(outer.join("b/file").exists() && !inner.exists());
        fs::create_dir(&inner).unwrap();
        drop(NewFolders::make(&inner).unwrap());
        assert!(inner.exists(), "it was there before");
        assert!(NewFolders::make(&outer.join("b/file/d")).is_err());
        assert!(outer.join("b/file").exists());
    }

    #[test]
    fn a_folder_appears_with_its_files_or_not_at_all_and_one_that_came_meanwhile_stays() {
        let temp = tempfile::tempdir().unwrap();
        let place = temp.path().join("a/b");
        let new = NewFolder::make(&place).unwrap();
        fs::write(new.path().join("file"), "").unwrap();
        assert!(!place.exists());
        drop(new);
        assert!(!temp.path().join("a").exists());
        let new = NewFolder::make(&place).unwrap();
        let late = NewFolder::make(&place).unwrap();
        fs::write(new.path().join("file"), "first").unwrap();
        fs::write(late.path().join("file"), "second").unwrap();
        assert!(new.persist().unwrap());
        assert!(!late.persist().unwrap());
        assert_eq!(fs::read_to_string(place.join("file")).unwrap(), "first");
        assert_eq!(fs::read_dir(temp.path().join("a")).unwrap().count(), 1, "nothing beside it");
    }

    #[test]
    fn a_folder_that_a_killed_process_left_is_removed_and_that_of_a_live_one_stays() {
        let temp = tempfile::tempdir().unwrap();
        let old = std::time::SystemTime::now() - std::time::Duration::from_secs(3600);
        let [dead, live] = ["dead", "live"].map(|name| {
            let path = temp.path().join(format!("{PREFIX}{name}{SUFFIX}"));
            fs::create_dir(&path).unwrap();
            fs::write(path.join("file"), "").unwrap();
            let folder = File::open(&path).unwrap();
            folder.set_modified(old).unwrap();
            (path, folder)
        });
        live.1.try_lock().unwrap();
        drop(NewFolder::make(&temp.path().join("new")).unwrap());
        assert!(!dead.0.exists() && live.0.join("file").exists());
    }
}
