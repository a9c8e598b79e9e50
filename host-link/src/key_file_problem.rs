//! What can be wrong with the file of a key.

use std::fmt;
use std::io;

/// What is wrong with the file of a key.
#[derive(Debug)]
pub enum KeyFileProblem {
    /// It cannot be read.
    Unreadable(io::Error),
    /// It is a pipe, a device or a folder.
    NotAFile,
    /// It does not hold 32 hexadecimal digits.
    NotAKey,
    /// Others than its owner may read or write it: these are its permissions.
    Shared(u32),
    /// It is another user's, with this uid.
    OfAnother(u32),
}

impl fmt::Display for KeyFileProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(cause) => write!(f, "it cannot be read ({cause})"),
            Self::NotAFile => f.write_str("it is not a file"),
            Self::NotAKey => f.write_str("it is not one line of 32 hexadecimal digits"),
            Self::OfAnother(uid) => write!(f, "it belongs to another user (uid {uid})"),
            Self::Shared(mode) => {
                write!(f, "others than its owner may read or change it (mode {mode:03o})")
            }
        }
    }
}
