//! Records of every layout that ever was, as bytes that never change.

use firmware::hal::StoreError;

use super::nor::{Nor, SECTOR_LEN, SECTORS};
use super::{load, numbered, save};

/// What an image that wrote layout 1 left in its flash: a mark, an item's header, the record.
const LAYOUT_1: &str = "00000000082a82f3cc0059fc010100d5943a83086e756d62657265643bdf4f8d976ea23f022b8716\
    d9ced73f67161f090100f03f0000000000208c40000000000000f03f000000000000208c40000000\
    000000f03f00000000000000000044400000000000004e40000000000000f03f7b14ae47e17aa43f\
    0000000000000040fca9f1d24d62b03f9a9999999999d93f000000000000f03f000000000000e03f\
    000000000000f03f00000000000034407b14ae47e17a943fb81e85eb51b8ae3f000000000000d03f\
    00000000000022409a9999999999c93f";

/// The same configuration in layout 2.
const LAYOUT_2: &str = "000000007f465eb1cc0059fc0102006ac5456b086e756d62657265643bdf4f8d976ea23f022b8716\
    d9ced73f67161f090100f03f0000000000208c40000000000000f03f000000000000208c40000000\
    000000f03f00000000000000000044400000000000004e40000000000000f03f7b14ae47e17aa43f\
    0000000000000040fca9f1d24d62b03f9a9999999999d93f000000000000f03f000000000000e03f\
    000000000000f03f00000000000034407b14ae47e17a943fb81e85eb51b8ae3f000000000000d03f\
    00000000000022409a9999999999c93f";

/// Where the record begins: behind the sector's mark, the item's header and its key.
const RECORD: usize = 13;

fn bytes(hex: &str) -> Vec<u8> {
    let digits: Vec<u8> = hex.bytes().filter(|digit| !digit.is_ascii_whitespace()).collect();
    let byte = |pair: &[u8]| {
        u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).expect("hexadecimal digits")
    };
    digits.chunks_exact(2).map(byte).collect()
}

fn flash(content: &[u8]) -> Nor {
    let mut bytes = vec![0xFF; SECTORS * SECTOR_LEN];
    bytes[..content.len()].copy_from_slice(content);
    Nor::holding(bytes)
}

#[test]
fn a_store_of_layout_1_is_read_and_the_next_save_makes_layout_2_of_it() {
    let old = bytes(LAYOUT_1);
    let (loaded, flash) = load(flash(&old));
    let config = loaded.expect("readable").expect("there is one");
    assert_eq!(config.name.as_str(), "numbered");
    assert_eq!(config.geometry.wheel_weight, numbered(7).geometry.wheel_weight);
    assert_eq!(flash.operations, 0, "reading writes nothing");

    let (saved, flash) = save(Nor::holding(flash.bytes), &config);
    assert_eq!(saved, Ok(()));
    let (again, flash) = load(Nor::holding(flash.bytes));
    assert_eq!(again, Ok(Some(config)));
    // The old record is as it was; behind it stands one with the same configuration in layout 2.
    assert_eq!(flash.bytes[..old.len()], old);
    let new = &flash.bytes[old.len()..];
    let (header, new) = new[RECORD - 4..].split_at(6);
    assert_eq!(header[..2], 2_u16.to_le_bytes());
    assert_eq!(new[..old.len() - RECORD - 6], old[RECORD + 6..], "every value is kept");
}

#[test]
fn a_configuration_of_another_shape_needs_a_new_layout() {
    let golden = bytes(LAYOUT_2);
    let config = load(flash(&golden)).0.expect("readable").expect("there is one");
    let (_, flash) = save(Nor::blank(), &config);
    assert_eq!(
        flash.bytes[..golden.len()],
        golden,
        "raise `store::LAYOUT`, keep the old type for `decode`, and add a record of the new layout here"
    );
}

#[test]
fn a_record_of_an_unknown_layout_and_a_damaged_one_are_damage() {
    for at in [RECORD, RECORD + 2, RECORD + 6, RECORD + 100] {
        // Damage that the library's own checksum would find is put right there: it is ours that is tried.
        let mut record = bytes(LAYOUT_2)[RECORD..].to_vec();
        record[at - RECORD] ^= 4;
        assert_eq!(load(holding_record(&record)).0, Err(StoreError::Damaged), "byte {at}");
    }
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
