//! A conversation with one robot: handshake, requests with retries, telemetry, events.
//!
//! Async over a wire and a clock, so that the same procedure runs against a board in real time and
//! against the simulator in virtual time.

use std::collections::VecDeque;
use std::time::Duration;

use futures_lite::future;
use shared_proto::{
    Answer, Channel, Command, Config, ConfigOrigin, Decoder, Encoder, Event, FaultReport, Hello,
    Identity, MotionError, MotionId, Refusal, Reply, Request, Status, Telemetry,
};

use crate::error::{Error, Result};
use crate::link::{Clock, Wire};
use crate::stream::Stream;

/// A reply that has not come after this long is asked for again: ten times a round trip over USB.
const RETRY_AFTER: Duration = Duration::from_millis(40);

/// A robot that has not answered after this long is not there.
const GIVE_UP_AFTER: Duration = Duration::from_millis(1500);

/// A save may have to erase all of the store first: four sectors of half a second.
const GIVE_UP_SAVING_AFTER: Duration = Duration::from_secs(5);

/// A conversation with one robot.
pub struct Session {
    wire: Wire,
    clock: Clock,
    port: String,
    number: u32,
    encoder: Encoder,
    decoder: Decoder,
    next_id: u32,
    motions: u32,
    replies: VecDeque<Reply>,
    hello: Option<Hello>,
    telemetry: Stream,
    events: VecDeque<Event>,
    statistics: HostStatistics,
}

/// What the host received, and what it had to repeat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HostStatistics {
    /// Good frames.
    pub frames_received: u64,
    /// Frames that were damaged.
    pub frames_damaged: u64,
    /// Frames that the sequence numbers show to be missing.
    pub frames_lost: u64,
    /// Requests sent again.
    pub retries: u64,
    /// Telemetry that was lost on the way, asked for again, and had.
    pub telemetry_recalled: u64,
    /// Telemetry that is missing for good.
    pub telemetry_lost: u64,
}

impl Session {
    /// A conversation that has not begun.
    pub fn new(wire: Wire, clock: Clock, number: u32, port: String) -> Self {
        Self {
            wire,
            clock,
            port,
            number,
            encoder: Encoder::new(),
            decoder: Decoder::new(),
            next_id: 1,
            motions: 0,
            replies: VecDeque::new(),
            hello: None,
            telemetry: Stream::default(),
            events: VecDeque::new(),
            statistics: HostStatistics::default(),
        }
    }

    /// The clock that this conversation goes by.
    pub fn clock(&self) -> Clock {
        self.clock
    }

    /// A number for the next motion that the last one did not have.
    pub fn new_motion(&mut self) -> MotionId {
        self.motions += 1;
        MotionId(self.number.wrapping_add(self.motions.wrapping_mul(0x9e37_79b9)))
    }

    /// What was received and repeated.
    pub fn statistics(&self) -> HostStatistics {
        HostStatistics {
            telemetry_recalled: self.telemetry.had_again(),
            telemetry_lost: self.telemetry.lost(),
            ..self.statistics
        }
    }

    /// Shakes hands: both ends must speak the same version with the same message layouts.
    pub async fn open(&mut self) -> Result<()> {
        let ours = Hello::of_this_build(self.number);
        let give_up = self.clock.now_us() + GIVE_UP_AFTER.as_micros() as u64;
        while self.clock.now_us() < give_up {
            // A zero first: whatever noise the robot has heard so far is no frame of ours.
            self.write(&[0]).await?;
            let frame = self.encoder.hello(ours);
            self.write(&frame).await?;
            self.hello = None;
            let until = self.clock.now_us() + RETRY_AFTER.as_micros() as u64;
            while self.hello.is_none_or(|theirs| theirs.session != self.number) {
                if !self.receive_until(until).await? {
                    break;
                }
            }
            match self.hello {
                Some(theirs) if theirs.session == self.number => {
                    if ours.agrees_with(&theirs) {
                        return Ok(());
                    }
                    return Err(versions_differ(&ours, &theirs));
                }
                _ => self.statistics.retries += 1,
            }
        }
        let what = match self.statistics {
            HostStatistics { frames_damaged: 0, frames_received: 0, .. } => {
                format!("no robot answers on {}", self.port)
            }
            HostStatistics { frames_damaged, .. } => format!(
                "something on {} talks, but not as a Beeline robot ({frames_damaged} unreadable frames)",
                self.port
            ),
        };
        Err(Error::new(what).hint(
            "is it powered, flashed with Beeline, and is this the right port and baud rate? `beeline ports` lists the ports",
        ))
    }

