//! What did the runs of a campaign reach?

/// What the runs of a campaign reached: it bounds the shapes of effects.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Excitation {
    /// Fastest wheel \[rad/s\].
    pub wheel_rate_max_rad_s: f64,
    /// Longest path of one run \[m\].
    pub path_max_m: f64,
    /// First to last moment of the campaign \[s\].
    pub span_s: f64,
}
