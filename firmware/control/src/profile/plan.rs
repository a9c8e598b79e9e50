//! Plans: from a state of motion to a standstill at the target.

use shared_proto::{Config, Drive, MotionError, TravelUnit, WheelPair};

use super::course::{Course, Phase};
use super::ramps::{Ramps, TICK_BITS, Task, ceil};
use super::{Position, ProfileState};
use crate::units::{CONTROL_HZ, Travel};
use crate::wide::{div, mul};

/// 2^64, the steps of a metre.
const STEPS_PER_M: f64 = 18_446_744_073_709_551_616.0;

/// Farthest from the origin that travel can be told [2^-64 m]: 2^31 m.
const POSITION_MAX: u128 = 1 << 95;

/// A planned motion of both wheels, from its start tick to a standstill at its target.
///
/// Ticks count on through the end of `u32`; a tick is taken as before the start if it is less
/// than 2^31 ticks before it (24 days), and as after it otherwise.
#[derive(Clone, Debug)]
pub struct Plan {
    start_tick: u32,
    len_ticks: u32,
    /// True if there is no start to wait for.
    pub(super) at_once: bool,
    pub(super) courses: WheelPair<Course>,
}

impl Plan {
    /// Stands still at the origin.
    pub(super) const ORIGIN: Plan = Plan {
        start_tick: 0,
        len_ticks: 0,
        at_once: true,
        courses: WheelPair::both(Course::ORIGIN),
    };

    #[inline]
    fn new(start_tick: u32, courses: WheelPair<Course>) -> Plan {
        let len_ticks = courses.left.len_ticks().max(courses.right.len_ticks());
        Plan { start_tick, len_ticks, at_once: false, courses }
    }

    /// Stands still, from now on.
    #[inline]
    pub fn hold(at: WheelPair<Travel>) -> Plan {
        let courses = at.map(|travel| Course::hold(Position::from(travel).0.to_bits()));
        Plan { at_once: true, ..Plan::new(0, courses) }
    }

    /// The motion that `drive` asks for, from the state `from` at `start_tick`.
    ///
    /// From a standstill both wheels keep the proportion of their distances throughout. If a wheel
    /// moves, each one goes from its own velocity to its own target, as quickly as cruise speed and
    /// acceleration allow, and the quicker one then takes a lower cruise speed so that both end
    /// together. A wheel goes beyond its target only where it cannot brake in time.
    #[inline]
    pub fn drive(
        start_tick: u32,
        from: WheelPair<ProfileState>,
        drive: &Drive,
        config: &Config,
    ) -> Result<Plan, MotionError> {
        let order = Order::new(drive, config)?;
        let tasks = order.distances.zip(from).map(|(distance, from)| Task {
            distance,
            velocity: from.velocity.0.to_bits(),
            half: order.half,
            cruise: order.cruise,
        });
        let ramps = if tasks.all(|task| task.velocity == 0) {
            proportionate(tasks)
        } else {
            tasks.map(Ramps::quickest)
        };
        let steps = |time_s: f64| ((time_s * f64::from(CONTROL_HZ)) as i128) << TICK_BITS;
        if ramps.any(|ramps| {
            ramps.longest_ramp() > steps(Drive::RAMP_S_MAX)
                || ramps.duration() > steps(Drive::DURATION_S_MAX)
        }) {
            return Err(MotionError::TooLong);
        }
        let duration = ramps.left.duration().max(ramps.right.duration());
        let courses = ramps
            .zip(from)
            .map(|(ramps, from)| ramps.stretched(duration).course(from.position.0.to_bits()));
        if courses.any(|course| course.target().0.to_bits().unsigned_abs() >= POSITION_MAX) {
            return Err(MotionError::TooFar);
        }
        Ok(Plan::new(start_tick, courses))
    }

