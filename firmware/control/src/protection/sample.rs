//! What a wheel did by one tick.

use fixed::types::I32F32;

use crate::pid::{PidState, nearly_rests};
use crate::profile::Setpoint;
use crate::supply::SCALE_BITS;
use crate::units::{Duty, Travel, saturate_i32};

/// One wheel at one tick.
#[derive(Clone, Copy)]
pub struct WheelSample<'a> {
    pub setpoint: &'a Setpoint,
    pub travel: Travel,
    /// The count's lower half: between two ticks it changes by far less.
    pub counts: u32,
    pub controller: &'a PidState,
}

impl WheelSample<'_> {
    /// What the motor is driven with.
    pub fn duty(&self) -> Duty {
        self.controller.duty()
    }

    /// The setpoint rests.
    #[inline(always)]
    pub fn rests(&self) -> bool {
        self.setpoint.speed.0 == 0
    }

    /// It rests, or nearly, and is not about to speed up, which takes duty.
    #[inline(always)]
    pub fn nearly_rests(&self) -> bool {
        let Setpoint { speed, acceleration, .. } = self.setpoint;
        acceleration.0 == 0 && nearly_rests(speed.0.to_bits())
    }

    /// The duty, either way, beyond this one at the nominal supply; at rest also beyond the `bias` that held the wheel when it
    /// turned.
    #[inline(always)]
    pub fn excess(&self, duty: i32, bias: i32, supply_scale: i32) -> i32 {
        let applied = self.duty().0.to_bits();
        let mut least = applied.abs();
        if self.nearly_rests() {
            least = least.min((applied - at_supply(bias, supply_scale)).abs());
        }
        least - at_supply(duty, supply_scale)
    }

    #[inline(always)]
    pub fn positions(&self) -> Positions {
        Positions { setpoint: position(self.setpoint.travel), travel: position(self.travel) }
    }
}

/// A duty for the nominal supply at the supply at hand.
fn at_supply(duty: i32, supply_scale: i32) -> i32 {
    saturate_i32((i64::from(duty) * i64::from(supply_scale)) >> SCALE_BITS)
}

/// Fractional bits of a position: fine enough for any encoder, and 32 bits of them are 256 m.
pub const POSITION_BITS: u32 = 24;

/// A travel's lower bits. They wrap, but no two positions that are compared are 128 m apart.
#[inline(always)]
pub fn position(travel: Travel) -> i32 {
    (travel.0.to_bits() >> (I32F32::FRAC_NBITS - POSITION_BITS)) as i32
}

/// Setpoint and travel of a wheel at one instant [2^-24 m].
#[derive(Clone, Copy, Debug, Default)]
pub struct Positions {
    pub setpoint: i32,
    pub travel: i32,
}

impl Positions {
    /// Both distances since an earlier instant.
    pub fn since(self, earlier: Positions) -> Positions {
        Positions {
            setpoint: self.setpoint.wrapping_sub(earlier.setpoint),
            travel: self.travel.wrapping_sub(earlier.travel),
        }
    }

    /// Half the way from an earlier instant.
    pub fn midway(self, earlier: Positions) -> Positions {
        let Positions { setpoint, travel } = self.since(earlier);
        Positions {
            setpoint: earlier.setpoint.wrapping_add(setpoint >> 1),
            travel: earlier.travel.wrapping_add(travel >> 1),
        }
    }

    /// How far the setpoint moved, and the wheel along with it.
    pub fn along_setpoint(self) -> (i32, i32) {
        match self.setpoint {
            0.. => (self.setpoint, self.travel),
            _ => (self.setpoint.wrapping_neg(), self.travel.wrapping_neg()),
        }
    }

    /// How far the wheel is behind its setpoint.
    pub fn error(self) -> i32 {
        self.setpoint.wrapping_sub(self.travel)
    }
}
