//! Velocity drives: the setpoint changes while the robot moves, as from a joystick or a path follower.

use std::time::Duration;

use shared_proto::{Command, MotionId, Refusal, Velocity};

use super::ends_motion;
use super::rest::{
    bring_to_rest, faulted, is_anothers, leave_as_found, left_at, release, standing,
    stop_if_cancelled, wait_for_stop,
};
use crate::error::{Error, Result};
use crate::session::{LEASE, Session};

/// A velocity is commanded this often.
pub const EVERY: Duration = Duration::from_millis(30);

/// A velocity of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist {
    /// Speed of the middle between the wheels, forward positive \[m/s\].
    pub forward_mps: f64,
    /// Turn rate, to the left positive \[rad/s\].
    pub turn_rad_s: f64,
}

/// Drives at the velocity that `wanted` gives every [`EVERY`], with the time since the first one \[s\], until it gives
/// none; then brakes along a ramp, and leaves the motors off.
///
/// `acceleration_mps2` is that of the wheel whose speed changes most \[m/s^2\]. However this ends, by a fault, a
/// [`Cancel`](crate::Cancel) or a lost link, the robot is left standing still. A robot that is already moving is an
/// error, and nothing changes.
pub async fn drive_at(
    session: &mut Session,
    acceleration_mps2: f64,
    wanted: &mut dyn FnMut(f64) -> Option<Twist>,
) -> Result<()> {
    let found = standing(session).await?;
    let mut fastest_mps = 0.0_f64;
    let mut commanded = false;
    let id = session.new_motion();
    let driven =
        follow(session, id, acceleration_mps2, wanted, &mut fastest_mps, &mut commanded).await;
    // How long the longest ramp takes, with a robot's turning added generously.
    let ramp_s = 2.0 * fastest_mps / acceleration_mps2;
    let Err(error) = driven else {
        if !commanded {
            leave_as_found(session, found).await?;
            return Ok(());
        }
        if is_anothers(&session.status().await?, id) {
            return Err(Error::StoppedByAnother);
        }
        session
            .ask(Command::Stop)
            .await?
            .map_err(|refusal| Error::Refused { request: "stop", refusal })?;
        let status = wait_for_stop(session, id, ramp_s, false).await?;
        if let Some(report) = status.fault {
            return Err(faulted(session, report));
        }
        return release(session, id).await;
    };
    let rest = match commanded {
        true => bring_to_rest(session, id, ramp_s).await,
        false => leave_as_found(session, found).await,
    };
    Err(left_at(error, rest))
}

/// Commands one velocity after another; ends with the last one, or with the motion.
async fn follow(
    session: &mut Session,
    motion: MotionId,
    acceleration_mps2: f64,
    wanted: &mut dyn FnMut(f64) -> Option<Twist>,
    fastest_mps: &mut f64,
    commanded: &mut bool,
) -> Result<()> {
    let _stale = session.take_events().count();
    session.request(Command::Arm { take: false }).await?;
    let start_us = session.clock().now_us();
    let mut renewed_us = start_us;
    loop {
        stop_if_cancelled(session)?;
        // The clock may have been set back.
        let elapsed_us = session.clock().now_us().saturating_sub(start_us);
        let elapsed_s = elapsed_us as f64 * 1e-6;
        let Some(Twist { forward_mps, turn_rad_s }) = wanted(elapsed_s) else { return Ok(()) };
        let velocity = Velocity { motion, forward_mps, turn_rad_s, acceleration_mps2 };
        *fastest_mps = fastest_mps.max(forward_mps.abs());
        let silent = Duration::from_micros(session.clock().now_us().saturating_sub(renewed_us));
        let answer = session.ask(Command::Velocity(velocity)).await?;
        renewed_us = session.clock().now_us();
        *commanded |= answer.is_ok();
        let ended = session.take_events().any(|event| ends_motion(&event, motion));
        if ended && answer.is_ok() {
            // By another host or by a fault, which the next answer says.
            continue;
        }
        answer.map_err(|refusal| match refusal {
            Refusal::Faulted(report) if *commanded => faulted(session, report),
            Refusal::NoSuchMotion if *commanded && silent > LEASE => {
                Error::NotRenewed { silent_s: silent.as_secs_f64() }
            }
            Refusal::NoSuchMotion | Refusal::Driven if *commanded => Error::StoppedByAnother,
            refusal => Error::Refused { request: "drive", refusal },
        })?;
        session.listen(EVERY).await?;
    }
}
