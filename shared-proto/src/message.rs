//! Requests, replies and events.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::config::{Config, LimitsConfig};
use crate::config_check::ConfigError;
use crate::fault::FaultReport;
use crate::key::Key;
use crate::motion::{Drive, MotionError, MotionId, Velocity};
use crate::name::Name;
use crate::state::State;
use crate::telemetry::Telemetry;
use crate::voltage::Voltage;

/// A command from the host. Every command may be repeated without further effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Request {
    /// The sender's session, from its [`Hello`](crate::Hello).
    pub session: u32,
    /// Returned in the [`Reply`]; a retry carries the same one.
    pub id: u32,
    /// The lease: when this ends to be the host's wish, on the robot's clock \[ms since power-on\].
    ///
    /// Later than that, a command that [needs a lease](Command::needs_lease) is refused, however it
    /// was held up; a motion lives until then, unless it is renewed. Other commands have 0.
    pub until_ms: u64,
    /// What to do.
    pub command: Command,
}

impl Request {
    /// [`Request::until_ms`] may lie this far ahead \[ms\].
    pub const LEASE_MS_MAX: u64 = 10_000;
}

/// The robot's answer to a request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Reply {
    /// The request's session; 0 for a request that could not be read.
    pub session: u32,
    /// The request's id; 0 with [`Refusal::HelloFirst`] and [`Refusal::Unreadable`].
    pub id: u32,
    /// The robot's clock as it replied \[us since power-on\].
    pub t_us: u64,
    /// The answer, or why the robot refused.
    pub outcome: Result<Answer, Refusal>,
}

/// Something for the robot to do or to tell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[allow(clippy::large_enum_variant, reason = "no allocator on the board; one lives at a time")]
pub enum Command {
    /// Who are you? Answered by [`Answer::Identity`].
    Identify,
    /// State, fault and counters. Answered by [`Answer::Status`].
    Status,
    /// The configuration in use. Answered by [`Answer::Config`].
    ReadConfig,
    /// Use this configuration from now on, without saving. Refused while driving.
    WriteConfig(Config),
    /// Make the configuration in use survive power-off. Refused while armed.
    SaveConfig,
    /// Use an earlier configuration. Answered by [`Answer::Config`]. Refused while driving.
    RestoreConfig(ConfigOrigin),
    /// Idle to armed: motors on, standing still. The session becomes the driver: until the motors are off
    /// again, no other session may change anything. Every session may stop the robot.
    Arm {
        /// Take over from another driver. Its motion ends with its lease.
        take: bool,
    },
    /// Armed to idle: motors off. Stops first, where needed.
    Disarm,
    /// Drive. A motion that is under way changes into the new one without a jump.
    Drive(Drive),
    /// Drive at this velocity until the lease ends, then brake along a ramp. A motion that is under way changes
    /// into the new one without a jump.
    Velocity(Velocity),
    /// The host is alive and still wants this motion, until the end of this request's lease.
    Renew {
        /// The motion to renew.
        motion: MotionId,
    },
    /// Brake along a ramp, stay armed.
    Stop,
    /// Zero duty now, latched as a fault.
    EmergencyStop,
    /// Faulted to idle, if `number` still is the latched fault's.
    ClearFault {
        /// [`FaultReport::number`].
        number: u32,
    },
    /// Send telemetry every `period_ms`, 0 for none.
    Subscribe {
        /// Milliseconds between two frames, 0 or 1 to 1000.
        period_ms: u16,
    },
    /// Send the telemetry frame with this number again, because it was lost. Answered by [`Answer::Telemetry`].
    Recall {
        /// [`Telemetry::number`].
        number: u32,
    },
    /// Obey only holders of this key from now on; without one, everybody. Kept over power-off. Refused while armed.
    /// In a sealed session the key is [masked](Key::masked).
    SetKey {
        /// The new key.
        key: Option<Key>,
    },
    /// Voltages at the motors, without feedback, within bounds: to measure how they answer.
    Voltage(Voltage),
}

impl Command {
    /// Whether it changes something: such a command needs a [lease](Request::until_ms), and the driver's session while
    /// there is a driver.
    pub const fn needs_lease(&self) -> bool {
        match self {
            Command::WriteConfig(_)
            | Command::SaveConfig
            | Command::RestoreConfig(_)
            | Command::Arm { .. }
            | Command::Drive(_)
            | Command::Velocity(_)
            | Command::Voltage(_)
            | Command::Renew { .. }
            | Command::ClearFault { .. }
            | Command::Subscribe { .. }
            | Command::SetKey { .. } => true,
            Command::Identify
            | Command::Status
            | Command::ReadConfig
            | Command::Disarm
            | Command::Stop
            | Command::EmergencyStop
            | Command::Recall { .. } => false,
        }
    }
}

/// Where a configuration comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "snake_case")]
pub enum ConfigOrigin {
    /// Built into the firmware.
    Factory,
    /// The one that was saved last; the factory's, where none was.
    Saved,
}

