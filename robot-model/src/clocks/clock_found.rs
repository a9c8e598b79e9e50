//! How far is the clock of one run's poses off that of its wheels?

use serde::{Deserialize, Serialize};

/// The clock of one run's poses, relative to that of its wheels; equation (1) of [`super`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClockFound {
    /// The run.
    pub run: String,
    /// How late the poses are \[s\].
    pub offset_s: f64,
    /// Its standard error \[s\].
    pub offset_sigma_s: f64,
    /// By which share the poses' clock runs faster than that of the wheels.
    pub rate: f64,
    /// Its standard error; zero if the run is too short to tell, and the rate is then taken as zero.
    pub rate_sigma: f64,
}
