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
        match self {
            Self::Geometry(error) => error.fmt(f),
            Self::BadNumber { name, value } => write!(f, "{name} cannot be {}", readable(*value)),
            Self::NoTravel => write!(f, "the wheels did not turn: drive a straight run first"),
            Self::OffsetTooLarge { offset_m, largest_m } => write!(
                f,
                "a lateral offset of {} m is out of reach of this run \
                 (at most {largest_m:.3} m): check the unit and the counts",
                readable(*offset_m)
            ),
            Self::Impossible { value } => {
                let value = readable((value * 1e3).round() / 1e3);
                write!(f, "this deviation gives W_T = {value}: check its unit and the counts")
            }
        }
    }
}

/// A number without rows of zeros: `1e300`.
fn readable(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-9..1e15).contains(&size) || !size.is_finite() {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

impl core::error::Error for WheelWeightError {}

impl From<GeometryError> for WheelWeightError {
    fn from(error: GeometryError) -> Self {
        Self::Geometry(error)
    }
}