    /// Asks, and repeats the question until the robot answers.
    pub async fn ask(&mut self, command: Command) -> Result<std::result::Result<Answer, Refusal>> {
        let subscribes = matches!(command, Command::Subscribe { .. });
        let id = self.next_id;
        self.next_id += 1;
        let patience = match command {
            Command::SaveConfig => GIVE_UP_SAVING_AFTER,
            _ => GIVE_UP_AFTER,
        };
        let request = Request { id, command };
        let give_up = self.clock.now_us() + patience.as_micros() as u64;
        let mut first = true;
        while self.clock.now_us() < give_up {
            if !std::mem::take(&mut first) {
                self.statistics.retries += 1;
            }
            let frame = self.encoder.message(&request);
            self.write(&frame).await?;
            let until = self.clock.now_us() + RETRY_AFTER.as_micros() as u64;
            loop {
                if let Some(reply) = self.take_reply(id) {
                    if subscribes {
                        self.telemetry.restart();
                    }
                    return Ok(reply.outcome);
                }
                if !self.receive_until(until).await? {
                    break;
                }
            }
        }
        Err(Error::new(format_args!("the robot on {} stopped answering", self.port))
            .hint("is it still powered and plugged in?"))
    }

    /// Says something and does not wait for the answer: for what is said again soon anyway.
    pub async fn post(&mut self, command: Command) -> Result<()> {
        self.post_request(command).await.map(drop)
    }

    async fn post_request(&mut self, command: Command) -> Result<u32> {
        let id = self.next_id;
        self.next_id += 1;
        let frame = self.encoder.message(&Request { id, command });
        self.write(&frame).await?;
        Ok(id)
    }

    /// As [`ask`](Self::ask), where a refusal is an error.
    pub async fn request(&mut self, command: Command) -> Result<Answer> {
        let what = name_of(&command);
        self.ask(command).await?.map_err(|refusal| refused(what, &refusal))
    }

    /// Who the robot is.
    pub async fn identify(&mut self) -> Result<Identity> {
        match self.request(Command::Identify).await? {
            Answer::Identity(identity) => Ok(identity),
            other => Err(unexpected("identify", &other)),
        }
    }

    /// State, fault and counters.
    pub async fn status(&mut self) -> Result<Status> {
        match self.request(Command::Status).await? {
            Answer::Status(status) => Ok(status),
            other => Err(unexpected("status", &other)),
        }
    }

    /// The configuration in use.
    pub async fn read_config(&mut self) -> Result<Config> {
        match self.request(Command::ReadConfig).await? {
            Answer::Config(config) => Ok(config),
            other => Err(unexpected("read configuration", &other)),
        }
    }

    /// Uses another configuration, reads it back and compares.
    pub async fn write_config(&mut self, config: &Config) -> Result<()> {
        config
            .validate()
            .map_err(|error| refused("write configuration", &Refusal::Config(error)))?;
        self.request(Command::WriteConfig(config.clone())).await?;
        if self.read_config().await? != *config {
            return Err(Error::new("the robot read back another configuration than was written")
                .hint("nothing was saved; try again, and report it if it happens twice"));
        }
        Ok(())
    }

    /// Makes the configuration in use survive power-off. The robot reads back what it wrote.
    pub async fn save_config(&mut self) -> Result<()> {
        self.request(Command::SaveConfig).await?;
        Ok(())
    }

    /// Goes back to an earlier configuration, and returns it.
    pub async fn restore_config(&mut self, origin: ConfigOrigin) -> Result<Config> {
        match self.request(Command::RestoreConfig(origin)).await? {
            Answer::Config(config) => Ok(config),
            other => Err(unexpected("restore configuration", &other)),
        }
    }

