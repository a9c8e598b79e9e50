//! Why can a track not be fitted?

use core::fmt;

use crate::kinematics::geometry::GeometryError;

/// Why a track cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrackFitError {
    /// The nominal robot is unphysical.
    Geometry(GeometryError),
    /// Too few samples for the unknowns.
    TooFewSamples {
        /// How many there are within the time of the wheel angles.
        found: usize,
        /// How many it takes.
        needed: usize,
    },
    /// A number is not finite, or a sigma not above zero.
    BadNumber {
        /// Which.
        name: &'static str,
        /// The value refused.
        value: f64,
    },
    /// Times do not increase.
    TimeNotIncreasing {
        /// In what.
        name: &'static str,
        /// At which time \[s\].
        t_s: f64,
    },
    /// The wheels did not turn while the track was measured.
    NoTravel,
    /// The fit found no minimum.
    NotConverged,
}

impl fmt::Display for TrackFitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

impl core::error::Error for TrackFitError {}

impl From<GeometryError> for TrackFitError {
    fn from(error: GeometryError) -> Self {
        Self::Geometry(error)
    }
}
