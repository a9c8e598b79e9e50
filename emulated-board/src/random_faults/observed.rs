//! What was seen of one case: at the pins, at the wheels, and by the host.

use shared_proto::{Fault, MotionEnd, MotionId, ResetCause, WheelPair};

use super::fault_kind::FaultKind;
use crate::monitor::Powered;

/// Something that happened.
#[derive(Clone, Copy, Debug)]
pub struct Happened {
    /// What.
    pub kind: FaultKind,
    /// When \[us\].
    pub at_us: u64,
    /// How far the wheels had turned \[rad\].
    pub angles_rad: WheelPair<f64>,
}

/// Parts of the drive that the host commanded, and when they began, as the host saw it \[us\].
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    /// The robot answered the host's hello.
    pub opened_us: Option<u64>,
    /// The host armed the robot.
    pub armed_us: Option<u64>,
    /// The host commanded the first motion.
    pub commanded_us: Option<u64>,
    /// The loop closed and the wheels followed a motion.
    pub tracks_us: Vec<u64>,
    /// How far the wheels had turned at each of these \[rad\].
    pub tracks_rad: Vec<WheelPair<f64>>,
    /// The host commanded a stop.
    pub stop_us: Option<u64>,
    /// The host's emergency stop was latched.
    pub latched_us: Option<u64>,
    /// The host was about to disarm the robot.
    pub over_us: Option<u64>,
    /// The newest motion whose command was answered.
    pub followed: Option<MotionId>,
    /// How far the wheels were from their setpoints in the newest frame of a motion \[um\].
    pub error_um: WheelPair<i32>,
    /// Their duties there \[1/32767\].
    pub duty: WheelPair<i16>,
}

/// What was seen.
#[derive(Clone, Debug, Default)]
pub struct Observed {
    /// What happened, in order.
    pub happened: Vec<Happened>,
    /// What the host did.
    pub timeline: Timeline,
    /// When a motor had a duty, until the host looked at the state.
    pub powered: Vec<Powered>,
    /// When the chip restarted \[us\].
    pub resets_us: Vec<u64>,
    /// Why it started last, if the robot said so.
    pub cause: Option<ResetCause>,
    /// The latched fault.
    pub fault: Option<Fault>,
    /// Where nothing was latched and a motor has no current: what the next motion latched.
    pub next_fault: Option<Fault>,
    /// The robot drove a motion whose command was never answered, when the host looked at it.
    pub drives_unanswered: bool,
    /// How the last motion ended.
    pub motion_end: Option<MotionEnd>,
    /// What is wrong besides: driven again, not latched, not to be cleared, of no use afterwards.
    pub wrong: Vec<String>,
}
