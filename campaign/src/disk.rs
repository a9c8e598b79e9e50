//! The disk below the files of a campaign: the system's, or a small one that a simulation fills.

use std::fmt;
use std::fs::File;
use std::io::{self, ErrorKind, Write};

/// What keeps the bytes of files.
pub trait Disk: fmt::Debug + Send + Sync {
    /// Writes all of these bytes into a file, and syncs them; an error if they do not find room.
    fn keep(&self, file: &mut File, bytes: &[u8]) -> io::Result<()>;
}

/// The system's.
#[derive(Clone, Copy, Debug)]
pub struct SystemDisk;

impl Disk for SystemDisk {
    fn keep(&self, file: &mut File, bytes: &[u8]) -> io::Result<()> {
        file.write_all(bytes).map_err(of_writing)?;
        file.sync_all()
    }
}

/// An error of writing. That a file is too large means something else where one is read.
pub(crate) fn of_writing(error: io::Error) -> io::Error {
    match error.kind() {
        ErrorKind::FileTooLarge => {
            io::Error::new(ErrorKind::QuotaExceeded, "no file may be that large here")
        }
        _ => error,
    }
}
