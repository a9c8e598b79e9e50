//! A NOR flash in memory, whose power can go at any operation.

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// As on the NUCLEO-F429ZI: four sectors of 16 KiB, programmed by words of four bytes.
pub const SECTOR_LEN: usize = 16 * 1024;
pub const SECTORS: usize = 4;
const WORD_LEN: usize = 4;

/// What the operation during which the power goes leaves behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Torn {
    /// Nothing: the power went just before it.
    Nothing,
    /// Some of the bits are over, some are not, drawn from this seed.
    Bits(u64),
    /// A sector is erased up to a word drawn from this seed and old beyond, or the other way round if
    /// the seed is odd; a word as [`Torn::Bits`].
    Part(u64),
    /// A sector has been programmed to zeros, which comes first in an erasure; a word as
    /// [`Torn::Bits`].
    Zeros(u64),
    /// A sector is full of noise drawn from this seed; a word as [`Torn::Bits`].
    Noise(u64),
}

/// The flash, and what is to happen to it.
#[derive(Clone, Debug)]
pub struct Nor {
    pub bytes: Vec<u8>,
    /// Words programmed and sectors erased so far.
    pub operations: u64,
    /// Sectors erased so far.
    pub erasures: u64,
    /// The power goes at the operation with this number, counted from 0.
    pub cut: Option<(u64, Torn)>,
}

/// The power has gone, or a word was programmed that was not erased.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    NoPower,
}

impl NorFlashError for Failure {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl Nor {
    pub fn blank() -> Self {
        Self::holding(vec![0xFF; SECTORS * SECTOR_LEN])
    }

    /// What another flash held, with the power on again.
    pub fn holding(bytes: Vec<u8>) -> Self {
        Self { bytes, operations: 0, erasures: 0, cut: None }
    }

    pub fn cut_at(self, operation: u64, torn: Torn) -> Self {
        Self { cut: Some((operation, torn)), ..self }
    }

    /// Counts an operation; says how it is torn if the power goes in it.
    fn begin(&mut self) -> Result<Option<Torn>, Failure> {
        let torn = match self.cut {
            Some((at, _)) if self.operations > at => return Err(Failure::NoPower),
            Some((at, torn)) if self.operations == at => Some(torn),
            _ => None,
        };
        self.operations += 1;
        Ok(torn)
    }

    fn program(&mut self, at: usize, word: &[u8]) -> Result<(), Failure> {
        let torn = self.begin()?;
        let cells = &mut self.bytes[at..at + WORD_LEN];
        let mut noise = match torn {
            None => None,
            Some(Torn::Nothing) => return Err(Failure::NoPower),
            Some(Torn::Bits(seed) | Torn::Part(seed) | Torn::Zeros(seed) | Torn::Noise(seed)) => {
                Some(ChaCha8Rng::seed_from_u64(seed))
            }
        };
        for (cell, &asked) in cells.iter_mut().zip(word) {
            // Programming only ever clears bits, and not all of them if there is no time.
            let not_yet = noise.as_mut().map_or(0, |noise| noise.random::<u8>());
            *cell &= asked | not_yet;
        }
        if torn.is_some() { Err(Failure::NoPower) } else { Ok(()) }
    }

    fn erase_sector(&mut self, at: usize) -> Result<(), Failure> {
        let torn = self.begin()?;
        self.erasures += 1;
        let cells = &mut self.bytes[at..at + SECTOR_LEN];
        match torn {
            None => {
                cells.fill(0xFF);
                return Ok(());
            }
            Some(Torn::Nothing) => {}
            Some(Torn::Bits(seed)) => {
                let mut noise = ChaCha8Rng::seed_from_u64(seed);
                cells.iter_mut().for_each(|cell| *cell |= noise.random::<u8>());
            }
            Some(Torn::Part(seed)) => {
                let words = ChaCha8Rng::seed_from_u64(seed).random_range(0..SECTOR_LEN / WORD_LEN);
                let (start, end) = cells.split_at_mut(words * WORD_LEN);
                if seed % 2 == 0 { start.fill(0xFF) } else { end.fill(0xFF) }
            }
            Some(Torn::Zeros(_)) => cells.fill(0),
            Some(Torn::Noise(seed)) => ChaCha8Rng::seed_from_u64(seed).fill_bytes(cells),
        }
        Err(Failure::NoPower)
    }
}

impl ErrorType for Nor {
    type Error = Failure;
}

impl ReadNorFlash for Nor {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failure> {
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Nor {
    const WRITE_SIZE: usize = WORD_LEN;
    const ERASE_SIZE: usize = SECTOR_LEN;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Failure> {
        (from as usize..to as usize).step_by(SECTOR_LEN).try_for_each(|at| self.erase_sector(at))
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failure> {
        let words = bytes.chunks_exact(WORD_LEN).enumerate();
        words
            .map(|(index, word)| (offset as usize + WORD_LEN * index, word))
            .try_for_each(|(at, word)| self.program(at, word))
    }
}
