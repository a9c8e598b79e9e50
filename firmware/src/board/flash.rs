//! The flash sectors that hold the configuration.
//!
//! Uses the registers directly (RM0090, chapter 3): only a few sectors of one length are written.

use core::ops::Range;

use embassy_stm32::Peri;
use embassy_stm32::pac::flash::regs::Cr;
use embassy_stm32::pac::flash::vals::Psize;
use embassy_stm32::pac::gpio::vals::{Moder, Odr, Pupdr};
use embassy_stm32::pac::{self, FLASH as REGISTERS};
use embassy_stm32::peripherals::FLASH;
use embassy_time::Timer;
use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

use super::{ERASE_STALLS, STORE, STORE_SECTOR, guard};

/// Where the core sees the flash.
const FLASH_BASE: u32 = 0x0800_0000;

const SECTOR_LEN: usize = 16 * 1024;

/// [`STORE`] as a flash of its own, in sectors of 16 KiB.
pub struct StoreFlash(());

impl StoreFlash {
    /// Takes the chip's flash.
    pub fn new(_: Peri<'static, FLASH>) -> Self {
        hold_pa12_low();
        Self(())
    }
}

/// The flash did not take what was written, or is protected.
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
        // Reading takes no time, but a caller that reads a whole sector must let the other tasks run.
        embassy_futures::yield_now().await;
        if !readable() {
            return Err(Refused);
        }
        let from = (FLASH_BASE + STORE.start + offset) as *const u8;
        // SAFETY: flash can always be read, and nothing writes to this part while `self` is borrowed.
        bytes.copy_from_slice(unsafe { core::slice::from_raw_parts(from, bytes.len()) });
        Ok(())
    }

    fn capacity(&self) -> usize {
        (STORE.end - STORE.start) as usize
    }
}

impl NorFlash for StoreFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR_LEN;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        for sector in sectors(from..to) {
            if ERASE_STALLS {
                guard::stretched(erase_sector(sector)).await?;
            } else {
                erase_sector(sector).await?;
            }
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        program(offset, bytes)
    }
}

/// Numbers of sectors in the control register.
fn sectors(offsets: Range<u32>) -> Range<u8> {
    let number = |offset| STORE_SECTOR + (offset / SECTOR_LEN as u32) as u8;
    number(offsets.start)..number(offsets.end)
}

/// Programs whole words, 16 us each. A record has about 60 words: too few to yield in between.
#[inline(never)]
fn program(offset: u32, bytes: &[u8]) -> Result<(), Refused> {
    let mut what = Cr::default();
    what.set_pg(true);
    let unlocked = Unlocked::begin(what);
    let mut to = (FLASH_BASE + STORE.start + offset) as *mut u32;
    for word in bytes.as_chunks().0 {
        // SAFETY: the store's own part of the flash, unlocked, by aligned words.
        unsafe {
            to.write_volatile(u32::from_le_bytes(*word));
            to = to.add(1);
        }
        while REGISTERS.sr().read().bsy() {}
    }
    unlocked.end()
}

async fn erase_sector(sector: u8) -> Result<(), Refused> {
    let mut what = Cr::default();
    what.set_ser(true);
    what.set_snb(sector);
    let unlocked = Unlocked::begin(what);
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
    fn begin(mut what: Cr) -> Self {
        what.set_psize(Psize::PSIZE32);
        // The error flags are cleared by writing them back.
        REGISTERS.sr().modify(|_| {});
        if REGISTERS.cr().read().lock() {
            REGISTERS.keyr().write_value(0x4567_0123);
            REGISTERS.keyr().write_value(0xCDEF_89AB);
        }
        // On a chip with two banks the data cache must be off while writing (ES0206, 2.2.12).
        REGISTERS.acr().modify(|w| w.set_dcen(false));
        REGISTERS.cr().write_value(what);
        Self(())
    }

    #[inline(never)]
    fn end(self) -> Result<(), Refused> {
        let errors = REGISTERS.sr().read();
        REGISTERS.cr().write(|w| w.set_lock(true));
        // The cache may hold old content.
        REGISTERS.acr().modify(|w| w.set_dcrst(true));
        REGISTERS.acr().modify(|w| w.set_dcrst(false));
        REGISTERS.acr().modify(|w| w.set_dcen(true));
        if errors.pgserr() || errors.pgperr() || errors.pgaerr() || errors.wrperr() {
            return Err(Refused);
        }
        Ok(())
    }
}

const PA12: usize = 12;

/// Before revision 3, the chip's second bank reads wrongly unless PA12 is held low (ES0206, 2.2.14).
fn needs_pa12_low() -> bool {
    const REVISION_3: u16 = 0x2001;
    STORE.start >= 0x10_0000 && pac::DBGMCU.idcode().read().rev_id() < REVISION_3
}

/// Holds PA12 low on a chip that needs it. With USB, PA12 carries D+ instead, and such a chip has no store.
fn hold_pa12_low() {
    if cfg!(feature = "usb") || !needs_pa12_low() {
        return;
    }
    critical_section::with(|_| {
        pac::GPIOA.odr().modify(|w| w.set_odr(PA12, Odr::LOW));
        pac::GPIOA.pupdr().modify(|w| w.set_pupdr(PA12, Pupdr::PULL_DOWN));
        pac::GPIOA.moder().modify(|w| w.set_moder(PA12, Moder::OUTPUT));
    });
}

/// Whether what is read is what is stored.
fn readable() -> bool {
    !needs_pa12_low()
        || (pac::GPIOA.moder().read().moder(PA12) == Moder::OUTPUT
            && pac::GPIOA.pupdr().read().pupdr(PA12) == Pupdr::PULL_DOWN
            && pac::GPIOA.odr().read().odr(PA12) == Odr::LOW)
}
