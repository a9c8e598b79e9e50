//! Why does a reading give no W_T?

use core::fmt;

use crate::kinematics::geometry::GeometryError;

/// Why a reading gives no W_T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WheelWeightError {
    /// The nominal robot is unphysical.
    Geometry(GeometryError),
    /// A number is not finite, or a sigma negative.
    BadNumber {
        /// Which.
        name: &'static str,
        /// The value refused.
        value: f64,
    },
    /// A wheel did not turn: without travel there is no ratio.
    NoTravel,
    /// The offset is larger than any arc of this length reaches.
    OffsetTooLarge {
        /// The offset \[m\].
        offset_m: f64,
        /// The largest that an arc of this run can reach \[m\].
        largest_m: f64,
    },
    /// The deviation would need a wheel of negative radius.
    Impossible {
        /// The resulting W_T.
        value: f64,
    },
}

impl fmt::Display for WheelWeightError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

impl core::error::Error for WheelWeightError {}

impl From<GeometryError> for WheelWeightError {
    fn from(error: GeometryError) -> Self {
        Self::Geometry(error)
    }
}
