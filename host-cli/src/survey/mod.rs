//! Records a campaign: drives a plan of runs, one after the other, and has each of them measured.
//!
//! ```text
//! plan (built in, or a TOML file) -> for each run that is not there yet:
//!     put at its mark -> drive piece by piece -> measure -> rows -> runs/NN_name.csv, whole
//! ```
//!
//! A run is in the folder or it is not; so whatever ends a campaign early, the next call goes on with
//! the first run that is missing. The plan is of the crate `campaign`; [`record`] tells
//! whoever looks on how far it is, and only who is to measure is asked in the terminal.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`piece`] | what the wheels do in a piece of a run |
//! | [`pose_source`] | who measures the robot, and puts it at its mark |
//! | [`tape`] | a person with a tape measure |
//! | [`measured`] | what a run comes to once somebody was asked to measure it |
//! | [`samples`] | telemetry and measured poses as rows of a file |
//! | [`align`] | a tracker's clock brought to the robot's |
//! | [`gyro_log`] | a yaw rate sensor's log, its clock brought to the robot's |
//! | [`clock`] | one clock for all runs, over interruptions |
//! | [`record`] | the procedure |

pub mod align;
pub mod clock;
pub mod gyro_log;
pub mod measured;
pub mod piece;
pub mod pose_source;
pub mod record;
pub mod samples;
pub mod tape;

pub use gyro_log::GyroLog;
pub use measured::Sigma;
pub use pose_source::Witness;
pub use record::{Ran, RecordSettings, RecordedRun, Step, Summary, record_campaign, record_run};
pub use tape::Person;
