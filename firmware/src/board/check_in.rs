//! Where the parts check in with the guard ([`super::guard`]), and learn that it has tripped.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// A part that has to check in.
#[derive(Clone, Copy)]
pub enum CheckedTask {
    /// The encoders were read.
    Capture = 1,
    /// The motors were written.
    Pid = 2,
    /// Every safety task has checked in ([`crate::liveness`]).
    Others = 4,
}

/// The parts that have checked in since the guard's last check, as bits of [`CheckedTask`].
static ALIVE: AtomicU32 = AtomicU32::new(0);
/// A part missed its deadline: the motors stay off until the watchdog resets the board.
static TRIPPED: AtomicBool = AtomicBool::new(false);

/// A part checks in.
pub fn alive(part: CheckedTask) {
    ALIVE.fetch_or(part as u32, Ordering::Relaxed);
}

/// Whether the guard has switched the motors off for good.
pub fn tripped() -> bool {
    TRIPPED.load(Ordering::Relaxed)
}

/// The parts that have checked in since the last call, as bits of [`CheckedTask`].
pub(super) fn take() -> u32 {
    ALIVE.swap(0, Ordering::Relaxed)
}

/// The motors are to stay off from now on.
pub(super) fn trip() {
    TRIPPED.store(true, Ordering::Relaxed);
}
