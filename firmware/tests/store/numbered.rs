//! Configurations that can be told apart, saved and loaded.

use embassy_futures::block_on;
use firmware::hal::{Store, StoreError};
use firmware::store::FlashStore;
use shared_proto::{Config, Name};

use super::nor::Nor;

/// A configuration that can be told from all others by its number.
pub fn numbered(number: u32) -> Config {
    let mut config = Config { name: Name::new("numbered").unwrap(), ..Config::default() };
    // Every byte of the mantissa is in use: a word that is not written shows.
    config.geometry.wheel_weight = 1.0 + f64::from(number + 1) * 0.123_456_789e-6;
    config
}

/// What a store reads.
pub fn load(flash: Nor) -> (Result<Option<Config>, StoreError>, Nor) {
    let mut store = FlashStore::new(flash);
    let loaded = block_on(store.load());
    (loaded, store.into_flash())
}

/// Saves a configuration.
pub fn save(flash: Nor, config: &Config) -> (Result<(), StoreError>, Nor) {
    let mut store = FlashStore::new(flash);
    let saved = block_on(store.save(config));
    (saved, store.into_flash())
}
