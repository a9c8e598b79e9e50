//! A disk that is full after so many bytes.

use std::fs::File;
use std::io::{self, ErrorKind, Write};
use std::sync::Mutex;

use campaign::disk::{Disk, SystemDisk};

/// So many bytes find room on it \[bytes\].
#[derive(Debug)]
pub struct SmallDisk(pub Mutex<usize>);

impl Disk for SmallDisk {
    fn keep(&self, file: &mut File, bytes: &[u8]) -> io::Result<()> {
        let mut room = self.0.lock().expect("nobody panics with it");
        if bytes.len() > *room {
            // As a real one does: what finds room is there.
            file.write_all(&bytes[..*room])?;
            return Err(ErrorKind::StorageFull.into());
        }
        *room -= bytes.len();
        SystemDisk.keep(file, bytes)
    }
}
