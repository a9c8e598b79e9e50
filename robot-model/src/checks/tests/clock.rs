//! Is a clock in a smaller unit than seconds found?

use crate::checks::slow_clock;
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
