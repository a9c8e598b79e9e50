//! Voltages at the motors without feedback: the experiments that identify a motor.

use std::time::Duration;

use shared_proto::{Command, Event, MotionEnd, MotionId, State, Telemetry, Voltage, WheelPair};

use super::ends_motion;
use super::rest::RENEW_EVERY;
use super::rest::{
    bring_to_rest, faulted, is_anothers, leave_as_found, left_at, release, standing,
    stop_if_cancelled, wait_for_stop,
};
use crate::error::{Error, Result};
use crate::session::Session;

/// Voltages for a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoltageStep {
    /// At both motors, forward positive \[V\].
    pub volts: WheelPair<f64>,
    /// For so long \[s\].
    pub duration_s: f64,
}

/// Voltages one after the other, without a stop between them.
#[derive(Clone, Debug, PartialEq)]
pub struct VoltageRun {
    /// The voltages.
    pub steps: Vec<VoltageStep>,
    /// How fast they change \[V/s\].
    pub ramp_v_per_s: f64,
    /// A step ends the run once a wheel has gone this far from where the step began \[m\].
    pub travel_m_max: f64,
    /// The run ends once a wheel turns faster \[m/s\].
    pub speed_mps_max: f64,
    /// Time between two telemetry frames \[ms\].
    pub period_ms: u16,
}

/// How long the robot's step may outlast the host's, while the next one is on its way.
const STEP_MARGIN_S: f64 = 0.5;
/// Telemetry of the robot at rest, behind a run.
const REST: Duration = Duration::from_millis(150);
/// An emulated robot may be slower than real time: a fifth at most.
const SLOWEST: f64 = 5.0;
/// Wheels roll out for so long at most \[s\], as the firmware has it, and a little more.
const ROLL_S_MAX: f64 = 6.0;

/// Applies voltages until the last step is over, or a limit is reached; the motors are off before and after.
///
/// Returns how it ended, and appends the telemetry to the caller's, who has it even if this fails. However this ends,
/// by a fault, a [`Cancel`](crate::Cancel) or a lost link, the robot is left standing still.
pub async fn apply_voltages(
    session: &mut Session,
    run: &VoltageRun,
    telemetry: &mut Vec<Telemetry>,
) -> Result<MotionEnd> {
    let found = standing(session).await?;
    session.request(Command::Subscribe { period_ms: run.period_ms }).await?;
    let _stale = session.take_telemetry().count() + session.take_events().count();
    let mut commanded = None;
    let outcome = apply(session, run, telemetry, &mut commanded).await;
    telemetry.extend(session.take_all_telemetry());
    if let Err(error) = outcome {
        let rest = match commanded {
            Some(motion) => bring_to_rest(session, motion, ROLL_S_MAX).await,
            None => leave_as_found(session, found).await,
        };
        return Err(left_at(error, rest));
    }
    if let Some(motion) = commanded {
        release(session, motion).await?;
    } else {
        leave_as_found(session, found).await?;
    }
    outcome
}

async fn apply(
    session: &mut Session,
    run: &VoltageRun,
    telemetry: &mut Vec<Telemetry>,
    commanded: &mut Option<MotionId>,
) -> Result<MotionEnd> {
    session.request(Command::Arm { take: false }).await?;
    for (index, step) in run.steps.iter().enumerate() {
        stop_if_cancelled(session)?;
        let is_last = index + 1 == run.steps.len();
        let margin_s = if is_last { 0.0 } else { STEP_MARGIN_S };
        let motion = session.new_motion();
        let voltage = Voltage {
            motion,
            volts: step.volts,
            ramp_v_per_s: run.ramp_v_per_s,
            duration_s: step.duration_s + margin_s,
            travel_m_max: run.travel_m_max,
            speed_mps_max: run.speed_mps_max,
        };
        let answer = session.ask(Command::Voltage(voltage)).await?;
        if answer.is_ok() {
            *commanded = Some(motion);
        }
        let request = if index == 0 { "apply a voltage" } else { "apply another voltage" };
        answer.map_err(|refusal| Error::Refused { request, refusal })?;
        if hold(session, motion, step.duration_s, is_last, telemetry).await? {
            break;
        }
    }
    let Some(last) = *commanded else { return Ok(MotionEnd::Completed) };
    let status = wait_for_stop(session, last, ROLL_S_MAX, true).await?;
    if let Some(report) = status.fault {
        return Err(faulted(session, report));
    }
    if is_anothers(&status, last) {
        return Err(Error::StoppedByAnother);
    }
    session.listen(REST).await?;
    status.motion_end.ok_or(Error::NeverEnded)
}

/// Keeps a step alive for its time on the robot's clock; true if the motion ended.
async fn hold(
    session: &mut Session,
    motion: MotionId,
    duration_s: f64,
    to_the_end: bool,
    telemetry: &mut Vec<Telemetry>,
) -> Result<bool> {
    let begun_us = session.clock().now_us();
    // The encoder check comes before the first voltage, and takes its own time.
    let mut first_us = None;
    loop {
        stop_if_cancelled(session)?;
        session.post(Command::Renew { motion }).await?;
        session.listen(RENEW_EVERY.min(Duration::from_millis(10))).await?;
        telemetry.extend(session.take_telemetry());
        let mut events = session.take_events();
        let over = |event: Event| ends_motion(&event, motion);
        if events.any(over) {
            return Ok(true);
        }
        drop(events);
        if let Some(frame) = telemetry.last() {
            if frame.state == State::Driving && !frame.probing && first_us.is_none() {
                first_us = Some(frame.t_us);
            }
            // The event that says so may be lost.
            if first_us.is_some() && !matches!(frame.state, State::Driving | State::Stopping) {
                return Ok(true);
            }
            let elapsed_s =
                first_us.map_or(0.0, |first: u64| frame.t_us.saturating_sub(first) as f64 * 1e-6);
            if !to_the_end && elapsed_s >= duration_s {
                return Ok(false);
            }
        }
        // The clock may have been set back.
        let waited_us = session.clock().now_us().saturating_sub(begun_us);
        let waited_s = waited_us as f64 * 1e-6;
        if waited_s > SLOWEST * (duration_s + ROLL_S_MAX + STEP_MARGIN_S) {
            return Err(Error::NeverEnded);
        }
    }
}
