//! The part of the flash where the configuration lives.

use embassy_stm32::flash::{Async, Error, Flash};
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

use super::{ERASE_STALLS, STORE, guard};

/// [`STORE`] as a flash of its own, in sectors of 16 KiB.
pub struct StoreFlash(Flash<'static, Async>);

impl StoreFlash {
    /// Takes the chip's flash.
    pub const fn new(flash: Flash<'static, Async>) -> Self {
        Self(flash)
    }
}

impl ErrorType for StoreFlash {
    type Error = Error;
}

impl ReadNorFlash for StoreFlash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        // Reading is instant; whoever reads a whole sector lets the others go on in between.
        embassy_futures::yield_now().await;
        self.0.blocking_read(STORE.start + offset, bytes)
    }

    fn capacity(&self) -> usize {
        (STORE.end - STORE.start) as usize
    }
}

impl NorFlash for StoreFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 16 * 1024;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        let erase = self.0.erase(STORE.start + from, STORE.start + to);
        if ERASE_STALLS { guard::stretched(erase).await } else { erase.await }
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        self.0.write(STORE.start + offset, bytes).await
    }
}
