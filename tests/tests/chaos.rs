//! Sessions in a storm, each held to one list of invariants; and each invariant breaks where a fault is planted for it.
//! Thousands of them: `cargo xtask bench chaos`.

use beeline_tests::chaos::{Invariant, Plant, SESSIONS_EACH, robots, run_robot};
use beeline_tests::parallel::in_order;

#[test]
fn whatever_fails_in_a_hundred_and_twenty_sessions_the_invariants_hold() {
    let outcomes = in_order(&robots(16, 120), |robot| {
        let outcome = run_robot(*robot, SESSIONS_EACH, None);
        (*robot, outcome.broken, outcome.done)
    });
    for (robot, broken, _) in &outcomes {
        assert!(broken.is_empty(), "`cargo xtask bench chaos`, robot {robot}: {broken:#?}");
    }
    // A storm in which nobody gets anything done would show nothing, and neither would fine weather.
    for index in 0..outcomes[0].2.named().len() {
        let (name, count) = outcomes[0].2.named()[index];
        let all: u32 = outcomes.iter().map(|(.., done)| done.named()[index].1).sum();
        println!("{name}: {all}");
        assert!(all >= 10, "{name}: {all}, of robot one {count}");
    }
}

#[test]
fn the_same_seed_gives_the_same_sessions_and_another_one_others() {
    let [a, b, c] = [5, 5, 6].map(|seed| run_robot(seed, 3, None).fingerprint);
    assert_eq!(a, b);
    assert_ne!(a, c);
}

#[test]
fn each_invariant_breaks_where_a_fault_is_planted_for_it() {
    let plants = [
        (Plant::ServerThatRenews, Invariant::MovesOnlyUnderALease),
        (Plant::DriveObeyedThrice, Invariant::NothingIsObeyedTwice),
        (Plant::LimitsThatAreLifted, Invariant::SpeedsAreKept),
        (Plant::StopThatIsLost, Invariant::EmergencyStopStops),
        (Plant::ConfigThatIsForgotten, Invariant::StoredConfigIsOldOrNew),
        (Plant::KeyThatIsForgotten, Invariant::StoredKeyIsOldOrNew),
        (Plant::CountThatIsForgotten, Invariant::NoChallengeComesAgain),
        (Plant::ServerThatHoards, Invariant::QueuesAreBounded),
        (Plant::FileThatIsCutShort, Invariant::RunsAreWhole),
        (Plant::LineThatStaysCut, Invariant::TheSessionResumes),
    ];
    assert_eq!(plants.map(|(_, invariant)| invariant), Invariant::ALL);
    // Each kind of motion, by what bounds it.
    let motions = [
        (Plant::VelocityThatGoesOn, Invariant::MovesOnlyUnderALease),
        (Plant::VoltageThatGoesOn, Invariant::NothingIsObeyedTwice),
    ];
    let plants = [&plants[..], &motions].concat();
    let found = in_order(&plants, |(plant, invariant)| {
        let caught = robots(17, 400).into_iter().enumerate().find_map(|(number, robot)| {
            let broken = run_robot(robot, SESSIONS_EACH, Some(*plant)).broken;
            let caught = broken.into_iter().find(|(_, found)| found.invariant == *invariant);
            caught.map(|(session, found)| format!("robot {number}, session {session}: {found}"))
        });
        (*plant, caught)
    });
    for (plant, caught) in &found {
        println!("{plant:?}: {}", caught.as_deref().unwrap_or("not caught"));
    }
    assert!(found.iter().all(|(_, caught)| caught.is_some()), "{found:?}");
}
