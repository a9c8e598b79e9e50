//! Records a campaign: drives a plan of runs, one after the other, and has each of them measured.
//!
//! ```text
//! plan (built in, or a TOML file) -> for each run that is not there yet:
//!     put at its mark -> drive piece by piece -> measure -> rows -> runs/NN_name.csv, whole
//! ```
//!
//! A run is in the folder or it is not; so whatever ends a campaign early, the next call goes on with
//! the first run that is missing. Nothing here prints: [`record`] tells whoever looks on.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`plan`] | the runs of a campaign |
//! | [`plan_file`] | the same as a file that people edit |
//! | [`extra`] | single kinds of runs, by the names that `explain` suggests |
//! | [`piece`] | what the wheels do in a piece of a run |
//! | [`floor`] | how much room a run takes |
//! | [`witness`] | who measures the robot, and puts it at its mark |
//! | [`person`] | a person with a tape measure |
//! | [`samples`] | telemetry and measured poses as rows of a file |
//! | [`align`] | a tracker's clock brought to the robot's |
//! | [`gyro_log`] | a yaw rate sensor's log, its clock brought to the robot's |
//! | [`clock`] | one clock for all runs, over interruptions |
//! | [`record`] | the procedure |

pub mod align;
pub mod clock;
pub mod extra;
pub mod floor;
pub mod gyro_log;
pub mod person;
pub mod piece;
pub mod plan;
pub mod plan_file;
pub mod record;
pub mod samples;
pub mod witness;

pub use floor::Floor;
pub use gyro_log::GyroLog;
pub use person::{Person, Sigma};
pub use plan::{Plan, PlanSettings, PlannedRun};
pub use record::{Ran, RecordSettings, RecordedRun, Step, Summary, record_campaign, record_run};
pub use witness::Witness;
