//! Drives a motion: arms the robot, commands and renews the motion, records telemetry, and leaves
//! the robot standing still.
//!
//! What follows from the recording is left to the caller.

#[cfg(test)]
mod crawling_robot;
mod rest;
mod velocity;
mod voltage;

use std::rc::Rc;
use std::time::Duration;

use shared_proto::{
    Command, Drive, Event, MotionEnd, MotionError, MotionId, Refusal, Telemetry, TravelUnit,
    WheelPair,
};

use crate::error::{Error, Result};
use crate::session::Session;

pub use self::velocity::{EVERY, Twist, drive_at};
pub use self::voltage::{VoltageRun, VoltageStep, apply_voltages};

use self::rest::{
    RENEW_EVERY, bring_to_rest, faulted, is_anothers, is_moving, leave_as_found, left_at, release,
    standing, stop_if_cancelled, wait_for_stop,
};

/// From the command to the beginning of the recording: enough to send the command seven times.
const LEAD: Duration = Duration::from_millis(300);

/// A motion is given up after this many commands that arrived too late.
const START_TRIES: u32 = 3;

/// Telemetry that is this late will not come: twice the longest period.
const TELEMETRY_LATE: Duration = Duration::from_secs(2);

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

    /// The command for it: to begin at once.
    pub fn drive_now(&self, motion: MotionId) -> Drive {
        let Self { unit, distance, cruise, acceleration } = *self;
        Drive { motion, unit, distance, cruise, acceleration, start_us: None }
    }

    /// The same motion backwards.
    pub fn reversed(self) -> Self {
        Self { distance: self.distance.map(|distance| -distance), ..self }
    }

    /// How long it takes, from a standing start \[s\].
    ///
    /// With d the farther wheel's distance, v the cruise speed and a the acceleration:
    /// d/v + v/a if the ramps leave room for a cruise, else 2 sqrt(d/a).
    pub fn duration_s(&self) -> f64 {
        let Self { distance, cruise, acceleration, .. } = *self;
        let distance = distance.left.abs().max(distance.right.abs());
        if distance * acceleration >= cruise * cruise {
            distance / cruise + cruise / acceleration
        } else {
            2.0 * (distance / acceleration).sqrt()
        }
    }

    /// How long each of its ramps takes, from a standing start \[s\]: v/a, or sqrt(d/a) without a
    /// cruise.
    pub fn ramp_s(&self) -> f64 {
        let Self { distance, cruise, acceleration, .. } = *self;
        let distance = distance.left.abs().max(distance.right.abs());
        (cruise / acceleration).min((distance / acceleration).sqrt())
    }
}

/// What happened during a motion.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Telemetry from a moment before the motion to a moment after it.
    pub telemetry: Vec<Telemetry>,
    /// How the motion ended: at its target or by a stop. A fault is an error.
    pub end: MotionEnd,
}

/// Triggers a camera, so that its images are numbered from the beginning of a recording.
pub type Trigger = Rc<dyn Fn(u64)>;

/// How to record a motion.
#[derive(Clone)]
pub struct RecordOptions {
    /// Time between two telemetry frames \[ms\].
    pub period_ms: u16,
    /// How long to record the robot standing still before and after the motion.
    pub rest: Duration,
    /// Called with the time at which the recording begins, on the robot's clock \[us\], before the
    /// robot is commanded to drive.
    pub trigger: Option<Trigger>,
}

impl Default for RecordOptions {
    fn default() -> Self {
        Self { period_ms: 10, rest: Duration::from_millis(500), trigger: None }
    }
}

/// Drives a motion to its end, with the motors off before and after.
///
/// However this ends, by a fault, a [`Cancel`](crate::Cancel) or a lost link, the robot is left
/// standing still. A robot that is already moving, by another command, is an error, and nothing
/// changes.
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

