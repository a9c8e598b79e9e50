//! What can an effect of the user's own change in a motor, and in which of the two?

use crate::drivetrain::effect::definition::{Acting, Moment};
use crate::expression::{LeftSide, Unit};

/// What an expression changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotorTarget {
    /// The voltage that the motor needs.
    Voltage,
    /// Its friction.
    Friction,
    /// Its back-EMF constant.
    BackEmf,
    /// Its inertia.
    Inertia,
}

/// Which motors an expression changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motors {
    /// Both.
    Both,
    /// The left one.
    Left,
    /// The right one.
    Right,
}

/// An inertia is never less than this share of the motor's: without one, nothing follows from a voltage.
const INERTIA_SHARE_MIN: f64 = 0.05;

impl MotorTarget {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Voltage, Self::Friction, Self::BackEmf, Self::Inertia];

    /// Its name in an equation.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Voltage => "dV",
            Self::Friction => "dkS",
            Self::BackEmf => "dkV",
            Self::Inertia => "dkA",
        }
    }

    /// What a positive change means.
    pub(super) const fn sign(self) -> &'static str {
        match self {
            Self::Voltage => "brakes a wheel that rolls forward, drives one that rolls backward",
            Self::Friction => "more friction, both ways",
            Self::BackEmf => "more voltage at the same speed",
            Self::Inertia => "more voltage for the same acceleration",
        }
    }

    /// What an equation of it is of.
    pub(super) fn left_side(self) -> LeftSide {
        let unit = match self {
            Self::Voltage | Self::Friction => [0.0, 0.0, 0.0, 1.0],
            Self::BackEmf => [-1.0, 1.0, 0.0, 1.0],
            Self::Inertia => [-1.0, 2.0, 0.0, 1.0],
        };
        LeftSide { quantity: self.name(), per: None, unit: Unit(unit) }
    }

    /// The voltage that a change of one comes to at this speed \[V\]; an inertia at 1 m/s^2.
    pub(super) fn volts(self, speed_mps: f64) -> f64 {
        match self {
            Self::Voltage | Self::Friction | Self::Inertia => 1.0,
            Self::BackEmf => speed_mps.abs(),
        }
    }

    /// Adds a change.
    pub(super) fn add(self, change: f64, acting: &mut Acting) {
        let motor = &mut acting.motor;
        match self {
            Self::Voltage => acting.volts -= change,
            Self::Friction => acting.add_friction_v(change),
            Self::BackEmf => motor.kv_v_s_per_m = (motor.kv_v_s_per_m + change).max(0.0),
            Self::Inertia => {
                let least = INERTIA_SHARE_MIN * motor.ka_v_s2_per_m;
                motor.ka_v_s2_per_m = (motor.ka_v_s2_per_m + change).max(least);
            }
        }
    }
}

impl Motors {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Both, Self::Left, Self::Right];

    /// What stands behind the target's name.
    pub const fn suffix(self) -> &'static str {
        match self {
            Self::Both => "",
            Self::Left => "_left",
            Self::Right => "_right",
        }
    }

    /// Whether the motor of this moment is one of them.
    pub(super) fn holds(self, moment: &Moment) -> bool {
        match self {
            Self::Both => true,
            Self::Left => moment.side > 0.0,
            Self::Right => moment.side < 0.0,
        }
    }
}
