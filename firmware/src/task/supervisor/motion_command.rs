//! A motion that a host wants: how each wheel is checked, and its plan.

use shared_proto::{Config, Drive, MotionError, MotionId, Velocity, Voltage, WheelPair};

use crate::probe::Direction;
use crate::profile::{Plan, ProfileState};

/// How many motions before the last one are remembered; a power of two, so that the index can wrap.
pub(super) const EARLIER_MOTIONS: usize = 8;

/// A motion that a host wants.
#[derive(Clone, Copy)]
pub(super) enum MotionCommand {
    Drive(Drive),
    Velocity(Velocity),
    Voltage(Voltage),
}

impl MotionCommand {
    /// Its number.
    pub(super) fn motion(&self) -> MotionId {
        match self {
            MotionCommand::Drive(drive) => drive.motion,
            MotionCommand::Velocity(velocity) => velocity.motion,
            MotionCommand::Voltage(voltage) => voltage.motion,
        }
    }

    /// Which way each wheel is checked. The wheels of a velocity may turn either way next, so both are.
    pub(super) fn directions(&self, config: &Config) -> WheelPair<Direction> {
        match self {
            MotionCommand::Drive(drive) => drive.distance.map(Direction::of),
            MotionCommand::Velocity(velocity) => {
                let speeds = velocity.wheels_mps(config).unwrap_or(WheelPair::both(0.0));
                speeds.map(|speed| match Direction::of(speed) {
                    Direction::Still => Direction::Forward,
                    direction => direction,
                })
            }
            // A wheel that is to stand may be given a voltage next.
            MotionCommand::Voltage(voltage) => {
                voltage.volts.map(|volts| match Direction::of(volts) {
                    Direction::Still => Direction::Forward,
                    direction => direction,
                })
            }
        }
    }

    /// The plan for it, from this state at this tick.
    pub(super) fn plan(
        &self,
        start_tick: u32,
        from: WheelPair<ProfileState>,
        config: &Config,
    ) -> Result<Plan, MotionError> {
        match self {
            MotionCommand::Drive(drive) => Plan::drive(start_tick, from, drive, config),
            MotionCommand::Velocity(velocity) => {
                let speeds = velocity.wheels_mps(config)?;
                let acceleration = velocity.acceleration_mps2;
                Plan::cruise(start_tick, from, speeds, acceleration, &config.geometry)
            }
            // It has no setpoints.
            MotionCommand::Voltage(_) => Ok(Plan::hold(from.map(|state| state.position.into()))),
        }
    }
}
