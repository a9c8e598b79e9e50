//! Sentences: what `robot-model` finds, in words.
//!
//! The library gives verdicts and numbers; here they become sentences, for the terminal, the page and the JSON.
//!
//! | file | what it puts into words |
//! | --- | --- |
//! | `answer.rs` | what `explain` answers: the evidence for an effect, why one was rejected, the next run |
//! | `clocks.rs` | clocks of poses and counts that do not agree |
//! | `heading_zeros.rs` | headings whose zero differs from run to run |
//! | `runs_off.rs` | runs that are off by far more than the others |
//! | `sudden.rs` | a robot that at once moved as its wheels did not |
//! | `model.rs` | the verdict on an effect of a chosen model |
//! | `comparison.rs` | regimes, axes, and the main finding of a comparison |
//! | `motors.rs` | what the motors lack |
//! | `calibration.rs` | what W_T's uncertainty is made of, and what would reduce it |
//! | `errors.rs` | why a calibration gives no W_T |

mod answer;
mod calibration;
mod clocks;
mod comparison;
mod errors;
mod heading_zeros;
mod model;
pub mod motors;
mod runs_off;
mod sudden;

pub use answer::{
    depends_on, driven_again, evidence, expression, lacking, net_change, predicted, reason,
    second_opinion, slight, worth,
};
pub use calibration::{advice, out_and_back, source};
pub use clocks::clocks;
pub use comparison::{axis, finding, label, regime};
pub use errors::{out_and_back_error, track_fit_error, wheel_weight_error};
pub use heading_zeros::heading_zeros;
pub use model::verdict;
pub use runs_off::{DriveAgain, drive_again, error_floor, runs_off, set_aside};
pub use sudden::sudden_motion;

/// `a`, `a and b`, `a, b and c`.
pub fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
