//! Small made-up repositories, for the tests of the checks.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// A folder with files in it; gone with the test.
pub struct Example {
    folder: TempDir,
    files: Vec<PathBuf>,
}

impl Example {
    /// Files by their paths, and what is in them.
    pub fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a folder for the test");
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a file is in a folder")).unwrap();
            std::fs::write(path, text).unwrap();
        }
        Self { folder, files: files.iter().map(|(name, _)| name.into()).collect() }
    }

    pub fn base(&self) -> &Path {
        self.folder.path()
    }

    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }
}
