//! Configuration, key and count of starts in a flash memory: [`Store`] on any `NorFlash`.
//!
//! There is one record. A robot that has a key, or had one, keeps key and count in front of its configuration:
//!
//! ```text
//! length of what follows, 8 or 24 u8 | 0x80 | count u64 LE | key, 16 bytes, if there is one
//! ```
//!
//! In one record, since `sequential-storage` keeps the newest record through every power cut, but may lose an older
//! one of another kind, while it moves that one out of a sector. The configuration:
//!
//! ```text
//! layout  record, little-endian
//! 1       layout u16 | CRC-32 of the configuration u32            | configuration, postcard
//! 2       layout u16 | CRC-32 of layout and configuration u32     | configuration, postcard
//! 3       as 2, with geometry.heading_pull_rad_per_m in the configuration
//! 4       as 3, with feedforward.supply_v and protection.supply_v_max
//! 5       as 4, with limits.hold_s
//! 6       as 5, with driver
//! 7       as 6, with a feedforward in volts for each wheel and direction in place of one in duty for both
//! 8       as 7, with odometry
//! ```
//!
//! Layout 8 is written. The older ones are still read, with 0 for the numbers that they lack (`decode_older`): no
//! pull, no scaling by the supply, no upper limit of it, no hold. Their driver has a PWM and a direction line at 20 kHz, as
//! every image before layout 6 drove it; their feedforward is multiplied by the nominal supply, so that the same duty
//! results. How sure their odometry is, is that of a robot that nobody has calibrated. They become layout 8 at the next save.
//!
//! `sequential-storage` appends each record to the one before, so the old record stays whole until the
//! new one is complete: a power cut leaves one of the two. A power cut during an erasure leaves a sector
//! of half-erased bits, which is erased again before anything is read (`repair`). A record of an unknown
//! layout, or with a wrong checksum, counts as damaged.

use embedded_storage_async::nor_flash::NorFlash;
use sequential_storage::cache::key_pointers::ArrayKeyPointers;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use shared_proto::{Config, Crc32, FeedforwardConfig, Key, OdometryConfig, is_above};

use crate::hal::{LinkRecord, Store, StoreError};

/// The layout that is written. Raise it when [`Config`] changes; `decode` must still read the older ones.
pub const LAYOUT: u16 = 8;

/// The record's key in the map.
const RECORD: u8 = 1;

/// Second byte of a record that begins with count and key; no layout has it.
const LINK_MARK: u8 = 0x80;

/// Length of what precedes a count, and of the count \[bytes\].
const MARK_LEN: usize = 2;
const COUNT_LEN: usize = size_of::<u64>();

/// Longest record with its key; a configuration takes about 300 bytes, count and key 26.
const RECORD_LEN_MAX: usize = 512;

/// Layout and checksum.
const HEADER_LEN: usize = 6;

/// Remembers where the record is. Without it, each lookup computes a checksum over every record of a
/// sector, and erasing a sector takes a lookup for each of its records.
type KeyCache = Cache<Uncached, Uncached, ArrayKeyPointers<u8, 1>, u8>;

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
        let record = self.read().await?;
        match &record[link_len(record)?..] {
            [] => Ok(None),
            config => decode(config).map(Some),
        }
    }

    async fn save(&mut self, config: &Config) -> Result<(), StoreError> {
        let mut record = [0; RECORD_LEN_MAX];
        let had_key = self.has_key;
        let at = match self.read().await {
            Ok(present) => {
                let at = link_len(present)?;
                record[..at].copy_from_slice(&present[..at]);
                at
            }
            Err(_) if had_key => return Err(StoreError::Write),
            Err(_) => 0,
        };
        let len = at + encode(config, &mut record[at..])?;
        let record = &record[..len];
        if self.put(record).await.is_ok() {
            return Ok(());
        }
        // Only where nothing can be read either is there nothing to lose by erasing.
        if self.has_key || self.load().await.is_ok() {
            return Err(StoreError::Write);
        }
        self.map.erase_all().await.map_err(|_| StoreError::Write)?;
        self.put(record).await
    }

    async fn link(&mut self, change: Option<Option<Key>>) -> Result<LinkRecord, StoreError> {
        let mut record = [0; RECORD_LEN_MAX];
        let present = self.read().await?;
        let at = link_len(present)?;
        let (mut count, mut key) = decode_link(&present[..at]).ok_or(StoreError::UnknownKey)?;
        key = change.unwrap_or(key);
        if key.is_none() && change.is_none() {
            return Ok(LinkRecord { key, count: None });
        }
        count += 1;
        let len = encode_link(count, key, &present[at..], &mut record).ok_or(StoreError::Write)?;
        self.has_key |= key.is_some();
        match self.put(&record[..len]).await {
            Err(error) if change.is_some() => Err(error),
            kept => Ok(LinkRecord { key, count: kept.ok().map(|()| count) }),
        }
    }
}

