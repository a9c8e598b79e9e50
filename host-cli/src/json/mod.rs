//! What `robot-model` finds, as JSON: keys and shapes that other programs rely on.
//!
//! | file | what it shapes |
//! | --- | --- |
//! | `answer.rs` | what `explain` answers (schema 2, `docs/explain.schema.json`) |
//! | `comparison.rs` | what `compare` answers |
//! | `motors.rs` | what both answer with `--drivetrain` |

mod answer;
mod comparison;
mod motors;

pub use answer::{answer, data_hypothesis, errors, pair, parameters};
pub use comparison::{comparison, rms};
pub use motors::{motor_answer, motor_comparison};
