//! `beeline drive`, `beeline stop` and `beeline clear`.
//!
//! How a motion is driven to its end is left to `host-link`.

use std::time::{Duration, Instant};

use serde_json::json;
use shared_proto::{Command, Config, MotionEnd, Refusal, TravelUnit, WheelPair};

use crate::cli::{Common, DriveCommand, ProfileArgs};
use crate::error::{Error, Result};
use crate::limits;
use crate::port::{with_robot, with_session};
use crate::quantity::{Acceleration, Distance, Speed};
use crate::ui::{Progress, say, tell};
use host_link::fault_in_words::FaultInWords;
use host_link::motion::{self, Motion, RecordOptions, Recording};

pub(super) fn run(common: &Common, command: &DriveCommand) -> Result<()> {
    let (recording, config) = with_robot(&common.port, &common.sim(), async |session, _| {
        let config = session.read_config().await?;
        let motion = motion_of(command, &config)?;
        limits::check(&motion, &config, profile_of(command).long)?;
        let progress = Progress::new(kind(command), common.json);
        let options = RecordOptions::default();
        let recording =
            motion::drive(session, &motion, options, &mut |share| progress.set(share)).await?;
        Ok((recording, config))
    })?;
    report(common, &recording, &config)?;
    match recording.end {
        MotionEnd::Completed => Ok(()),
        _ => Err(host_link::Error::StoppedByAnother.into()),
    }
}

/// Others may crowd a port so that a connection is cut off before the robot hears it: a stop connects anew for so long.
const STOP_TRIES: Duration = Duration::from_secs(3);

pub(super) fn stop(common: &Common, now: bool) -> Result<()> {
    let begun = Instant::now();
    loop {
        match stop_once(common, now) {
            Err(error) if error.is_cut_off() && begun.elapsed() < STOP_TRIES => {}
            outcome => return outcome,
        }
    }
}

fn stop_once(common: &Common, now: bool) -> Result<()> {
    with_session(&common.port, &common.sim(), async |session, _| {
        if now {
            session.emergency_stop().await?;
        } else {
            session.open().await?;
            session.request(Command::Stop).await?;
            // It brakes first; then the motors are off, and the robot is anybody's.
            session.request(Command::Disarm).await?;
        }
        Ok(())
    })?;
    let line = if now { "motors off; `beeline clear` clears the fault" } else { "stopping" };
    tell(common.json, json!({"stopped": if now { "now" } else { "along a ramp" }}), line);
    Ok(())
}

pub(super) fn clear(common: &Common) -> Result<()> {
    let cleared = with_robot(&common.port, &common.sim(), async |session, _| {
        let Some(report) = session.status().await?.fault else { return Ok(None) };
        match session.request(Command::ClearFault { number: report.number }).await {
            Ok(_) => Ok(Some(report)),
            Err(host_link::Error::Refused { refusal: Refusal::CauseRemains, .. }) => {
                let fault = FaultInWords(&report);
                let problem =
                    format_args!("the robot keeps the fault {fault}: its cause is still there");
                Err(Error::new(problem).hint(report.fault.remedy()))
            }
            Err(error) => Err(error.into()),
        }
    })?;
    let fault = cleared.map(|report| report.fault.to_string());
    let line = match &fault {
        Some(fault) => {
            format!("cleared: {fault}; if its cause is still there, the next motion finds it again")
        }
        None => "no fault is latched".into(),
    };
    tell(common.json, json!({ "cleared": fault }), line);
    Ok(())
}

/// `"straight"`, `"spin"` or `"arc"`.
pub(super) fn kind(command: &DriveCommand) -> &'static str {
    match command {
        DriveCommand::Straight { .. } => "straight",
        DriveCommand::Spin { .. } => "spin",
        DriveCommand::Arc { .. } => "arc",
    }
}

/// The shape of the motion.
pub(super) fn profile_of(command: &DriveCommand) -> &ProfileArgs {
    match command {
        DriveCommand::Straight { profile, .. }
        | DriveCommand::Spin { profile, .. }
        | DriveCommand::Arc { profile, .. } => profile,
    }
}

