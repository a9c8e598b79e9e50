//! Duty for the supply at hand: gains and feedforward are tuned at one supply, and a battery has another.
//!
//! ```text
//! U' = (u - U) / 64 per tick                         (1)
//! duty = duty at the nominal supply x U_nominal / U  (2)
//! ```
//!
//! (1) is a low pass of 64 ms over the noise of the measurement and the dips of starting motors. The factor of
//! (2) is bounded to a half and two: beyond, the measurement is wrong rather than the supply.

/// Fractional bits of the factor.
pub const SCALE_BITS: u32 = 10;
/// A factor of one: the supply is the nominal one.
pub const UNSCALED: i32 = 1 << SCALE_BITS;
/// Bits by which (1) is slower than the tick.
const SMOOTHING_BITS: u32 = 6;

/// Nominal over measured supply.
#[derive(Clone, Copy, Debug, Default)]
pub struct SupplyScale {
    /// In steps of 2^-6 mV; 0: duty is not scaled.
    nominal: u32,
    /// U, in steps of 2^-6 mV; 0 before the first tick.
    smoothed: u32,
}

impl SupplyScale {
    /// For gains that hold at this supply; 0: at any.
    pub const fn new(nominal_mv: u16) -> Self {
        Self { nominal: (nominal_mv as u32) << SMOOTHING_BITS, smoothed: 0 }
    }

    /// One tick, with the measured supply: the factor of (2), with [`SCALE_BITS`] fractional bits.
    #[inline(always)]
    pub fn step(&mut self, supply_mv: u16) -> i32 {
        if self.smoothed == 0 {
            self.smoothed = u32::from(supply_mv) << SMOOTHING_BITS;
        }
        self.smoothed = self.smoothed + u32::from(supply_mv) - (self.smoothed >> SMOOTHING_BITS);
        if self.nominal == 0 {
            return UNSCALED;
        }
        // 65,535 mV in steps of 2^-6 mV are below 2^22.
        let scale = (self.nominal << SCALE_BITS).checked_div(self.smoothed).unwrap_or(u32::MAX);
        scale.min(2 * UNSCALED as u32).max(UNSCALED as u32 / 2) as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_is_nominal_over_measured_within_its_bounds_at_any_supply() {
        for nominal_mv in (0..=60_000).step_by(1000) {
            for supply_mv in (0..=u16::MAX).step_by(255) {
                let mut scale = SupplyScale::new(nominal_mv);
                let factor = (0..2000).map(|_| scale.step(supply_mv)).last().unwrap_or(0);
                let exact = match (nominal_mv, supply_mv) {
                    (0, _) => 1.0,
                    (_, 0) => 2.0,
                    _ => (f64::from(nominal_mv) / f64::from(supply_mv)).clamp(0.5, 2.0),
                };
                let error = f64::from(factor) / 1024.0 - exact;
                assert!(error.abs() < 2e-3, "{nominal_mv} {supply_mv}: {error}");
            }
        }
    }

    #[test]
    fn a_dip_of_a_tick_hardly_matters_and_a_step_settles_in_a_third_of_a_second() {
        let mut scale = SupplyScale::new(12_000);
        assert_eq!(scale.step(12_000), 1024);
        assert!((1024..1036).contains(&scale.step(6_000)));
        let settled = (0..320).map(|_| scale.step(9_600)).last().unwrap_or(0);
        assert!((1270..=1281).contains(&settled), "{settled}");
    }
}
