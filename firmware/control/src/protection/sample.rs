//! What a wheel did by one tick.

use crate::pid::PidState;
use crate::profile::Setpoint;
use crate::units::{Duty, Travel};

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

    #[inline(always)]
    pub fn positions(&self) -> Positions {
        Positions { setpoint: self.setpoint.travel.0.to_bits(), travel: self.travel.0.to_bits() }
    }
}

/// Setpoint and travel of a wheel at one instant [2^-32 m].
#[derive(Clone, Copy, Debug, Default)]
pub struct Positions {
    pub setpoint: i64,
    pub travel: i64,
}

impl Positions {
    /// Both distances since an earlier instant.
    pub fn since(self, earlier: Positions) -> Positions {
        Positions {
            setpoint: self.setpoint.wrapping_sub(earlier.setpoint),
            travel: self.travel.wrapping_sub(earlier.travel),
        }
    }
}
