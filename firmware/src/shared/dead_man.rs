//! The dead-man: how long the motors may be driven without a word from the supervisor.

use core::sync::atomic::{AtomicU32, Ordering};

/// Control ticks that are left. The supervisor grants them, and the control tick counts them down.
///
/// Counted in ticks and not by the clock, so that nothing but the control timer has to run.
pub struct DeadMan(AtomicU32);

impl DeadMan {
    /// No motion that somebody has to keep alive.
    const AT_REST: u32 = u32::MAX;

    pub(super) const fn new() -> Self {
        Self(AtomicU32::new(Self::AT_REST))
    }

    /// The motors may be driven for this many ticks from now on.
    pub(crate) fn grant(&self, ticks: u32) {
        self.0.store(ticks.min(Self::AT_REST - 1), Ordering::Relaxed);
    }

    /// No motion needs a host: the wheels rest, or a plan brakes them that ends by itself.
    pub(crate) fn rest(&self) {
        self.0.store(Self::AT_REST, Ordering::Relaxed);
    }

    /// A tick with the motors driven; false if none was left.
    ///
    /// The control tick alone calls this. No other task runs between the two accesses, because the
    /// control tick interrupts the others and not the reverse.
    #[inline(always)]
    pub(crate) fn spend(&self) -> bool {
        match self.0.load(Ordering::Relaxed) {
            Self::AT_REST => true,
            0 => false,
            left => {
                self.0.store(left - 1, Ordering::Relaxed);
                true
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grant_ends_by_itself_and_rest_does_not() {
        let dead_man = DeadMan::new();
        assert!((0..1000).all(|_| dead_man.spend()));
        dead_man.grant(3);
        assert_eq!([(); 5].map(|()| dead_man.spend()), [true, true, true, false, false]);
        dead_man.grant(u32::MAX);
        assert!(dead_man.spend());
        assert_eq!(dead_man.0.load(Ordering::Relaxed), u32::MAX - 2, "not at rest");
        dead_man.rest();
        assert!((0..1000).all(|_| dead_man.spend()));
    }
}
