//! How a motion ends before its time: what is taken back, and what the user has to know of the robot.

use shared_proto::{Command, State};

use super::{Motion, RENEW_EVERY, TTL_MS, is_moving};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::session::Session;

/// Whoever sees this error brings the robot to a stand, and says how that went.
pub(super) fn stop_if_interrupted() -> Result<()> {
    if interrupt::requested() {
        return Err(Error::interrupted("stopped by Ctrl-C"));
    }
    Ok(())
}

/// Brakes, waits for the stand and takes the power off; the state in which the robot is then.
pub(super) async fn bring_to_rest(session: &mut Session, motion: &Motion) -> Result<State> {
    // Refused where a fault has stopped it already.
    let _refused = session.ask(Command::Stop).await?;
    if wait_for_stop(session, motion, false).await.is_err() {
        // It answers and does not stop, or did not answer for long enough.
        let _refused = session.ask(Command::EmergencyStop).await?;
    }
    let _refused = session.ask(Command::Disarm).await?;
    let state = session.status().await?.state;
    let _refused = session.ask(Command::Subscribe { period_ms: 0 }).await?;
    Ok(state)
}

/// After a motion that never began: takes back what was asked for it, and nothing else.
pub(super) async fn leave_as_found(session: &mut Session, found: State) -> Result<State> {
    // To a robot that moves this would be a stop, and the motion is none of ours.
    if found == State::Idle && session.status().await?.state == State::Armed {
        session.request(Command::Disarm).await?;
    }
    session.request(Command::Subscribe { period_ms: 0 }).await?;
    Ok(session.status().await?.state)
}

/// What a user who pressed Ctrl-C has to know of the robot, and nothing that is not known.
pub(super) fn interrupted(rest: &Result<State>) -> Error {
    match rest {
        Ok(State::Idle | State::Boot) => {
            Error::interrupted("stopped by Ctrl-C; the robot stands still, its motors are off")
        }
        Ok(State::Faulted) => Error::interrupted("stopped by Ctrl-C; the robot's motors are off")
            .hint("a fault is latched: `beeline identify` shows which"),
        Ok(state) => Error::interrupted(format_args!(
            "stopped by Ctrl-C, but the robot says that it is {}",
            state.name()
        ))
        .hint("`beeline stop --now`, or its stop button"),
        Err(error) => Error::interrupted(format_args!(
            "stopped by Ctrl-C; whether the robot stands still is not known: {error}"
        ))
        .hint(format_args!(
            "by itself it stops {TTL_MS} ms after its host fell silent; watch it, and use its stop button if it does not"
        )),
    }
}

/// Waits until the robot stands, for as long as its ramp takes and a little more.
pub(super) async fn wait_for_stop(
    session: &mut Session,
    motion: &Motion,
    until_interrupted: bool,
) -> Result<shared_proto::Status> {
    const MORE_S: f64 = 5.0;
    let patience_s = motion.cruise / motion.acceleration + MORE_S;
    let give_up_us = session.clock().now_us() + (patience_s * 1e6) as u64;
    loop {
        let status = session.status().await?;
        if !is_moving(status.state) {
            return Ok(status);
        }
        if until_interrupted {
            stop_if_interrupted()?;
        }
        if session.clock().now_us() > give_up_us {
            return Err(Error::new("the robot does not come to a stand at the end of its motion")
                .hint("is something pushing it? `beeline identify` shows its state"));
        }
        if let Some(motion) = status.motion {
            session.post(Command::Renew { motion, ttl_ms: TTL_MS }).await?;
        }
        session.listen(RENEW_EVERY).await?;
    }
}
