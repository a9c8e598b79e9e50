//! Records a campaign: drives a plan of runs, one after the other, and has each of them measured.
//!
//! ```text
//! plan (built in, or a TOML file) -> for each run that is not there yet:
//!     put at its mark -> drive piece by piece -> measure -> rows -> runs/NN_name.csv, whole
//! ```
//!
//! A run is in the folder or it is not; so whatever ends a campaign early, the next call goes on with
//! the first run that is missing. The plan is of the crate `campaign`; [`record`] tells
//! whoever looks on how far it is, and [`crate::pose_source`] has it measured.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`piece`] | what the wheels do in a piece of a run |
//! | [`samples`] | telemetry and measured poses as rows of a file |
//! | [`clock`] | one clock for all runs, over interruptions |
//! | [`record`] | the procedure |

pub mod clock;
pub mod piece;
pub mod record;
pub mod samples;

pub use record::{
    Ran, RecordSettings, RecordStep, RecordedRun, Summary, record_campaign, record_run,
};