/// As [`drive`], but appends the telemetry to the caller's, who has it even if this fails.
pub async fn drive_into(
    session: &mut Session,
    motion: &Motion,
    options: RecordOptions,
    telemetry: &mut Vec<Telemetry>,
    progress: &mut dyn FnMut(f64),
) -> Result<MotionEnd> {
    let found = standing(session).await?;
    session.request(Command::Subscribe { period_ms: options.period_ms }).await?;
    let mut commanded = false;
    let id = session.new_motion();
    // Telemetry of earlier motions must not be taken for this one's.
    let mut own = Vec::new();
    let outcome =
        drive_armed(session, (motion, id), &options, &mut own, progress, &mut commanded).await;
    telemetry.append(&mut own);
    // If the link is lost, this fails as well, and the robot has stopped by itself.
    if let Err(error) = outcome {
        let rest = match commanded {
            true => bring_to_rest(session, id, motion.cruise / motion.acceleration).await,
            false => leave_as_found(session, found).await,
        };
        telemetry.extend(session.take_all_telemetry());
        return Err(left_at(error, rest));
    }
    release(session, id).await?;
    outcome
}

/// Steering against a pull makes a wheel travel farther by b c / 2, at most 5 m x 0.1 rad/m / 2 by their ranges.
const STEERED: f64 = 1.25;
/// An emulated robot may be slower than real time: a fifth at most.
const SLOWEST: f64 = 5.0;
/// The longest lead of a command to drive: [`LEAD`] times 16.
const LEAD_S_MAX: f64 = 4.8;

async fn drive_armed(
    session: &mut Session,
    (motion, id): (&Motion, MotionId),
    options: &RecordOptions,
    telemetry: &mut Vec<Telemetry>,
    progress: &mut dyn FnMut(f64),
    commanded: &mut bool,
) -> Result<MotionEnd> {
    let _stale = session.take_telemetry().count() + session.take_events().count();
    stop_if_cancelled(session)?;
    session.request(Command::Arm { take: false }).await?;
    let start_us = start(session, motion, id, options, telemetry, commanded).await?;

    let begun_us = session.clock().now_us();
    let mut heard_us = begun_us;
    let mut last_us = 0;
    let duration_s = motion.duration_s();
    loop {
        session.listen(RENEW_EVERY).await?;
        telemetry.extend(session.take_telemetry());
        let now_us = session.clock().now_us();
        // Progress is taken from the robot's clock: an emulated robot may be slower than real time.
        if let Some(frame) = telemetry.last()
            && frame.t_us != last_us
        {
            (last_us, heard_us) = (frame.t_us, now_us);
        }
        let elapsed_s = (last_us as f64 - start_us as f64) * 1e-6;
        // The clock may have been set back.
        let silent_s = now_us.saturating_sub(heard_us) as f64 * 1e-6;
        progress((elapsed_s / duration_s).clamp(0.0, 1.0));
        stop_if_cancelled(session)?;
        if session.take_events().any(|event| ends_motion(&event, id))
            || end_us(telemetry, start_us).is_some()
            || elapsed_s > STEERED * duration_s + 5.0
            || silent_s > 5.0
        {
            break;
        }
        // By the computer's clock: with the robot's alone, one that crawls would be renewed for ever.
        let waited_s = now_us.saturating_sub(begun_us) as f64 * 1e-6;
        if waited_s
            > SLOWEST * (STEERED * duration_s + 5.0) + LEAD_S_MAX + options.rest.as_secs_f64()
        {
            return Err(Error::ClockCrawls { waited_s, elapsed_s: elapsed_s.max(0.0) });
        }
        // If the motion has just ended by a fault, the status below says so.
        session.post(Command::Renew { motion: id }).await?;
    }
    let status = wait_for_stop(session, id, motion.cruise / motion.acceleration, true).await?;
    if let Some(report) = status.fault {
        return Err(faulted(session, report));
    }
    if is_anothers(&status, id) {
        return Err(Error::StoppedByAnother);
    }
    let end = match status.motion_end {
        Some(end) => end,
        None => return Err(Error::NeverEnded),
    };
    progress(1.0);
    let until_us = receive_until_end(session, start_us, options.rest, telemetry).await?;
    stop_if_cancelled(session)?;
    let from_us = start_us.saturating_sub(options.rest.as_micros() as u64);
    telemetry.retain(|frame| (from_us..=until_us).contains(&frame.t_us));
    Ok(end)
}

