//! Driving: arms, commands, keeps the motion alive, listens, and leaves the robot standing still.

use std::time::Duration;

use shared_proto::{Command, Drive, MotionEnd, State, Telemetry, TravelUnit, WheelPair};

use crate::error::{Error, Result};
use crate::interrupt;
use crate::session::{Session, faulted};

/// The robot stops by itself if it hears nothing for this long \[ms\].
const TTL_MS: u16 = 200;

/// The host renews a motion this often: of six in a time to live five may be lost, the shortest
/// `protection.link_timeout_s` leaves room for one, and a line of 9600 baud carries it.
const RENEW_EVERY: Duration = Duration::from_millis(30);

/// What to drive, on the wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// The unit of the other quantities.
    pub unit: TravelUnit,
    /// How far each wheel travels \[unit\].
    pub distance: WheelPair<f64>,
    /// Speed between the ramps \[unit/s\].
    pub cruise: f64,
    /// Steepness of the ramps \[unit/s^2\].
    pub acceleration: f64,
}

impl Motion {
    /// The paper's run: eight wheel revolutions at 0.523 rev/s, with ramps of 0.101 rev/s^2.
    pub const PAPER: Self = Self {
        unit: TravelUnit::WheelRevolution,
        distance: WheelPair::both(8.0),
        cruise: 0.523,
        acceleration: 0.101,
    };

    /// The same motion backwards.
    pub fn reversed(self) -> Self {
        Self { distance: self.distance.map(|distance| -distance), ..self }
    }

    /// How long it takes, from a standing start \[s\].
    ///
    /// With d the farther wheel's distance, v the cruise speed and a the acceleration:
    /// d/v + v/a where the ramps leave room for a cruise, else 2 sqrt(d/a).
    pub fn duration_s(&self) -> f64 {
        let Self { distance, cruise, acceleration, .. } = *self;
        let distance = distance.left.abs().max(distance.right.abs());
        if distance * acceleration >= cruise * cruise {
            distance / cruise + cruise / acceleration
        } else {
            2.0 * (distance / acceleration).sqrt()
        }
    }
}

/// What happened during a motion.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Telemetry from a moment before the motion to a moment after it.
    pub telemetry: Vec<Telemetry>,
    /// How it ended: at its target or by a stop. A fault is an error.
    pub end: MotionEnd,
}

/// How to record a motion.
#[derive(Clone, Copy, Debug)]
pub struct RecordOptions {
    /// Time between two telemetry frames \[ms\].
    pub period_ms: u16,
    /// Recording goes on this long before and after the motion, standing still.
    pub rest: Duration,
}

impl Default for RecordOptions {
    fn default() -> Self {
        Self { period_ms: 10, rest: Duration::from_millis(500) }
    }
}

/// Drives a motion to its end, with the motors off before and after.
///
/// However this ends, by a fault, Ctrl-C or a lost link, the robot is left standing still.
pub async fn drive(
    session: &mut Session,
    motion: &Motion,
    options: RecordOptions,
    progress: &mut dyn FnMut(f64),
) -> Result<Recording> {
    let mut telemetry = Vec::new();
    let end = drive_into(session, motion, options, &mut telemetry, progress).await?;
    Ok(Recording { telemetry, end })
}

/// As [`drive`], but whoever calls has the telemetry even if this fails.
pub async fn drive_into(
    session: &mut Session,
    motion: &Motion,
    options: RecordOptions,
    telemetry: &mut Vec<Telemetry>,
    progress: &mut dyn FnMut(f64),
) -> Result<MotionEnd> {
    session.request(Command::Subscribe { period_ms: options.period_ms }).await?;
    let outcome = drive_armed(session, motion, options, telemetry, progress).await;
    // Where it failed for want of a link these fail too, and the robot has stopped by itself.
    if let Err(error) = outcome {
        let _ = session.ask(Command::Stop).await;
        let _ = wait_for_stop(session).await;
        let _ = session.ask(Command::Disarm).await;
        let _ = session.ask(Command::Subscribe { period_ms: 0 }).await;
        telemetry.extend(session.take_telemetry());
        return Err(error);
    }
    session.request(Command::Disarm).await?;
    session.request(Command::Subscribe { period_ms: 0 }).await?;
    outcome
}

async fn drive_armed(
    session: &mut Session,
    motion: &Motion,
    options: RecordOptions,
    telemetry: &mut Vec<Telemetry>,
    progress: &mut dyn FnMut(f64),
) -> Result<MotionEnd> {
    let _stale = session.take_telemetry().count() + session.take_events().count();
    session.listen(options.rest).await?;
    stop_if_interrupted()?;
    session.request(Command::Arm).await?;
    let id = session.new_motion();
    let Motion { unit, distance, cruise, acceleration } = *motion;
    let drive = Drive { motion: id, ttl_ms: TTL_MS, unit, distance, cruise, acceleration };
    session.request(Command::Drive(drive)).await?;

    let start_us = session.clock().now_us();
    let duration_s = motion.duration_s();
    loop {
        session.listen(RENEW_EVERY).await?;
        telemetry.extend(session.take_telemetry());
        // The robot's own clock says how far it is, where telemetry tells: an emulated one may be slower
        // than the world.
        let robot_us = telemetry.first().zip(telemetry.last()).map(|(a, b)| b.t_us - a.t_us);
        let elapsed_us = robot_us.unwrap_or(session.clock().now_us() - start_us);
        let elapsed_s = elapsed_us as f64 * 1e-6;
        progress((elapsed_s / duration_s).min(1.0));
        stop_if_interrupted()?;
        if session.take_events().any(|event| ends_motion(&event))
            || telemetry.last().is_some_and(|last| !is_moving(last.state))
            || elapsed_s > duration_s + 5.0
        {
            break;
        }
        // A motion that has just ended by a fault says so in the status below.
        session.post(Command::Renew { motion: id, ttl_ms: TTL_MS }).await?;
    }
    let status = wait_for_stop(session).await?;
    if let Some(report) = status.fault {
        return Err(faulted(&report));
    }
    let end = match status.motion_end {
        Some(end) => end,
        None => return Err(Error::new("the robot never came to the end of its motion")),
    };
    progress(1.0);
    session.listen(options.rest).await?;
    stop_if_interrupted()?;
    telemetry.extend(session.take_telemetry());
    Ok(end)
}

/// Whoever sees this error brings the robot to a stand, or says that the link is lost.
fn stop_if_interrupted() -> Result<()> {
    if interrupt::requested() {
        return Err(Error::interrupted(
            "stopped by Ctrl-C; the robot stands still, its motors are off",
        ));
    }
    Ok(())
}

async fn wait_for_stop(session: &mut Session) -> Result<shared_proto::Status> {
    loop {
        let status = session.status().await?;
        if !is_moving(status.state) {
            return Ok(status);
        }
        session.listen(RENEW_EVERY).await?;
        if let Some(motion) = status.motion {
            session.post(Command::Renew { motion, ttl_ms: TTL_MS }).await?;
        }
    }
}

fn is_moving(state: State) -> bool {
    matches!(state, State::Driving | State::Stopping)
}

fn ends_motion(event: &shared_proto::Event) -> bool {
    matches!(event, shared_proto::Event::MotionEnded { .. } | shared_proto::Event::Fault(_))
}