    /// Telemetry that has come and not been taken, oldest first, each frame once.
    ///
    /// What comes behind a frame that was lost is held back until that one has been had again.
    pub fn take_telemetry(&mut self) -> impl Iterator<Item = Telemetry> + '_ {
        self.telemetry.drain()
    }

    /// As [`take_telemetry`](Self::take_telemetry), but waits for nothing that was lost.
    pub fn take_all_telemetry(&mut self) -> impl Iterator<Item = Telemetry> + '_ {
        self.telemetry.give_up();
        self.telemetry.drain()
    }

    /// Events that have come and not been taken, oldest first.
    pub fn take_events(&mut self) -> impl Iterator<Item = Event> + '_ {
        self.events.drain(..)
    }

    /// Listens for this long.
    pub async fn listen(&mut self, duration: Duration) -> Result<()> {
        let until = self.clock.now_us() + duration.as_micros() as u64;
        while self.receive_until(until).await? {}
        Ok(())
    }

    fn take_reply(&mut self, id: u32) -> Option<Reply> {
        let at = self.replies.iter().position(|reply| reply.id == id)?;
        let reply = self.replies.remove(at);
        // Older ones answer questions that were repeated and have been answered.
        self.replies.retain(|reply| reply.id > id);
        reply
    }

    async fn write(&mut self, bytes: &[u8]) -> Result<()> {
        let result = self.wire.write(bytes).await;
        result.map_err(|error| lost(&self.port, &error))
    }

    /// Receives something; false if nothing came until then.
    async fn receive_until(&mut self, t_us: u64) -> Result<bool> {
        let clock = self.clock;
        if clock.now_us() > t_us {
            // Something that never stops talking must not keep us for ever.
            return Ok(false);
        }
        let read = async { Some(self.wire.read().await) };
        let timeout = async {
            clock.sleep_until_us(t_us).await;
            None
        };
        let Some(bytes) = future::or(read, timeout).await else { return Ok(false) };
        let bytes = bytes.map_err(|error| lost(&self.port, &error))?;
        for byte in bytes {
            self.take_byte(byte)?;
        }
        if let Some(number) = self.telemetry.missing(clock.now_us()) {
            let id = self.post_request(Command::Recall { number }).await?;
            self.telemetry.has_asked(number, id, clock.now_us());
        }
        Ok(true)
    }

    fn take_byte(&mut self, byte: u8) -> Result<()> {
        let frame = match self.decoder.push(byte) {
            None => return Ok(()),
            Some(Err(_)) => {
                self.statistics.frames_damaged += 1;
                return Ok(());
            }
            Some(Ok(frame)) => frame,
        };
        self.statistics.frames_received += 1;
        self.statistics.frames_lost += u64::from(frame.lost);
        match frame.channel {
            Channel::Hello => self.hello = frame.hello(),
            Channel::Reply => {
                let Some(reply) = frame.message::<Reply>() else { return Ok(()) };
                match reply {
                    Reply { id: 0, outcome: Err(Refusal::HelloFirst) } => {
                        return Err(Error::new(format_args!(
                            "the robot on {} restarted in the middle of this",
                            self.port
                        ))
                        .hint("check its supply; what it does not save, it has forgotten"));
                    }
                    Reply { id, outcome } if self.telemetry.has_asked_by(id) => match outcome {
                        Ok(Answer::Telemetry(telemetry)) => self.telemetry.recalled(telemetry),
                        _ => self.telemetry.forgotten(id),
                    },
                    reply => self.replies.push_back(reply),
                }
            }
            Channel::Telemetry => {
                if let Some(telemetry) = frame.message::<Telemetry>() {
                    self.telemetry.take_in(telemetry);
                }
            }
            Channel::Event => self.events.extend(frame.message::<Event>()),
            Channel::Request => {}
        }
        Ok(())
    }
}

fn lost(port: &str, error: &std::io::Error) -> Error {
    Error::new(format_args!("the connection to {port} is gone: {error}"))
        .hint("it was unplugged, or another host took over (a robot has one at a time); without its host it stops by itself")
}

