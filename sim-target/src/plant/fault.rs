//! Faults of wires, encoders, motors and supply.

use shared_proto::{Wheel, WheelPair};

/// A fault that can be injected and removed again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlantFault {
    /// The encoder's plug is out: the count stands still.
    EncoderUnplugged(Wheel),
    /// The encoder's A and B are swapped: the count runs the other way.
    EncoderReversed(Wheel),
    /// Interference counts as edges, at this mean rate \[counts/s\], upwards if positive.
    EncoderNoise(Wheel, f64),
    /// A hand grabs the wheel: its grip grows to [`CLAMP_NM`] within [`CLAMP_RAMP_US`].
    WheelBlocked(Wheel),
    /// Something locks the wheel at once.
    WheelJammed(Wheel),
    /// A motor lead is off: no current.
    MotorUnplugged(Wheel),
    /// The motor's leads are swapped.
    MotorReversed(Wheel),
    /// The encoders' plugs are exchanged: each counter counts the other wheel.
    EncodersExchanged,
    /// The motors' connectors are exchanged: each duty drives the other wheel.
    MotorsExchanged,
    /// The motor driver shuts both bridges off and pulls its fault line.
    DriverFault,
    /// The battery's voltage falls; or rises, if negative, as a full one does under braking motors.
    SupplyDip {
        /// By how much \[V\].
        volts: f64,
    },
    /// The emergency stop is pressed. It is a line to the controller and cuts no power by itself.
    EmergencyStop,
}

/// What a hand that grabs a wheel holds in the end: more than any small gear motor and tyre \[N m\].
pub const CLAMP_NM: f64 = 4.0;
/// How long the hand takes to close \[us\].
pub const CLAMP_RAMP_US: u64 = 25_000;

/// One wheel's mechanical and motor faults. The encoder keeps its own.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WheelFaults {
    pub blocked_since_us: Option<u64>,
    pub jammed: bool,
    pub motor_unplugged: bool,
    pub motor_reversed: bool,
}

impl WheelFaults {
    /// The friction of a hand or a jam at a time \[N m\].
    #[inline]
    pub fn clamp_nm(&self, t_us: u64) -> f64 {
        match self.blocked_since_us {
            _ if self.jammed => f64::INFINITY,
            None => 0.0,
            Some(since_us) => {
                let closed = t_us.saturating_sub(since_us) as f64 / CLAMP_RAMP_US as f64;
                CLAMP_NM * closed.min(1.0)
            }
        }
    }
}

/// The faults that are present.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Faults {
    pub wheel: WheelPair<WheelFaults>,
    pub driver: bool,
    pub encoders_exchanged: bool,
    pub motors_exchanged: bool,
    pub estop: bool,
    pub dip_v: f64,
}
