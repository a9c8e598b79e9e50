//! What can go wrong between a host and a robot.
//!
//! Each error says what failed and on what. What to try depends on the program that uses this
//! crate, which must say it itself.

use std::fmt;
use std::io;

use crate::fault_in_words::FaultInWords;
use crate::key_file_problem::KeyFileProblem;
use shared_proto::{Answer, Command, ConfigError, FaultReport, Hello, MotionError, Refusal, State};

/// A result of the link.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a request or a procedure failed.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// Nothing was received from this port.
    NoAnswer {
        /// The port.
        port: String,
    },
    /// Something was received, but not from a Beeline robot.
    NotARobot {
        /// The port.
        port: String,
        /// Unreadable frames.
        damaged: u64,
    },
    /// Host and robot have different versions of the protocol.
    VersionsDiffer {
        /// The host's.
        ours: Hello,
        /// The robot's.
        theirs: Hello,
    },
    /// The file of a key cannot be used.
    KeyFile {
        /// The file.
        path: std::path::PathBuf,
        /// What is wrong with it.
        problem: KeyFileProblem,
    },
    /// The motion is beyond the robot's limits: it was not asked to drive.
    BeyondLimits(MotionError),
    /// The system gives no random numbers, which a key is made of.
    NoRandomNumbers(String),
    /// The robot has a key, and this host has none.
    KeyNeeded {
        /// The port.
        port: String,
    },
    /// The robot has another key than this host.
    WrongKey {
        /// The port.
        port: String,
    },
    /// The host has a key, and the robot has none: it may be another robot, or none.
    RobotWithoutKey {
        /// The port.
        port: String,
    },
    /// The robot answered before, but does not any more.
    StoppedAnswering {
        /// The port.
        port: String,
    },
    /// The connection broke.
    ConnectionLost {
        /// The port.
        port: String,
        /// The system's error.
        cause: io::Error,
    },
    /// The robot has forgotten this session, which others have pushed out: its clock went on.
    Forgotten {
        /// The port.
        port: String,
    },
    /// The robot has forgotten this session, and its clock began anew.
    Restarted {
        /// The port.
        port: String,
    },
    /// The robot's answer does not belong to the request.
    WrongAnswer {
        /// The request.
        request: &'static str,
        /// The answer.
        answer: Box<Answer>,
    },
    /// The robot refused a request, and nothing changed.
    Refused {
        /// The request.
        request: &'static str,
        /// Why.
        refusal: Refusal,
    },
    /// The robot read back another configuration than was written. Nothing was saved.
    ReadBackDiffers,
    /// The robot stopped with a fault.
    Faulted(FaultReport),
    /// The robot is still moving by an earlier command; nothing changed.
    AlreadyMoving(State),
    /// The robot sends no telemetry.
    NoTelemetry,
    /// Each time the command arrived after the time at which the motion was to begin.
    StartTooLate,
    /// The robot stands still, but did not reach the end of its motion.
    NeverEnded,
    /// Another host stopped the robot before its motion was over.
    StoppedByAnother,
    /// The robot stopped by itself, as this computer did not renew its motion in time.
    NotRenewed {
        /// For how long it said nothing \[s\].
        silent_s: f64,
    },
    /// The robot sent a configuration that no robot can have.
    InvalidConfig {
        /// The field and what is wrong with it.
        problem: ConfigError,
    },
    /// The motion takes far longer by this computer's clock than it can.
    ClockCrawls {
        /// How long it was waited for \[s\].
        waited_s: f64,
        /// How much of the motion has passed by the robot's clock \[s\].
        elapsed_s: f64,
    },
    /// The robot still moves when it should stand still.
    NeverStands,
    /// The procedure was cancelled: see [`Cancel`](crate::Cancel).
    Cancelled(AfterCancel),
    /// A TCP address could not be reached.
    Connect {
        /// `host:port`.
        address: String,
        /// The system's error.
        cause: io::Error,
    },
    /// A serial port could not be opened.
    OpenSerial {
        /// The device.
        path: String,
        /// The system's error.
        cause: serialport::Error,
    },
    /// The address cannot be listened on.
    Listen {
        /// `host:port`.
        address: String,
        /// The system's error.
        cause: io::Error,
    },
    /// This system has no pseudo-terminals.
    NoPseudoTerminals,
    /// A pseudo-terminal could not be opened.
    PseudoTerminal(serialport::Error),
}

