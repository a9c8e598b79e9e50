//! Plans: from a state of motion to a standstill at the target.

use shared_proto::{Config, Drive, DriveSi, GeometryConfig, MotionError, WheelPair};

use super::ramps::{Ramps, WheelMove, ceil, position_steps};
use super::state::{Position, ProfileState, Velocity};
use super::trajectory::{Phase, Trajectory};
use crate::soft_float::{is_above, max, min, nearest, to_f64};
use crate::units::{CONTROL_HZ, Travel};

/// A step \[m\]: 2^-64.
const STEP_M: f64 = 1.0 / 18_446_744_073_709_551_616.0;

/// Fractional bits of positions, velocities and accelerations.
const STEP_BITS: u32 = 64;

const HZ: f64 = CONTROL_HZ as f64;

/// Limit of travel from the origin [2^-64 m]: 2^31 m.
const POSITION_MAX: u128 = 1 << 95;

/// A planned motion of both wheels, from its start tick to a standstill at its target.
///
/// Tick numbers wrap around. A tick counts as before the start if the start is less than 2^31 ticks (24 days)
/// ahead, and as after the start otherwise.
#[derive(Clone, Debug)]
pub struct Plan {
    start_tick: u32,
    len_ticks: u32,
    /// False if the plan holds at once. Inverted so that a blank plan is all zeros and takes no flash.
    pub(super) has_start: bool,
    pub(super) trajectories: WheelPair<Trajectory>,
}

impl Plan {
    /// Stands still at the origin.
    pub(super) const ORIGIN: Plan = Plan {
        start_tick: 0,
        len_ticks: 0,
        has_start: false,
        trajectories: WheelPair::both(Trajectory::ORIGIN),
    };

    #[inline]
    fn new(start_tick: u32, trajectories: WheelPair<Trajectory>) -> Plan {
        let len_ticks = trajectories.left.len_ticks().max(trajectories.right.len_ticks());
        Plan { start_tick, len_ticks, has_start: true, trajectories }
    }

    /// Stands still, from now on.
    #[inline]
    pub fn hold(at: WheelPair<Travel>) -> Plan {
        let trajectories = at.map(|travel| Trajectory::hold(Position::from(travel).0.to_bits()));
        Plan { has_start: false, ..Plan::new(0, trajectories) }
    }

    /// The motion that `drive` asks for, from the state `from` at `start_tick`.
    ///
    /// From a standstill both wheels keep the proportion of their distances throughout. If a wheel
    /// moves, each one goes from its own velocity to its own target, as quickly as cruise speed and
    /// acceleration allow, and the quicker one then takes a lower cruise speed so that both end
    /// together. A wheel goes beyond its target only where it cannot brake in time.
    ///
    /// The distances compensate a heading pull, see `steered`. A stop on the way keeps the wheels'
    /// proportion, and with that the compensation.
    #[inline]
    pub fn drive(
        start_tick: u32,
        from: WheelPair<ProfileState>,
        drive: &Drive,
        config: &Config,
    ) -> Result<Plan, MotionError> {
        let drive = DriveInTicks::new(drive, config)?;
        let moves = drive.distances.zip(from).map(|(distance, from)| WheelMove {
            distance,
            velocity: velocity_m_per_tick(&from),
            half: drive.half,
            cruise: drive.cruise,
        });
        let mut ramps = if from.all(|from| from.velocity == Velocity::default()) {
            proportionate(&moves)
        } else {
            moves.as_ref().map(Ramps::quickest)
        };
        if ramps.as_ref().any(|ramps| {
            is_above(ramps.longest_ramp(), Drive::RAMP_S_MAX * HZ)
                || is_above(ramps.duration(), Drive::DURATION_S_MAX * HZ)
        }) {
            return Err(MotionError::TooLong);
        }
        let duration = max(ramps.left.duration(), ramps.right.duration());
        let trajectories = ramps.as_mut().zip(from).map(|(ramps, from)| {
            ramps.stretch(duration);
            ramps.trajectory(from.position.0.to_bits())
        });
        let too_far = |trajectory: &Trajectory| {
            trajectory.target().0.to_bits().unsigned_abs() >= POSITION_MAX
        };
        if trajectories.as_ref().any(too_far) {
            return Err(MotionError::TooFar);
        }
        Ok(Plan::new(start_tick, trajectories))
    }

