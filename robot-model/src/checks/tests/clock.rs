//! Is a clock in a smaller unit than seconds found, and one that jumps?

use crate::checks::{clock_jump, slow_clock};
use crate::tests::synthetic::sound;

#[test]
fn a_clock_in_milliseconds_or_less_is_found_and_seconds_are_not() {
    for per_s in [1.0, 1e3, 1e6, 1e9] {
        for mut run in sound().runs.clone() {
            run.wheels.iter_mut().for_each(|sample| sample.t_s *= per_s);
            let found = slow_clock(&run).map(|found| found.per_s);
            assert_eq!(found, (per_s > 1.0).then_some(per_s), "{}", run.name);
        }
    }
}

#[test]
fn a_clock_that_jumps_while_wheels_turn_is_found_and_rows_that_are_missing_and_pauses_are_not() {
    for run in sound().runs.clone() {
        assert_eq!(clock_jump(&run), None, "{}", run.name);
        let moves = run.wheels.iter().position(|sample| sample.phi_rad.left.abs() > 3.0).unwrap();
        let at = moves.max(run.wheels.len() / 2);
        for jump_s in [2.0, 60.0, 1800.0, 1e9] {
            let mut jumped = run.clone();
            jumped.wheels[at..].iter_mut().for_each(|sample| sample.t_s += jump_s);
            let turns = jumped.wheels[at + 10].phi_rad.since(jumped.wheels[at - 10].phi_rad);
            let found = clock_jump(&jumped).map(|found| (found.t_s, found.jump_s.round()));
            // A robot that stands may have stood for longer.
            if jump_s > 3600.0 || turns.left.abs().max(turns.right.abs()) > 1.0 {
                assert_eq!(found, Some((jumped.wheels[at].t_s, jump_s)), "{}", run.name);
            }
        }
        let mut thinned = run.clone();
        thinned.wheels.drain(at - 5..(at + 300).min(run.wheels.len() - 12));
        assert_eq!(clock_jump(&thinned), None, "{}: rows are missing", run.name);
    }
}
