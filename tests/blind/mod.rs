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
//! | [`mystery`] | one such campaign to try oneself, its answer sealed |

pub mod case;
pub mod field;
pub mod hide;
pub mod mystery;
pub mod score;
pub mod strength;
pub mod verdict;

use crate::parallel::in_order;
use case::Case;
use verdict::{Verdict, judge};

/// Judges cases on all cores; `seen` hears of each as it is done.
pub fn judge_all(
    cases: &[Case],
    seen: &(dyn Fn(usize, &Result<Verdict, String>) + Sync),
) -> Vec<Result<Verdict, String>> {
    let indices: Vec<usize> = (0..cases.len()).collect();
    in_order(&indices, |index| {
        let result = judge(&cases[*index]);
        seen(*index, &result);
        result
    })
}
