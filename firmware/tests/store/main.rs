//! The store: whatever happens to the power, it reads the old configuration or the new one.

mod layouts;
mod link;
mod nor;
mod numbered;
mod power_cut;

use nor::Nor;
use numbered::{load, numbered, save};
use shared_proto::Config;

#[test]
fn what_was_saved_is_read_back_and_a_blank_store_holds_nothing() {
    let (nothing, flash) = load(Nor::blank());
    assert_eq!(nothing, Ok(None));
    let mut flash = flash;
    // Long enough to fill every sector and begin again.
    for number in 0..400 {
        let (saved, after) = save(flash, &numbered(number));
        assert_eq!(saved, Ok(()), "save {number}");
        let (loaded, after) = load(after);
        assert_eq!(loaded, Ok(Some(numbered(number))));
        flash = after;
    }
    drop(flash);
}

/// How many writes there are from one erasure to the next, once the flash has filled.
fn writes_per_erasure(mut flash: Nor, write: fn(Nor) -> Nor) -> u32 {
    let mut writes_to_the_next = || {
        let before = flash.erasures;
        let mut writes = 0;
        while flash.erasures == before {
            flash = write(std::mem::replace(&mut flash, Nor::holding(Vec::new())));
            writes += 1;
        }
        writes
    };
    (0..2 * nor::SECTORS).for_each(|_| _ = writes_to_the_next());
    writes_to_the_next()
}

/// docs/safety.md and the pages of the boards with one flash bank say so.
#[test]
fn a_sector_takes_fifty_two_saves_or_forty_eight_starts_with_a_key() {
    let saved = save(Nor::blank(), &Config::default()).1;
    let saves = writes_per_erasure(saved.clone(), |flash| save(flash, &Config::default()).1);
    let starts = writes_per_erasure(link::with_key(saved), link::start);
    assert_eq!((saves, starts), (52, 48));
}
