//! The configuration in the last 16 KiB of the flash, four sectors.

use embassy_rp::flash::{Blocking, ERASE_SIZE, Error, Flash};
use embassy_rp::peripherals::FLASH;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// The Pico 2's flash.
const FLASH_LEN: usize = 4 * 1024 * 1024;
const STORE_LEN: u32 = 4 * ERASE_SIZE as u32;
const STORE: u32 = FLASH_LEN as u32 - STORE_LEN;

/// That part of the flash. The core stands still while a sector is erased or written: only with the motors off.
pub struct StoreFlash(pub Flash<'static, FLASH, Blocking, FLASH_LEN>);

impl ErrorType for StoreFlash {
    type Error = Error;
}

impl ReadNorFlash for StoreFlash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        // A caller that reads a whole sector must let the other tasks run.
        embassy_futures::yield_now().await;
        self.0.blocking_read(STORE + offset, bytes)
    }

    fn capacity(&self) -> usize {
        STORE_LEN as usize
    }
}

impl NorFlash for StoreFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        for sector in (from..to).step_by(ERASE_SIZE) {
            self.0.blocking_erase(STORE + sector, STORE + sector + ERASE_SIZE as u32)?;
            embassy_futures::yield_now().await;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        self.0.blocking_write(STORE + offset, bytes)
    }
}
