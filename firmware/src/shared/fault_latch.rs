//! The latched fault.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_sync::blocking_mutex::raw::RawMutex;
use shared_proto::{Fault, FaultReport, Wheel, WheelAtFault, WheelPair};

use super::handoff::SharedCell;
use super::tick::Tick;

/// The first fault since the last clearing, and whether it forces the motors off.
pub struct FaultLatch<M: RawMutex> {
    latched: SharedCell<M, Latched>,
    /// Apart from the rest: every control tick reads it.
    motors_off: AtomicBool,
}

#[derive(Clone, Copy)]
struct Latched {
    report: Option<FaultReport>,
    /// The report says how the wheels were.
    noted: bool,
    last_number: u32,
}

impl<M: RawMutex> FaultLatch<M> {
    pub(super) const fn new() -> Self {
        Self {
            latched: SharedCell::new(Latched { report: None, noted: false, last_number: 0 }),
            motors_off: AtomicBool::new(false),
        }
    }

    /// The latched fault.
    pub fn report(&self) -> Option<FaultReport> {
        self.latched.get().report
    }

    /// Whether a latched fault forbids any duty at all.
    pub fn forces_motors_off(&self) -> bool {
        self.motors_off.load(Ordering::Relaxed)
    }

    /// The number of the fault that was latched last, 0 before the first.
    pub fn last_number(&self) -> u32 {
        self.latched.get().last_number
    }

    /// Latches a fault; returns true if the supervisor has to act on it.
    pub(super) fn latch(&self, fault: Fault, t_us: u64) -> bool {
        let mut news = false;
        self.latched.update(|latched| {
            let motors_off = !fault.allows_ramp();
            news = latched.report.is_none() || (motors_off && !self.forces_motors_off());
            if motors_off {
                self.motors_off.store(true, Ordering::Relaxed);
            }
            match &mut latched.report {
                // A fault that is raised at every tick counts once.
                Some(report) if report.fault == fault => {}
                Some(report) => report.followed_by = report.followed_by.saturating_add(1),
                None => {
                    latched.last_number = latched.last_number.wrapping_add(1);
                    let number = latched.last_number;
                    latched.noted = false;
                    latched.report = Some(FaultReport {
                        fault,
                        number,
                        t_us,
                        followed_by: 0,
                        wheels: WheelPair::both(WheelAtFault::default()),
                        supply_mv: 0,
                    });
                }
            }
        });
        news
    }

    /// Notes how the wheels are at this tick in the report of a fault that was just latched.
    #[cold]
    #[inline(never)]
    pub(crate) fn note(&self, tick: &Tick) {
        self.latched.update(|latched| {
            if let Some(report) = &mut latched.report
                && !latched.noted
            {
                latched.noted = true;
                report.supply_mv = tick.supply_mv;
                report.wheels = WheelPair {
                    left: tick.at_fault(Wheel::Left),
                    right: tick.at_fault(Wheel::Right),
                };
            }
        });
    }

    /// Clears the latched fault. Only the supervisor calls this, and only on command.
    pub(crate) fn clear(&self) {
        self.latched.update(|latched| {
            latched.report = None;
            self.motors_off.store(false, Ordering::Relaxed);
        });
    }
}
