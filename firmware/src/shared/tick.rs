//! The control tick that capture, profile and PID work on, and telemetry from it.

use core::cell::Cell;

use embassy_sync::blocking_mutex::{Mutex, raw::RawMutex};
use fixed::types::{I8F24, I32F32};
use shared_proto::{
    Pose, PoseDeviation, Telemetry, Wheel, WheelAtFault, WheelPair, WheelTelemetry,
};

use super::in_place::InPlace;
use crate::capture::Measured;
use crate::pid::PidState;
use crate::profile::Setpoint;
use crate::units::{Duty, Speed, Travel};
use crate::voltage::AppliedVoltage;

/// One control tick. Capture, profile and PID each fill in their part in place; nothing is copied.
#[derive(Clone, Copy)]
pub struct Tick {
    /// The wheels as measured.
    pub measured: Measured,
    /// What to do with the wheels.
    pub action: Action,
    /// What to follow, if the action is to track.
    pub setpoints: WheelPair<Setpoint>,
    /// Supply \[mV\].
    pub supply_mv: u16,
    /// Both controllers' states, all zero while the loop is open.
    pub loops: WheelPair<PidState>,
    /// The motors' duties, forward positive.
    pub duty: WheelPair<Duty>,
    /// The encoder-sign check is under way.
    pub probing: bool,
    /// The motors' voltage, summed over time.
    pub applied: AppliedVoltage,
}

/// What to do with the wheels at one tick.
#[derive(Clone, Copy)]
pub enum Action {
    /// Zero duty, drivers off.
    Off,
    /// Zero duty, drivers on: the motors brake.
    Rest,
    /// Check the encoders' signs, open loop.
    Probe {
        /// Identifies the check; returned in the event.
        id: u32,
    },
    /// Follow the tick's setpoints, closed loop.
    Track,
    /// Apply these voltages, open loop \[2^-24 V\].
    Voltage(WheelPair<i32>),
}

/// The wheels and the supply at one control tick.
#[derive(Clone, Copy)]
pub struct Snapshot {
    /// The wheels as measured.
    pub measured: Measured,
    /// Supply \[mV\].
    pub supply_mv: u16,
}

impl<M: RawMutex> InPlace<M, Tick> {
    /// The whole tick, for use outside the control tick: that has no time for conversions to the wire's units.
    #[inline(never)]
    pub fn copy(&self) -> Tick {
        self.with(|tick| *tick)
    }

    /// The wheels and the supply.
    #[inline(never)]
    pub fn get(&self) -> Snapshot {
        self.with(|tick| Snapshot { measured: tick.measured, supply_mv: tick.supply_mv })
    }
}

impl Tick {
    /// Before the first one.
    pub(super) const FIRST: Self = Self {
        measured: Measured {
            tick: 0,
            t_us: 0,
            counts: WheelPair::both(0),
            travel: WheelPair::both(Travel(I32F32::ZERO)),
            speed: WheelPair::both(Speed(I8F24::ZERO)),
        },
        action: Action::Off,
        setpoints: WheelPair::both(Setpoint::ZERO),
        supply_mv: 0,
        loops: WheelPair::both(PidState::ZERO),
        duty: WheelPair::both(Duty::ZERO),
        probing: false,
        applied: AppliedVoltage::ZERO,
    };

    /// The telemetry frame of this tick.
    pub(crate) fn telemetry(
        &self,
        number: u32,
        state: shared_proto::State,
        pose: Pose,
        deviation: PoseDeviation,
    ) -> Telemetry {
        Telemetry {
            number,
            t_us: self.measured.t_us,
            state,
            probing: self.probing,
            wheels: WheelPair { left: self.wheel(Wheel::Left), right: self.wheel(Wheel::Right) },
            supply_mv: self.supply_mv,
            pose,
            deviation,
        }
    }

    /// A wheel as a fault's report has it.
    pub(super) fn at_fault(&self, wheel: Wheel) -> WheelAtFault {
        let WheelTelemetry { error_um, speed_um_s, duty, .. } = self.wheel(wheel);
        WheelAtFault { error_um, speed_um_s, duty }
    }

    fn wheel(&self, wheel: Wheel) -> WheelTelemetry {
        let travel = *self.measured.travel.get(wheel);
        let setpoint = match &self.action {
            Action::Track => self.setpoints.get(wheel).travel,
            _ => travel,
        };
        WheelTelemetry {
            counts: *self.measured.counts.get(wheel),
            setpoint_um: setpoint.to_um(),
            error_um: setpoint.error_um_from(travel),
            speed_um_s: self.measured.speed.get(wheel).to_um_s(),
            terms: self.loops.get(wheel).terms(),
            duty: self.duty.get(wheel).to_i16(),
            applied_uvs: *self.applied.to_uvs().get(wheel),
        }
    }
}

/// The last [`Telemetry::KEPT`] frames that were sent, each in the slot of its number.
pub struct TelemetryHistory<M: RawMutex>(
    Mutex<M, [Cell<Option<Telemetry>>; Telemetry::KEPT as usize]>,
);

impl<M: RawMutex> TelemetryHistory<M> {
    pub(super) const fn new() -> Self {
        Self(Mutex::new([const { Cell::new(None) }; Telemetry::KEPT as usize]))
    }

    /// Keeps a frame, in place of the one that is [`Telemetry::KEPT`] older.
    pub fn keep(&self, telemetry: Telemetry) {
        self.0.lock(|slots| Self::slot(slots, telemetry.number).set(Some(telemetry)));
    }

    /// The frame with this number, if it is still kept.
    pub fn recall(&self, number: u32) -> Option<Telemetry> {
        self.0.lock(|slots| Self::slot(slots, number).get()).filter(|kept| kept.number == number)
    }

    fn slot(slots: &[Cell<Option<Telemetry>>], number: u32) -> &Cell<Option<Telemetry>> {
        &slots[(number % Telemetry::KEPT) as usize]
    }
}
