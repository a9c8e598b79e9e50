//! The blind benchmark: robots with a hidden effect, recorded as a user would, explained without being
//! told, and judged by the truth.
//!
//! ```text
//! seed -> case: which effect, how strong          (kept from everything but the judge)
//!      -> robot of forces, firmware, camera       -> campaign, as `beeline campaign record` drives it
//!                                                       |-> explain(campaign)        -> answer
//!      truth ------------------------------------------------> judge(truth, answer)  -> verdict
//! ```
//!
//! | module | what it is |
//! | --- | --- |
//! | [`case`] | what is hidden, drawn by seed |
//! | [`field`] | the robot recorded |
//! | [`strength`] | how strong an effect must be to stand out by so many sigma |
//! | [`verdict`] | the answer against the truth |
//! | [`score`] | many verdicts against the bars |

pub mod case;
pub mod field;
pub mod hide;
pub mod score;
pub mod strength;
pub mod verdict;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use case::Case;
use verdict::{Verdict, judge};

/// Judges cases on all cores; `seen` hears of each as it is done.
pub fn judge_all(
    cases: &[Case],
    seen: &(dyn Fn(usize, &Result<Verdict, String>) + Sync),
) -> Vec<Result<Verdict, String>> {
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let results: Vec<Mutex<Option<Result<Verdict, String>>>> =
        cases.iter().map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = cases.get(index) else { return };
                    let result = judge(case);
                    seen(index, &result);
                    *results[index].lock().expect("nobody panicked with it") = Some(result);
                }
            });
        }
    });
    let done = results.into_iter().map(|it| it.into_inner().expect("nobody panicked with it"));
    done.map(|it| it.expect("every case was judged")).collect()
}
