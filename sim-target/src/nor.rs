//! A NOR flash that takes its time, and whose operation under way is torn when the power goes: the board's own store on it
//! meets what it meets on a chip.

use core::cell::RefCell;
use core::convert::Infallible;
use std::rc::Rc;

use embassy_time::Timer;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// As on the NUCLEO-F429ZI: four sectors of 16 KiB, programmed by words of four bytes.
const SECTOR_LEN: usize = 16 * 1024;
const SECTORS: usize = 4;
const WORD_LEN: usize = 4;

/// What its data sheet calls typical: 16 us a word, 250 ms a sector.
const WORD_US: u64 = 16;
const SECTOR_US: u64 = 250_000;

/// A flash; clones are the same one.
#[derive(Clone)]
pub struct Nor(Rc<RefCell<Cells>>);

#[derive(Clone)]
struct Cells {
    bytes: Vec<u8>,
    under_way: Option<Operation>,
    rng: ChaCha8Rng,
    takes_time: bool,
}

#[derive(Clone, Copy)]
enum Operation {
    Program(usize, [u8; WORD_LEN]),
    Erase(usize),
}

impl Nor {
    /// A blank flash; what a power cut leaves is drawn from the seed.
    pub fn blank(seed: u64) -> Self {
        let bytes = vec![0xFF; SECTORS * SECTOR_LEN];
        let rng = ChaCha8Rng::seed_from_u64(seed);
        Self(Rc::new(RefCell::new(Cells { bytes, under_way: None, rng, takes_time: true })))
    }

    /// Another flash with the same bytes, which takes no time: for looking into this one. Where an operation is under
    /// way, it is as if the power went now.
    pub fn copy(&self) -> Self {
        let copy = Cells { takes_time: false, ..self.0.borrow().clone() };
        let copy = Self(Rc::new(RefCell::new(copy)));
        copy.tear();
        copy
    }

    /// Puts back what the flash held when this copy of it was made.
    pub fn put_back(&self, earlier: &Self) {
        self.0.borrow_mut().bytes.clone_from(&earlier.0.borrow().bytes);
    }

    /// The power goes: of the operation under way some bits are done.
    pub(crate) fn tear(&self) {
        let Cells { bytes, under_way, rng, .. } = &mut *self.0.borrow_mut();
        match under_way.take() {
            None => {}
            Some(Operation::Program(at, word)) => {
                for (cell, asked) in bytes[at..].iter_mut().zip(word) {
                    *cell &= asked | rng.random::<u8>();
                }
            }
            Some(Operation::Erase(at)) => {
                let cells = &mut bytes[at..at + SECTOR_LEN];
                match rng.random_range(0..4) {
                    0 => {}
                    // An erasure programs everything first.
                    1 => cells.fill(0),
                    2 => cells.iter_mut().for_each(|cell| *cell |= rng.random::<u8>()),
                    _ => {
                        let len = rng.random_range(0..SECTOR_LEN);
                        cells[..len].fill(0xFF);
                    }
                }
            }
        }
    }

    async fn operate(&self, operation: Operation, takes_us: u64) {
        self.0.borrow_mut().under_way = Some(operation);
        if self.0.borrow().takes_time {
            Timer::after_micros(takes_us).await;
        }
        let Cells { bytes, under_way, .. } = &mut *self.0.borrow_mut();
        *under_way = None;
        match operation {
            // Programming only ever clears bits.
            Operation::Program(at, word) => {
                bytes[at..].iter_mut().zip(word).for_each(|(cell, asked)| *cell &= asked);
            }
            Operation::Erase(at) => bytes[at..at + SECTOR_LEN].fill(0xFF),
        }
    }
}

impl ErrorType for Nor {
    type Error = Infallible;
}

impl ReadNorFlash for Nor {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
        bytes.copy_from_slice(&self.0.borrow().bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        SECTORS * SECTOR_LEN
    }
}

impl NorFlash for Nor {
    const WRITE_SIZE: usize = WORD_LEN;
    const ERASE_SIZE: usize = SECTOR_LEN;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Infallible> {
        for at in (from as usize..to as usize).step_by(SECTOR_LEN) {
            self.operate(Operation::Erase(at), SECTOR_US).await;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Infallible> {
        for (index, word) in bytes.chunks_exact(WORD_LEN).enumerate() {
            let at = offset as usize + WORD_LEN * index;
            let word = word.try_into().expect("chunks of a word");
            self.operate(Operation::Program(at, word), WORD_US).await;
        }
        Ok(())
    }
}
