//! From the hardware counter to an absolute count, and from counts to speed.
//!
//! # Speed by time and count
//!
//! At 0.1 rev/s and 900 counts a wheel gives 90 counts a second: the count changes in one tick of
//! eleven, and a difference over any few ticks is noise. So the estimator remembers the ticks at
//! which the count changed, and divides counts by the time between two changes:
//!
//! ```text
//! v   = Q (C_n - C_o) / (t_n - t_o)     n the newest change, o the oldest within the window    (1)
//! |v| <= Q / (t - t_n)                  no change since t_n: the next count is still to come    (2)
//! ```
//!
//! Each change is known to one tick, so v is known to 1 tick in t_n - t_o: 2.5 % over a full
//! window of 40 ticks, better where a count takes longer than the window. The estimate is the
//! mean over the window, so it lags by half the window. Valid while Q (C_n - C_o) stays below 8 m.

use fixed::types::I8F24;

use crate::units::{CONTROL_HZ, MetersPerCount, Speed};

/// Extends a 16-bit hardware counter to 64 bits.
#[derive(Clone, Copy, Debug)]
pub struct CounterExtender {
    hardware: u16,
    counts: i64,
}

impl CounterExtender {
    /// Starts at zero counts; `hardware` is the counter's present value.
    pub const fn new(hardware: u16) -> Self {
        Self { hardware, counts: 0 }
    }

    /// The absolute count, as wired. Between two calls the counter may move by at most 32767 counts
    /// either way.
    pub fn extend(&mut self, hardware: u16) -> i64 {
        let difference = hardware.wrapping_sub(self.hardware) as i16;
        self.hardware = hardware;
        self.counts = self.counts.wrapping_add(i64::from(difference));
        self.counts
    }
}

/// Longest time over which speed is averaged, unless one count takes longer \[ticks\].
///
/// 40 ms resolve the speed to 2.5 % and keep the lag of 20 ms well below the travel loop's time
/// constant of kv/kp = 50 ms.
const WINDOW_TICKS: u32 = 40;

/// More than the changes that fit into the window; a power of two, so that the index wraps by a mask.
const CHANGES_LEN: usize = 64;
const _: () = assert!(CHANGES_LEN > WINDOW_TICKS as usize + 2 && CHANGES_LEN.is_power_of_two());

/// A wheel without a count for this long stands still \[ticks\].
const STANDSTILL_TICKS: u32 = 20 * CONTROL_HZ;

/// One change of the count: when it was seen, and the count's low bits after it.
#[derive(Clone, Copy, Debug)]
struct Change {
    tick: u32,
    counts: u32,
}

/// A wheel's distance per count, scaled for (1) and (2).
#[derive(Clone, Copy, Debug)]
pub struct SpeedScale {
    /// Speed of one count per tick [2^-40 m/s].
    speed_per_rate: u64,
    /// Most counts that (1) can take without overflow.
    counts_max: u32,
}

impl SpeedScale {
    /// The scale of a wheel that rolls this far per count.
    pub const fn new(MetersPerCount(q): MetersPerCount) -> Self {
        let q = q.to_bits();
        let hz = CONTROL_HZ as u64;
        // Q below 1 m keeps this below 2^50.
        let speed_per_rate = (((q >> 32) * hz) << 8) + (((q & 0xFFFF_FFFF) * hz) >> 24);
        // A power of two: the bound need not be sharp, and a shift takes no division.
        let room = speed_per_rate.leading_zeros().saturating_sub(10);
        let counts_max = if room > 31 { i32::MAX as u32 } else { 1 << room };
        Self { speed_per_rate, counts_max }
    }

    /// Q counts / time [2^-24 m/s], by one 32-bit division.
    #[inline(always)]
    fn quotient(&self, counts: u32, ticks: u32) -> u32 {
        // Below 2^54, in 2^-40 m/s ticks.
        let rolled = u64::from(counts.min(self.counts_max)) * self.speed_per_rate;
        // 2^32 / ticks, less than one part in 2^32 / ticks too small.
        let reciprocal = u64::from(u32::MAX / ticks.max(1));
        let speed = (rolled >> 32) * reciprocal + (((rolled & 0xFFFF_FFFF) * reciprocal) >> 32);
        // Told by the upper word alone.
        if (speed >> 32) as u32 >= 1 << 15 { i32::MAX as u32 } else { (speed >> 16) as u32 }
    }
}

