//! The control timer's ticks: how late each one is taken, and how many were lost.
//!
//! The timer has one flag. A core that stands still for several periods, as while its flash is erased or
//! a debugger holds it, finds that flag set once: all ticks of the stall but one are lost. The next tick
//! then comes on the timer's own grid again.
//!
//! ```text
//! timer    |     |     |     |     |     |
//! taken    x     x..............x  x     x
//!                       2 lost  ^ late by a part of a period
//! ```
//!
//! A clock can lose time in a stall too, so after lost ticks nothing is concluded from the old due time:
//! the next tick sets it anew.

use crate::units::CONTROL_PERIOD_US;

const PERIOD_US: u64 = CONTROL_PERIOD_US as u64;

/// The due time is later than the timer's grid by as much as a tick usually waits to be taken: less than
/// this \[us\]. Whether a tick that is late by a period less this much hid another one, only the next tells.
const DUE_TIME_ERROR_US: u64 = PERIOD_US / 20;

/// When the next tick is due.
#[derive(Clone, Copy, Debug)]
pub struct ControlTicks {
    due_us: u64,
    /// Ticks were lost just now, or may have been: the next one sets the due time.
    resynchronise: bool,
}

/// One tick, as it was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LateTick {
    /// How late \[us\].
    pub delay_us: u64,
    /// Ticks that were lost before this one.
    pub lost: u32,
}

impl ControlTicks {
    /// The first tick is in time, whenever it comes.
    pub const START: Self = Self { due_us: u64::MAX, resynchronise: false };

    /// Takes the next tick; tells when the tick was late.
    #[inline(always)]
    pub fn take(&mut self, t_us: u64) -> Option<LateTick> {
        if t_us > self.due_us {
            return self.take_late(t_us);
        }
        // No tick comes early: the tick that set the due time was late itself.
        self.due_us = t_us + PERIOD_US;
        self.resynchronise = false;
        None
    }

    #[inline(never)]
    fn take_late(&mut self, t_us: u64) -> Option<LateTick> {
        let delay_us = t_us - self.due_us;
        if delay_us + DUE_TIME_ERROR_US >= PERIOD_US {
            self.due_us = t_us + PERIOD_US;
            self.resynchronise = true;
            let lost = u32::try_from(delay_us / PERIOD_US).unwrap_or(u32::MAX);
            return Some(LateTick { delay_us, lost });
        }
        if self.resynchronise {
            self.resynchronise = false;
            self.due_us = t_us + PERIOD_US;
            return None;
        }
        self.due_us += PERIOD_US;
        Some(LateTick { delay_us, lost: 0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ticks that a timer with one flag gives to a core that stands still from `from` to `to` \[us\].
    fn taken(from_us: u64, to_us: u64, end_us: u64) -> Vec<u64> {
        let mut times = Vec::new();
        let mut grid = 1000;
        while grid <= end_us {
            if (from_us..to_us).contains(&grid) {
                times.push(to_us);
                grid = to_us / 1000 * 1000 + 1000;
            } else {
                times.push(grid + 3);
                grid += 1000;
            }
        }
        times
    }

    #[test]
    fn after_a_stall_of_any_length_and_phase_the_next_ticks_are_on_time() {
        for stall_us in [1_500, 2_000, 2_750, 20_000, 250_000, 5_000_000] {
            for phase_us in [0, 100, 499, 900] {
                let (from_us, to_us) = (10_000 - phase_us, 10_000 - phase_us + stall_us);
                let mut ticks = ControlTicks::START;
                let mut lost = 0;
                for t_us in taken(from_us, to_us, to_us + 50_000) {
                    let tick = ticks.take(t_us.max(1003));
                    if t_us > to_us {
                        assert_eq!(tick, None, "{stall_us} {phase_us} at {t_us}");
                    }
                    lost += tick.map_or(0, |tick| u64::from(tick.lost));
                }
                // To one tick: the due time is a little later than the timer's grid.
                assert!(lost.abs_diff(stall_us / 1000) <= 1, "{lost} of {stall_us} us");
            }
        }
    }

    #[test]
    fn a_clock_that_loses_time_in_a_stall_does_not_make_later_ticks_late() {
        // 131.072 ms: the period of a clock that counts overflows of 16 bits.
        for skipped_us in [65_536, 131_072] {
            let mut ticks = ControlTicks::START;
            for t_us in taken(10_000, 260_300, 300_000) {
                let seen_us = if t_us >= 260_300 { t_us - skipped_us } else { t_us };
                let tick = ticks.take(seen_us);
                assert!(t_us <= 260_300 || tick.is_none(), "{t_us}: {tick:?}");
            }
        }
    }

    #[test]
    fn a_beat_that_is_late_by_less_than_a_period_moves_no_later_one() {
        let mut ticks = ControlTicks::START;
        assert_eq!(ticks.take(0), None);
        assert_eq!(ticks.take(1_700), Some(LateTick { delay_us: 700, lost: 0 }));
        assert_eq!(ticks.take(2_000), None);
        assert_eq!(ticks.take(3_001), Some(LateTick { delay_us: 1, lost: 0 }));
        assert_eq!(ticks.take(4_999), Some(LateTick { delay_us: 999, lost: 0 }));
    }

    #[test]
    fn a_beat_that_is_late_by_almost_a_period_makes_no_later_one_late() {
        // The tick of 2000 is taken just after that of 3000 came, and was lost: the next is that of 4000.
        // With a due time that only counts on, each of them would be late by almost a period, for ever.
        for jitter_us in [0, 1, 2] {
            let mut ticks = ControlTicks::START;
            ticks.take(1_003);
            assert_eq!(ticks.take(3_001), Some(LateTick { delay_us: 998, lost: 0 }));
            for ms in 4..20 {
                assert_eq!(ticks.take(ms * 1000 + 3 - jitter_us), None, "{jitter_us} at {ms} ms");
            }
        }
        // It is taken just before that of 3000 comes, which is not lost.
        let mut ticks = ControlTicks::START;
        ticks.take(1_003);
        assert_eq!(ticks.take(2_998), Some(LateTick { delay_us: 995, lost: 0 }));
        assert_eq!(ticks.take(3_003), None);
        assert_eq!(ticks.take(4_053), Some(LateTick { delay_us: 50, lost: 0 }));
    }

    #[test]
    fn two_stalls_in_a_row_are_both_counted() {
        let mut ticks = ControlTicks::START;
        ticks.take(0);
        assert_eq!(ticks.take(6_200).map(|tick| tick.lost), Some(5));
        assert_eq!(ticks.take(11_200).map(|tick| tick.lost), Some(4));
        assert_eq!(ticks.take(12_000), None);
    }
}
