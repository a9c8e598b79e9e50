//! The flash array that the firmware stores in.
//!
//! The emulator models the flash interface (keys, busy times, interrupts) but not the array behind it:
//! that is here, as NOR flash is. An erased word is all ones, programming only clears bits, and one
//! that asks for more than that is noted: the chip would keep the old bits.

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

/// What the firmware's part of the flash holds.
pub type Flash = Vec<u8>;

/// What a blank one holds.
pub fn blank() -> Flash {
    vec![0xFF; LEN as usize]
}

/// One thing that was done to the flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// A word was programmed.
    Program {
        /// Which, from the beginning of the array.
        index: usize,
        /// With what.
        word: u32,
    },
    /// A sector was erased.
    Erase {
        /// Which.
        sector: usize,
    },
}

impl Operation {
    /// Carries it out on what the flash holds.
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
    /// What was done to it, in order.
    pub journal: Vec<Operation>,
    /// Erasures and programmed words so far.
    pub operations: u64,
    /// The power goes before the operation with this number, counted from 0.
    pub cut_before: Option<u64>,
    /// Words that were programmed without an erasure that they needed.
    pub overwritten: u64,
}

impl FlashArray {
    /// What a flash held, or a blank one.
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

    /// Holds something else from now on.
    pub fn put(&mut self, content: &[u8], host: &mut dyn Host) {
        let words = Self::new(Some(content)).words;
        for (index, (old, new)) in self.words.iter_mut().zip(words).enumerate() {
            if *old != new {
                *old = new;
                write(host, index, new);
            }
        }
    }

    /// What has to be watched for [`Self::on_store`].
    pub fn watch() -> Watch {
        Watch::Writes { address: BASE, length: LEN }
    }

    /// Shows the array to the core, from power-on.
    pub fn show(&self, host: &mut dyn Host) {
        for (index, &word) in self.words.iter().enumerate() {
            write(host, index, word);
        }
    }

    /// What it holds.
    pub fn content(&self) -> Vec<u8> {
        self.words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    /// True once the power has gone.
    pub fn is_cut(&self) -> bool {
        self.cut_before.is_some_and(|number| self.operations >= number)
    }

    /// The core has stored into the array.
    pub fn on_store(&mut self, address: u64, host: &mut dyn Host) {
        let index = ((address - BASE) / 4) as usize;
        let asked = host.read(BASE + 4 * index as u64, Width::W32).expect("it is memory") as u32;
        let before = self.words[index];
        if !self.is_cut() {
            self.overwritten += u64::from(asked & !before != 0);
            self.words[index] = before & asked;
            self.journal.push(Operation::Program { index, word: asked });
            self.operations += 1;
        }
        write(host, index, self.words[index]);
    }

    /// The core has accessed the flash interface, or something else.
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
    host.write(BASE + 4 * index as u64, Width::W32, word.into()).expect("it is memory");
}
