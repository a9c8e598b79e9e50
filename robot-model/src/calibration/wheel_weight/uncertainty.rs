//! What contributes to the uncertainty of W_T?

/// One source of uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// Where it comes from.
    pub source: Source,
    /// The sigma of W_T if it were the only source.
    pub sigma: f64,
}

/// Where uncertainty comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// The reading at the end of the run.
    Reading,
    /// The noise of the measured track.
    TrackNoise,
    /// Random wandering of the heading, which integrates along the run.
    Wander,
    /// How well the robot was aligned at the start.
    StartHeading,
    /// Tolerance of the track width b.
    TrackWidth,
    /// Tolerance of the wheel radius.
    WheelRadius,
    /// Rounding of the encoders to whole counts.
    EncoderQuantisation,
}
