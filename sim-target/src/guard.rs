//! The board's guard and watchdog, simulated: as `firmware/src/board/guard.rs`, in virtual time.
//!
//! The guard checks every 10 ms whether encoders were read, motors written, and every safety task has
//! checked in. When one misses its deadline, the motors go off, and the watchdog, which is no longer fed,
//! restarts the robot.

/// How often the guard checks \[us\].
const CHECK_US: u64 = 10_000;

/// The watchdog's timeout \[us\].
const WATCHDOG_US: u64 = 31_000;

/// Checks in a row that a task may miss, in the order of [`GuardedTask`].
const MISSES_MAX: [u32; 3] = [1, 1, 3];

/// Checks until every task must have checked in once.
const BOOT_CHECKS: u32 = 300;

/// A task that has to check in with the guard, or all others together.
#[derive(Clone, Copy)]
pub(crate) enum GuardedTask {
    /// The encoders were read.
    Capture,
    /// The motors were written.
    Pid,
    /// Every safety task has checked in.
    Others,
}

/// Guard and watchdog.
pub(crate) struct Guard {
    alive: [bool; 3],
    missed: [u32; 3],
    boot_checks: u32,
    next_check_us: u64,
    fed_us: u64,
    tripped: bool,
}

impl Guard {
    /// Starts guard and watchdog.
    pub(crate) fn new(now_us: u64) -> Self {
        Self {
            alive: [false; 3],
            missed: [0; 3],
            boot_checks: BOOT_CHECKS,
            next_check_us: now_us + CHECK_US,
            fed_us: now_us,
            tripped: false,
        }
    }

    /// A task checks in.
    pub(crate) fn alive(&mut self, task: GuardedTask) {
        self.alive[task as usize] = true;
    }

    /// Whether the motors have to stay off.
    pub(crate) fn tripped(&self) -> bool {
        self.tripped
    }

    /// When the guard checks next, or the watchdog restarts the robot \[us\].
    pub(crate) fn next_us(&self) -> u64 {
        self.next_check_us.min(self.fed_us + WATCHDOG_US)
    }

    /// Checks, if a check is due; true if the watchdog restarts the robot now.
    ///
    /// A core that stood still is checked once, and the watchdog is not counted meanwhile: its time is
    /// stretched before a flash is erased, and it stands still with a debugger.
    pub(crate) fn act(&mut self, now_us: u64) -> bool {
        if now_us >= self.next_check_us {
            if now_us >= self.next_check_us + CHECK_US {
                self.fed_us = now_us;
            }
            self.next_check_us = now_us - now_us % CHECK_US + CHECK_US;
            self.check(now_us);
        }
        now_us >= self.fed_us + WATCHDOG_US
    }

    fn check(&mut self, now_us: u64) {
        let alive = core::mem::take(&mut self.alive);
        for (missed, alive) in self.missed.iter_mut().zip(alive) {
            *missed = if alive { 0 } else { *missed + 1 };
        }
        if self.boot_checks > 0 {
            self.boot_checks = if alive == [true; 3] { 0 } else { self.boot_checks - 1 };
            self.fed_us = now_us;
            return;
        }
        self.tripped |= self.missed.iter().zip(MISSES_MAX).any(|(missed, max)| *missed > max);
        if !self.tripped {
            self.fed_us = now_us;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lets all tasks but one check in for a while; returns when the motors went off and the restart.
    fn without(missing: GuardedTask) -> (u64, u64) {
        let mut guard = Guard::new(0);
        let (mut off_us, mut t_us) = (None, 0);
        loop {
            t_us += 1000;
            for task in [GuardedTask::Capture, GuardedTask::Pid, GuardedTask::Others] {
                if t_us < 500_000 || task as usize != missing as usize {
                    guard.alive(task);
                }
            }
            let restart = guard.act(t_us);
            if guard.tripped() && off_us.is_none() {
                off_us = Some(t_us - 500_000);
            }
            if restart {
                return (off_us.expect("off before the restart"), t_us - 500_000);
            }
        }
    }

    #[test]
    fn a_missing_task_has_the_motors_off_within_50_ms_and_a_restart_within_100() {
        for task in [GuardedTask::Capture, GuardedTask::Pid, GuardedTask::Others] {
            let (off_us, restart_us) = without(task);
            assert!((10_000..=50_000).contains(&off_us), "{off_us}");
            assert!((off_us..100_000).contains(&restart_us), "{restart_us}");
        }
    }
}