impl<F: NorFlash> FlashStore<F> {
    /// The newest record; empty if there never was one.
    async fn read(&mut self) -> Result<&[u8], StoreError> {
        match self.map.fetch_item::<&[u8]>(&mut self.buffer, &RECORD).await {
            Ok(record) => Ok(record.unwrap_or_default()),
            Err(_) => Err(StoreError::Damaged),
        }
    }

    /// Appends a record and reads it back.
    async fn put(&mut self, record: &[u8]) -> Result<(), StoreError> {
        let stored = self.map.store_item(&mut self.buffer, &RECORD, &record).await;
        stored.map_err(|_| StoreError::Write)?;
        match self.read().await {
            Ok(stored) if stored == record => Ok(()),
            _ => Err(StoreError::Write),
        }
    }
}

/// Length of what precedes the configuration in a record.
fn link_len(record: &[u8]) -> Result<usize, StoreError> {
    match record {
        [len, LINK_MARK, rest @ ..] if usize::from(*len) <= rest.len() => {
            Ok(MARK_LEN + usize::from(*len))
        }
        [_, LINK_MARK, ..] => Err(StoreError::UnknownKey),
        _ => Ok(0),
    }
}

/// Count and key, of what precedes the configuration.
fn decode_link(link: &[u8]) -> Option<(u64, Option<Key>)> {
    let Some((_, link)) = link.split_first_chunk::<MARK_LEN>() else { return Some((0, None)) };
    let (count, key) = link.split_first_chunk()?;
    let key = match key {
        [] => None,
        key => Some(Key::new(key.try_into().ok()?)),
    };
    Some((u64::from_le_bytes(*count), key))
}

/// A record of count, key, and a configuration as it was stored; returns the record's length.
fn encode_link(
    count: u64,
    key: Option<Key>,
    config: &[u8],
    record: &mut [u8; RECORD_LEN_MAX],
) -> Option<usize> {
    let key = key.as_ref().map_or(&[][..], |key| key.expose());
    let head = [(COUNT_LEN + key.len()) as u8, LINK_MARK];
    let mut len = 0;
    for part in [&head[..], &count.to_le_bytes(), key, config] {
        record.get_mut(len..len + part.len())?.copy_from_slice(part);
        len += part.len();
    }
    // `sequential-storage` needs room for its key in the same buffer.
    (len < RECORD_LEN_MAX).then_some(len)
}

