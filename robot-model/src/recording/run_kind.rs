//! What kind of run was driven? Straight, spin, arc, square and others, told by the motion.

use serde::{Deserialize, Serialize};

use crate::recording::motion::Motion;
use crate::recording::run::{Recording, RecordingError, Robot};

/// Kinds of runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum RunKind {
    /// Hardly moved.
    Rest,
    /// Straight, one way.
    Straight,
    /// Straight, there and back.
    OutAndBack,
    /// On the spot.
    Spin,
    /// One curve.
    Arc,
    /// Straights with turns between.
    Square,
    /// Anything else.
    Mixed,
}

impl RunKind {
    /// The kind of a recording.
    pub fn of(robot: &Robot, recording: &Recording) -> Result<Self, RecordingError> {
        recording.validate()?;
        Ok(kind_of(&Motion::new(robot, recording, None)))
    }

    /// Its stable name, as in files and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            RunKind::Rest => "rest",
            RunKind::Straight => "straight",
            RunKind::OutAndBack => "out-and-back",
            RunKind::Spin => "spin",
            RunKind::Arc => "arc",
            RunKind::Square => "square",
            RunKind::Mixed => "mixed",
        }
    }
}

/// Curvature below which a step counts as straight \[1/m\]: a radius of 3 m.
const STRAIGHT_CURVATURE_PER_M: f64 = 0.33;
/// Curvature above which a step counts as turning on the spot \[1/m\]: a radius of 5 cm.
const SPIN_CURVATURE_PER_M: f64 = 20.0;

/// The kind of a run.
pub(crate) fn kind_of(motion: &Motion) -> RunKind {
    // Rolling of the rim, by what the robot did: straight, in a curve, on the spot.
    let (mut straight_m, mut curve_m, mut spin_m) = (0.0, 0.0, 0.0);
    let (mut ahead_m, mut back_m, mut left_rad, mut right_rad) = (0.0_f64, 0.0_f64, 0.0, 0.0);
    for step in &motion.steps {
        let rolled_m = step.wheel_travel_m().map(f64::abs).mean();
        let (speed, rate) = (step.speed_mps().abs(), step.turn_rate_rad_s().abs());
        if rate <= STRAIGHT_CURVATURE_PER_M * speed {
            straight_m += rolled_m;
        } else if rate >= SPIN_CURVATURE_PER_M * speed {
            spin_m += rolled_m;
        } else {
            curve_m += rolled_m;
        }
        ahead_m += step.travel_m().max(0.0);
        back_m += (-step.travel_m()).max(0.0);
        left_rad += step.turn_rad().max(0.0);
        right_rad += (-step.turn_rad()).max(0.0);
    }
    let rolled_m = straight_m + curve_m + spin_m;
    let turned_rad = left_rad.max(right_rad);
    if rolled_m < 0.02 {
        RunKind::Rest
    } else if spin_m > 0.8 * rolled_m {
        RunKind::Spin
    } else if straight_m > 0.8 * rolled_m && turned_rad < 0.7 {
        if ahead_m.min(back_m) > 0.2 * ahead_m.max(back_m) {
            RunKind::OutAndBack
        } else {
            RunKind::Straight
        }
    } else if curve_m > 0.8 * rolled_m && left_rad.min(right_rad) < 0.1 * turned_rad {
        RunKind::Arc
    } else if straight_m > 0.3 * rolled_m && turned_rad > 1.2 {
        RunKind::Square
    } else {
        RunKind::Mixed
    }
}
