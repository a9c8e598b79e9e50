//! The power goes before and in flash operations of a save, on the flashed image.
//!
//! A save's operations, each erasure and each programmed word, are noted one by one in a first life, in which the flash
//! is blank or nearly full. In a second one the board is switched on with what the flash held before some of
//! them, and with an erasure and its neighbours half done. The store's own tests (`firmware/tests/store/`) try many more ways to
//! tear an operation, on the same code.

use std::collections::VecDeque;

use emulated_board::{Bench, Emulation, Flash, Operation, blank};
use firmware::hal::Store;
use firmware::store::FlashStore;
use futures_lite::future;
use nor::Nor;
use shared_proto::{Config, ConfigOrigin, Name};

use super::nor;
use super::robot::Robot;
use super::{emulation, uneventful};

/// A configuration that can be told from all others by its number.
fn numbered(number: u32) -> Config {
    let mut config = Config { name: Name::new("numbered").unwrap(), ..Config::default() };
    config.geometry.wheel_weight = 1.0 + f64::from(number + 1) * 0.123_456_789e-6;
    config
}

/// A flash in which the firmware's store has saved so often that one of the next [`LAST`] saves erases; and how often
/// that is. A board may save once a second, so the emulator is spared the minutes before.
fn nearly_full() -> (u32, Flash) {
    let mut flash = Nor::blank();
    let mut before = VecDeque::from([flash.bytes.clone()]);
    for number in 0.. {
        let mut store = FlashStore::new(flash);
        future::block_on(store.save(&numbered(number))).unwrap();
        flash = store.into_flash();
        if flash.erasures > 0 {
            return (number + 1 - before.len() as u32, before[0].clone());
        }
        before.push_back(flash.bytes.clone());
        if before.len() > LAST as usize {
            before.pop_front();
        }
    }
    unreachable!("a flash is full at last")
}

/// So many saves are made on the emulated board.
const LAST: u32 = 3;

/// What is done to a flash by each of the board's next saves.
fn saves(first: u32, flash: &Flash) -> Vec<Vec<Operation>> {
    let ended = Emulation { flash: Some(flash.clone()), ..emulation() }
        .run(move |bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            let (mut ends, mut longest_us) = (Vec::new(), 0);
            for number in first..first + LAST {
                robot.0.session.write_config(&numbered(number)).await.unwrap();
                let begin_us = sim_target::now_us();
                robot.0.session.save_config().await.unwrap();
                longest_us = longest_us.max(sim_target::now_us() - begin_us);
                robot.listen(1).await;
                ends.push(robot.0.monitor.flash_operations() as usize);
            }
            (ends, longest_us)
        })
        .unwrap();
    uneventful(&ended);
    let (ends, longest_us) = &ended.found;
    println!(
        "the longest of saves {first} to {}: {:.0} ms",
        first + LAST,
        *longest_us as f64 * 1e-3
    );
    assert_eq!(ends.last(), Some(&ended.flash_journal.len()));
    let starts = std::iter::once(0).chain(ends.clone());
    starts.zip(ends).map(|(start, &end)| ended.flash_journal[start..end].to_vec()).collect()
}

fn erases(save: &[Operation]) -> bool {
    save.iter().any(|operation| matches!(operation, Operation::Erase { .. }))
}

/// A case: what the flash holds, and what may be read from it.
struct Case {
    what: String,
    flash: Flash,
    allowed: [Option<u32>; 2],
}

/// Cases of one save, from what the flash held before it: the power goes before some operations; and before and in the
/// middle of an erasure, and of the operations beside it.
fn cases(number: u32, before: &Flash, save: &[Operation]) -> Vec<Case> {
    let mut flash = before.clone();
    let allowed = [number.checked_sub(1), Some(number)];
    let erasure = save.iter().position(|o| matches!(o, Operation::Erase { .. }));
    let step = if erasure.is_some() { 1 } else { 3 };
    let mut cases = Vec::new();
    for (index, &operation) in save.iter().enumerate() {
        let beside = |erasure: usize| index.abs_diff(erasure) <= BESIDE;
        if index % step == 0 {
            let what = format!("save {number}, before operation {index}");
            cases.push(Case { what, flash: flash.clone(), allowed });
        }
        let before = flash.clone();
        operation.apply(&mut flash);
        if erasure.is_some_and(beside) {
            let what = format!("save {number}, in operation {index}");
            cases.push(Case { what, flash: torn(&before, &flash, index), allowed });
        }
    }
    let what = format!("save {number}, after it");
    cases.push(Case { what, flash, allowed: [allowed[1]; 2] });
    cases
}