/// How a cancelled procedure left the robot.
#[derive(Debug)]
pub enum AfterCancel {
    /// In this state.
    In(State),
    /// Unknown, for this reason.
    Unknown(Box<Error>),
}

impl Error {
    /// Whether the procedure was cancelled.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled(_))
    }
}

impl std::error::Error for Error {}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAnswer { port } => write!(f, "no robot answers on {port}"),
            Self::NotARobot { port, damaged } => write!(
                f,
                "something on {port} sends data, but not as a Beeline robot ({damaged} unreadable frames)"
            ),
            Self::VersionsDiffer { ours, theirs } => versions_differ(f, ours, theirs),
            Self::KeyFile { .. }
            | Self::NoRandomNumbers(_)
            | Self::KeyNeeded { .. }
            | Self::WrongKey { .. }
            | Self::RobotWithoutKey { .. } => self.fmt_key(f),
            Self::StoppedAnswering { port } => {
                write!(f, "the robot on {port} stopped answering")
            }
            Self::ConnectionLost { port, cause } => {
                write!(f, "the connection to {port} was lost: {cause}")
            }
            Self::Forgotten { port } => {
                write!(f, "more hosts use the robot on {port} than it remembers, and it has forgotten this one")
            }
            Self::Restarted { port } => {
                write!(f, "the robot on {port} restarted during this command")
            }
            Self::WrongAnswer { request, answer } => {
                write!(f, "the robot gave a wrong answer when asked to {request}: {answer:?}")
            }
            Self::BeyondLimits(error) => write!(f, "not driven: {error}"),
            Self::Refused { request, refusal } => refused(f, request, refusal),
            Self::ReadBackDiffers => {
                f.write_str("the configuration read back differs from the one written")
            }
            Self::Faulted(report) => faulted(f, report),
            Self::AlreadyMoving(state) => write!(
                f,
                "not driven: the robot is already {}, by another host or an earlier command",
                state.name()
            ),
            Self::NoTelemetry => f.write_str("the robot sends no telemetry"),
            Self::StartTooLate => f.write_str(
                "every command for the motion reached the robot too late: the line is too slow, or loses too much",
            ),
            Self::InvalidConfig { problem } => {
                write!(f, "the robot's own configuration is invalid: {problem}")
            }
            Self::ClockCrawls { waited_s, elapsed_s } => write!(
                f,
                "after {waited_s:.0} s the robot's clock had counted only {elapsed_s:.1} s of the motion, so the robot was stopped"
            ),
            Self::StoppedByAnother => f.write_str(
                "another host stopped the robot, or it heard nothing for longer than protection.link_timeout_s permits",
            ),
            Self::NotRenewed { silent_s } => write!(
                f,
                "the robot stopped by itself, because this computer said nothing for {silent_s:.1} s"
            ),
            Self::NeverEnded => f.write_str("the robot stands still, but did not reach the end of its motion"),
            Self::NeverStands => {
                f.write_str("the robot does not come to a standstill at the end of its motion")
            }
            Self::Cancelled(left) => write!(f, "cancelled{left}"),
            Self::Connect { .. }
            | Self::OpenSerial { .. }
            | Self::Listen { .. }
            | Self::NoPseudoTerminals
            | Self::PseudoTerminal(_) => self.fmt_port(f),
        }
    }
}

fn versions_differ(f: &mut fmt::Formatter<'_>, ours: &Hello, theirs: &Hello) -> fmt::Result {
    write!(
        f,
        "the robot speaks protocol {} (schema {:016x}), this host speaks protocol {} (schema {:016x})",
        theirs.protocol, theirs.schema, ours.protocol, ours.schema
    )
}

