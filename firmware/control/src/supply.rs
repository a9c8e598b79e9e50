//! Duty for the supply at hand: gains and feedforward are tuned at one supply, and a battery has another.
//!
//! ```text
//! U' = (u - U) / 64 per tick                                (1)
//! g' = round((U_nominal - g U) / 64 mV) / 1024 per tick     (2)
//! duty = g x duty at the nominal supply                     (3)
//! ```
//!
//! (1) is a low pass of 64 ms over the noise of the measurement and the dips of starting motors. (2) takes g to U_nominal / U
//! in some 10 ticks, without a division. Within 32 mV it rests: what noise is left does not reach the motors, and a
//! drive on an even supply is the same from run to run. A supply that sags or recovers moves g in steps of a 1024th, which a
//! wheel does not notice. g is bounded to a half and two: beyond, the measurement is wrong rather than the supply.

/// Fractional bits of the factor.
pub const SCALE_BITS: u32 = 10;
/// A factor of one: the supply is the nominal one.
pub const UNSCALED: i32 = 1 << SCALE_BITS;
/// Bits by which (1) is slower than the tick.
const SMOOTHING_BITS: u32 = 6;
/// Steps of 2^-10 mV in the 64 mV of (2), in bits. A step of g changes g U by less than this at any supply: (2) comes to rest.
const REST_BITS: u32 = 16;

/// Nominal over measured supply.
#[derive(Clone, Copy, Debug)]
pub struct SupplyScale {
    /// In steps of 2^-10 mV; 0: duty is not scaled.
    nominal: i32,
    /// U in steps of 2^-6 mV.
    smoothed: u32,
    /// g.
    factor: i32,
}

impl SupplyScale {
    /// For gains that hold at this supply; 0: at any.
    pub const fn new(nominal_mv: u16) -> Self {
        Self {
            nominal: (nominal_mv as i32) << SCALE_BITS,
            smoothed: (nominal_mv as u32) << SMOOTHING_BITS,
            factor: UNSCALED,
        }
    }

    /// For other gains, on the same supply.
    pub const fn set_nominal(&mut self, nominal_mv: u16) {
        self.nominal = (nominal_mv as i32) << SCALE_BITS;
        if nominal_mv == 0 {
            self.factor = UNSCALED;
        }
    }

    /// One tick, with the measured supply: the factor of (3), with [`SCALE_BITS`] fractional bits.
    #[inline(always)]
    pub fn step(&mut self, supply_mv: u16) -> i32 {
        let smoothed_mv = self.smoothed >> SMOOTHING_BITS;
        self.smoothed = self.smoothed - smoothed_mv + u32::from(supply_mv);
        // 65,535 mV times two are below 2^27 steps.
        let missing = self.nominal - self.factor * smoothed_mv as i32;
        let steps = (missing + (1 << (REST_BITS - 1))) >> REST_BITS;
        if steps != 0 {
            self.follow(steps);
        }
        self.factor
    }

    /// (2), within its bounds.
    #[cold]
    #[inline(never)]
    fn follow(&mut self, steps: i32) {
        if self.nominal != 0 {
            self.factor = (self.factor + steps).clamp(UNSCALED / 2, 2 * UNSCALED);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the factor is to be.
    fn exact(nominal_mv: u16, supply_mv: u16) -> f64 {
        match (nominal_mv, supply_mv) {
            (0, _) => 1.0,
            (_, 0) => 2.0,
            _ => (f64::from(nominal_mv) / f64::from(supply_mv)).clamp(0.5, 2.0),
        }
    }

    #[test]
    fn the_factor_is_nominal_over_measured_to_32_mv_within_its_bounds_at_any_supply() {
        for nominal_mv in (0..=60_000).step_by(1000) {
            for supply_mv in (0..=u16::MAX).step_by(255) {
                let mut scale = SupplyScale::new(nominal_mv);
                for _ in 0..2000 {
                    scale.step(supply_mv);
                }
                let factor = scale.step(supply_mv);
                assert_eq!(factor, scale.step(supply_mv), "{nominal_mv} {supply_mv}: at rest");
                let factor = f64::from(factor) / f64::from(UNSCALED);
                // (2) rests within 32 mV, (1) within one; at the bounds nothing is left to do.
                let error_mv = (factor - exact(nominal_mv, supply_mv)) * f64::from(supply_mv);
                assert!(error_mv.abs() < 34.0, "{nominal_mv} {supply_mv}: {error_mv}");
            }
        }
    }

    #[test]
    fn noise_does_not_reach_the_motors_a_dip_hardly_and_a_step_settles_in_a_third_of_a_second() {
        let mut scale = SupplyScale::new(12_000);
        let noise_mv = |tick: u32| (tick.wrapping_mul(2_654_435_761) >> 25) as u16;
        for tick in 0..10_000 {
            assert_eq!(scale.step(11_936 + noise_mv(tick)), UNSCALED, "tick {tick}");
        }
        for tick in 0..10_000 {
            let dip_mv = if tick % 500 == 499 { 6000 } else { 0 };
            let factor = scale.step(11_936 + noise_mv(tick) - dip_mv);
            assert!((UNSCALED..UNSCALED + 9).contains(&factor), "tick {tick}: {factor}");
        }
        let settled = (0..320).map(|_| scale.step(9_600)).last().unwrap_or(0);
        assert!((1270..=1285).contains(&settled), "{settled}");
    }

    #[test]
    fn a_supply_that_sags_moves_the_factor_by_little_at_a_time() {
        let mut scale = SupplyScale::new(12_000);
        let mut last = UNSCALED;
        for tick in 0..1500_u16 {
            // 1.5 V in 1.5 s.
            let factor = scale.step(12_000 - tick);
            assert!((0..=1).contains(&(factor - last)), "{tick}: {last} {factor}");
            // (1) is 64 ms late, (2) rests within 32 mV and a step of 12 mV.
            let now_mv = f64::from(12_000 - tick);
            let off_mv = (f64::from(factor) / f64::from(UNSCALED) - 12_000.0 / now_mv) * now_mv;
            assert!(off_mv.abs() < 64.0 + 34.0 + 12.0, "{tick}: {off_mv}");
            last = factor;
        }
    }

    #[test]
    fn other_gains_keep_what_is_known_of_the_supply() {
        let mut scale = SupplyScale::new(12_000);
        for _ in 0..1000 {
            scale.step(18_000);
        }
        scale.set_nominal(18_000);
        let factor = (0..40).map(|_| scale.step(18_000)).last().unwrap_or(0);
        assert!((UNSCALED - 2..=UNSCALED + 2).contains(&factor), "{factor}");
        scale.set_nominal(12_000);
        for _ in 0..40 {
            scale.step(18_000);
        }
        scale.set_nominal(0);
        assert_eq!(scale.step(18_000), UNSCALED);
    }
}