    /// Brakes both wheels in proportion, so that they come to rest together and the path keeps its
    /// curvature; the faster one brakes with `deceleration_mps2`, above zero.
    #[inline]
    pub fn stop(start_tick: u32, from: WheelPair<ProfileState>, deceleration_mps2: f64) -> Plan {
        /// Longer than any `Drive`: reached only by a deceleration that no configuration permits.
        const DURATION_MAX: f64 = (u32::MAX / 2) as f64;
        let velocities = from.as_ref().map(velocity_m_per_tick);
        let fastest = max(velocities.left.abs(), velocities.right.abs());
        let duration = min(fastest / (deceleration_mps2 / (HZ * HZ)), DURATION_MAX);
        let end_tick = ceil(duration).max(1);
        let trajectories = from.zip(velocities).map(|(from, velocity)| {
            let (position, velocity_steps) = (from.position.0.to_bits(), from.velocity.0.to_bits());
            if velocity_steps == 0 {
                return Trajectory::hold(position);
            }
            let half = nearest(velocity / (2.0 * duration), STEP_BITS);
            let target = position + position_steps(0.5 * velocity * duration);
            Trajectory::brake(Phase::new(0, position, velocity_steps, -half), end_tick, target)
        });
        Plan::new(start_tick, trajectories)
    }

    /// Both wheels change to these speeds \[m/s\] along one ramp, and keep them for [`Plan::CRUISE_TICKS`].
    ///
    /// The wheel whose speed changes most does so with `acceleration_mps2`, above zero; the other one takes as
    /// long. The speeds compensate a heading pull, as the distances of a drive do.
    #[inline]
    pub fn cruise(
        start_tick: u32,
        from: WheelPair<ProfileState>,
        speeds_mps: WheelPair<f64>,
        acceleration_mps2: f64,
        geometry: &GeometryConfig,
    ) -> Result<Plan, MotionError> {
        let before = from.as_ref().map(velocity_m_per_tick);
        let after = steered(speeds_mps, geometry).map(|speed| speed / HZ);
        let changes = after.zip(before).map(|(after, before)| after - before);
        let acceleration = acceleration_mps2 / (HZ * HZ);
        let duration = max(changes.left.abs(), changes.right.abs()) / acceleration;
        if is_above(duration, Drive::RAMP_S_MAX * HZ) {
            return Err(MotionError::TooLong);
        }
        let trajectories = from.zip(before.zip(changes)).map(|(from, (velocity, change))| {
            ramp_to_cruise(from.position.0.to_bits(), velocity, change, duration)
        });
        let too_far = |trajectory: &Trajectory| {
            trajectory.target().0.to_bits().unsigned_abs() >= POSITION_MAX
        };
        if trajectories.as_ref().any(too_far) {
            return Err(MotionError::TooFar);
        }
        Ok(Plan::new(start_tick, trajectories))
    }

    /// How long a [`Plan::cruise`] lasts: 24 days, the longest time that tick numbers can tell.
    pub const CRUISE_TICKS: u32 = i32::MAX as u32 - 1;

    /// State of both wheels at `tick`: the start's before the start, the target's after the end.
    #[inline]
    pub fn at(&self, tick: u32) -> WheelPair<ProfileState> {
        let elapsed = self.elapsed(tick);
        self.trajectories.map(|trajectory| trajectory.at(elapsed).state())
    }

    /// Tick at which the plan begins.
    pub const fn start_tick(&self) -> u32 {
        self.start_tick
    }

    /// First tick at which both wheels stand at the target.
    pub const fn end_tick(&self) -> u32 {
        self.start_tick.wrapping_add(self.len_ticks)
    }

    /// Where the plan ends.
    #[inline]
    pub fn target(&self) -> WheelPair<Travel> {
        self.trajectories.map(|trajectory| trajectory.target().into())
    }

    /// Ticks since the start, 0 before it.
    pub(super) fn elapsed(&self, tick: u32) -> u32 {
        (tick.wrapping_sub(self.start_tick) as i32).max(0) as u32
    }