impl Error {
    /// What is wrong with a port.
    fn fmt_port(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Connect { address, cause } => {
                write!(f, "cannot connect to tcp:{address}: {cause}")
            }
            Self::OpenSerial { path, cause } => {
                write!(f, "cannot open the serial port {path}: {cause}")
            }
            Self::Listen { address, cause } => {
                write!(f, "cannot listen on tcp:{address}: {cause}")
            }
            Self::NoPseudoTerminals => f.write_str("this system has no pseudo-terminals"),
            Self::PseudoTerminal(cause) => write!(f, "cannot open a pseudo-terminal: {cause}"),
            _ => Ok(()),
        }
    }

    /// What is wrong with a key.
    fn fmt_key(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::KeyFile { path, problem } => write!(f, "{}: {problem}", path.display()),
            Self::NoRandomNumbers(cause) => {
                write!(f, "the system provides no random numbers for a key ({cause})")
            }
            Self::KeyNeeded { port } => {
                write!(f, "the robot on {port} has a key, and none was given")
            }
            Self::WrongKey { port } => write!(f, "the robot on {port} has a different key"),
            Self::RobotWithoutKey { port } => {
                write!(
                    f,
                    "a key was given, but the robot on {port} has none: it may be a different robot"
                )
            }
            _ => Ok(()),
        }
    }
}

impl fmt::Display for AfterCancel {
    /// Continues a sentence that says what was stopped.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::In(State::Idle | State::Boot) => {
                f.write_str("; the robot stands still, its motors are off")
            }
            Self::In(State::Faulted) => f.write_str("; the robot's motors are off"),
            Self::In(state) => write!(f, ", but the robot reports that it is {}", state.name()),
            Self::Unknown(error) => {
                write!(f, "; it is not known whether the robot stands still: {error}")
            }
        }
    }
}

fn faulted(f: &mut fmt::Formatter<'_>, report: &FaultReport) -> fmt::Result {
    write!(f, "the robot stopped with a fault: {}", FaultInWords(report))?;
    match report.followed_by {
        0 => Ok(()),
        1 => f.write_str(", and one more fault after it"),
        n => write!(f, ", and {n} more faults after it"),
    }
}

fn refused(f: &mut fmt::Formatter<'_>, request: &str, refusal: &Refusal) -> fmt::Result {
    write!(f, "the robot refused to {request}: ")?;
    match refusal {
        Refusal::State(state) => write!(f, "it is {}", state.name()),
        Refusal::Faulted(report) => write!(f, "a fault is latched, {}", FaultInWords(report)),
        Refusal::Config(error) => write!(f, "{error}"),
        Refusal::Motion(error) => write!(f, "{error}"),
        Refusal::NoSuchMotion => f.write_str("no such motion is under way"),
        Refusal::NoSuchFault => f.write_str("that fault is not latched, or no longer"),
        Refusal::CauseRemains => f.write_str("the cause of the fault is still there"),
        Refusal::Period => f.write_str("the telemetry period must be from 1 to 1000 ms"),
        Refusal::Store => {
            f.write_str("its flash could not be written; the saved configuration is as it was")
        }
        Refusal::Late => f.write_str("the request arrived too late"),
        Refusal::Lease => f.write_str("its lease is too long: the robot may not move for that long without a renewal from the host"),
        Refusal::Driven => f.write_str("another host drives it"),
        Refusal::Forgotten => f.write_str("it no longer has that telemetry"),
        Refusal::Key | Refusal::WrongKey => f.write_str("it obeys only hosts with its key"),
        Refusal::HelloFirst => f.write_str("it restarted"),
        Refusal::Unreadable => f.write_str("it could not read the request"),
    }
}

/// What a request asks the robot to do, to follow "asked to".
pub(crate) fn name_of(command: &Command) -> &'static str {
    match command {
        Command::Identify => "identify itself",
        Command::Status => "report its status",
        Command::ReadConfig => "read the configuration",
        Command::WriteConfig(_) => "use the configuration",
        Command::SaveConfig => "save the configuration",
        Command::RestoreConfig(_) => "restore the configuration",
        Command::Arm { .. } => "arm",
        Command::Disarm => "disarm",
        Command::Drive(_) | Command::Velocity(_) => "drive",
        Command::Voltage(_) => "apply a voltage",
        Command::Renew { .. } => "renew the motion",
        Command::Stop => "stop",
        Command::EmergencyStop => "stop at once",
        Command::ClearFault { .. } => "clear the fault",
        Command::Subscribe { .. } => "send telemetry",
        Command::Recall { .. } => "repeat telemetry",
        Command::SetKey { key: Some(_) } => "take another key",
        Command::SetKey { key: None } => "forget its key",
    }
}
