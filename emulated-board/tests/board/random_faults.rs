//! A subset of `cargo xtask bench faults`: random faults at random instants, on the flashed image.

use emulated_board::random_faults::{Case, run};

use super::image;

/// The bench's own default, so that a case that fails here is found there.
const SEED: u64 = 1;
/// What takes half a minute on two cores.
const CASES: u64 = 20;

#[test]
fn whatever_happens_at_any_instant_the_motors_are_off_in_time_and_it_has_a_true_name() {
    let halves = [0, 1].map(|half| (0..CASES).filter(move |index| index % 2 == half));
    let wrong = std::thread::scope(|scope| {
        let threads = halves.map(|indices| {
            scope.spawn(move || {
                let mut wrong = Vec::new();
                for case in indices.map(|index| Case::draw(SEED, index)) {
                    match run(&image(), &case) {
                        Ok(verdict) if verdict.wrong.is_empty() => {}
                        Ok(verdict) => {
                            wrong.push(format!("{}: {:?}", case.command(), verdict.wrong))
                        }
                        Err(error) => wrong.push(format!("{}: {error}", case.command())),
                    }
                }
                wrong
            })
        });
        threads.map(|thread| thread.join().expect("a board that ends")).concat()
    });
    assert!(wrong.is_empty(), "{} of {CASES}: {wrong:#?}", wrong.len());
    println!("{CASES} random faults, seed {SEED}: off in time, and called what they are");
}

#[test]
fn a_case_is_the_same_each_time_and_another_one_is_another() {
    let text = |seed, index| format!("{:?}", Case::draw(seed, index));
    assert_eq!(text(7, 3), text(7, 3));
    assert_ne!(text(7, 3), text(7, 4));
    assert_ne!(text(7, 3), text(8, 3));
    let case = Case::draw(SEED, 0);
    let verdicts = [(); 2].map(|()| format!("{:?}", run(&image(), &case)));
    assert_eq!(verdicts[0], verdicts[1]);
}
