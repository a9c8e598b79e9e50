//! Configuration, key and count of starts in a flash memory: [`Store`] on any `NorFlash`.
//!
//! The link's record is a count, u64 little-endian, and the key's 16 bytes, where there is a key. The configuration's:
//!
//! ```text
//! layout  record, little-endian
//! 1       layout u16 | CRC-32 of the configuration u32            | configuration, postcard
//! 2       layout u16 | CRC-32 of layout and configuration u32     | configuration, postcard
//! 3       as 2, with geometry.heading_pull_rad_per_m in the configuration
//! 4       as 3, with feedforward.supply_v and protection.supply_v_max
//! 5       as 4, with limits.hold_s
//! 6       as 5, with driver
//! ```
//!
//! Layout 6 is written. The older ones are still read, with 0 for the numbers that they lack (`decode_older`): no
//! pull, no scaling by the supply, no upper limit of it, no hold. Their driver has a PWM and a direction line at 20 kHz, as
//! every image before layout 6 drove it. They become layout 6 at the next save. Should a
//! layout ever differ in more than something added, a frozen copy of its type and a conversion belong here.
//!
//! `sequential-storage` appends each record to the one before, so the old record stays whole until the
//! new one is complete: a power cut leaves one of the two. A power cut during an erasure leaves a sector
//! of half-erased bits, which is erased again before anything is read (`repair`). A record of an unknown
//! layout, or with a wrong checksum, counts as damaged.

use embedded_storage_async::nor_flash::NorFlash;
use sequential_storage::cache::key_pointers::ArrayKeyPointers;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use shared_proto::{Config, Crc32, Key};

use crate::hal::{LinkRecord, Store, StoreError};

/// The layout that is written. Raise it when [`Config`] changes; `decode` must still read the older ones.
pub const LAYOUT: u16 = 6;

/// The records' keys.
const CONFIGURATION: u8 = 1;
const LINK: u8 = 2;

/// How many there are.
const RECORDS: usize = 2;

/// Length of the link's record, and of its count \[bytes\].
const LINK_LEN: usize = COUNT_LEN + Key::LEN;
const COUNT_LEN: usize = size_of::<u64>();

/// Longest record with its key; a configuration takes about 270 bytes.
const RECORD_LEN_MAX: usize = 512;

/// Layout and checksum.
const HEADER_LEN: usize = 6;

/// Remembers where the record is. Without it, each lookup computes a checksum over every record of a
/// sector, and erasing a sector takes a lookup for each of its records.
type KeyCache = Cache<Uncached, Uncached, ArrayKeyPointers<u8, RECORDS>, u8>;

/// What survives power-off, in a flash of at least three sectors of one length: one full, one in use, one free.
pub struct FlashStore<F: NorFlash> {
    map: MapStorage<u8, F, KeyCache>,
    buffer: [u8; RECORD_LEN_MAX],
    /// There was one, at any time since power-on.
    has_key: bool,
}

impl<F: NorFlash> FlashStore<F> {
    /// Takes the whole of this flash.
    ///
    /// # Panics
    /// If the flash has fewer than two sectors, which is a mistake in the board's file.
    pub fn new(flash: F) -> Self {
        // `is_blank` reads whole buffers; `is_marked` single bytes.
        const { assert!(F::ERASE_SIZE.is_multiple_of(RECORD_LEN_MAX) && F::READ_SIZE == 1) };
        let range = 0..flash.capacity() as u32;
        Self {
            map: MapStorage::new(
                flash,
                MapConfig::new(range),
                Cache::new(Uncached, Uncached, ArrayKeyPointers::new()),
            ),
            buffer: [0; RECORD_LEN_MAX],
            has_key: false,
        }
    }

    /// Gives the flash back.
    pub fn into_flash(self) -> F {
        self.map.destroy().0
    }
}

/// A sector's two marks, which tell `sequential-storage` the sector's state.
///
/// ```text
/// first byte   last byte    the sector
/// blank        blank        is free
/// marked       blank        takes records
/// marked       marked       is full
/// blank        marked       was being erased; the library erases this sector again by itself
/// ```
#[derive(Clone, Copy, PartialEq, Eq)]
struct Marks {
    first: bool,
    last: bool,
}

