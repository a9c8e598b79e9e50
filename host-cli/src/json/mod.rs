//! What `robot-model` finds, as JSON: keys and shapes that other programs rely on.
//!
//! | file | what it shapes |
//! | --- | --- |
//! | `answer.rs` | what `explain` answers (schema 2, `docs/explain.schema.json`) |
//! | `comparison.rs` | what `compare` answers |

mod answer;
mod comparison;

pub use answer::{answer, data_hypothesis, errors, pair, parameters};
pub use comparison::{comparison, rms};
