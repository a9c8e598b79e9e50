//! A wheel's planned state: exact for planning, rounded for the controller.

use fixed::types::{I0F64, I8F24, I32F32, I64F64};

use crate::units::{Acceleration, Speed, Travel};

/// A wheel's planned travel \[m\] in steps of 2^-64 m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position(pub I64F64);

/// A wheel's planned velocity \[m per control tick\] in steps of 2^-64, forward positive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Velocity(pub I0F64);

impl From<Travel> for Position {
    fn from(travel: Travel) -> Self {
        Self(I64F64::from_bits(i128::from(travel.0.to_bits()) << 32))
    }
}

impl From<Position> for Travel {
    /// To the nearest step; wraps beyond 2^31 m.
    fn from(position: Position) -> Self {
        Self(I32F32::from_bits(((position.0.to_bits() + (1 << 31)) >> 32) as i64))
    }
}

/// A wheel's planned state at one tick, which the next plan starts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProfileState {
    /// Planned travel.
    pub position: Position,
    /// Planned velocity.
    pub velocity: Velocity,
}

/// A wheel's setpoint at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Setpoint {
    /// Planned travel.
    pub travel: Travel,
    /// Planned speed.
    pub speed: Speed,
    /// Planned acceleration.
    pub acceleration: Acceleration,
}

impl Setpoint {
    /// At rest where travel begins.
    pub const ZERO: Self = Self {
        travel: Travel(I32F32::ZERO),
        speed: Speed(I8F24::ZERO),
        acceleration: Acceleration(I8F24::ZERO),
    };
}
