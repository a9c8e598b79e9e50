//! What a user can try when a robot or a plan refuses, with the commands of this program.
//!
//! What failed is said by the errors themselves.

use std::path::Path;

use campaign::plan::{PlanError, run_kinds};
use host_link::Error;
use host_link::error::AfterCancel;
use host_link::key_file::KeyFileProblem;
use host_link::session::LEASE;
use shared_proto::{FaultReport, MotionError, Refusal, State};

use crate::escape::shell_path;

/// What to try after an error of the link.
pub fn on_link(error: &Error) -> Option<String> {
    let advice = match error {
        Error::NoAnswer { .. } | Error::NotARobot { .. } => {
            "is it powered, flashed with Beeline, and is this the right port and baud rate? `beeline ports` lists the ports"
        }
        Error::VersionsDiffer { ours, theirs } if ours.protocol < theirs.protocol => {
            "update beeline"
        }
        Error::VersionsDiffer { ours, theirs } if ours.protocol > theirs.protocol => {
            "flash the robot with this beeline's firmware"
        }
        Error::VersionsDiffer { .. } => {
            "flash the robot with this beeline's firmware, or use the beeline that belongs to it"
        }
        Error::KeyFile { problem, path } => return Some(on_key_file(problem, path)),
        Error::KeyNeeded { .. } => {
            "--key-file FILE, or BEELINE_KEY_FILE, names the file of its key; if that is lost, erase the flash with a debugger"
        }
        Error::WrongKey { .. } => {
            "name the file of this robot's key with --key-file; if that is lost, erase the flash with a debugger"
        }
        Error::RobotWithoutKey { .. } => {
            "check --port; leave --key-file and BEELINE_KEY_FILE out for a robot without a key; `beeline key set` gives it one"
        }
        Error::StoppedAnswering { .. } => {
            "is it still powered and plugged in? What it was asked last it may have done all the same: `beeline config get` tells"
        }
        Error::ConnectionLost { .. } => {
            "it was unplugged, or the program at the other end ended; without its host a robot stops by itself"
        }
        Error::Forgotten { .. } => "end some of them, then try again",
        Error::Restarted { .. } => "check its supply; what was not saved is lost",
        Error::ReadBackDiffers => "nothing was saved; try again, and report it if it happens twice",
        Error::Refused { refusal, .. } => return on_refusal(refusal),
        Error::BeyondLimits(error) => return on_refusal(&Refusal::Motion(*error)),
        Error::Faulted(report) => return Some(on_fault(report)),
        Error::AlreadyMoving(_) => {
            "wait until the other host is done, or end it by `beeline stop`; a robot whose host is gone stops by itself"
        }
        Error::NoTelemetry => "is the line too slow? raise the baud rate",
        Error::StartTooLate => {
            "check the cable and the baud rate: too high for the cable, or too low for the telemetry"
        }
        Error::NotRenewed { .. } => {
            "a computer that sleeps, or has too much to do, cannot drive a robot"
        }
        Error::ClockCrawls { .. } => {
            "check the robot's clock source; a simulated robot needs a faster computer"
        }
        Error::InvalidConfig { .. } => {
            "`beeline config restore --factory` puts a valid one in its place"
        }
        Error::NeverStands => "is something pushing it? `beeline identify` shows its state",
        Error::Cancelled(left) => return on_left(left),
        Error::Connect { .. } => "is the robot, or `beeline sim --listen tcp:...`, running there?",
        // Another program has the port open, perhaps one that drives the robot.
        Error::OpenSerial { cause, .. } if cause.to_string().contains("exclusive lock") => {
            "another program has it open; to stop the robot, press Ctrl-C there, or the robot's stop button"
        }
        Error::OpenSerial { path, .. } => return Some(on_serial(path)),
        Error::Listen { .. } => "port 0 takes any that is free: --listen tcp:127.0.0.1:0",
        Error::NoPseudoTerminals => "--listen tcp:127.0.0.1:0",
        _ => return None,
    };
    Some(advice.into())
}