/// The motion of the wheels.
///
/// For a body that turns by theta about a centre at radius r (left positive), the wheels travel
/// theta (r -+ b/2), left minus, right plus.
pub(super) fn motion_of(command: &DriveCommand, config: &Config) -> Result<Motion> {
    let half_track_m = config.geometry.track_width_m / 2.0;
    match command {
        DriveCommand::Straight { distance, profile } => Ok(straight(*distance, profile, config)),
        DriveCommand::Spin { angle, profile } => {
            let travel_m = angle.rad * half_track_m;
            Ok(in_meters(WheelPair::new(-travel_m, travel_m), profile, config))
        }
        DriveCommand::Arc { radius, angle, profile } => {
            if radius.m == 0.0 {
                return Err(
                    Error::new("an arc of radius zero is a spin").hint("`beeline drive spin`")
                );
            }
            // Forwards for a positive radius, to the left for a positive angle.
            let (ahead, turn) = (radius.m * angle.rad.abs(), angle.rad * radius.m.signum());
            let travel = WheelPair::new(ahead - turn * half_track_m, ahead + turn * half_track_m);
            Ok(in_meters(travel, profile, config))
        }
    }
}

/// A straight motion, in turns of a wheel if all its quantities are given so.
pub(super) fn straight(distance: Distance, profile: &ProfileArgs, config: &Config) -> Motion {
    let radius_m = config.geometry.wheel_radius_m;
    match (distance, profile.cruise, profile.acceleration) {
        (Distance::Wheel(_), Speed::Wheel(_), Acceleration::Wheel(_)) => Motion {
            unit: TravelUnit::WheelRevolution,
            distance: WheelPair::both(distance.rev(radius_m)),
            cruise: profile.cruise.rev_per_s(radius_m),
            acceleration: profile.acceleration.rev_per_s2(radius_m),
        },
        _ => in_meters(WheelPair::both(distance.m(radius_m)), profile, config),
    }
}

fn in_meters(distance: WheelPair<f64>, profile: &ProfileArgs, config: &Config) -> Motion {
    let radius_m = config.geometry.wheel_radius_m;
    Motion {
        unit: TravelUnit::Meter,
        distance,
        cruise: profile.cruise.mps(radius_m),
        acceleration: profile.acceleration.mps2(radius_m),
    }
}

fn report(common: &Common, recording: &Recording, config: &Config) -> Result<()> {
    let (Some(first), Some(last)) = (recording.telemetry.first(), recording.telemetry.last())
    else {
        return Err(Error::new("the robot sent no telemetry during the motion"));
    };
    let counts = first.wheels.zip(last.wheels);
    let counts = counts.map(|(first, last)| last.counts.checked_sub(first.counts));
    let (Some(left), Some(right)) = (counts.left, counts.right) else {
        return Err(Error::new("the robot's counts jumped farther than any wheel turns").hint(
            "`beeline watch` shows them; check the cable, and report it if it happens twice",
        ));
    };
    let counts = WheelPair::new(left, right);
    let turns = counts
        .zip(config.encoder)
        .map(|(counts, encoder)| counts as f64 / (encoder.counts_per_rev * encoder.gear_reduction));
    let error_um = last.wheels.map(|wheel| wheel.error_um);
    if common.json {
        say(json!({
            "end": format!("{:?}", recording.end).to_lowercase(),
            "counts": counts,
            "wheel_revolutions": turns,
            "error_um": error_um,
        }));
        return Ok(());
    }
    say(format_args!(
        "{:?}: left {} counts ({:.4} rev), right {} counts ({:.4} rev)",
        recording.end, counts.left, turns.left, counts.right, turns.right
    ));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{Angle, Length};

    fn profile() -> ProfileArgs {
        ProfileArgs {
            cruise: Speed::Ground(0.2),
            acceleration: Acceleration::Ground(0.1),
            long: false,
        }
    }

    fn arc(radius_m: f64, angle_rad: f64) -> WheelPair<f64> {
        let command = DriveCommand::Arc {
            radius: Length { m: radius_m },
            angle: Angle { rad: angle_rad },
            profile: profile(),
        };
        motion_of(&command, &Config::default()).unwrap().distance
    }

    #[test]
    fn a_left_arc_turns_the_right_wheel_farther() {
        let left = arc(1.0, 1.0);
        assert!(
            (left.left - 0.814).abs() < 1e-12 && (left.right - 1.186).abs() < 1e-12,
            "{left:?}"
        );
        let right = arc(1.0, -1.0);
        assert_eq!((right.left, right.right), (left.right, left.left));
    }

    #[test]
    fn a_negative_radius_drives_the_same_arc_backwards() {
        let (ahead, back) = (arc(1.0, 1.0), arc(-1.0, 1.0));
        assert_eq!((back.left, back.right), (-ahead.left, -ahead.right));
    }

    #[test]
    fn a_spin_moves_nothing_but_the_heading() {
        let command = DriveCommand::Spin { angle: Angle { rad: 1.0 }, profile: profile() };
        let travel = motion_of(&command, &Config::default()).unwrap().distance;
        assert_eq!(travel.left, -travel.right);
        assert!((travel.right - 0.186).abs() < 1e-12);
    }
}
