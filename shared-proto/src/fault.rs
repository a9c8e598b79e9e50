//! Faults: why a robot stopped by itself.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::pair::{Wheel, WheelPair};

/// A condition under which the robot does not drive.
///
/// A fault is latched: only [`Command::ClearFault`](crate::Command::ClearFault), or holding the emergency
/// stop's button, clears a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// The wheel is farther from its setpoint than `protection.following_error_m_max`.
    FollowingError(Wheel),
    /// The wheel slowed down and stood still although it was driven: blocked, or the motor is off.
    Stall(Wheel),
    /// The count stopped dead, or goes up and down, while the wheel turned: an encoder wire, or a hard jam.
    EncoderDead(Wheel),
    /// The count runs against the motor: encoder or motor wires are swapped.
    EncoderReversed(Wheel),
    /// The count changed faster than the wheel can turn: interference, or a loose wire.
    CountRate(Wheel),
    /// Nothing was heard from the host for `protection.link_timeout_s`, or since the lease that has ended.
    LinkLost,
    /// The host talks, but did not renew the motion before its lease ended.
    TimeToLive,
    /// The supply is below `protection.supply_v_min`.
    SupplyLow,
    /// A control tick came too late.
    DeadlineMissed,
    /// The motor driver reports a fault of its own, or turns a wheel, without a duty, as soon as it is switched on.
    Driver,
    /// The emergency stop was pressed, or commanded.
    EmergencyStop,
    /// The supervisor did not act on a silent host in time: the control tick did.
    Unsupervised,
    /// Pushing this wheel's motor moves the other wheel's count: encoders, or motors, are exchanged.
    EncodersExchanged(Wheel),
    /// The supply is above `protection.supply_v_max`.
    SupplyHigh,
    /// The count does not change although the wheel is driven, and what it did before does not tell a motor without current
    /// from a wheel that is held or an encoder without a plug: it had hardly begun to turn, or turned slowly.
    NoResponse(Wheel),
}

