//! The blind benchmark: does `explain` find the effect that is hidden in a robot, and nothing in a sound one?
//!
//! The robots are recorded as a user would record them, explained without knowledge of what is hidden, and the answer
//! is compared with the truth. Half of them are of forces ([`sim_target`]), half of another plant ([`kinematic`]).
//!
//! ```text
//! seed -> case: which effect, how strong          (known to the verdict alone)
//!      -> robot: forces, firmware, camera         -> campaign, as `beeline campaign record` drives it
//!         or kinematics                           -> campaign of files and rows
//!      -> difficulty: data sheet, poses, clock           |-> explain(campaign)        -> answer
//!      truth ------------------------------------------------> compare(truth, answer)  -> verdict
//! ```
//!
//! | module | what it is |
//! | --- | --- |
//! | [`case`] | what is hidden, drawn by seed |
//! | [`hard`] | what makes a campaign as hard as the world |
//! | [`plant`] | a robot of either plant, recorded and made hard |
//! | [`robots`] | the robots of both plants |
//! | [`sim_target_robot`] | the robot of forces, recorded |
//! | [`kinematic`] | the second plant |
//! | [`hidden_effects`] | the effects that can be hidden, and their true parameters |
//! | [`strength`] | how strong an effect must be to stand out by so many sigma |
//! | [`benchmark_robot`] | a case with its robot: effects scaled, campaign recorded |
//! | [`noise_of_twins`] | how large is noise that a plant does not know? |
//! | [`verdict`] | the answer against the truth |
//! | [`score`] | many verdicts against the bars |
//! | [`mystery`] | one such campaign for a reader to solve, with its answer sealed |

pub mod benchmark_robot;
pub mod case;
pub mod hard;
pub mod hidden_effects;
pub mod kinematic;
pub mod mystery;
pub mod noise_of_twins;
pub mod plant;
pub mod robots;
pub mod score;
pub mod sim_target_robot;
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
