//! What the uncertainty of W_T is made of.

/// One source of uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// Where it comes from.
    pub source: Source,
    /// What it alone would make of the sigma of W_T.
    pub sigma: f64,
}

/// Where uncertainty comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// The reading at the end of the run.
    Reading,
    /// The noise of the measured track.
    TrackNoise,
    /// The robot's own wandering, which integrates along the run.
    Wander,
    /// How well the robot was aligned at the start.
    StartHeading,
    /// Tolerance of the track width b.
    TrackWidth,
    /// Tolerance of the wheel radius.
    WheelRadius,
    /// Encoders count whole counts.
    EncoderQuantisation,
}
