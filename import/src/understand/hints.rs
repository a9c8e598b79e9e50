//! What the user knows.

use crate::cut::CutOptions;

/// What the user says about robot and log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hints {
    /// What the robot is called.
    pub name: Option<String>,
    /// Nominal radius of both wheels \[m\].
    pub wheel_radius_m: Option<f64>,
    /// Nominal track width \[m\].
    pub track_width_m: Option<f64>,
    /// Counts per encoder revolution, where wheels are in counts.
    pub counts_per_rev: Option<f64>,
    /// Encoder revolutions per wheel revolution.
    pub gear_reduction: Option<f64>,
    /// Where the log is cut.
    pub cut: CutOptions,
}
