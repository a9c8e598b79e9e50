//! Folders made for files to come: what stays empty, as the file did not come, is removed again.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::file::sync_folder;

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
}
