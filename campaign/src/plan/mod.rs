//! Which runs a campaign is to drive, and the file that lists them.
//!
//! How they are driven is left to the program.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`default_plan`] | the campaign that tells all effects apart, on a given floor |
//! | [`run_kinds`] | single kinds of runs, by the names that `explain` suggests |
//! | `file`, `piece` | `plan.toml`, which people edit |
//! | [`floor`] | how much floor a run needs |

pub mod default_plan;
mod file;
pub mod floor;
mod piece;
pub mod run_kinds;

use std::fmt;

use robot_model::recording::Piece;

pub use default_plan::PlanSettings;
pub use file::plan_path;
pub use floor::Floor;

/// Standing still before and after each piece \[s\]: the robot settles, and its noise shows.
pub const PAUSE_S: f64 = 0.3;

/// Longest run \[s\]: an hour, so that a typing error does not drive the robot for a day.
const DURATION_S_MAX: f64 = 3600.0;

/// What to drive.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignPlan {
    /// Steepness of the ramps, of the faster wheel \[m/s^2\].
    pub acceleration_mps2: f64,
    /// The runs, in the order in which they are driven.
    pub runs: Vec<PlannedRun>,
}

/// One run, from rest to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedRun {
    /// Its name, which no other run of the plan has.
    pub name: String,
    /// What kind of run, as `explain` calls it.
    pub kind: String,
    /// Which way the robot faces at its start, from the campaign's x axis \[rad\].
    pub heading_rad: f64,
    /// What it carries \[kg\].
    pub payload_kg: f64,
    /// Held out: nothing is fitted to it.
    pub held_out: bool,
    /// What it is driven for.
    pub shows: String,
    /// Its motions, one after the other.
    pub pieces: Vec<Piece>,
}

/// Why runs cannot be planned.
#[derive(Clone, Debug, PartialEq)]
pub enum PlanError {
    /// Nothing can be driven on this floor.
    FloorTooSmall {
        /// The free floor \[m\].
        floor_m: [f64; 2],
        /// Distance between the wheels \[m\].
        track_width_m: f64,
        /// The least side of a square floor that will do \[m\].
        least_m: f64,
    },
    /// A run takes longer than the longest that is allowed.
    RunTooLong {
        /// Its name.
        run: String,
        /// How long it takes \[s\].
        duration_s: f64,
    },
    /// There is no such kind of run.
    UnknownKind(String),
    /// A run needs more floor than there is.
    RunTooLarge {
        /// Its kind.
        kind: String,
        /// The floor that it needs, the shorter side first \[m\].
        needed_m: [f64; 2],
        /// The free floor, the shorter side first \[m\].
        floor_m: [f64; 2],
    },
}

impl std::error::Error for PlanError {}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FloorTooSmall { floor_m, track_width_m, .. } => write!(
                f,
                "a floor of {} m by {} m is too small for a robot with a track of {} m",
                in_mm(floor_m[0]),
                in_mm(floor_m[1]),
                in_mm(*track_width_m)
            ),
            Self::RunTooLong { run, duration_s } => {
                write!(f, "the run {run} would take {duration_s:.0} s")
            }
            Self::UnknownKind(kind) => write!(f, "`{kind}` is not a kind of run"),
            Self::RunTooLarge { kind, needed_m, floor_m } => write!(
                f,
                "`{kind}` needs a floor of {} m by {} m, but only {} m by {} m are free",
                in_mm(needed_m[0]),
                in_mm(needed_m[1]),
                in_mm(floor_m[0]),
                in_mm(floor_m[1])
            ),
        }
    }
}

/// A length rounded to the millimetre \[m\]: the digits of a conversion, as of 37.2 cm, say nothing.
fn in_mm(length_m: f64) -> f64 {
    (length_m * 1e3).round() / 1e3
}

impl CampaignPlan {
    /// How long the runs take, without the time to place the robot at its marks \[s\].
    pub fn duration_s(&self, track_width_m: f64) -> f64 {
        self.runs.iter().map(|run| run.duration_s(track_width_m, self.acceleration_mps2)).sum()
    }

    /// Refuses a run that takes longer than an hour.
    pub fn check_durations(&self, track_width_m: f64) -> Result<(), PlanError> {
        for run in &self.runs {
            let duration_s = run.duration_s(track_width_m, self.acceleration_mps2);
            if duration_s > DURATION_S_MAX {
                return Err(PlanError::RunTooLong { run: run.name.clone(), duration_s });
            }
        }
        Ok(())
    }

    /// The floor that the whole plan needs if each run starts at the same mark, with its own
    /// heading.
    pub fn floor(&self, track_width_m: f64) -> Floor {
        let each = self.runs.iter().map(|run| Floor::of(&run.pieces, track_width_m));
        each.fold(Floor::default(), Floor::with)
    }
}

impl PlannedRun {
    /// How long it takes \[s\].
    pub fn duration_s(&self, track_width_m: f64, acceleration_mps2: f64) -> f64 {
        let each = self.pieces.iter().map(|piece| {
            let pauses_s = if matches!(piece, Piece::Rest { .. }) { 0.0 } else { 2.0 * PAUSE_S };
            pauses_s + piece.duration_s(track_width_m, acceleration_mps2)
        });
        each.sum()
    }
}
