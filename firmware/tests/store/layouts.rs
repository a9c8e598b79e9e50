//! Records of every layout that ever was, as bytes that never change.

use firmware::hal::StoreError;
use shared_proto::{
    AtFault, Config, Driver, DriverConfig, FeedforwardConfig, OdometryConfig, WheelFeedforward,
};

use super::nor::{Nor, SECTOR_LEN, SECTORS};
use super::numbered::{load, numbered, save};

/// What an image that wrote layout 1 left in its flash: a mark, an item's header, the record.
const LAYOUT_1: &[u8] = include_bytes!("layout_1.bin");

/// The same configuration in layout 2.
const LAYOUT_2: &[u8] = include_bytes!("layout_2.bin");

/// With a pull, in layout 3.
const LAYOUT_3: &[u8] = include_bytes!("layout_3.bin");

/// With a nominal and a highest supply, in layout 4.
const LAYOUT_4: &[u8] = include_bytes!("layout_4.bin");

/// With a hold, in layout 5.
const LAYOUT_5: &[u8] = include_bytes!("layout_5.bin");

/// With a driver, in layout 6.
const LAYOUT_6: &[u8] = include_bytes!("layout_6.bin");

/// With a feedforward for each wheel and direction, in layout 7.
const LAYOUT_7: &[u8] = include_bytes!("layout_7.bin");

/// With how sure the odometry is, in layout 8.
const LAYOUT_8: &[u8] = include_bytes!("layout_8.bin");

/// Where the record begins: behind the sector's mark, the item's header and its key.
const RECORD: usize = 13;

fn flash(content: &[u8]) -> Nor {
    let mut bytes = vec![0xFF; SECTORS * SECTOR_LEN];
    bytes[..content.len()].copy_from_slice(content);
    Nor::holding(bytes)
}

/// The configuration of the first three.
fn stored(heading_pull_rad_per_m: f64) -> Config {
    let mut config = numbered(7);
    config.limits.hold_s = 0.0;
    config.geometry.heading_pull_rad_per_m = heading_pull_rad_per_m;
    (config.feedforward.supply_v, config.protection.supply_v_max) = (0.0, 0.0);
    config
}

/// That of layout 4.
fn with_supply() -> Config {
    let mut config = stored(-0.0125);
    // What was stored are shares of the nominal supply: 0.04, 2 s/m and 0.064 s^2/m.
    let wheel = WheelFeedforward {
        ks_forward_v: 0.04 * 12.6,
        ks_backward_v: 0.04 * 12.6,
        kv_v_s_per_m: 2.0 * 12.6,
        ka_v_s2_per_m: 0.064 * 12.6,
    };
    config.feedforward = FeedforwardConfig { left: wheel, right: wheel, supply_v: 12.6 };
    config.protection.supply_v_max = 16.8;
    config
}

/// That of layout 5.
fn with_hold() -> Config {
    let mut config = with_supply();
    config.limits.hold_s = 2.5;
    config
}

/// That of layout 6.
fn with_driver() -> Config {
    let driver = DriverConfig {
        pwm_hz: 16_000.0,
        enable_inverted: true,
        fault_inverted: false,
        name: Driver::Drv8833,
        at_fault: AtFault::Brake,
    };
    Config { driver, ..with_hold() }
}

/// That of layout 7.
fn with_each_wheel() -> Config {
    let mut config = with_driver();
    let FeedforwardConfig { left, right, .. } = &mut config.feedforward;
    (left.ks_backward_v, left.ka_v_s2_per_m) = (0.625, 1.5);
    (right.ks_forward_v, right.kv_v_s_per_m) = (0.375, 26.5);
    config
}

/// That of the newest.
fn newest() -> Config {
    let odometry = OdometryConfig {
        noise_m_per_sqrt_m: 0.000_75,
        wheel_weight_sd: 0.000_25,
        track_width_sd_m: 0.001_5,
    };
    Config { odometry, ..with_each_wheel() }
}

