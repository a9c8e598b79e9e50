//! How a motion ends before its time, and what is taken back then.

use shared_proto::{Command, State};

use super::{Motion, RENEW_EVERY, TTL_MS, is_moving};
use crate::error::{Error, Left, Result};
use crate::session::Session;

/// Whoever sees this error brings the robot to a stand, and says how that went.
pub(super) fn stop_if_cancelled(session: &Session) -> Result<()> {
    if session.is_cancelled() {
        return Err(Error::Cancelled(Left::In(State::Driving)));
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

/// Waits until the robot stands, for as long as its ramp takes and a little more.
pub(super) async fn wait_for_stop(
    session: &mut Session,
    motion: &Motion,
    until_cancelled: bool,
) -> Result<shared_proto::Status> {
    const MORE_S: f64 = 5.0;
    let patience_s = motion.cruise / motion.acceleration + MORE_S;
    let give_up_us = session.clock().now_us() + (patience_s * 1e6) as u64;
    loop {
        let status = session.status().await?;
        if !is_moving(status.state) {
            return Ok(status);
        }
        if until_cancelled {
            stop_if_cancelled(session)?;
        }
        if session.clock().now_us() > give_up_us {
            return Err(Error::NeverStands);
        }
        if let Some(motion) = status.motion {
            session.post(Command::Renew { motion, ttl_ms: TTL_MS }).await?;
        }
        session.listen(RENEW_EVERY).await?;
    }
}
