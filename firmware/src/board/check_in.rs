//! Where the parts check in with the guard ([`super::guard`]), and learn that it has tripped.

use core::sync::atomic::{AtomicBool, Ordering};

/// A part that has to check in.
#[derive(Clone, Copy)]
pub enum CheckedTask {
    /// The encoders were read.
    Capture,
    /// The motors were written.
    Pid,
    /// Every safety task has checked in ([`crate::liveness`]).
    Others,
}

/// How many parts there are.
pub(super) const PARTS: usize = 3;

/// Which parts have checked in since the guard's last check, in the order of [`CheckedTask`]. A flag for each: to set it is
/// one store.
static ALIVE: [AtomicBool; PARTS] = [const { AtomicBool::new(false) }; PARTS];
/// A part missed its deadline: the motors stay off until the watchdog resets the board.
static TRIPPED: AtomicBool = AtomicBool::new(false);

/// A part checks in.
#[inline(always)]
pub fn alive(part: CheckedTask) {
    ALIVE[part as usize].store(true, Ordering::Relaxed);
}

/// Whether the guard has switched the motors off for good.
pub fn tripped() -> bool {
    TRIPPED.load(Ordering::Relaxed)
}

/// Whether a part, by its place in [`CheckedTask`], has checked in since the last call.
#[inline(always)]
pub(super) fn take(part: usize) -> bool {
    // Only the guard calls this, which interrupts all parts: none checks in between both accesses.
    let alive = ALIVE[part].load(Ordering::Relaxed);
    ALIVE[part].store(false, Ordering::Relaxed);
    alive
}

/// The motors are to stay off from now on.
pub(super) fn trip() {
    TRIPPED.store(true, Ordering::Relaxed);
}
