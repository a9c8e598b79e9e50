//! When each control tick reads the encoders and writes the motors, observed from outside the firmware.

use rigless::emulator::{Access, AccessKind};

/// The left encoder's counter, in TIM3: read once in each control tick, and nowhere else.
const ENCODER: u64 = 0x4000_0424;

/// The right wheel's PWM, TIM1's third compare value: the last write of each control tick.
const PWM: u64 = 0x4001_003C;

/// One control tick \[ns since power-on\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TickTimes {
    /// When the encoders were read.
    pub read_ns: u64,
    /// When the motors were written.
    pub written_ns: u64,
}

/// Records the times of all control ticks.
#[derive(Debug, Default)]
pub(crate) struct TickRecorder {
    read_ns: Option<u64>,
    pub tick_times: Vec<TickTimes>,
}

impl TickRecorder {
    pub fn on_access(&mut self, access: &Access) {
        let ns = access.virtual_time.0;
        match (access.kind, access.address) {
            (AccessKind::Read, ENCODER) => self.read_ns = Some(ns),
            (AccessKind::Write, PWM) => {
                if let Some(read_ns) = self.read_ns.take() {
                    self.tick_times.push(TickTimes { read_ns, written_ns: ns });
                }
            }
            _ => {}
        }
    }
}
