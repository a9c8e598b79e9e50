//! What a host counts of its link.

/// What the host received, and what it had to repeat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HostStatistics {
    /// Intact frames.
    pub frames_received: u64,
    /// Frames that were damaged.
    pub frames_damaged: u64,
    /// Frames that the sequence numbers show to be missing.
    pub frames_lost: u64,
    /// Frames that were not believed: not sealed by the robot's key, or sent before.
    pub frames_refused: u64,
    /// Requests sent again.
    pub retries: u64,
    /// Telemetry frames that were lost, requested again, and received.
    pub telemetry_recalled: u64,
    /// Telemetry frames that were lost for good.
    pub telemetry_lost: u64,
}
