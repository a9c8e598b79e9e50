//! Random faults at random instants: whatever happens to the board, the motors are off in time, and the
//! robot says what it was.
//!
//! ```text
//! seed, index -> Case     robot, motion, instant, one or two faults                (draw)
//!             -> Observed what the pins did, and what the host was told            (script, run)
//!             -> Verdict  compared with what is promised for what happened         (promise, judge)
//! ```
//!
//! The pins tell when the motors were driven, the host's session what the fault is called. Then the cause is
//! removed and the fault cleared: the robot must drive a few centimetres again.

mod bound;
mod draw;
mod fault_injection;
mod fault_instant;
mod fault_kind;
mod friction;
mod judge;
mod observed;
mod other_gains;
mod promise;
mod run;
mod script;

pub use bound::{MotorsOff, Name};
pub use draw::{Case, Phase};
pub use fault_instant::Situation;
pub use fault_kind::FaultKind;
pub use judge::Verdict;
pub use observed::{Happened, Observed, Timeline};
pub use run::run;
