//! The virtual clock: this program's one embassy-time driver, with a separate time for each thread.
//!
//! Time stands still until [`advance_to`] is called. Each thread has its own time and its own alarms, so
//! many simulated robots run side by side without affecting each other.

use std::cell::RefCell;
use std::task::Waker;

use embassy_time_driver::Driver;

struct VirtualClock;

embassy_time_driver::time_driver_impl!(static CLOCK: VirtualClock = VirtualClock);

#[derive(Default)]
struct ThreadTime {
    claimed: bool,
    now_us: u64,
    // Few tasks: a linear search is faster than keeping the alarms sorted.
    alarms: Vec<(u64, Waker)>,
}

thread_local! {
    static TIME: RefCell<ThreadTime> = RefCell::default();
}

const _: () = assert!(embassy_time_driver::TICK_HZ == 1_000_000, "ticks here are microseconds");

impl Driver for VirtualClock {
    fn now(&self) -> u64 {
        now_us()
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        TIME.with_borrow_mut(|time| {
            if at <= time.now_us {
                waker.wake_by_ref();
                return;
            }
            match time.alarms.iter_mut().find(|(_, other)| other.will_wake(waker)) {
                // A task that is woken too early schedules again.
                Some((alarm, _)) => *alarm = at.min(*alarm),
                None => time.alarms.push((at, waker.clone())),
            }
        });
    }
}

/// This thread's time \[us\].
pub fn now_us() -> u64 {
    TIME.with_borrow(|time| time.now_us)
}

/// When the next alarm of this thread is due \[us\].
pub(crate) fn next_alarm_us() -> Option<u64> {
    TIME.with_borrow(|time| time.alarms.iter().map(|&(at, _)| at).min())
}

/// Advances this thread's time and wakes the tasks whose alarms are due.
pub(crate) fn advance_to(t_us: u64) {
    TIME.with_borrow_mut(|time| {
        assert!(t_us >= time.now_us, "time does not run backwards");
        time.now_us = t_us;
        let mut i = 0;
        while i < time.alarms.len() {
            if time.alarms[i].0 <= t_us {
                // `remove` keeps the order: which task wakes first must not depend on earlier alarms.
                time.alarms.remove(i).1.wake();
            } else {
                i += 1;
            }
        }
    });
}

/// Claims this thread's clock for one robot. Its time starts at zero, without alarms.
///
/// # Panics
/// If another robot has claimed the clock.
pub(crate) fn claim() {
    TIME.with_borrow_mut(|time| {
        assert!(!time.claimed, "a thread simulates one robot at a time");
        *time = ThreadTime { claimed: true, ..ThreadTime::default() };
    });
}

/// Forgets every alarm: the tasks that set them are about to end, and whoever else waits must be polled
/// again.
pub(crate) fn forget_alarms() {
    // When a thread ends by a panic, its time may be dropped before its robot.
    let _ = TIME.try_with(|time| time.borrow_mut().alarms.clear());
}

/// Releases the clock.
pub(crate) fn release() {
    // When a thread ends by a panic, its time may be dropped before its robot.
    let _ = TIME.try_with(|time| *time.borrow_mut() = ThreadTime::default());
}
