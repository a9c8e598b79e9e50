//! What may residuals depend on? The names only; the functions of each are in `auxiliary_effects.rs`.

use serde::{Deserialize, Serialize};

/// A quantity that residuals may depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Regressor {
    /// The angle of a wheel, or a multiple of it.
    WheelAngle,
    /// The heading.
    Heading,
    /// Speed of the midpoint between the wheels.
    Speed,
    /// Speed of a wheel.
    WheelSpeed,
    /// Acceleration of a wheel.
    Acceleration,
    /// Turn rate.
    TurnRate,
    /// Forward or backward.
    TravelDirection,
    /// Time since the run began.
    TimeInRun,
    /// Time since the campaign began.
    TimeInCampaign,
    /// Distance since the last reversal of travel.
    SinceReversal,
    /// Place on the floor.
    Place,
    /// Load on board.
    Load,
    /// The run itself.
    Run,
}

impl Regressor {
    /// Its stable name, as in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::WheelAngle => "wheel angle",
            Self::Heading => "heading",
            Self::Speed => "speed",
            Self::WheelSpeed => "wheel speed",
            Self::Acceleration => "acceleration",
            Self::TurnRate => "turn rate",
            Self::TravelDirection => "direction of travel",
            Self::TimeInRun => "time in the run",
            Self::TimeInCampaign => "time in the campaign",
            Self::SinceReversal => "distance since reversal",
            Self::Place => "place",
            Self::Load => "load",
            Self::Run => "run",
        }
    }

    /// Whether it changes from run to run and hardly within a run.
    pub(crate) const fn is_of_runs(self) -> bool {
        matches!(self, Self::Load | Self::TimeInCampaign)
    }
}