/// Estimates a wheel's speed from its count.
#[derive(Clone, Debug)]
pub struct SpeedEstimator {
    scale: SpeedScale,
    changes: [Change; CHANGES_LEN],
    /// Total changes stored; the newest is at `newest - 1`.
    newest: usize,
    /// Changes in use, up to the newest; they all went the same way.
    len: usize,
    /// The tick of the newest change.
    newest_tick: u32,
    /// The count's lower half: between two ticks it changes by far less.
    counts: u32,
    forward: bool,
    /// Of the newest change [2^-24 m/s], without sign.
    magnitude: u32,
    /// Counts and ticks that (1) had of the newest change.
    window: (u32, u32),
}

impl SpeedEstimator {
    /// An estimator for a wheel that stands at `counts`.
    pub const fn new(q: MetersPerCount, counts: i64) -> Self {
        Self::with(SpeedScale::new(q), counts)
    }

    /// An estimator with a given scale.
    pub const fn with(scale: SpeedScale, counts: i64) -> Self {
        Self {
            scale,
            changes: [Change { tick: 0, counts: 0 }; CHANGES_LEN],
            newest: 0,
            len: 0,
            newest_tick: 0,
            counts: counts as u32,
            forward: true,
            magnitude: 0,
            window: (0, 0),
        }
    }

    /// Adopts a scale, from the next count on. What the wheel did before stays known.
    pub const fn adopt(&mut self, scale: SpeedScale) {
        self.scale = scale;
    }

    /// The count may have jumped: the speed is zero until it has changed twice more.
    pub const fn forget(&mut self) {
        self.len = 0;
        self.magnitude = 0;
    }

    /// The speed after the count taken at `tick`. Call this once a tick.
    #[inline(always)]
    pub fn step(&mut self, tick: u32, counts: i64) -> Speed {
        let counts = counts as u32;
        let moved = counts.wrapping_sub(self.counts) as i32;
        if moved != 0 {
            self.counts = counts;
            self.record(Change { tick, counts }, moved > 0);
        } else if self.len > 0 {
            let ticks = tick.wrapping_sub(self.newest_tick);
            if ticks >= STANDSTILL_TICKS {
                self.len = 0;
                self.magnitude = 0;
            } else if self.magnitude != 0
                && u64::from(ticks) * u64::from(self.window.0) > u64::from(self.window.1)
            {
                // (2): slower than (1), as no count has come for longer than one took. Told without a division.
                self.magnitude = self.magnitude.min(self.scale.quotient(1, ticks));
            }
        }
        let bits = self.magnitude as i32;
        Speed(I8F24::from_bits(if self.forward { bits } else { -bits }))
    }

    #[inline(always)]
    fn record(&mut self, change: Change, forward: bool) {
        // A wheel that changed direction, or dithers on an edge, has no speed until two counts in a
        // row went the same way.
        if forward != self.forward {
            self.forward = forward;
            self.len = 0;
        }
        self.newest_tick = change.tick;
        self.changes[self.newest % CHANGES_LEN] = change;
        self.newest = self.newest.wrapping_add(1);
        self.len += 1;
        if self.len < 2 {
            self.magnitude = 0;
            return;
        }
        let mut oldest = self.change(self.len);
        // One change enters at a time, so at most two have to leave.
        for _ in 0..2 {
            if self.len > 2 && change.tick.wrapping_sub(oldest.tick) > WINDOW_TICKS {
                self.len -= 1;
                oldest = self.change(self.len);
            }
        }
        // (1)
        let counts = (change.counts.wrapping_sub(oldest.counts) as i32).unsigned_abs();
        let ticks = change.tick.wrapping_sub(oldest.tick);
        self.magnitude = self.scale.quotient(counts, ticks);
        self.window = (counts, ticks);
    }

    /// The `age`-th newest change, from 1.
    #[inline(always)]
    fn change(&self, age: usize) -> Change {
        self.changes[self.newest.wrapping_sub(age) % CHANGES_LEN]
    }
}
