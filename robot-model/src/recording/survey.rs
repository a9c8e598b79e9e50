//! What the runs of a campaign reached.

/// What the runs of a campaign reached: where the shapes of effects are looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Survey {
    /// Fastest wheel \[rad/s\].
    pub wheel_rate_max_rad_s: f64,
    /// Longest path of one run \[m\].
    pub path_max_m: f64,
    /// First to last moment of the campaign \[s\].
    pub span_s: f64,
}
