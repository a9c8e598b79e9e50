//! How a motion is ended early, and how the robot is brought to standstill.

use std::time::Duration;

use shared_proto::{Command, Fault, FaultReport, MotionId, Refusal, State, Status};

use crate::error::{AfterCancel, Error, Result};
use crate::session::Session;

/// The host renews a motion this often: of the six renewals in a [`LEASE`](crate::session::LEASE), five may be lost;
/// one fits into the shortest `protection.link_timeout_s`; and a line of
/// [`BAUD_MIN`](crate::address::BAUD_MIN) carries them.
pub(super) const RENEW_EVERY: Duration = Duration::from_millis(30);

/// Whether the robot drives or brakes.
pub(super) fn is_moving(state: State) -> bool {
    matches!(state, State::Driving | State::Stopping)
}

/// Whether another motion has taken the place of this one.
pub(super) fn is_anothers(status: &Status, own: MotionId) -> bool {
    status.motion.is_some_and(|motion| motion != own)
}

/// An error if the session is cancelled. [`drive_into`](super::drive_into) then brings the robot to
/// standstill, and replaces the state in the error by the one that it found.
pub(super) fn stop_if_cancelled(session: &Session) -> Result<()> {
    if session.is_cancelled() {
        return Err(Error::Cancelled(AfterCancel::In(State::Driving)));
    }
    Ok(())
}

/// The error of a motion that a fault ended.
///
/// A motion that was renewed no more because its holder fell silent ends at the same instant on the robot and here, and
/// whichever says so first, the reason is the holder.
pub(super) fn faulted(session: &Session, report: FaultReport) -> Error {
    if report.fault == Fault::TimeToLive && session.holder_is_late() {
        return Error::Cancelled(AfterCancel::In(State::Faulted));
    }
    Error::Faulted(report)
}

/// The state of a robot that may be driven: an error if it moves, or if a fault is latched.
pub(super) async fn standing(session: &mut Session) -> Result<State> {
    let status = session.status().await?;
    if let Some(report) = status.fault {
        // The robot may still be braking for the fault, which says more than its state.
        return Err(Error::Refused { request: "drive", refusal: Refusal::Faulted(report) });
    }
    if is_moving(status.state) {
        return Err(Error::AlreadyMoving(status.state));
    }
    Ok(status.state)
}

/// The error of a drive that failed; a cancelled one says in which state it left the robot.
pub(super) fn left_at(error: Error, rest: Result<State>) -> Error {
    match rest {
        _ if !error.is_cancelled() => error,
        Ok(state) => Error::Cancelled(AfterCancel::In(state)),
        Err(error) => Error::Cancelled(AfterCancel::Unknown(Box::new(error))),
    }
}

/// After a motion that has ended: switches the motors off and the telemetry, unless another host drives the robot by now.
pub(super) async fn release(session: &mut Session, own: MotionId) -> Result<()> {
    if !is_anothers(&session.status().await?, own) {
        session.request(Command::Disarm).await?;
        session.request(Command::Subscribe { period_ms: 0 }).await?;
    }
    Ok(())
}

/// Brakes, waits for the robot to stand still after a ramp of this length \[s\], and disarms it; returns its state. A motion of
/// another host, which has ended this one, is left alone.
pub(super) async fn bring_to_rest(
    session: &mut Session,
    own: MotionId,
    ramp_s: f64,
) -> Result<State> {
    let status = session.status().await?;
    if is_anothers(&status, own) {
        return Ok(status.state);
    }
    // Refused if a fault has stopped the robot already.
    let _refused = session.ask(Command::Stop).await?;
    if wait_for_stop(session, own, ramp_s, false).await.is_err() {
        // The robot answers but does not stop, or has not answered for too long.
        let _refused = session.ask(Command::EmergencyStop).await?;
    }
    let _refused = session.ask(Command::Disarm).await?;
    let state = session.status().await?.state;
    let _refused = session.ask(Command::Subscribe { period_ms: 0 }).await?;
    Ok(state)
}

/// After a motion that never began: takes back the arming and the subscription, and nothing else.
pub(super) async fn leave_as_found(session: &mut Session, found: State) -> Result<State> {
    // Disarming a moving robot would stop it, and that motion is not ours.
    if found == State::Idle && session.status().await?.state == State::Armed {
        session.request(Command::Disarm).await?;
    }
    session.request(Command::Subscribe { period_ms: 0 }).await?;
    Ok(session.status().await?.state)
}

/// Waits until the robot stands still, or drives another host's motion, for as long as its ramp takes \[s\] and a little more.
pub(super) async fn wait_for_stop(
    session: &mut Session,
    own: MotionId,
    ramp_s: f64,
    until_cancelled: bool,
) -> Result<Status> {
    const MORE_S: f64 = 5.0;
    let give_up_us = session.clock().now_us().saturating_add(((ramp_s + MORE_S) * 1e6) as u64);
    loop {
        let status = session.status().await?;
        if !is_moving(status.state) || is_anothers(&status, own) {
            return Ok(status);
        }
        if until_cancelled {
            stop_if_cancelled(session)?;
        }
        if session.clock().now_us() > give_up_us {
            return Err(Error::NeverStands);
        }
        session.post(Command::Renew { motion: own }).await?;
        session.listen(RENEW_EVERY).await?;
    }
}