/// Commands the motion to begin at a time on the robot's clock, and returns that time \[us\].
///
/// So a command that is repeated does not begin later, and the recording has the same instants of
/// the motion, whatever the line lost. `commanded` is true as soon as the robot may have received
/// the command.
async fn start(
    session: &mut Session,
    motion: &Motion,
    id: MotionId,
    options: &RecordOptions,
    telemetry: &mut Vec<Telemetry>,
    commanded: &mut bool,
) -> Result<u64> {
    let rest_us = options.rest.as_micros() as u64;
    let period_us = u64::from(options.period_ms.max(1)) * 1000;
    for attempt in 0..START_TRIES {
        let now_us = latest_time_us(session, telemetry).await?;
        // A multiple of the telemetry period, so that every recording has the same instants of its
        // motion. If the command came too late on a busy line, the next one has four times as long.
        let ahead_us = (LEAD.as_micros() as u64) * 4_u64.pow(attempt) + rest_us;
        let start_us = now_us.saturating_add(ahead_us.next_multiple_of(period_us));
        let drive = Drive { start_us: Some(start_us), ..motion.drive_now(id) };
        if let Some(trigger) = &options.trigger {
            trigger(start_us - rest_us);
        }
        *commanded = true;
        let answer = session.ask(Command::Drive(drive)).await?;
        *commanded = answer.is_ok();
        match answer {
            Ok(_) => return Ok(start_us),
            // So many copies of the command were lost that its time had passed.
            Err(Refusal::Motion(MotionError::Start)) => {}
            // Before the arming there was none.
            Err(Refusal::Faulted(report)) => return Err(faulted(session, report)),
            Err(refusal) => return Err(Error::Refused { request: "drive", refusal }),
        }
    }
    Err(Error::StartTooLate)
}

/// The time of the latest telemetry on the robot's clock \[us\]; waits for the first frame.
async fn latest_time_us(session: &mut Session, telemetry: &mut Vec<Telemetry>) -> Result<u64> {
    let give_up_us = session.clock().now_us() + TELEMETRY_LATE.as_micros() as u64;
    loop {
        telemetry.extend(session.take_telemetry());
        if let Some(latest) = telemetry.last() {
            return Ok(latest.t_us);
        }
        if session.clock().now_us() > give_up_us {
            return Err(Error::NoTelemetry);
        }
        session.listen(RENEW_EVERY).await?;
    }
}

/// Listens until all telemetry of the rest after the motion has arrived; returns when that rest
/// ends, on the robot's clock \[us\].
async fn receive_until_end(
    session: &mut Session,
    start_us: u64,
    rest: Duration,
    telemetry: &mut Vec<Telemetry>,
) -> Result<u64> {
    let give_up_us = session.clock().now_us() + (rest + TELEMETRY_LATE).as_micros() as u64;
    loop {
        telemetry.extend(session.take_telemetry());
        let until_us = end_us(telemetry, start_us)
            .map(|end_us| end_us.saturating_add(rest.as_micros() as u64));
        if let Some(until_us) = until_us
            && telemetry.last().is_some_and(|last| last.t_us >= until_us)
        {
            return Ok(until_us);
        }
        if session.clock().now_us() > give_up_us {
            telemetry.extend(session.take_all_telemetry());
            return Ok(until_us.unwrap_or(u64::MAX));
        }
        session.listen(RENEW_EVERY).await?;
    }
}

/// When the motion that began at `start_us` ended, by the telemetry \[us\].
fn end_us(telemetry: &[Telemetry], start_us: u64) -> Option<u64> {
    // Searched from the end: after the motion no frame shows the robot moving.
    let over = |frame: &&Telemetry| frame.t_us > start_us && !is_moving(frame.state);
    telemetry.iter().rev().take_while(over).last().map(|frame| frame.t_us)
}

/// Whether an event says that this motion is over.
fn ends_motion(event: &Event, id: MotionId) -> bool {
    match event {
        Event::MotionEnded { motion, .. } => *motion == id,
        Event::Fault(_) => true,
        Event::State { .. } => false,
    }
}