impl Marks {
    const FREE: Self = Self { first: false, last: false };
    const IN_USE: Self = Self { first: true, last: false };
}

impl<F: NorFlash> FlashStore<F> {
    /// Erases what an interrupted erasure has left, where the library would mistake its state.
    ///
    /// Sectors are used in a ring, and the one after the sector that takes records is free. So a second
    /// sector that seems to take records, right after the first, is one whose erasure was interrupted; so
    /// is a free sector that is not blank. Neither ever holds data that is needed.
    async fn repair(&mut self) -> Result<(), F::Error> {
        let sectors = (self.map.flash().capacity() / F::ERASE_SIZE) as u32;
        let mut before = self.marks(sectors - 1).await?;
        for sector in 0..sectors {
            let marks = self.marks(sector).await?;
            let twice = marks == Marks::IN_USE && before == Marks::IN_USE;
            if twice || (marks == Marks::FREE && !self.is_blank(sector).await?) {
                let start = sector * F::ERASE_SIZE as u32;
                self.map.flash().erase(start, start + F::ERASE_SIZE as u32).await?;
            }
            before = marks;
        }
        Ok(())
    }

    async fn marks(&mut self, sector: u32) -> Result<Marks, F::Error> {
        let start = sector * F::ERASE_SIZE as u32;
        Ok(Marks {
            first: self.is_marked(start).await?,
            last: self.is_marked(start + F::ERASE_SIZE as u32 - 1).await?,
        })
    }

    /// The library's rule: half of the bits are programmed.
    async fn is_marked(&mut self, offset: u32) -> Result<bool, F::Error> {
        let mut byte = [0];
        self.map.flash().read(offset, &mut byte).await?;
        Ok(byte[0].count_zeros() >= 4)
    }