fn on_key_file(problem: &KeyFileProblem, path: &Path) -> String {
    let file = shell_path(path);
    match problem {
        KeyFileProblem::Shared(_) => {
            format!("chmod 600 {file}; if somebody has read it, make another key")
        }
        KeyFileProblem::OfAnother(_) => format!(
            "give the command as that user, or make the file your own: sudo chown $(id -u) {file}"
        ),
        _ => "`beeline key new FILE` makes the file of a key".into(),
    }
}

fn on_refusal(refusal: &Refusal) -> Option<String> {
    let advice = match refusal {
        Refusal::State(_) => "`beeline identify` shows its state, `beeline stop` ends a motion",
        Refusal::Faulted(report) => return Some(on_fault(report)),
        Refusal::Config(_) => "`beeline config get` shows the values in use",
        Refusal::Motion(MotionError::TooFast | MotionError::TooSteep) => {
            "`beeline config get limits` shows the limits"
        }
        Refusal::Motion(_) => "check the distance, --cruise and --acceleration",
        Refusal::NoSuchMotion => "`beeline identify` shows its state",
        Refusal::NoSuchFault => "`beeline identify` shows the latched fault",
        Refusal::CauseRemains => "release the emergency stop, check the driver and the battery",
        Refusal::Store => {
            "try again; with --flash FILE, check whether the disk is full, or another process has written that file since"
        }
        Refusal::Late => {
            "the line delays frames: check the cable, the baud rate, and whatever is in between"
        }
        Refusal::Driven => {
            "wait until the other host is done; `beeline stop` ends its motion and switches the motors off"
        }
        Refusal::Period
        | Refusal::Lease
        | Refusal::Forgotten
        | Refusal::HelloFirst
        | Refusal::Key
        | Refusal::WrongKey
        | Refusal::Unreadable => return None,
    };
    Some(advice.into())
}

fn on_fault(report: &FaultReport) -> String {
    format!("{}; then `beeline clear`", report.fault.remedy())
}

/// What a user who pressed Ctrl-C needs to know about the robot.
fn on_left(left: &AfterCancel) -> Option<String> {
    match left {
        AfterCancel::In(State::Idle | State::Boot) => None,
        AfterCancel::In(State::Faulted) => {
            Some("a fault is latched: `beeline identify` shows which".into())
        }
        AfterCancel::In(_) => Some("`beeline stop --now`, or its stop button".into()),
        AfterCancel::Unknown(_) => Some(format!(
            "it stops by itself {} ms after its host falls silent; if it does not, press its stop button",
            LEASE.as_millis()
        )),
    }
}

fn on_serial(path: &str) -> String {
    let ports = serialport::available_ports().unwrap_or_default();
    match ports.as_slice() {
        [] => "no serial port is plugged in; `--port sim` drives the simulator".into(),
        ports if ports.iter().any(|port| port.port_name == path) => {
            "it exists: is another program using it, or are you not allowed to (group dialout)?"
                .into()
        }
        ports => {
            let names: Vec<_> = ports.iter().map(|port| port.port_name.as_str()).collect();
            format!("these ports exist: {}", names.join(", "))
        }
    }
}

/// What to try when runs cannot be planned.
pub fn on_plan(error: &PlanError) -> String {
    match error {
        PlanError::FloorTooSmall { least_m, .. } => format!(
            "use at least --floor {least_m}mx{least_m}m; half a metre more in each direction is comfortable"
        ),
        PlanError::RunTooLong { .. } => {
            "a run may take an hour: check speeds, distances and turns in the plan".into()
        }
        PlanError::UnknownKind(_) => {
            format!("a run of the campaign's plan, or one of: {}", run_kinds::kinds().join("; "))
        }
        PlanError::RunTooLarge { .. } => {
            "choose another kind of run, or give the free floor with --floor".into()
        }
    }
}
