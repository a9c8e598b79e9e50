//! What a wheel did by one tick.

use crate::profile::Setpoint;
use crate::units::{Duty, Travel};

/// One wheel at one tick.
#[derive(Clone, Copy)]
pub struct WheelSample {
    pub positions: Positions,
    pub counts: i64,
    /// The setpoint rests.
    pub rests: bool,
    pub duty: Duty,
}

impl WheelSample {
    #[inline(always)]
    pub fn new(setpoint: &Setpoint, (travel, counts): (Travel, i64), duty: Duty) -> Self {
        let positions =
            Positions { setpoint: setpoint.travel.0.to_bits(), travel: travel.0.to_bits() };
        Self { positions, counts, rests: setpoint.speed.0 == 0, duty }
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
