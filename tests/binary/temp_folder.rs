//! A folder of its own in which the program runs.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use tempfile::TempDir;

use crate::outcome::{Outcome, collect};

/// A folder of its own in which the program runs; gone with the test.
pub struct TempFolder {
    folder: TempDir,
    /// What fits found: not in the folder, whose listing tests look at.
    cache: TempDir,
}

impl TempFolder {
    /// An empty one.
    pub fn new() -> Self {
        let folder = || tempfile::tempdir().expect("a folder for the test");
        Self { folder: folder(), cache: folder() }
    }

    /// A place in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A place in the folder of what is kept to save time.
    pub fn cache(&self, name: &str) -> PathBuf {
        self.cache.path().join(name)
    }

    /// Puts a file there.
    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// A file's bytes; the file must be there.
    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The names of all files and folders directly in the folder, sorted.
    pub fn listing(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// `beeline` with these arguments, separated by spaces.
    pub fn run(&self, arguments: &str) -> Outcome {
        self.run_with(&words(arguments), "")
    }

    /// `beeline` with these arguments and this on its standard input.
    pub fn run_with(&self, arguments: &[&str], input: &str) -> Outcome {
        let mut child = self.spawn(arguments);
        let mut stdin = child.stdin.take().expect("standard input is a pipe");
        // A program that does not read its input may have ended by now.
        let _ = stdin.write_all(input.as_bytes());
        drop(stdin);
        collect(child)
    }

    /// Starts `beeline` with all of its streams piped.
    pub fn spawn(&self, arguments: &[&str]) -> Child {
        self.command(arguments).spawn().expect("the executable starts")
    }

    /// `beeline` with all of its streams piped, to be started.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_beeline"));
        command
            .args(arguments)
            .current_dir(self.folder.path())
            .env("XDG_STATE_HOME", self.path("state"))
            .env("XDG_CACHE_HOME", self.cache.path())
            .env_remove("BEELINE_PORT")
            .env_remove("BEELINE_KEY_FILE")
            .env_remove("CLICOLOR_FORCE")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }
}

/// Copies a folder with all that is in it.
pub fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// The words of a command line; what stands between double quotes is one.
pub fn words(line: &str) -> Vec<&str> {
    let quoted = |(index, part): (usize, &'_ str)| index % 2 == 1 && !part.is_empty();
    let parts = line.split('"').enumerate();
    parts
        .flat_map(
            |part| if quoted(part) { vec![part.1] } else { part.1.split_whitespace().collect() },
        )
        .collect()
}