    /// Brakes both wheels in proportion, so that they come to rest together and the path keeps its
    /// curvature; the faster one brakes with `deceleration_mps2`, above zero.
    #[inline]
    pub fn stop(start_tick: u32, from: WheelPair<ProfileState>, deceleration_mps2: f64) -> Plan {
        let half = i128::from(half_acceleration(deceleration_mps2).max(1));
        let speed = |state: ProfileState| i128::from(state.velocity.0.to_bits()).abs();
        let fastest = speed(from.left).max(speed(from.right));
        // Rounded up, so that the deceleration is not exceeded; at least one step.
        let duration = div((fastest << TICK_BITS) + 2 * half - 1, 2 * half).max(1);
        // Longer than any `Drive` takes: only a deceleration that no configuration has asks for it.
        let duration = duration.min(i128::from(u32::MAX / 2) << TICK_BITS);
        let courses = from.map(|from| {
            let (position, velocity) = (from.position.0.to_bits(), from.velocity.0.to_bits());
            if fastest == 0 {
                return Course::hold(position);
            }
            let half = div(i128::from(velocity) << TICK_BITS, 2 * duration);
            let target = position + (mul(velocity.into(), duration) >> (TICK_BITS + 1));
            Course::brake(Phase::new(0, position, velocity, -half as i64), ceil(duration), target)
        });
        Plan::new(start_tick, courses)
    }

    /// State of both wheels at `tick`: that at the start before it, that at the target after the end.
    #[inline]
    pub fn at(&self, tick: u32) -> WheelPair<ProfileState> {
        let elapsed = self.elapsed(tick);
        self.courses.map(|course| course.at(elapsed).state())
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
        self.courses.map(|course| course.target().into())
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

/// A valid [`Drive`] in steps of 2^-64 m and ticks.
struct Order {
    distances: WheelPair<i128>,
    cruise: i64,
    half: i64,
}

impl Order {
    #[inline]
    fn new(drive: &Drive, config: &Config) -> Result<Self, MotionError> {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        if !positive(drive.cruise)
            || !positive(drive.acceleration)
            || !drive.distance.all(f64::is_finite)
        {
            return Err(MotionError::NotPositive);
        }
        if !Drive::TTL_MS.contains(&drive.ttl_ms) {
            return Err(MotionError::TimeToLive);
        }
        let unit_m = match drive.unit {
            TravelUnit::Meter => 1.0,
            TravelUnit::WheelRevolution => core::f64::consts::TAU * config.geometry.wheel_radius_m,
        };
        let (cruise_mps, acceleration_mps2) = (drive.cruise * unit_m, drive.acceleration * unit_m);
        let distances_m = drive.distance.map(|distance| distance * unit_m);
        if distances_m.any(|distance| distance.abs() > Drive::DISTANCE_M_MAX) {
            return Err(MotionError::TooFar);
        }
        if cruise_mps > config.limits.speed_mps_max {
            return Err(MotionError::TooFast);
        }
        if acceleration_mps2 > config.limits.acceleration_mps2_max {
            return Err(MotionError::TooSteep);
        }
        let order = Self {
            distances: distances_m.map(|distance| (distance * STEPS_PER_M) as i128),
            cruise: (cruise_mps / f64::from(CONTROL_HZ) * STEPS_PER_M) as i64,
            half: half_acceleration(acceleration_mps2),
        };
        if order.distances.all(|distance| distance == 0) {
            return Err(MotionError::NoDistance);
        }
        // So slow that one step of 2^-64 is too much.
        if order.cruise == 0 || order.half == 0 {
            return Err(MotionError::TooLong);
        }
        Ok(order)
    }
}

/// Half an acceleration [2^-64 m/tick^2], rounded down.
#[inline]
fn half_acceleration(acceleration_mps2: f64) -> i64 {
    let hz = f64::from(CONTROL_HZ);
    (acceleration_mps2 / (hz * hz) * (STEPS_PER_M / 2.0)) as i64
}

/// From rest: the wheel that goes farther as quickly as it may, the other one in proportion.
#[inline]
fn proportionate(tasks: WheelPair<Task>) -> WheelPair<Ramps> {
    if tasks.left.distance.abs() >= tasks.right.distance.abs() {
        let left = Ramps::quickest(tasks.left);
        WheelPair::new(left, left.in_proportion(tasks.right.distance))
    } else {
        let right = Ramps::quickest(tasks.right);
        WheelPair::new(right.in_proportion(tasks.left.distance), right)
    }
}
