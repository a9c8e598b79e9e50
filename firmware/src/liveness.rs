//! Signs of life of the safety tasks.
//!
//! Each task on which safety depends checks in every 10 ms, wherever it waits. The heartbeat
//! ([`crate::task::heartbeat`]) passes on to the guard only if every one has: the watchdog is not fed when
//! a single task stops, although the others and their executor run on.

use core::future::Future;
use core::pin::pin;
use core::sync::atomic::{AtomicU32, Ordering};

use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Timer};

/// A safety task checks in this often.
pub const CHECK_IN: Duration = Duration::from_millis(10);

/// A task on which safety depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SafetyTask {
    /// Executes requests and stops a robot whose host is silent.
    Supervisor = 1,
    /// Receives frames: the host's renewals, and its stop.
    Receive = 2,
    /// Sends frames: the host learns of a fault.
    Transmit = 4,
    /// Watches the emergency stop.
    EmergencyStop = 8,
    /// Watches the motor driver's fault line.
    DriverFault = 16,
}

/// Every [`SafetyTask`].
const ALL: u32 = 0b1_1111;

/// Which safety tasks have checked in.
pub struct Liveness(AtomicU32);

impl Liveness {
    /// Nobody has checked in yet.
    pub const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// A task checks in.
    pub fn check_in(&self, task: SafetyTask) {
        self.0.fetch_or(task as u32, Ordering::Relaxed);
    }

    /// Whether every task has checked in since the last time that all had.
    pub fn take_all(&self) -> bool {
        self.0.compare_exchange(ALL, 0, Ordering::Relaxed, Ordering::Relaxed).is_ok()
    }

    /// Waits for `work`, and checks in meanwhile.
    pub async fn while_waiting<T>(&self, task: SafetyTask, work: impl Future<Output = T>) -> T {
        let mut work = pin!(work);
        loop {
            self.check_in(task);
            if let Either::First(done) = select(work.as_mut(), Timer::after(CHECK_IN)).await {
                return done;
            }
        }
    }
}

impl Default for Liveness {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TASKS: [SafetyTask; 5] = [
        SafetyTask::Supervisor,
        SafetyTask::Receive,
        SafetyTask::Transmit,
        SafetyTask::EmergencyStop,
        SafetyTask::DriverFault,
    ];

    #[test]
    fn one_missing_task_is_enough() {
        for missing in TASKS {
            let liveness = Liveness::new();
            for task in TASKS.into_iter().filter(|task| *task != missing) {
                liveness.check_in(task);
                liveness.check_in(task);
            }
            assert!(!liveness.take_all(), "{missing:?}");
            liveness.check_in(missing);
            assert!(liveness.take_all(), "{missing:?} was late");
            assert!(!liveness.take_all(), "all over again");
        }
    }
}