/// The answer to a request that was carried out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[allow(clippy::large_enum_variant, reason = "no allocator on the board; one lives at a time")]
pub enum Answer {
    /// Done.
    Done,
    /// Who the robot is.
    Identity(Identity),
    /// State, fault and counters.
    Status(Status),
    /// The configuration in use.
    Config(Config),
    /// An earlier telemetry frame, unchanged.
    Telemetry(Telemetry),
}

/// Why the robot refused a request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// Not permitted in this state.
    State(State),
    /// A fault is latched.
    Faulted(FaultReport),
    /// The configuration is unphysical.
    Config(ConfigError),
    /// The motion is impossible.
    Motion(MotionError),
    /// No such motion is under way.
    NoSuchMotion,
    /// The number is not the latched fault's.
    NoSuchFault,
    /// The cause of the fault is still there.
    CauseRemains,
    /// The telemetry period is outside 0 to 1000 ms.
    Period,
    /// The store could not be written; the configuration in use is unchanged and unsaved.
    Store,
    /// Say hello first: the robot does not know this session. The reply's id is 0.
    HelloFirst,
    /// The request could not be read. The reply's id is 0.
    Unreadable,
    /// The request arrived after the end of its lease.
    Late,
    /// The lease ends more than [`Request::LEASE_MS_MAX`] ahead.
    Lease,
    /// Another session drives the robot.
    Driven,
    /// The robot no longer has the telemetry frame with this number: it keeps the last [`Telemetry::KEPT`].
    Forgotten,
    /// The robot has a key, and the frame is not sealed by a holder of that key. The reply's id is 0.
    Key,
    /// What should have shown the key does not: it is another key, or another host was quicker. The reply's id is 0.
    WrongKey,
}

/// Who the robot is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Identity {
    /// The robot's name, given by its owner.
    pub name: Name,
    /// The board or target that the firmware was built for.
    pub board: Name,
    /// The chip's unique number.
    pub uid: [u8; 12],
    /// Firmware version: major, minor, patch.
    pub firmware: [u16; 3],
    /// [`PROTOCOL_VERSION`](crate::PROTOCOL_VERSION) of the firmware.
    pub protocol: u16,
    /// Time between two control ticks \[us\].
    pub control_period_us: u32,
    /// What no motion may exceed.
    pub limits: LimitsConfig,
    /// Why the board started last.
    pub reset_cause: ResetCause,
    /// What the board starts with: a saved configuration, if there is one.
    pub config_origin: ConfigOrigin,
    /// The store held something unreadable at start, and the factory configuration is in use.
    pub store_damaged: bool,
    /// The configuration in use differs from the saved one.
    pub unsaved: bool,
}

/// Why a board started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "snake_case")]
pub enum ResetCause {
    /// Power came on.
    PowerOn,
    /// The reset button or pin.
    Pin,
    /// The firmware restarted itself.
    Software,
    /// The watchdog: a task missed its deadline.
    Watchdog,
    /// The firmware panicked.
    Panic,
    /// The supply dipped.
    BrownOut,
}

/// State, fault and counters since power-on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Status {
    /// Time since power-on \[us\].
    pub t_us: u64,
    /// The robot's state.
    pub state: State,
    /// The motion under way, or the last one.
    pub motion: Option<MotionId>,
    /// How the last motion ended; `None` while it is under way or before the first.
    pub motion_end: Option<MotionEnd>,
    /// The latched fault.
    pub fault: Option<FaultReport>,
    /// Supply \[mV\].
    pub supply_mv: u16,
    /// The link's counters on the robot's side.
    pub link: LinkStatistics,
    /// Control ticks so far.
    pub ticks: u32,
    /// Longest delay of a control tick \[us\].
    pub tick_delay_us_max: u32,
    /// Control ticks that were lost, because the core stood still.
    pub ticks_lost: u32,
}

/// How a motion ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MotionEnd {
    /// At its target.
    Completed,
    /// By a stop command, or a [`Velocity`] at the end of its lease.
    Stopped,
    /// By a fault.
    Faulted,
    /// By a new motion.
    Replaced,
    /// By a wheel that went as far as the [`Voltage`] allows.
    TravelLimit,
    /// By a wheel that turned as fast as the [`Voltage`] allows.
    SpeedLimit,
}

/// What the robot received and sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct LinkStatistics {
    /// Good frames.
    pub frames_received: u32,
    /// Frames with a wrong checksum, or too long, or too short.
    pub frames_damaged: u32,
    /// Frames that the sequence numbers show to be missing.
    pub frames_lost: u32,
    /// Frames sent.
    pub frames_sent: u32,
    /// Telemetry frames dropped because the line was busy.
    pub telemetry_dropped: u32,
    /// Frames dropped because nobody who holds the robot's key sent them, or because they came before.
    pub frames_refused: u32,
}

/// News that the robot sends unasked. An event may be lost: [`Status`] gives the same information.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Event {
    /// The robot's state changed.
    State {
        /// When, since power-on \[us\].
        t_us: u64,
        /// The new state.
        state: State,
    },
    /// A fault was latched.
    Fault(FaultReport),
    /// A motion ended.
    MotionEnded {
        /// When, since power-on \[us\].
        t_us: u64,
        /// Which.
        motion: MotionId,
        /// How.
        end: MotionEnd,
    },
}
