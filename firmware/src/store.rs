//! The configuration in a flash memory: [`Store`] on any `NorFlash`.
//!
//! ```text
//! layout u16 | CRC-32 of what follows u32 | configuration, postcard        little-endian
//! ```
//!
//! `sequential-storage` appends each record to the one before, so that the old record is whole until
//! the new one is: a power cut leaves either. A record of a layout that this firmware does not know,
//! or one that fails its checksum, is damage, and never guessed at.

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use embedded_storage_async::nor_flash::NorFlash;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use shared_proto::Config;

use crate::hal::{Store, StoreError};

/// The layout that is written. Raised when [`Config`] changes; `decode` goes on reading the older
/// ones.
pub const LAYOUT: u16 = 1;

/// The one record's key.
const CONFIGURATION: u8 = 1;

/// Longest record with its key; a configuration takes about 260 bytes.
const RECORD_LEN_MAX: usize = 512;

/// Layout and checksum.
const HEADER_LEN: usize = 6;

/// Without a table, which would take a kilobyte of flash: it is worked out twice a day.
const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// No cache: the store is looked at twice a day.
type NoCache = Cache<Uncached, Uncached, Uncached, u8>;

/// A configuration in a flash of at least two pages.
pub struct FlashStore<F: NorFlash> {
    map: MapStorage<u8, F, NoCache>,
    buffer: [u8; RECORD_LEN_MAX],
}

impl<F: NorFlash> FlashStore<F> {
    /// Takes the whole of this flash.
    ///
    /// # Panics
    /// If the flash has fewer than two pages: that is a board file's mistake.
    pub fn new(flash: F) -> Self {
        let range = 0..flash.capacity() as u32;
        Self {
            map: MapStorage::new(flash, MapConfig::new(range), Cache::new_uncached()),
            buffer: [0; RECORD_LEN_MAX],
        }
    }

    /// Gives the flash back.
    pub fn into_flash(self) -> F {
        self.map.destroy().0
    }
}

impl<F: NorFlash> Store for FlashStore<F> {
    async fn load(&mut self) -> Result<Option<Config>, StoreError> {
        match self.map.fetch_item::<&[u8]>(&mut self.buffer, &CONFIGURATION).await {
            Ok(Some(record)) => decode(record).map(Some),
            Ok(None) => Ok(None),
            Err(_) => Err(StoreError::Damaged),
        }
    }

    async fn save(&mut self, config: &Config) -> Result<(), StoreError> {
        let mut record = [0; RECORD_LEN_MAX];
        let len = encode(config, &mut record)?;
        let record = &record[..len];
        if self.map.store_item(&mut self.buffer, &CONFIGURATION, &record).await.is_err() {
            // What cannot be appended to cannot be read either; there is nothing to lose.
            if self.load().await.is_ok() {
                return Err(StoreError::Write);
            }
            self.map.erase_all().await.map_err(|_| StoreError::Write)?;
            let stored = self.map.store_item(&mut self.buffer, &CONFIGURATION, &record).await;
            stored.map_err(|_| StoreError::Write)?;
        }
        match self.map.fetch_item::<&[u8]>(&mut self.buffer, &CONFIGURATION).await {
            Ok(Some(stored)) if stored == record => Ok(()),
            _ => Err(StoreError::Write),
        }
    }
}

/// A configuration as a record; its length.
fn encode(config: &Config, record: &mut [u8; RECORD_LEN_MAX]) -> Result<usize, StoreError> {
    let (header, body) = record.split_at_mut(HEADER_LEN);
    // `sequential-storage` needs room for its key in the same buffer.
    let room = body.len() - size_of::<u8>();
    let body = postcard::to_slice(config, &mut body[..room]).map_err(|_| StoreError::Write)?;
    header[..2].copy_from_slice(&LAYOUT.to_le_bytes());
    header[2..].copy_from_slice(&CRC.checksum(body).to_le_bytes());
    Ok(HEADER_LEN + body.len())
}

/// The configuration in a record of any layout that ever was.
fn decode(record: &[u8]) -> Result<Config, StoreError> {
    let (header, body) = record.split_at_checked(HEADER_LEN).ok_or(StoreError::Damaged)?;
    let [layout @ .., a, b, c, d] = header else { return Err(StoreError::Damaged) };
    if u32::from_le_bytes([*a, *b, *c, *d]) != CRC.checksum(body) {
        return Err(StoreError::Damaged);
    }
    match layout {
        [low, high] if u16::from_le_bytes([*low, *high]) == LAYOUT => {
            postcard::from_bytes(body).map_err(|_| StoreError::Damaged)
        }
        _ => Err(StoreError::Damaged),
    }
}
