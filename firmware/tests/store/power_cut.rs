//! Power cuts at every operation of a save: between two operations, and in the middle of one.

use super::nor::{Nor, Torn};
use super::numbered::{load, numbered, save};
use shared_proto::Config;

/// Ways to tear an operation; several draws of those that are drawn.
fn ways_to_tear() -> Vec<Torn> {
    let drawn = (0..4).flat_map(|seed| [Torn::Bits(seed), Torn::Part(seed), Torn::Noise(seed)]);
    [Torn::Nothing, Torn::Zeros(0)].into_iter().chain(drawn).collect()
}

/// A flash after this many saves, and what it holds.
fn after_saves(saves: u32) -> (Nor, Option<Config>) {
    let mut flash = Nor::blank();
    for number in 0..saves {
        let (saved, after) = save(Nor::holding(flash.bytes), &numbered(number));
        assert_eq!(saved, Ok(()));
        flash = after;
    }
    (Nor::holding(flash.bytes), saves.checked_sub(1).map(numbered))
}

/// How many saves come before the first one that erases, and before the first that goes on to another
/// sector.
fn turning_points() -> (u32, u32) {
    let mut flash = Nor::blank();
    let mut next_sector = None;
    for number in 0.. {
        let before = flash.bytes.clone();
        let (_, after) = save(Nor::holding(before.clone()), &numbered(number));
        let opened = |bytes: &[u8]| bytes[super::nor::SECTOR_LEN] != 0xFF;
        if !opened(&before) && opened(&after.bytes) {
            next_sector = Some(number);
        }
        if after.erasures > 0 {
            return (number, next_sector.expect("a sector is filled before one is erased"));
        }
        flash = after;
    }
    unreachable!("the flash is never full")
}

/// Cuts the power at every operation of the save that follows on `saves` others.
///
/// After each: the store reads the old or the new configuration, and takes the next one.
fn sweep(saves: u32) -> (u64, u64) {
    let (flash, old) = after_saves(saves);
    let new = numbered(saves);
    let (saved, whole) = save(flash.clone(), &new);
    assert_eq!(saved, Ok(()));
    let mut cases = 0;
    let mut wrong = Vec::new();
    for operation in 0..whole.operations {
        for torn in ways_to_tear() {
            let (failed, cut) = save(flash.clone().cut_at(operation, torn), &new);
            assert!(failed.is_err(), "the power was cut");
            if let Err(what) = survives(cut.bytes, old.as_ref(), &new, saves + 1) {
                wrong.push(format!("save {saves}, operation {operation}, {torn:?}: {what}"));
            }
            cases += 1;
        }
    }
    assert!(wrong.is_empty(), "{} of {cases}:\n{}", wrong.len(), wrong.join("\n"));
    (whole.operations, cases)
}

/// What a store must do with what a power cut has left: read, read the same again, and take the next.
fn survives(bytes: Vec<u8>, old: Option<&Config>, new: &Config, next: u32) -> Result<(), String> {
    let (loaded, flash) = load(Nor::holding(bytes));
    let loaded = loaded.map_err(|error| format!("reads {error:?}"))?;
    if loaded.as_ref() != old && loaded.as_ref() != Some(new) {
        return Err(format!("reads {}", if loaded.is_some() { "another one" } else { "nothing" }));
    }
    // Mending it at the first boot does not lose it.
    let (second, flash) = load(Nor::holding(flash.bytes));
    if second != Ok(loaded) {
        return Err("reads something else at the second boot".into());
    }
    let (saved, flash) = save(Nor::holding(flash.bytes), &numbered(next));
    saved.map_err(|error| format!("refuses the next save: {error:?}"))?;
    match load(Nor::holding(flash.bytes)).0 {
        Ok(Some(loaded)) if loaded == numbered(next) => Ok(()),
        _ => Err("does not read the next one".into()),
    }
}

#[test]
fn a_power_cut_at_any_operation_of_a_save_leaves_the_old_or_the_new_configuration() {
    let (erases, next_sector) = turning_points();
    for (what, saves) in [
        ("first save ever", 0),
        ("second save", 1),
        ("save that goes on to the next sector", next_sector),
        ("save that erases a sector", erases),
    ] {
        let (operations, cases) = sweep(saves);
        println!("{what}: {operations} operations, {cases} power cuts");
        assert!(operations > 50 && cases > 50);
    }
}

#[test]
fn a_second_power_cut_while_the_first_one_is_mended_leaves_the_old_or_the_new_configuration() {
    let (erases, _) = turning_points();
    let (flash, old) = after_saves(erases);
    let new = numbered(erases);
    let whole = save(flash.clone(), &new).1;
    let (mut cases, mut wrong) = (0, Vec::new());
    for operation in 0..whole.operations {
        for torn in ways_to_tear() {
            let cut = save(flash.clone().cut_at(operation, torn), &new).1;
            let mended = load(Nor::holding(cut.bytes.clone())).1.operations;
            for second in 0..mended {
                for torn_again in [Torn::Nothing, Torn::Bits(second), Torn::Noise(second)] {
                    let flash = Nor::holding(cut.bytes.clone()).cut_at(second, torn_again);
                    let flash = load(flash).1;
                    if let Err(what) = survives(flash.bytes, old.as_ref(), &new, erases + 1) {
                        wrong.push(format!("{operation}, {torn:?}, then {second}: {what}"));
                    }
                    cases += 1;
                }
            }
        }
    }
    println!("{cases} pairs of power cuts");
    assert!(cases > 20);
    assert!(wrong.is_empty(), "{} of {cases}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn after_a_power_cut_in_an_erasure_the_store_goes_on_for_a_whole_round_of_sectors() {
    let (erases, _) = turning_points();
    let (flash, old) = after_saves(erases);
    let new = numbered(erases);
    let whole = save(flash.clone(), &new).1;
    let erasure = (0..whole.operations)
        .find(|&operation| {
            save(flash.clone().cut_at(operation, Torn::Nothing), &new).1.erasures > 0
        })
        .expect("this save erases");
    for torn in ways_to_tear() {
        let mut flash = save(flash.clone().cut_at(erasure, torn), &new).1;
        let mut expected = load(Nor::holding(flash.bytes.clone())).0;
        assert!(expected == Ok(old.clone()) || expected == Ok(Some(new.clone())), "{torn:?}");
        for number in 0..erases {
            let (loaded, after) = load(Nor::holding(flash.bytes));
            assert_eq!(loaded, expected, "{torn:?}, {number} saves later");
            let next = numbered(erases + 1 + number);
            let (saved, after) = save(Nor::holding(after.bytes), &next);
            assert_eq!(saved, Ok(()), "{torn:?}, {number} saves later");
            (flash, expected) = (after, Ok(Some(next)));
        }
    }
}