impl Fault {
    /// Stable identifier, `"following_error"`.
    pub const fn id(self) -> &'static str {
        match self {
            Fault::FollowingError(_) => "following_error",
            Fault::Stall(_) => "stall",
            Fault::EncoderDead(_) => "encoder_dead",
            Fault::EncoderReversed(_) => "encoder_reversed",
            Fault::CountRate(_) => "count_rate",
            Fault::LinkLost => "link_lost",
            Fault::TimeToLive => "time_to_live",
            Fault::SupplyLow => "supply_low",
            Fault::DeadlineMissed => "deadline_missed",
            Fault::Driver => "driver",
            Fault::EmergencyStop => "emergency_stop",
            Fault::Unsupervised => "unsupervised",
            Fault::EncodersExchanged(_) => "encoders_exchanged",
            Fault::SupplyHigh => "supply_high",
            Fault::NoResponse(_) => "no_response",
        }
    }

    /// The wheel in question, for a fault of one wheel.
    pub const fn wheel(self) -> Option<Wheel> {
        match self {
            Fault::FollowingError(w)
            | Fault::Stall(w)
            | Fault::EncoderDead(w)
            | Fault::EncoderReversed(w)
            | Fault::CountRate(w)
            | Fault::NoResponse(w)
            | Fault::EncodersExchanged(w) => Some(w),
            _ => None,
        }
    }

    /// What to check first.
    pub const fn remedy(self) -> &'static str {
        match self {
            Fault::FollowingError(_) => {
                "check counts_per_rev and gear_reduction; with the duty at its limit, motor wires, driver and battery too; else drive slower, raise protection.following_error_m_max, or let `beeline tune` set feedforward and gains"
            }
            Fault::Stall(_) => {
                "free the wheel; check motor wires, driver supply, driver.name, counts_per_rev and gear_reduction; a motor that nobody tuned: `beeline tune`"
            }
            Fault::EncoderDead(_) => {
                "check the encoder's plug, its supply and its two lines, the motor's wires, and whether something jammed the wheel; if all are well, counts_per_rev and gear_reduction"
            }
            Fault::NoResponse(_) => {
                "check the motor's wires, the driver, driver.name and the driver's supply, the encoder's plug and supply, and whether the wheel turns freely by hand; if all are well, counts_per_rev and gear_reduction, and let `beeline tune` find what this motor needs"
            }
            Fault::EncoderReversed(Wheel::Left) => {
                "on a slope, try a level floor first, and of a new robot check driver.name; else set encoder.left.reversed to its other value with `beeline config set`, whichever of A and B or the motor's leads it is; then let `beeline wiring` find out which way the wheel turns, and mend that"
            }
            Fault::EncoderReversed(Wheel::Right) => {
                "on a slope, try a level floor first, and of a new robot check driver.name; else set encoder.right.reversed to its other value with `beeline config set`, whichever of A and B or the motor's leads it is; then let `beeline wiring` find out which way the wheel turns, and mend that"
            }
            Fault::CountRate(_) => {
                "check counts_per_rev and gear_reduction; shield the encoder's wires"
            }
            Fault::LinkLost => "check the cable; the host stopped talking during a motion",
            Fault::TimeToLive => "the host stopped renewing the motion; was it suspended?",
            Fault::SupplyLow => "charge the battery, or lower protection.supply_v_min",
            Fault::DeadlineMissed => "please report this: a control tick missed its deadline",
            Fault::Driver => {
                "check the motor driver: over-current, over-temperature, or its supply; if a wheel moved as soon as the robot was armed, driver.name is not the driver's (docs/drivers.md), or the robot rolls down a slope, or somebody pushed it"
            }
            Fault::EmergencyStop => "release the emergency stop if it is pressed",
            Fault::Unsupervised => "please report this: the supervisor task stopped",
            Fault::EncodersExchanged(_) => {
                "on a slope, try a level floor first, and of a new robot check driver.name; then turn the left wheel by hand: if the right count changes, exchange the encoders' plugs, otherwise the motors' wires; if neither is exchanged, shield the other encoder's wires: weak interference looks the same"
            }
            Fault::SupplyHigh => {
                "if nothing braked, this supply is too high for the robot or for its divider (18.8 V with 47k and 10k); braking motors charge it: brake more slowly, or use a battery instead of a mains adapter; raise protection.supply_v_max only if driver and divider stand it"
            }
        }
    }

    /// Whether the wheels are braked along a ramp (true) or go to zero duty at once (false).
    ///
    /// Only a fault that leaves encoders and motors trustworthy allows a ramp.
    pub const fn allows_ramp(self) -> bool {
        matches!(self, Fault::LinkLost | Fault::TimeToLive)
    }
}

impl core::fmt::Display for Fault {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.wheel() {
            Some(wheel) => write!(f, "{} ({} wheel)", self.id(), wheel.name()),
            None => f.write_str(self.id()),
        }
    }
}

/// A fault, when it happened, and how the wheels were then.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultReport {
    /// The first fault; later ones are only counted while this one is latched.
    pub fault: Fault,
    /// Counts the faults since power-on, from 1; identifies this fault in the command that clears it.
    pub number: u32,
    /// When, since power-on \[us\].
    pub t_us: u64,
    /// How many more followed while this one was latched.
    pub followed_by: u16,
    /// Each wheel as it was, with the duty until then.
    pub wheels: WheelPair<WheelAtFault>,
    /// Supply \[mV\].
    pub supply_mv: u16,
}

/// A wheel as it was when a fault was latched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelAtFault {
    /// Setpoint minus measured travel \[um\].
    pub error_um: i32,
    /// Measured speed \[um/s\].
    pub speed_um_s: i32,
    /// Duty, forward positive \[1/32767\].
    pub duty: i16,
}
