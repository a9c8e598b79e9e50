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
        match self {
            Self::Geometry(error) => error.fmt(f),
            Self::TooFewSamples { found, needed } => write!(
                f,
                "only {found} samples of the track lie within the run, it takes {needed}: \
                 check that both use the same clock"
            ),
            Self::BadNumber { name, value } => write!(f, "{name} cannot be {value}"),
            Self::TimeNotIncreasing { name, t_s } => {
                write!(f, "the time of the {name} does not increase at {t_s} s")
            }
            Self::NoTravel => write!(f, "the wheels did not turn while the track was measured"),
            Self::NotConverged => write!(
                f,
                "no wheel weight explains this track: check its clock, its unit and its axes \
                 (x forward, y left)"
            ),
        }
    }
}

impl core::error::Error for TrackFitError {}

impl From<GeometryError> for TrackFitError {
    fn from(error: GeometryError) -> Self {
        Self::Geometry(error)
    }
}
