//! For how long what the host wants goes on, and what ends it.

use std::time::Duration;

use super::{LEASE, Session};
use crate::cancel::Cancel;
use crate::lease::Holder;

impl Session {
    /// Makes this session's procedures end in good order once `cancel` is requested.
    pub fn cancel_by(&mut self, cancel: &Cancel) {
        self.cancel = cancel.clone();
    }

    /// Lets motions go on only while `holder` gives signs of life; without them, this session's procedures end in good order.
    pub fn hold_by(&mut self, holder: &Holder) {
        self.holder = Some(holder.clone());
    }

    /// Whether the procedures of this session are to end.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_requested() || self.holder.as_ref().is_some_and(Holder::is_gone)
    }

    /// Whether the holder's last sign of life is so old that a motion may have ended for want of another.
    pub(crate) fn holder_is_late(&self) -> bool {
        self.holder.as_ref().is_some_and(|holder| holder.left() < LEASE / 4)
    }

    /// When a lease that is given now ends, on the robot's clock \[ms\].
    pub fn lease_end_ms(&self) -> u64 {
        self.robot_clock.lease_end_ms(self.lease(), self.clock.now_us())
    }

    /// How long a motion goes on without another renewal.
    pub(super) fn lease(&self) -> Duration {
        self.holder.as_ref().map_or(LEASE, Holder::left)
    }
}
