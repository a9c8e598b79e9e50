//! The key of something found: a hash of all that it came from.

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::sync::OnceLock;

use robot_model::effect::Effect;
use robot_model::recording::Campaign;
use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::hex::hex;

/// A SHA-256.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Key(pub [u8; 32]);

impl Key {
    /// Of the program, the campaign as it was read, and all candidate effects: of the noise that these give. None if this program
    /// cannot be read.
    ///
    /// What was read is hashed, not the files: they may have changed since. An effect of the user's own is what its fields are:
    /// `Debug` shows them all.
    pub fn of_noise(campaign: &Campaign, catalogue: &[&dyn Effect]) -> Option<Self> {
        Self::of(&(program()?, campaign, format!("{catalogue:?}")))
    }

    /// Of an answer that needs this noise, if the model has these effects already.
    pub fn of_answer(noise: &Self, in_model: &[&str]) -> Option<Self> {
        Self::of(&(noise.0, in_model))
    }

    fn of(all: &impl Serialize) -> Option<Self> {
        let mut hash = Hashing(Sha256::new());
        postcard::to_io(all, &mut hash).ok()?;
        Some(Self(hash.0.finalize().into()))
    }

    /// The name of its file.
    pub fn file_name(&self) -> String {
        hex(&self.0)
    }
}

/// The hash of this executable: any other build may find other digits. None if it cannot be read.
fn program() -> Option<[u8; 32]> {
    static PROGRAM: OnceLock<Option<[u8; 32]>> = OnceLock::new();
    *PROGRAM.get_or_init(|| {
        // The file that runs, even if another one has taken its place.
        let file = match File::open("/proc/self/exe") {
            Ok(file) => file,
            Err(_) => File::open(std::env::current_exe().ok()?).ok()?,
        };
        hash_of(file).ok()
    })
}

fn hash_of(file: impl Read) -> io::Result<[u8; 32]> {
    let mut hash = Hashing(Sha256::new());
    io::copy(&mut BufReader::with_capacity(1 << 16, file), &mut hash)?;
    Ok(hash.0.finalize().into())
}

struct Hashing(Sha256);

impl Write for Hashing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
