//! Watches the wheels while the motor drivers have just been switched on, without a duty.
//!
//! What is no duty to one driver is full duty to another one: with both inputs high a driver with two inputs brakes, and one
//! with a PWM and a direction input drives backwards. A wheel that begins to turn then is stopped before it has gone far.

use fixed::types::I8F24;
use shared_proto::{Fault, Wheel, WheelPair};

use crate::capture::Measured;
use crate::protection::Thresholds;
use crate::units::Speed;

/// So long a wheel that begins to turn is looked for \[ticks\].
const TICKS: u32 = 4 * LOOK_TICKS;
/// In one of the looks a wheel at full duty is as fast as a tenth of its speed limit. On a slope a braked wheel creeps more slowly.
const LOOK_TICKS: u32 = 48;

/// Both wheels since the drivers were switched on.
#[derive(Clone, Debug)]
pub struct SwitchingOn {
    ticks_left: u32,
    stood: WheelPair<u32>,
    /// A wheel was not there any more at the tick before.
    away: bool,
}

impl SwitchingOn {
    /// Nothing is watched.
    pub const OVER: Self = Self { ticks_left: 0, stood: WheelPair::both(0), away: false };

    /// The drivers are switched on at this tick, and the wheels stand.
    pub fn begin() -> Self {
        Self { ticks_left: TICKS, ..Self::OVER }
    }

    /// Whether it is time for the encoder check: after the first look, as a robot on a slope creeps meanwhile.
    pub fn lets_check(&self) -> bool {
        self.ticks_left <= TICKS - LOOK_TICKS
    }

    /// One tick: a wheel that has moved in this look by more than [`Thresholds::counts_at_rest_max`] is the driver's fault.
    ///
    /// In one tick no wheel turns a quarter of that. A count that is half of it beyond, or a tick later, is interference.
    pub fn step(&mut self, thresholds: &Thresholds, counts: WheelPair<i64>) -> Option<Fault> {
        if self.ticks_left == 0 {
            return None;
        }
        if self.ticks_left.is_multiple_of(LOOK_TICKS) && !self.away {
            self.stood = counts.map(|counts| counts as u32);
        }
        self.ticks_left -= 1;
        let was_away = self.away;
        for wheel in Wheel::BOTH {
            let moved = (*counts.get(wheel) as u32).wrapping_sub(*self.stood.get(wheel)) as i32;
            let moved = moved.unsigned_abs();
            let most = thresholds.counts_at_rest_max(wheel);
            if moved > most + most / 2 {
                return Some(Fault::CountRate(wheel));
            }
            self.away |= moved > most;
        }
        was_away.then_some(Fault::Driver)
    }
}

/// A wheel that is faster than this rolls \[m/s\]: less, and it has no count in 20 ms.
const ROLLING: I8F24 = I8F24::lit("0.01");

/// Whether a wheel rolls.
#[inline(never)]
pub fn rolls(measured: &Measured) -> bool {
    // Two's complement: one comparison for both signs.
    let rolls = |speed: Speed| {
        speed.0.wrapping_add(ROLLING).to_bits() as u32 > 2 * ROLLING.to_bits() as u32
    };
    rolls(measured.speed.left) | rolls(measured.speed.right)
}

#[cfg(test)]
mod tests {
    use shared_proto::Config;

    use super::*;

    /// What is found of a left wheel that counts like this, and at which tick.
    fn found(mut counts: impl FnMut(u32) -> i64) -> Option<(u32, Fault)> {
        let thresholds = Thresholds::new(&Config::default());
        let mut watch = SwitchingOn::begin();
        (0..1000).find_map(|tick| {
            let counts = WheelPair { left: -10 + counts(tick), right: 7 };
            Some((tick, watch.step(&thresholds, counts)?))
        })
    }

    /// Counts of 0.25 mm, from where the wheel stood.
    fn at(metres: f64) -> i64 {
        (metres / 0.25e-3) as i64
    }

    #[test]
    fn a_wheel_at_full_duty_is_the_drivers_fault_within_seven_millimetres() {
        // 0.5 m/s, reached within 30 ms, as without a load, to 400 ms, as with heavy wheels; at once or after the first look.
        for lag_ticks in [30.0, 100.0, 400.0] {
            for sign in [1.0, -1.0] {
                let way = |tick: u32| {
                    let t = f64::from(tick);
                    sign * 0.5e-3 * (t - lag_ticks * (1.0 - (-t / lag_ticks).exp()))
                };
                let (tick, fault) = found(|tick| at(way(tick))).expect("found");
                assert_eq!(fault, Fault::Driver);
                assert!(way(tick).abs() < 0.0065, "{lag_ticks}: {} m", way(tick));
            }
        }
    }

    #[test]
    fn neither_the_speed_limit_nor_the_encoder_lets_a_wheel_at_full_duty_get_far() {
        for speed_mps_max in [0.05, 0.4, 3.0, 20.0] {
            for counts_per_rev in [48.0, 900.0, 20_000.0] {
                let mut config = Config::default();
                config.limits.speed_mps_max = speed_mps_max;
                config.encoder.left.counts_per_rev = counts_per_rev;
                config.encoder.right.counts_per_rev = counts_per_rev;
                let thresholds = Thresholds::new(&config);
                let count_m =
                    core::f64::consts::TAU * config.geometry.wheel_radius_m / counts_per_rev;
                let counts = thresholds.counts_at_rest_max(Wheel::Left);
                let way_m = f64::from(counts) * count_m;
                // 1 mm, so that a robot that creeps at 20 mm/s is let go; and 4 counts and 2 mm, or twice 4 counts.
                let most_m = 4.0 * count_m + (4.0 * count_m).max(2e-3);
                let case = (speed_mps_max, counts_per_rev, way_m);
                assert!(way_m > 1e-3 - count_m && way_m <= most_m + count_m, "{case:?}");
            }
        }
    }

    #[test]
    fn interference_is_called_so_whenever_it_begins() {
        for counts_per_tick in 16..100 {
            for begin in 0..150 {
                for part in 0..counts_per_tick {
                    let since = |tick: u32| i64::from(tick.saturating_sub(begin));
                    let counts = |tick| match since(tick) {
                        0 => 0,
                        ticks => -(part + (ticks - 1) * counts_per_tick),
                    };
                    let found = found(counts).map(|(_, fault)| fault);
                    assert_eq!(
                        found,
                        Some(Fault::CountRate(Wheel::Left)),
                        "{counts_per_tick}, {begin}, {part}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_robot_that_creeps_down_a_slope_or_is_pushed_later_is_let_go() {
        assert_eq!(found(|tick| at(0.04e-3 * f64::from(tick))), None);
        assert_eq!(found(|tick| at(0.5e-3 * f64::from(tick.saturating_sub(193)))), None);
    }
}
