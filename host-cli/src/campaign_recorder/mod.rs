//! Records a campaign: drives the runs of a plan, one after the other, and has each of them
//! measured.
//!
//! ```text
//! plan (built in, or a TOML file) -> for each run that is not there yet:
//!     put at its mark -> drive piece by piece -> measure -> rows -> runs/NN_name.csv, whole
//! ```
//!
//! A run is in the folder whole or not at all, so after an interruption the next call goes on with
//! the first run that is missing. The plan comes from the crate `campaign`, and
//! [`crate::pose_source`] measures. [`record`] reports its progress to the caller, and prints
//! nothing itself; questions to a person are asked by the source.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`piece`] | the motion that drives a piece of a run |
//! | [`samples`] | telemetry and measured poses as rows of a file |
//! | [`clock`] | one clock for all runs, over interruptions |
//! | `resumed` | what a campaign that is continued takes from its folder |
//! | [`run`] | one run |
//! | [`record`] | the whole campaign |

pub mod clock;
pub mod piece;
pub mod record;
mod resumed;
pub mod run;
pub mod samples;

pub use record::{RecordSettings, RecordStep, Summary, record_campaign};
pub use run::{RecordedRun, RunOutcome, record_run};
pub use samples::{on_one_encoder, robot_file, seconds};