fn versions_differ(ours: &Hello, theirs: &Hello) -> Error {
    let hint = if ours.protocol < theirs.protocol {
        "update beeline"
    } else if ours.protocol > theirs.protocol {
        "flash the robot with this beeline's firmware"
    } else {
        "flash the robot with this beeline's firmware, or use the beeline that belongs to it"
    };
    Error::new(format_args!(
        "the robot speaks protocol {} (schema {:016x}), this beeline speaks protocol {} (schema {:016x})",
        theirs.protocol, theirs.schema, ours.protocol, ours.schema
    ))
    .hint(hint)
}

fn unexpected(what: &str, answer: &Answer) -> Error {
    Error::new(format_args!("the robot answered {what} with something else: {answer:?}"))
}

fn name_of(command: &Command) -> &'static str {
    match command {
        Command::Identify => "identify",
        Command::Status => "status",
        Command::ReadConfig => "read configuration",
        Command::WriteConfig(_) => "write configuration",
        Command::SaveConfig => "save configuration",
        Command::RestoreConfig(_) => "restore configuration",
        Command::Arm => "arm",
        Command::Disarm => "disarm",
        Command::Drive(_) => "drive",
        Command::Renew { .. } => "renew",
        Command::Stop => "stop",
        Command::EmergencyStop => "emergency stop",
        Command::ClearFault { .. } => "clear fault",
        Command::Subscribe { .. } => "subscribe",
        Command::Recall { .. } => "recall telemetry",
    }
}

/// A fault, as a person should read it.
pub fn faulted(report: &FaultReport) -> Error {
    let after = match report.followed_by {
        0 => String::new(),
        1 => ", and one more fault after it".into(),
        n => format!(", and {n} more faults after it"),
    };
    Error::new(format_args!(
        "the robot stopped with a fault: {} at {:.3} s{after}",
        report.fault,
        report.t_us as f64 * 1e-6
    ))
    .hint(format_args!("{}; then `beeline clear`", report.fault.remedy()))
}

/// A refusal, as a person should read it.
pub fn refused(what: &str, refusal: &Refusal) -> Error {
    let refused = |why: &dyn std::fmt::Display| {
        Error::new(format_args!("the robot refused to {what}: {why}"))
    };
    match refusal {
        Refusal::State(state) => refused(&format_args!("it is {}", state.name()))
            .hint("`beeline identify` shows its state, `beeline stop` ends a motion"),
        Refusal::Faulted(report) => Error::new(format_args!(
            "the robot refused to {what}: a fault is latched, {} at {:.3} s",
            report.fault,
            report.t_us as f64 * 1e-6
        ))
        .hint(format_args!("{}; then `beeline clear`", report.fault.remedy())),
        Refusal::Config(error) => refused(error).hint("`beeline config get` shows what is there"),
        Refusal::Motion(error @ (MotionError::TooFast | MotionError::TooSteep)) => {
            refused(error).hint("`beeline config get limits` shows the limits")
        }
        Refusal::Motion(error) => {
            refused(error).hint("check the distance, --cruise and --acceleration")
        }
        Refusal::NoSuchMotion => {
            refused(&"no such motion is under way").hint("`beeline identify` shows its state")
        }
        Refusal::NoSuchFault => refused(&"that fault is not latched (any more)")
            .hint("`beeline identify` shows the one that is"),
        Refusal::CauseRemains => refused(&"the cause of the fault is still there")
            .hint("release the emergency stop, check the driver and the battery"),
        Refusal::Period => refused(&"the telemetry period must be from 1 to 1000 ms"),
        Refusal::Store => {
            refused(&"its flash could not be written; the saved configuration is as it was")
                .hint("try again; a simulated robot's is --flash FILE: is its disk full?")
        }
        Refusal::Forgotten => refused(&"it no longer keeps that telemetry"),
        Refusal::HelloFirst => refused(&"it restarted"),
        Refusal::Unreadable => refused(&"it could not read the request"),
    }
}
