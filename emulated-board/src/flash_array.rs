//! The flash array that the firmware stores in.
//!
//! The emulator models the flash interface (keys, busy times, interrupts) but not the array behind that
//! interface. Here it is, as NOR flash: an erased word is all ones, and programming only clears bits. A
//! write that would have to set bits is counted: the chip would keep the old bits.

use rigless::emulator::{Access, AccessKind, Host, Watch};
use rigless::soc::Width;

/// Where the second bank begins.
pub(crate) const BASE: u64 = 0x0810_0000;

/// Its first four sectors.
pub(crate) const LEN: u64 = 4 * SECTOR_LEN;

const SECTOR_LEN: u64 = 16 * 1024;

/// The flash interface's control register, and its bits to start the erasure of a sector.
const FLASH_CR: u64 = 0x4002_3C10;
const SER: u64 = 1 << 1;
const STRT: u64 = 1 << 16;

/// Number of the second bank's first sector in the control register.
const FIRST_SECTOR: u64 = 0x10;

/// The content of the firmware's part of the flash.
pub type Flash = Vec<u8>;

/// The content of a blank flash.
pub fn blank() -> Flash {
    vec![0xFF; LEN as usize]
}

/// An operation on the flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// A word was programmed.
    Program {
        /// Index of the word in the array.
        index: usize,
        /// The programmed value.
        word: u32,
    },
    /// A sector was erased.
    Erase {
        /// Index of the sector.
        sector: usize,
    },
}

impl Operation {
    /// Applies the operation to a flash's content.
    pub fn apply(self, flash: &mut Flash) {
        match self {
            Operation::Program { index, word } => {
                let cells = &mut flash[4 * index..4 * index + 4];
                cells.iter_mut().zip(word.to_le_bytes()).for_each(|(cell, byte)| *cell &= byte);
            }
            Operation::Erase { sector } => {
                let len = SECTOR_LEN as usize;
                flash[sector * len..(sector + 1) * len].fill(0xFF);
            }
        }
    }
}

/// The array's words.
#[derive(Debug)]
pub(crate) struct FlashArray {
    words: Vec<u32>,
    /// All operations, in order.
    pub journal: Vec<Operation>,
    /// Erasures and programmed words so far.
    pub operations: u64,
    /// The power fails before the operation with this number, counted from 0.
    pub cut_before: Option<u64>,
    /// Words that were programmed without the necessary erasure.
    pub overwritten: u64,
}

impl FlashArray {
    /// An array with this content, or a blank one.
    pub fn new(content: Option<&[u8]>) -> Self {
        let blank = blank();
        let words = content.unwrap_or(&blank).chunks_exact(4);
        let word = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().expect("four bytes"));
        Self {
            words: words.map(word).collect(),
            journal: Vec::new(),
            operations: 0,
            cut_before: None,
            overwritten: 0,
        }
    }

    /// Replaces the content.
    pub fn put(&mut self, content: &[u8], host: &mut dyn Host) {
        let words = Self::new(Some(content)).words;
        for (index, (old, new)) in self.words.iter_mut().zip(words).enumerate() {
            if *old != new {
                *old = new;
                write(host, index, new);
            }
        }
    }

    /// The watch that triggers [`Self::on_store`].
    pub fn watch() -> Watch {
        Watch::Writes { address: BASE, length: LEN }
    }

    /// Shows the array to the core, from power-on.
    pub fn show(&self, host: &mut dyn Host) {
        for (index, &word) in self.words.iter().enumerate() {
            write(host, index, word);
        }
    }

    /// The content.
    pub fn content(&self) -> Vec<u8> {
        self.words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    /// True once the power has failed.
    pub fn is_cut(&self) -> bool {
        self.cut_before.is_some_and(|number| self.operations >= number)
    }

    /// Handles a store into the array.
    pub fn on_store(&mut self, address: u64, host: &mut dyn Host) {
        let index = ((address - BASE) / 4) as usize;
        let asked = host
            .read(BASE + 4 * index as u64, Width::W32)
            .expect("the array is mapped as memory") as u32;
        let before = self.words[index];
        if !self.is_cut() {
            self.overwritten += u64::from(asked & !before != 0);
            self.words[index] = before & asked;
            self.journal.push(Operation::Program { index, word: asked });
            self.operations += 1;
        }
        write(host, index, self.words[index]);
    }

    /// Handles any access: an erasure may begin.
    pub fn on_access(&mut self, access: &Access, host: &mut dyn Host) {
        let starts = access.kind == AccessKind::Write
            && access.address == FLASH_CR
            && access.value & (SER | STRT) == SER | STRT;
        let sector = (access.value >> 3 & 0x1F).wrapping_sub(FIRST_SECTOR);
        if !starts || sector >= LEN / SECTOR_LEN || self.is_cut() {
            return;
        }
        self.operations += 1;
        self.journal.push(Operation::Erase { sector: sector as usize });
        let words_per_sector = (SECTOR_LEN / 4) as usize;
        let first = sector as usize * words_per_sector;
        for index in first..first + words_per_sector {
            self.words[index] = u32::MAX;
            write(host, index, u32::MAX);
        }
    }
}

fn write(host: &mut dyn Host, index: usize, word: u32) {
    host.write(BASE + 4 * index as u64, Width::W32, word.into())
        .expect("the array is mapped as memory");
}