/// So many operations at either side of an erasure are cut short, too.
const BESIDE: usize = 2;

/// Cases of each of these saves.
fn cases_of(first: u32, flash: &Flash) -> (Vec<Case>, usize) {
    let (mut flash, mut all, mut longest) = (flash.clone(), Vec::new(), 0);
    let saves = saves(first, &flash);
    let last = saves.iter().position(|save| erases(save)).unwrap_or(saves.len() - 1);
    for (number, save) in (first..).zip(&saves[..=last]) {
        all.extend(cases(number, &flash, save));
        save.iter().for_each(|operation| operation.apply(&mut flash));
        longest = if erases(save) { save.len() } else { longest };
    }
    (all, longest)
}

/// Half done: of the bits that the operation changes, a half that looks drawn has changed.
fn torn(before: &Flash, after: &Flash, seed: usize) -> Flash {
    let mut noise = seed as u64 + 1;
    let half = |(&before, &after): (&u8, &u8)| {
        noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let mask = (noise >> 56) as u8;
        before & mask | after & !mask
    };
    before.iter().zip(after).map(half).collect()
}

/// Switches a board on with the flash of each case; the cases in which it finds what it may not.
fn wrong_boots(cases: Vec<Case>) -> Vec<String> {
    let ended = emulation().run(move |bench: Bench| async move {
        let mut robot = Robot::meet(bench).await;
        let mut wrong = Vec::new();
        for (number, case) in cases.into_iter().enumerate() {
            robot.0.monitor.power_cycle(case.flash);
            sim_target::sleep_until_us(sim_target::now_us() + 20_000).await;
            robot.meet_again(2 + number as u32).await;
            let identity = robot.0.session.identify().await.unwrap();
            let config = robot.0.session.read_config().await.unwrap();
            let found = (identity.config_origin == ConfigOrigin::Saved).then_some(config);
            let allowed = case.allowed.map(|number| number.map(numbered));
            if identity.store_damaged || !allowed.contains(&found) {
                wrong.push(format!("{}: {}", case.what, identity.store_damaged));
            }
        }
        wrong
    });
    ended.unwrap().found
}

#[test]
fn a_power_cut_in_a_save_leaves_the_old_or_the_new_configuration() {
    let (nearly, full) = nearly_full();
    // Every operation of a save that erases, and a third of those of others. Every one of every save is tried in the
    // store's own tests.
    let (mut cases, none) = cases_of(0, &blank());
    let (more, operations) = cases_of(nearly, &full);
    cases.extend(more);
    let count = cases.len();
    let wrong = wrong_boots(cases);
    assert!(wrong.is_empty(), "{} of {count}: {wrong:#?}", wrong.len());
    println!(
        "{count} power cuts, before and in operations of saves, before each of {operations} in the one that erases: old \
         or new configuration each time"
    );
    assert!(none == 0 && operations > 50);
}

#[test]
fn a_flash_without_power_keeps_what_it_held_before_the_operation() {
    // The sweep above takes the flash's content from the journal: here it is the array itself that loses
    // its power in the middle of a save, and the program that goes on without it.
    let whole = save_with(None);
    for operation in [0, 1, 17, 52] {
        let cut = save_with(Some(operation));
        let mut expected = blank();
        whole.flash_journal[..operation as usize].iter().for_each(|o| o.apply(&mut expected));
        assert!(cut.flash == expected, "before operation {operation}");
        assert!(!cut.found, "a save without power does not say that it is done");
    }
    assert!(whole.found);
}

fn save_with(cut_before: Option<u64>) -> emulated_board::RunResult<bool> {
    Emulation { cut_before, ..emulation() }
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            robot.0.session.write_config(&numbered(0)).await.unwrap();
            robot.0.session.save_config().await.is_ok()
        })
        .unwrap()
}
