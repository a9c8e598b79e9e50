//! Sentences: what `robot-model` finds, in words.
//!
//! The library gives verdicts and numbers; here they become sentences, for the terminal, the page and the JSON.
//!
//! | file | what it puts into words |
//! | --- | --- |
//! | `answer.rs` | what `explain` answers: the evidence for an effect, why one was rejected, the next run |
//! | `model.rs` | the verdict on an effect of a chosen model |
//! | `comparison.rs` | regimes, axes, and the main finding of a comparison |
//! | `calibration.rs` | what W_T's uncertainty is made of, and what would reduce it |

mod answer;
mod calibration;
mod comparison;
mod model;

pub use answer::{
    clocks, depends_on, expression, lacking, net_change, promise, reason, second_opinion, why,
    worth,
};
pub use calibration::{advice, out_and_back, source};
pub use comparison::{axis, finding, label, regime};
pub use model::verdict;

/// `a`, `a and b`, `a, b and c`.
pub(crate) fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// A probability with its name: `p = 0.03`, `p < 1e-99`; with three decimals below 0.01.
pub(crate) fn p_text(p: f64) -> String {
    match p {
        p if p >= 0.01 => format!("p = {p:.2}"),
        p if p >= 0.001 => format!("p = {p:.3}"),
        p if p > 1e-99 => format!("p = {p:.0e}"),
        _ => "p < 1e-99".to_owned(),
    }
}
