//! Duty for the supply at hand: gains and feedforward are tuned at one supply, and a battery has another.
//!
//! ```text
//! U' = (u - U) / 64 per tick                          (1)
//! U_0 = U,  as soon as they differ by U_0 / 64        (2)
//! duty = duty at the nominal supply x U_nominal / U_0 (3)
//! ```
//!
//! (1) is a low pass of 64 ms over the noise of the measurement and the dips of starting motors. U_0 begins at the
//! nominal supply; for (2) what noise is left does not reach the motors, and a drive on the nominal supply is the same
//! from run to run. The factor of (3) is bounded to a half and two: beyond, the measurement is wrong rather than the
//! supply.

/// Fractional bits of the factor.
pub const SCALE_BITS: u32 = 10;
/// A factor of one: the supply is the nominal one.
pub const UNSCALED: i32 = 1 << SCALE_BITS;
/// Bits by which (1) is slower than the tick, and of the share in (2).
const SMOOTHING_BITS: u32 = 6;

/// Nominal over measured supply; supplies in steps of 2^-6 mV.
#[derive(Clone, Copy, Debug)]
pub struct SupplyScale {
    /// 0: duty is not scaled.
    nominal: u32,
    /// U; 0 before the first tick.
    smoothed: u32,
    /// U_0.
    held: u32,
    factor: i32,
}

impl SupplyScale {
    /// For gains that hold at this supply; 0: at any.
    pub const fn new(nominal_mv: u16) -> Self {
        let nominal = (nominal_mv as u32) << SMOOTHING_BITS;
        Self { nominal, smoothed: 0, held: nominal, factor: UNSCALED }
    }

    /// One tick, with the measured supply: the factor of (3), with [`SCALE_BITS`] fractional bits.
    #[inline(always)]
    pub fn step(&mut self, supply_mv: u16) -> i32 {
        if self.smoothed == 0 {
            self.smoothed = u32::from(supply_mv) << SMOOTHING_BITS;
        }
        self.smoothed = self.smoothed + u32::from(supply_mv) - (self.smoothed >> SMOOTHING_BITS);
        if self.smoothed.abs_diff(self.held) > self.held >> SMOOTHING_BITS && self.nominal != 0 {
            self.hold();
        }
        self.factor
    }

    /// (2), and the factor of (3).
    #[cold]
    fn hold(&mut self) {
        self.held = self.smoothed;
        // 65,535 mV in steps of 2^-6 mV are below 2^22.
        let factor = (self.nominal << SCALE_BITS).checked_div(self.held).unwrap_or(u32::MAX);
        self.factor = factor.min(2 * UNSCALED as u32).max(UNSCALED as u32 / 2) as i32;
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
                let error = f64::from(factor) / f64::from(UNSCALED) / exact - 1.0;
                assert!(error.abs() < 1.0 / 64.0 + 2e-3, "{nominal_mv} {supply_mv}: {error}");
            }
        }
    }

    #[test]
    fn noise_and_short_dips_do_not_reach_the_motors_and_a_step_settles_in_a_third_of_a_second() {
        let mut scale = SupplyScale::new(12_000);
        for tick in 0..10_000_u32 {
            let noise_mv = (tick.wrapping_mul(2_654_435_761) >> 25) as u16;
            let dip_mv = if tick % 500 == 499 { 6000 } else { 0 };
            assert_eq!(scale.step(11_936 + noise_mv - dip_mv), UNSCALED, "tick {tick}");
        }
        let settled = (0..320).map(|_| scale.step(9_600)).last().unwrap_or(0);
        assert!((1260..=1290).contains(&settled), "{settled}");
    }
}