    /// Ticks from start to end.
    pub(super) const fn len_ticks(&self) -> u32 {
        self.len_ticks
    }
}

/// One wheel's velocity changes in `duration` and stays, until [`Plan::CRUISE_TICKS`] \[m, ticks\]; from position
/// `from` [2^-64 m].
#[inline]
fn ramp_to_cruise(from: i128, velocity: f64, change: f64, duration: f64) -> Trajectory {
    let cruise = velocity + change;
    let first = ceil(duration).min(Plan::CRUISE_TICKS);
    // Without a ramp there is nothing to divide by, and no tick inside.
    let half = if first == 0 { 0.0 } else { change / (2.0 * duration) };
    let ramped = (velocity + 0.5 * change) * duration;
    let into_cruise = to_f64(i64::from(first)) - duration;
    let [steps, half] = [cruise, half].map(|value| nearest(value, STEP_BITS));
    let at_cruise = from + position_steps(ramped + cruise * into_cruise);
    let target = at_cruise + i128::from(Plan::CRUISE_TICKS - first) * i128::from(steps);
    let cruising = Phase::new(first, at_cruise, steps, 0);
    Trajectory::new([
        Phase::new(0, from, nearest(velocity, STEP_BITS), half),
        cruising,
        cruising,
        Phase::new(Plan::CRUISE_TICKS, target, 0, 0),
    ])
}

/// A valid [`Drive`] in metres and ticks, steered against the robot's pull.
struct DriveInTicks {
    distances: WheelPair<f64>,
    cruise: f64,
    half: f64,
}

impl DriveInTicks {
    #[inline]
    fn new(drive: &Drive, config: &Config) -> Result<Self, MotionError> {
        let DriveSi { distance_m, cruise_mps, acceleration_mps2 } = drive.to_si(config)?;
        let distances = steered(distance_m, &config.geometry);
        if distances.all(|distance| is_above(STEP_M, distance.abs())) {
            return Err(MotionError::NoDistance);
        }
        let (cruise, half) = (cruise_mps / HZ, acceleration_mps2 / (2.0 * HZ * HZ));
        // So slow that it is less than one step of 2^-64 m.
        if is_above(STEP_M, cruise) || is_above(STEP_M, half) {
            return Err(MotionError::TooLong);
        }
        Ok(Self { distances, cruise, half })
    }
}

/// Wheel distances that compensate the robot's heading pull:
///
/// ```text
/// dtheta = (d_R - d_L) / b + c |s|,   s = (d_L + d_R) / 2      heading change with the pull
/// d_L' = d_L + b c |s| / 2,   d_R' = d_R - b c |s| / 2         so dtheta is (d_R - d_L) / b again
/// ```
///
/// b is the track width \[m\], c the pull \[rad/m\], to the left if positive. s does not change.
/// Without a pull, and in a turn on the spot, the distances keep their bits. A motion that reverses before
/// its target, as one from a moving state may, travels more than |s|: the compensation is then too small.
#[inline]
fn steered(distances_m: WheelPair<f64>, geometry: &GeometryConfig) -> WheelPair<f64> {
    let WheelPair { left, right } = distances_m;
    let gain = 0.25 * geometry.track_width_m * geometry.heading_pull_rad_per_m;
    let bend_m = gain * (left + right).abs();
    WheelPair::new(left + bend_m, right - bend_m)
}

#[inline]
fn velocity_m_per_tick(state: &ProfileState) -> f64 {
    to_f64(state.velocity.0.to_bits()) * STEP_M
}

/// From rest: the wheel that goes farther takes the quickest motion, the other one follows in proportion.
#[inline]
fn proportionate(moves: &WheelPair<WheelMove>) -> WheelPair<Ramps> {
    if !is_above(moves.right.distance.abs(), moves.left.distance.abs()) {
        let left = Ramps::quickest(&moves.left);
        WheelPair::new(left, left.in_proportion(moves.right.distance))
    } else {
        let right = Ramps::quickest(&moves.right);
        WheelPair::new(right.in_proportion(moves.left.distance), right)
    }
}