/// Encodes a configuration as it is stored; returns its length.
fn encode(config: &Config, record: &mut [u8]) -> Result<usize, StoreError> {
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

/// Length of a number in a configuration.
const NUMBER: usize = size_of::<f64>();

/// Decodes a configuration of an older layout: each number that it lacks is inserted, the driver is appended, and the
/// feedforward becomes one in volts for each wheel and direction.
fn decode_older(body: &[u8], layout: u16) -> Option<Config> {
    const SURE: OdometryConfig = OdometryConfig::UNCALIBRATED;
    /// Since which layout there is a number, the numbers and flags before it, and its value: the pull,
    /// `feedforward.supply_v`, `limits.hold_s`, `protection.supply_v_max`, and those of `odometry`.
    const ADDED: [(u16, usize, usize, f64); 7] = [
        (3, 3, 0, 0.0),
        (4, 14, 4, 0.0),
        (5, 20, 4, 0.0),
        (4, 25, 4, 0.0),
        (8, 27, 4, SURE.noise_m_per_sqrt_m),
        (8, 28, 4, SURE.wheel_weight_sd),
        (8, 29, 4, SURE.track_width_sd_m),
    ];
    /// By so many numbers the feedforward of layout 7 is longer.
    const WIDER: usize = 5;
    /// The driver's PWM before layout 6 \[Hz\]; behind it two flags, the name and what it does at a fault, all 0.
    const PWM_HZ: f64 = 20_000.0;
    const DRIVER_CHOICES: usize = 4;
    let mut whole = [0; RECORD_LEN_MAX];
    whole.get_mut(..body.len())?.copy_from_slice(body);
    let mut len = body.len();
    // The name's length, in one byte, and the name.
    let name = 1 + usize::from(*body.first()?);
    let wider = if layout < 7 { 0 } else { WIDER };
    for (_, numbers, flags, value) in ADDED.into_iter().filter(|(since, ..)| layout < *since) {
        let at = name + (numbers + wider) * NUMBER + flags;
        if at > len || len + NUMBER > whole.len() {
            return None;
        }
        whole.copy_within(at..len, at + NUMBER);
        whole.get_mut(at..at + NUMBER)?.copy_from_slice(&f64::to_le_bytes(value));
        len += NUMBER;
    }
    if layout < 6 {
        let driver = whole.get_mut(len..len + NUMBER + DRIVER_CHOICES)?;
        driver.fill(0);
        driver[..NUMBER].copy_from_slice(&PWM_HZ.to_le_bytes());
        len += NUMBER + DRIVER_CHOICES;
    }
    if layout < 7 {
        widen_feedforward(&mut whole, &mut len, name)?;
    }
    Config::from_postcard(&whole[..len])
}

/// From ks, kv, ka as shares of the nominal supply, and that supply, to volts: kS+, kS-, kV, kA of the left wheel and of
/// the right one, and that supply.
fn widen_feedforward(whole: &mut [u8; RECORD_LEN_MAX], len: &mut usize, name: usize) -> Option<()> {
    /// Numbers and flags in front of it.
    const BEFORE: usize = 11 * NUMBER + 4;
    let at = name + BEFORE;
    let read = |number: usize| {
        let bytes = whole.get(at + number * NUMBER..)?.first_chunk()?;
        Some(f64::from_le_bytes(*bytes))
    };
    let [ks, kv, ka, supply_v] = [read(0)?, read(1)?, read(2)?, read(3)?];
    let nominal_v =
        if is_above(supply_v, 0.0) { supply_v } else { FeedforwardConfig::SUPPLY_V_UNKNOWN };
    let wheel = [ks, ks, kv, ka].map(|share| share * nominal_v);
    let added = (2 * wheel.len() - 3) * NUMBER;
    if at + 3 * NUMBER > *len || *len + added > whole.len() {
        return None;
    }
    whole.copy_within(at + 3 * NUMBER..*len, at + 3 * NUMBER + added);
    *len += added;
    for (place, volts) in whole[at..].chunks_exact_mut(NUMBER).zip(wheel.into_iter().chain(wheel)) {
        place.copy_from_slice(&volts.to_le_bytes());
    }
    Some(())
}

fn checksum(parts: &[&[u8]]) -> u32 {
    parts.iter().fold(Crc32::new(), |crc, part| crc.over(part)).value()
}
