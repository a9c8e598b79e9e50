//! The blind benchmark: does `explain` find the effect that is hidden in a robot, and nothing in a sound one?
//!
//! The robots are recorded as a user would record them, explained without knowledge of what is hidden, and the answer
//! is compared with the truth.
//!
//! ```text
//! seed -> case: which effect, how strong          (known to the verdict alone)
//!      -> robot of forces, firmware, camera       -> campaign, as `beeline campaign record` drives it
//!                                                       |-> explain(campaign)        -> answer
//!      truth ------------------------------------------------> compare(truth, answer)  -> verdict
//! ```
//!
//! | module | what it is |
//! | --- | --- |
//! | [`case`] | what is hidden, drawn by seed |
//! | [`field`] | the robot, recorded |
//! | [`hide`] | the effects that can be hidden, and their true parameters |
//! | [`strength`] | how strong an effect must be to stand out by so many sigma |
//! | [`verdict`] | the answer against the truth |
//! | [`score`] | many verdicts against the bars |
//! | [`mystery`] | one such campaign for a reader to solve, with its answer sealed |

pub mod case;
pub mod field;
pub mod hide;
pub mod mystery;
pub mod score;
pub mod strength;
pub mod verdict;

use crate::parallel::in_order;
use case::Case;
use verdict::{Verdict, verdict_on};

/// The verdicts on these cases, on all cores; `seen` is called for each as it is done.
pub fn verdicts_on(
    cases: &[Case],
    seen: &(dyn Fn(usize, &Result<Verdict, String>) + Sync),
) -> Vec<Result<Verdict, String>> {
    let indices: Vec<usize> = (0..cases.len()).collect();
    in_order(&indices, |index| {
        let result = verdict_on(&cases[*index]);
        seen(*index, &result);
        result
    })
}