    async fn is_blank(&mut self, sector: u32) -> Result<bool, F::Error> {
        let start = sector * F::ERASE_SIZE as u32;
        let Self { map, buffer, .. } = self;
        for offset in (0..F::ERASE_SIZE).step_by(buffer.len()) {
            map.flash().read(start + offset as u32, buffer).await?;
            if buffer.iter().any(|&byte| byte != 0xFF) {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

impl<F: NorFlash> Store for FlashStore<F> {
    async fn load(&mut self) -> Result<Option<Config>, StoreError> {
        self.repair().await.map_err(|_| StoreError::Damaged)?;
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
        if self.put(CONFIGURATION, record).await.is_ok() {
            return Ok(());
        }
        // Only where nothing can be read either is there nothing to lose by erasing.
        if self.has_key || self.load().await.is_ok() {
            return Err(StoreError::Write);
        }
        self.map.erase_all().await.map_err(|_| StoreError::Write)?;
        self.put(CONFIGURATION, record).await
    }

    async fn link(&mut self, change: Option<Option<Key>>) -> Result<LinkRecord, StoreError> {
        let (mut count, mut key) = match self.map.fetch_item::<&[u8]>(&mut self.buffer, &LINK).await
        {
            Ok(None) => (0, None),
            Ok(Some(record)) => decode_link(record).ok_or(StoreError::UnknownKey)?,
            Err(_) => return Err(StoreError::Damaged),
        };
        key = change.unwrap_or(key);
        self.has_key |= key.is_some();
        if key.is_none() && change.is_none() {
            return Ok(LinkRecord { key, count: None });
        }
        count += 1;
        let mut record = [0; LINK_LEN];
        record[..COUNT_LEN].copy_from_slice(&count.to_le_bytes());
        record[COUNT_LEN..].copy_from_slice(key.unwrap_or(Key::new([0; Key::LEN])).expose());
        let len = if key.is_some() { LINK_LEN } else { COUNT_LEN };
        match self.put(LINK, &record[..len]).await {
            Err(error) if change.is_some() => Err(error),
            kept => Ok(LinkRecord { key, count: kept.ok().map(|()| count) }),
        }
    }
}

impl<F: NorFlash> FlashStore<F> {
    /// Appends a record and reads it back.
    async fn put(&mut self, key: u8, record: &[u8]) -> Result<(), StoreError> {
        let stored = self.map.store_item(&mut self.buffer, &key, &record).await;
        stored.map_err(|_| StoreError::Write)?;
        match self.map.fetch_item::<&[u8]>(&mut self.buffer, &key).await {
            Ok(Some(stored)) if stored == record => Ok(()),
            _ => Err(StoreError::Write),
        }
    }
}

/// Count and key in the link's record.
fn decode_link(record: &[u8]) -> Option<(u64, Option<Key>)> {
    let (count, key) = record.split_first_chunk()?;
    let key = match key {
        [] => None,
        key => Some(Key::new(key.try_into().ok()?)),
    };
    Some((u64::from_le_bytes(*count), key))
}

/// Encodes a configuration as a record; returns the record's length.
fn encode(config: &Config, record: &mut [u8; RECORD_LEN_MAX]) -> Result<usize, StoreError> {
    let (header, body) = record.split_at_mut(HEADER_LEN);
    // `sequential-storage` needs room for its key in the same buffer.
    let room = body.len() - size_of::<u8>();
    let len = config.to_postcard(&mut body[..room]).ok_or(StoreError::Write)?;
    let body = &body[..len];
    let layout = LAYOUT.to_le_bytes();
    header[..2].copy_from_slice(&layout);
    header[2..].copy_from_slice(&checksum(&[&layout, body]).to_le_bytes());
    Ok(HEADER_LEN + body.len())
}

/// Decodes the configuration in a record of any known layout.
fn decode(record: &[u8]) -> Result<Config, StoreError> {
    let (header, body) = record.split_at_checked(HEADER_LEN).ok_or(StoreError::Damaged)?;
    let &[low, high, a, b, c, d] = header else { return Err(StoreError::Damaged) };
    let layout = u16::from_le_bytes([low, high]);
    let expected = match layout {
        1 => checksum(&[body]),
        2..=LAYOUT => checksum(&[&[low, high], body]),
        _ => return Err(StoreError::Damaged),
    };
    if u32::from_le_bytes([a, b, c, d]) != expected {
        return Err(StoreError::Damaged);
    }
    let config =
        if layout == LAYOUT { Config::from_postcard(body) } else { decode_older(body, layout) };
    config.ok_or(StoreError::Damaged)
}

/// Decodes a configuration of an older layout: eight zero bytes are inserted for each number that it lacks, and the
/// driver is appended.
fn decode_older(body: &[u8], layout: u16) -> Option<Config> {
    const NUMBER: usize = size_of::<f64>();
    /// Since which layout there is a number, and the numbers and flags before it: the pull, `feedforward.supply_v`,
    /// `limits.hold_s` and `protection.supply_v_max`.
    const ADDED: [(u16, usize, usize); 4] = [(3, 3, 0), (4, 14, 4), (5, 20, 4), (4, 25, 4)];
    /// The driver's PWM before layout 6 \[Hz\]; behind it two flags, the name and what it does at a fault, all 0.
    const PWM_HZ: f64 = 20_000.0;
    const DRIVER_CHOICES: usize = 4;
    let mut whole = [0; RECORD_LEN_MAX];
    whole.get_mut(..body.len())?.copy_from_slice(body);
    let mut len = body.len();
    // The name's length, in one byte, and the name.
    let name = 1 + usize::from(*body.first()?);
    for (_, numbers, flags) in ADDED.into_iter().filter(|(since, ..)| layout < *since) {
        let at = name + numbers * NUMBER + flags;
        if at > len || len + NUMBER > whole.len() {
            return None;
        }
        whole.copy_within(at..len, at + NUMBER);
        whole.get_mut(at..at + NUMBER)?.fill(0);
        len += NUMBER;
    }
    let driver = whole.get_mut(len..len + NUMBER + DRIVER_CHOICES)?;
    driver.fill(0);
    driver[..NUMBER].copy_from_slice(&PWM_HZ.to_le_bytes());
    Config::from_postcard(&whole[..len + NUMBER + DRIVER_CHOICES])
}

fn checksum(parts: &[&[u8]]) -> u32 {
    parts.iter().fold(Crc32::new(), |crc, part| crc.over(part)).value()
}
