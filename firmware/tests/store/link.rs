//! The link's key and count: whatever happens to the power, the key is the old one or the new, and no count comes twice.

use embassy_futures::block_on;
use firmware::hal::{LinkRecord, Store, StoreError};
use firmware::store::FlashStore;
use shared_proto::Key;

use super::nor::{Nor, Torn};
use super::numbered::{load, numbered, save};

fn link(flash: Nor, change: Option<Option<Key>>) -> (Result<LinkRecord, StoreError>, Nor) {
    let mut store = FlashStore::new(flash);
    // As at power-on: what an interrupted erasure left is mended first.
    let _ = block_on(store.load());
    let record = block_on(store.link(change));
    (record, store.into_flash())
}

fn key(number: u32) -> Key {
    Key::new(std::array::from_fn(|i| number.to_le_bytes()[i % 4] ^ i as u8))
}

/// The same flash, of a robot with a key.
pub fn with_key(flash: Nor) -> Nor {
    link(flash, Some(Some(key(1)))).1
}

/// A start of a robot with a key, which counts it.
pub fn start(flash: Nor) -> Nor {
    link(flash, None).1
}

fn ways_to_tear(operation: u64) -> [Torn; 5] {
    let bits = Torn::Bits(operation);
    [Torn::Nothing, bits, Torn::Part(operation), Torn::Noise(operation), Torn::Zeros(operation)]
}

/// A flash with a configuration and a key after this many starts.
fn after_starts(starts: u32) -> Nor {
    let flash = save(Nor::blank(), &numbered(7)).1;
    let mut flash = with_key(flash);
    for _ in 0..starts {
        flash = link(Nor::holding(flash.bytes), None).1;
    }
    Nor::holding(flash.bytes)
}

#[test]
fn a_key_is_kept_beside_the_configuration_and_every_start_has_a_count_of_its_own() {
    let (nothing, flash) = link(Nor::blank(), None);
    assert_eq!(nothing, Ok(LinkRecord::default()));
    assert_eq!(flash.operations, 0, "without a key nothing is written");
    let mut flash = save(flash, &numbered(7)).1;
    flash = link(flash, Some(Some(key(1)))).1;
    // Long enough to fill every sector and begin again.
    let mut last = 0;
    for start in 0..4000 {
        let (record, after) = link(Nor::holding(flash.bytes), None);
        let record = record.expect("readable");
        assert_eq!(record.key, Some(key(1)), "start {start}");
        let count = record.count.expect("writable");
        assert!(count > last, "{count} after {last}");
        (last, flash) = (count, after);
    }
    assert_eq!(load(Nor::holding(flash.bytes.clone())).0, Ok(Some(numbered(7))));
    let (cleared, flash) = link(flash, Some(None));
    assert_eq!(cleared.expect("writable").key, None);
    let (record, flash) = link(flash, None);
    assert_eq!(record, Ok(LinkRecord::default()));
    // A key that is set again goes on counting.
    let (record, _) = link(flash, Some(Some(key(1))));
    assert!(record.expect("writable").count.expect("writable") > last);
}

#[test]
fn a_power_cut_at_any_operation_leaves_the_old_key_or_the_new_one_and_no_count_comes_again() {
    let erases = (0..).map(|n| n * 100).find(|&starts| {
        let flash = after_starts(starts);
        // Within the next hundred.
        let mut flash = Nor::holding(flash.bytes);
        for _ in 0..100 {
            let bytes = flash.bytes;
            flash = link(Nor::holding(bytes), None).1;
            if flash.erasures > 0 {
                return true;
            }
        }
        false
    });
    let first = erases.expect("a flash is full some time");
    let mut cases = 0;
    for starts in [0, 1].into_iter().chain(first..first + 100) {
        let flash = after_starts(starts);
        for change in [None, Some(Some(key(2))), Some(None)] {
            let (told, whole) = link(flash.clone(), change);
            if starts > 1 && whole.erasures == 0 {
                break;
            }
            let told = told.expect("writable").count;
            for operation in 0..whole.operations {
                for torn in ways_to_tear(operation) {
                    let cut = link(flash.clone().cut_at(operation, torn), change).1;
                    // What was cut has told no count.
                    let (record, after) = link(Nor::holding(cut.bytes), None);
                    let record = record.expect("readable");
                    let wanted = change.unwrap_or(Some(key(1)));
                    let known = record.key == Some(key(1)) || record.key == wanted;
                    assert!(known, "{starts} starts, {operation}, {torn:?}: {record:?}");
                    if record.key.is_some() {
                        assert!(record.count >= told, "{record:?}, {told:?}");
                    }
                    let config = load(Nor::holding(after.bytes)).0;
                    let kept = config == Ok(Some(numbered(7)));
                    assert!(kept, "{starts} starts, {change:?}, {operation}, {torn:?}: {config:?}");
                    cases += 1;
                }
            }
        }
    }
    println!("{cases} power cuts");
    assert!(cases > 100);
}

#[test]
fn a_power_cut_at_any_operation_of_a_save_leaves_the_key() {
    let mut flash = after_starts(1);
    let mut erasing = false;
    // It has number 7.
    for number in 8.. {
        let whole = save(flash.clone(), &numbered(number)).1;
        if number == 8 || whole.erasures > 0 {
            for operation in 0..whole.operations {
                for torn in ways_to_tear(operation) {
                    let cut = save(flash.clone().cut_at(operation, torn), &numbered(number)).1;
                    let (record, after) = link(Nor::holding(cut.bytes), None);
                    let record = record.expect("readable");
                    assert_eq!(record.key, Some(key(1)), "save {number}, {operation}, {torn:?}");
                    assert!(record.count > Some(1), "{record:?}");
                    let config = load(Nor::holding(after.bytes)).0.expect("readable");
                    let known = [number - 1, number].map(numbered);
                    assert!(known.map(Some).contains(&config), "save {number}, {operation}");
                }
            }
        }
        if std::mem::replace(&mut erasing, whole.erasures > 0) {
            break;
        }
        flash = Nor::holding(whole.bytes);
    }
}

#[test]
fn a_failed_save_does_not_erase_a_key() {
    let flash = after_starts(3);
    let mut store = FlashStore::new(flash.cut_at(0, Torn::Nothing));
    assert!(block_on(store.link(None)).expect("readable").count.is_none());
    assert_eq!(block_on(store.save(&numbered(8))), Err(StoreError::Write));
    let flash = Nor::holding(store.into_flash().bytes);
    assert_eq!(link(flash, None).0.expect("readable").key, Some(key(1)));
}
