//! A value that several tasks work on in place, one at a time.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_sync::blocking_mutex::{Mutex, raw::RawMutex};

/// A value behind a lock. Nothing is copied, and nothing counts who works on it: a `RefCell` would, at every control tick.
pub struct InPlace<M: RawMutex, T> {
    value: Mutex<M, T>,
    /// Somebody works on it. Checked in tests only.
    taken: AtomicBool,
}

impl<M: RawMutex, T> InPlace<M, T> {
    /// Holds a value.
    pub(super) const fn new(value: T) -> Self {
        Self { value: Mutex::new(value), taken: AtomicBool::new(false) }
    }

    /// Works on the value. The work never asks for the same value again: whatever it calls is given it.
    #[inline(always)]
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        // SAFETY: never within itself, which tests hold below; so there is one reference at a time.
        unsafe {
            self.value.lock_mut(|value| {
                debug_assert!(!self.taken.swap(true, Ordering::Relaxed), "taken while taken");
                let done = work(value);
                if cfg!(debug_assertions) {
                    self.taken.store(false, Ordering::Relaxed);
                }
                done
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use embassy_sync::blocking_mutex::raw::NoopRawMutex;

    use super::*;

    #[test]
    fn work_changes_the_value_and_answers() {
        let cell = InPlace::<NoopRawMutex, u32>::new(1);
        assert_eq!(cell.with(|value| core::mem::replace(value, 2)), 1);
        assert_eq!(cell.with(|value| *value), 2);
    }

    #[test]
    #[should_panic(expected = "taken while taken")]
    fn work_within_work_is_a_bug_that_tests_see() {
        let cell = InPlace::<NoopRawMutex, u32>::new(1);
        cell.with(|_| cell.with(|_| ()));
    }
}
