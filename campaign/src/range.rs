//! The plausible range of every quantity of a campaign: one table for reading and writing.
//!
//! The ranges are wide: a value in another unit, in millimetres or in degrees, must still be read, so that the checks of the data
//! can say so. They only keep out what no instrument gives, and what the arithmetic could not square.

use crate::row::Column;

/// The numbers that a quantity may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least.
    pub least: f64,
    /// The greatest.
    pub most: f64,
    /// The unit, for people; empty without one.
    pub unit: &'static str,
}

const fn range(least: f64, most: f64, unit: &'static str) -> Range {
    Range { least, most, unit }
}

/// Every whole number up to this one is exact.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// A load on the robot.
pub const PAYLOAD_KG: Range = range(0.0, 1e5, "kg");

/// The keys of `robot.toml`. A length may be in micrometres or kilometres by mistake.
pub(crate) const KEYS: [(&str, Range); 9] = [
    ("wheel_radius_m", range(1e-6, 1e6, "m")),
    ("track_width_m", range(1e-6, 1e6, "m")),
    ("counts_per_rev", range(1e-3, 1e9, "")),
    ("gear_reduction", range(1e-6, 1e6, "")),
    ("position_sigma_m", range(1e-7, 0.5, "m")),
    ("heading_sigma_rad", range(1e-7, 1.0, "rad")),
    ("supply_v", range(0.01, 1e4, "V")),
    // Seconds since 1970, too.
    ("started_s", range(-1e11, 1e11, "s")),
    ("payload_kg", PAYLOAD_KG),
];

/// The keys of `plan.toml`; distances and turns have either sign. A plan is written to the micrometre, the microsecond and the
/// nanodegree: what is less would be zero when it is read again.
const PLAN_KEYS: [(&str, Range); 9] = [
    ("acceleration_mps2", range(1e-6, 1e6, "m/s^2")),
    ("straight_m", range(1e-6, 1e6, "m")),
    ("spin_deg", range(1e-6, 1e6, "degrees")),
    ("arc_deg", range(1e-6, 1e6, "degrees")),
    ("radius_m", range(1e-6, 1e6, "m")),
    ("speed_mps", range(1e-6, 1e3, "m/s")),
    ("rest_s", range(1e-6, 1e6, "s")),
    ("heading_deg", range(-1e6, 1e6, "degrees")),
    ("payload_kg", PAYLOAD_KG),
];

/// The range of a key of `plan.toml`.
pub(crate) fn of_plan_key(key: &str) -> Option<Range> {
    PLAN_KEYS.iter().find(|(name, _)| *name == key).map(|(_, range)| *range)
}

/// The range of a key of `robot.toml`.
pub(crate) fn of_key(key: &str) -> Option<Range> {
    KEYS.iter().find(|(name, _)| *name == key).map(|(_, range)| *range)
}

impl Column {
    /// The numbers that a cell of this column may have.
    pub const fn range(self) -> Range {
        match self {
            // Nanoseconds since 1970, too.
            Self::Time => range(-1e19, 1e19, "s"),
            Self::LeftCounts | Self::RightCounts => range(-EXACT, EXACT, "counts"),
            // A duty of 16 bits may round to a little more than 1.
            Self::LeftDuty | Self::RightDuty => range(-1.01, 1.01, ""),
            Self::BusV | Self::LeftV | Self::RightV => range(-1e4, 1e4, "V"),
            Self::X | Self::Y => range(-1e8, 1e8, "m"),
            Self::Heading => range(-1e8, 1e8, "rad"),
            Self::GyroZ => range(-1e6, 1e6, "rad/s"),
            Self::LeftCurrent | Self::RightCurrent => range(-1e4, 1e4, "A"),
        }
    }
}

impl Range {
    /// Whether a number is in it; one that is not finite is in none.
    pub fn contains(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }
}

impl std::fmt::Display for Range {
    /// `from -1e8 to 1e8 m`
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (least, most) = (short(self.least), short(self.most));
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        write!(f, "from {least} to {most}{unit}")
    }
}

/// A number in few digits: `1.79e308`, not 309 of them.
pub(crate) fn short(value: f64) -> String {
    match value.abs() {
        size if size != 0.0 && size.is_finite() && !(1e-4..1e6).contains(&size) => {
            format!("{value:e}")
        }
        _ => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_said_in_few_digits() {
        assert_eq!(Column::X.range().to_string(), "from -1e8 to 1e8 m");
        assert_eq!(Column::LeftDuty.range().to_string(), "from -1.01 to 1.01");
        assert_eq!(
            (short(1e160), short(0.036), short(f64::NAN)),
            ("1e160".into(), "0.036".into(), "NaN".into())
        );
    }
}
