//! What `robot-model` finds, as JSON: keys and shapes that other programs rely on.
//!
//! | file | what it shapes |
//! | --- | --- |
//! | `answer.rs` | what `explain` answers (schema 2, `docs/explain.schema.json`) |
//! | `comparison.rs` | what `compare` answers |
//! | `fleet.rs` | what many robots say about one parameter |
//! | `model.rs` | a model that was fitted |
//! | `motors.rs` | what both answer with `--drivetrain` |

mod answer;
mod comparison;
mod fleet;
mod model;
mod motors;

pub use answer::{answer, data_hypotheses, errors, pair, parameters, steps};
pub use comparison::{compared, comparison, rms};
pub use fleet::judgement;
pub use model::{effects, fitted, held_out};
pub use motors::{chosen_effects, motor_answer, motor_comparison, motor_errors, motor_estimates};
