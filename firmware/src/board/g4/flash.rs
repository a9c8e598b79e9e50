//! The flash pages that hold the configuration.
//!
//! Uses the registers directly (RM0440, chapter 3): only a few pages are written.
//!
//! A double word of 8 bytes has 8 bits with it that correct one wrong bit and detect two (3.3.2). So it can be programmed
//! once per erasure; `sequential-storage`, whose word it is, programs none twice. A power cut may leave one that no longer
//! fits its 8 bits: reading it raises an interrupt that cannot be masked. [`was_unreadable`] ends that interrupt while the
//! store is read. The bits come as they are, and the checksums of the records and of their heads judge them, as on a chip
//! without correction. Data sheet, table 47: a double word takes 83 us, a page is erased in 25 ms.

use core::ops::Range;
use core::sync::atomic::{AtomicBool, Ordering, compiler_fence};

use embassy_stm32::Peri;
use embassy_stm32::pac::flash::regs::Cr;
use embassy_stm32::pac::{FLASH as REGISTERS, RCC};
use embassy_stm32::peripherals::FLASH;
use embassy_time::Timer;
use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

/// Where the core sees the second bank. The program runs on from the first one while a page is erased (3.3.8).
const BANK_2: u32 = 0x0804_0000;

/// Length of the store: the second bank's first 32 pages.
const STORE_LEN: usize = 64 * 1024;

const PAGE_LEN: usize = 2 * 1024;

const DOUBLE_WORD_LEN: usize = 8;

/// The store is read just now.
static READING: AtomicBool = AtomicBool::new(false);

/// The second bank's first 64 KiB as a flash of its own, in pages of 2 KiB.
pub struct StoreFlash(());

impl StoreFlash {
    /// Takes the chip's flash.
    pub fn new(_: Peri<'static, FLASH>) -> Self {
        Self(())
    }
}

/// The flash did not take what was written, is protected, or is set to a single bank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused;

impl NorFlashError for Refused {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl ErrorType for StoreFlash {
    type Error = Refused;
}

impl ReadNorFlash for StoreFlash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        // Reading takes no time, but a caller that reads a whole page must let the other tasks run.
        embassy_futures::yield_now().await;
        two_banks()?;
        let from = (BANK_2 + offset) as *const u8;
        READING.store(true, Ordering::Relaxed);
        compiler_fence(Ordering::SeqCst);
        // SAFETY: flash can always be read, and nothing writes to this part while `self` is borrowed.
        bytes.copy_from_slice(unsafe { core::slice::from_raw_parts(from, bytes.len()) });
        // What could not be corrected has raised its interrupt by the end of this: the handler clears the flag.
        cortex_m::asm::dsb();
        let _ = (0..100).any(|_| !REGISTERS.eccr().read().eccd());
        compiler_fence(Ordering::SeqCst);
        READING.store(false, Ordering::Relaxed);
        Ok(())
    }

    fn capacity(&self) -> usize {
        STORE_LEN
    }
}

impl NorFlash for StoreFlash {
    const WRITE_SIZE: usize = DOUBLE_WORD_LEN;
    const ERASE_SIZE: usize = PAGE_LEN;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        for page in pages(from..to) {
            erase_page(page).await?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        program(offset, bytes).await
    }
}

/// Whether the flash is in two banks, as it comes from the factory. In one, pages are twice as long, and a change of
/// `DBANK` erases the program (3.4.2).
fn two_banks() -> Result<(), Refused> {
    if REGISTERS.optr().read().dbank() { Ok(()) } else { Err(Refused) }
}

/// Numbers of pages in their bank.
fn pages(offsets: Range<u32>) -> Range<u8> {
    let number = |offset| (offset / PAGE_LEN as u32) as u8;
    number(offsets.start)..number(offsets.end)
}

/// Programs whole double words. A record has about 40, so the other tasks run meanwhile.
async fn program(offset: u32, bytes: &[u8]) -> Result<(), Refused> {
    let mut what = Cr::default();
    what.set_pg(true);
    let unlocked = Unlocked::begin(what)?;
    let mut to = (BANK_2 + offset) as *mut u32;
    for double_word in bytes.as_chunks::<DOUBLE_WORD_LEN>().0 {
        for word in double_word.as_chunks().0 {
            // SAFETY: the store's own part of the flash, unlocked, by aligned double words, the lower half first.
            unsafe {
                to.write_volatile(u32::from_le_bytes(*word));
                to = to.add(1);
            }
        }
        while REGISTERS.sr().read().bsy() {
            embassy_futures::yield_now().await;
        }
    }
    unlocked.end()
}

/// Erases a page of the second bank.
async fn erase_page(page: u8) -> Result<(), Refused> {
    let mut what = Cr::default();
    what.set_per(true);
    what.set_bker(true);
    what.set_pnb(page);
    let unlocked = Unlocked::begin(what)?;
    REGISTERS.cr().modify(|w| w.set_strt(true));
    while REGISTERS.sr().read().bsy() {
        Timer::after_millis(1).await;
    }
    unlocked.end()
}

/// The flash can be written while this exists.
struct Unlocked(());

impl Unlocked {
    #[inline(never)]
    fn begin(what: Cr) -> Result<Self, Refused> {
        two_banks()?;
        // The error flags are cleared by writing them back.
        REGISTERS.sr().modify(|_| {});
        if REGISTERS.cr().read().lock() {
            REGISTERS.keyr().write_value(0x4567_0123);
            REGISTERS.keyr().write_value(0xCDEF_89AB);
        }
        // The data cache must be off while one bank is written and the other one read (ES0430, 2.2.2).
        REGISTERS.acr().modify(|w| w.set_dcen(false));
        REGISTERS.cr().write_value(what);
        Ok(Self(()))
    }

    #[inline(never)]
    fn end(self) -> Result<(), Refused> {
        let errors = REGISTERS.sr().read();
        REGISTERS.cr().write(|w| {
            w.set_optlock(true);
            w.set_lock(true);
        });
        // The cache may hold old content (3.3.7).
        REGISTERS.acr().modify(|w| w.set_dcrst(true));
        REGISTERS.acr().modify(|w| w.set_dcrst(false));
        REGISTERS.acr().modify(|w| w.set_dcen(true));
        let refused = errors.progerr() || errors.wrperr() || errors.pgaerr();
        if refused || errors.sizerr() || errors.pgserr() {
            return Err(Refused);
        }
        Ok(())
    }
}

/// Whether an interrupt that cannot be masked came from reading the store; then it is over.
///
/// Which double word it was is not asked: the register that tells holds an older error until that is cleared, and blank
/// flash counts as corrected (3.3.2). No other source is switched on but the clock's.
pub(in crate::board) fn was_unreadable() -> bool {
    if !READING.load(Ordering::Relaxed) || RCC.cifr().read().cssf() {
        return false;
    }
    // The flags are cleared by writing 1.
    REGISTERS.eccr().write(|w| {
        w.set_eccd(true);
        w.set_eccc(true);
    });
    // The write must finish before the interrupt ends, or it begins again (Arm erratum 838869).
    cortex_m::asm::dsb();
    true
}