#[test]
fn a_store_of_an_older_layout_is_read_without_what_it_lacks_and_the_next_save_makes_layout_8_of_it()
{
    for (old, config) in [
        (LAYOUT_1, stored(0.0)),
        (LAYOUT_2, stored(0.0)),
        (LAYOUT_3, stored(-0.0125)),
        (LAYOUT_4, with_supply()),
        (LAYOUT_5, with_hold()),
        (LAYOUT_6, with_driver()),
        (LAYOUT_7, with_each_wheel()),
    ] {
        let (loaded, flash) = load(flash(old));
        assert_eq!(loaded, Ok(Some(config)), "every value is kept");
        assert_eq!(flash.operations, 0, "reading writes nothing");

        let (saved, flash) = save(Nor::holding(flash.bytes), &newest());
        assert_eq!(saved, Ok(()));
        let (again, flash) = load(Nor::holding(flash.bytes));
        assert_eq!(again, Ok(Some(newest())));
        // The old record is as it was; behind it stands one in layout 8.
        assert_eq!(&flash.bytes[..old.len()], old);
        let header = &flash.bytes[old.len() + RECORD - 4..];
        assert_eq!(header[..2], 8_u16.to_le_bytes());
    }
}

#[test]
fn a_configuration_of_another_shape_needs_a_new_layout() {
    assert_eq!(load(flash(LAYOUT_8)).0, Ok(Some(newest())));
    let (_, flash) = save(Nor::blank(), &newest());
    let (written, beyond) = flash.bytes.split_at(LAYOUT_8.len());
    let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    assert_eq!(
        hex(written),
        hex(LAYOUT_8),
        "raise `store::LAYOUT`, convert the old one in `decode`, and add a record of the new layout here (`xxd -r -p` makes one of these digits)"
    );
    assert!(beyond[..64].iter().all(|byte| *byte == 0xFF), "and no more");
}

#[test]
fn a_record_of_an_unknown_layout_and_a_damaged_one_are_damage() {
    for layout in [LAYOUT_1, LAYOUT_2, LAYOUT_3, LAYOUT_4, LAYOUT_5, LAYOUT_6, LAYOUT_7, LAYOUT_8] {
        let record = &layout[RECORD..];
        // Damage that the library's own checksum would find is put right there: it is ours that is tried.
        for at in [0, 2, 6, 100] {
            let mut record = record.to_vec();
            record[at] ^= 4;
            assert_eq!(load(holding_record(&record)).0, Err(StoreError::Damaged), "byte {at}");
        }
    }
    // What an older firmware wrote and no firmware can have: a name beyond the record's end.
    let mut record = LAYOUT_2[RECORD..].to_vec();
    record[6] = 0xF0;
    let sum = shared_proto::Crc32::new().over(&record[..2]).over(&record[6..]).value();
    record[2..6].copy_from_slice(&sum.to_le_bytes());
    assert_eq!(load(holding_record(&record)).0, Err(StoreError::Damaged));
}

/// A flash with a record that the library finds nothing wrong with.
fn holding_record(record: &[u8]) -> Nor {
    use sequential_storage::cache::Cache;
    use sequential_storage::map::{MapConfig, MapStorage};
    let range = MapConfig::new(0..(SECTORS * SECTOR_LEN) as u32);
    let mut map = MapStorage::<u8, _, _>::new(Nor::blank(), range, Cache::new_uncached());
    let mut buffer = [0; 512];
    embassy_futures::block_on(map.store_item(&mut buffer, &1, &record)).expect("it is stored");
    Nor::holding(map.destroy().0.bytes)
}

#[test]
fn a_store_full_of_noise_boots_and_takes_a_configuration() {
    use rand::{Rng, SeedableRng};
    for seed in 0..20 {
        let mut noise = vec![0; SECTORS * SECTOR_LEN];
        rand_chacha::ChaCha8Rng::seed_from_u64(seed).fill_bytes(&mut noise);
        let (loaded, flash) = load(Nor::holding(noise));
        assert!(matches!(loaded, Ok(None) | Err(StoreError::Damaged)), "seed {seed}: {loaded:?}");
        let (saved, flash) = save(Nor::holding(flash.bytes), &numbered(1));
        assert_eq!(saved, Ok(()), "seed {seed}");
        assert_eq!(load(Nor::holding(flash.bytes)).0, Ok(Some(numbered(1))), "seed {seed}");
    }
}
