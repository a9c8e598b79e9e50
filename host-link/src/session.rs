//! A session with one robot: handshake, requests with retries, telemetry, events.
//!
//! It is async over a wire and a clock, so that the same procedure runs against a board in real
//! time and against the simulator in virtual time. How a motion is driven is a matter of
//! [`crate::motion`].

use std::collections::VecDeque;
use std::time::Duration;

use futures_lite::future;
use shared_proto::{
    Answer, Channel, Command, Config, ConfigOrigin, Decoder, Encoder, Event, Hello, Identity,
    MotionId, Refusal, Reply, Request, Status, Telemetry,
};

use crate::cancel::Cancel;
use crate::clock::Clock;
use crate::error::{Error, Result, name_of};
use crate::received::{keep, sound};
use crate::stream::Stream;
use crate::wire::Wire;

/// A request without a reply is repeated after this long: ten times a round trip over USB.
const RETRY_AFTER: Duration = Duration::from_millis(40);

/// A robot that has not answered after this long is taken to be gone.
const GIVE_UP_AFTER: Duration = Duration::from_millis(1500);

/// A save may have to erase all of the store first: four sectors of half a second.
const GIVE_UP_SAVING_AFTER: Duration = Duration::from_secs(5);

/// A session with one robot.
pub struct Session {
    wire: Box<dyn Wire>,
    clock: Clock,
    cancel: Cancel,
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
    /// Intact frames.
    pub frames_received: u64,
    /// Frames that were damaged.
    pub frames_damaged: u64,
    /// Frames that the sequence numbers show to be missing.
    pub frames_lost: u64,
    /// Requests sent again.
    pub retries: u64,
    /// Telemetry frames that were lost, requested again, and received.
    pub telemetry_recalled: u64,
    /// Telemetry frames that were lost for good.
    pub telemetry_lost: u64,
}

impl Session {
    /// A session that is not open yet: [`open`](Self::open) begins it.
    ///
    /// `number` must differ from that of the robot's last session; `port` is what errors call the
    /// wire.
    pub fn new(wire: impl Wire + 'static, clock: Clock, number: u32, port: String) -> Self {
        Self {
            wire: Box::new(wire),
            clock,
            cancel: Cancel::default(),
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

    /// The clock of this session.
    pub fn clock(&self) -> Clock {
        self.clock.clone()
    }

    /// Makes this session's procedures end in good order once `cancel` is requested.
    pub fn cancel_by(&mut self, cancel: &Cancel) {
        self.cancel = cancel.clone();
    }

    /// Whether the procedures of this session are to end.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_requested()
    }

    /// A number for the next motion, different from that of the last.
    pub fn new_motion(&mut self) -> MotionId {
        self.motions += 1;
        MotionId(self.number.wrapping_add(self.motions.wrapping_mul(0x9e37_79b9)))
    }

    /// What was received and repeated.
    pub fn statistics(&self) -> HostStatistics {
        HostStatistics {
            telemetry_recalled: self.telemetry.recalled(),
            telemetry_lost: self.telemetry.lost(),
            ..self.statistics
        }
    }

    /// Shakes hands: both ends must speak the same version with the same message layouts.
    pub async fn open(&mut self) -> Result<()> {
        let ours = Hello::of_this_build(self.number);
        let give_up = self.clock.now_us() + GIVE_UP_AFTER.as_micros() as u64;
        while self.clock.now_us() < give_up {
            // A zero first ends whatever noise the robot has received so far, so that it is not
            // part of our frame.
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
                    return Err(Error::VersionsDiffer { ours, theirs });
                }
                _ => self.statistics.retries += 1,
            }
        }
        let port = self.port.clone();
        match self.statistics {
            HostStatistics { frames_damaged: 0, frames_received: 0, .. } => {
                Err(Error::NoAnswer { port })
            }
            HostStatistics { frames_damaged: damaged, .. } => {
                Err(Error::NotARobot { port, damaged })
            }
        }
    }

    /// Sends a request, and repeats it until the robot answers.
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
        Err(Error::StoppedAnswering { port: self.port.clone() })
    }

    /// Sends a request without waiting for the answer: for what is soon repeated anyway.
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
        let request = name_of(&command);
        self.ask(command).await?.map_err(|refusal| Error::Refused { request, refusal })
    }

    /// Who the robot is.
    pub async fn identify(&mut self) -> Result<Identity> {
        match self.request(Command::Identify).await? {
            Answer::Identity(identity) => Ok(identity),
            other => Err(wrong_answer("identify itself", other)),
        }
    }

    /// State, fault and counters.
    pub async fn status(&mut self) -> Result<Status> {
        match self.request(Command::Status).await? {
            Answer::Status(status) => Ok(status),
            other => Err(wrong_answer("report its status", other)),
        }
    }

    /// The configuration in use.
    pub async fn read_config(&mut self) -> Result<Config> {
        match self.request(Command::ReadConfig).await? {
            Answer::Config(config) => sound(config),
            other => Err(wrong_answer("read the configuration", other)),
        }
    }

    /// Uses another configuration, reads it back and compares.
    pub async fn write_config(&mut self, config: &Config) -> Result<()> {
        config.validate().map_err(|error| Error::Refused {
            request: "use the configuration",
            refusal: Refusal::Config(error),
        })?;
        self.request(Command::WriteConfig(config.clone())).await?;
        if self.read_config().await? != *config {
            return Err(Error::ReadBackDiffers);
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
            Answer::Config(config) => sound(config),
            other => Err(wrong_answer("restore the configuration", other)),
        }
    }

    /// Telemetry that was received and not taken yet, oldest first, each frame once.
    ///
    /// Frames after a lost one are held back until that one has been received.
    pub fn take_telemetry(&mut self) -> impl Iterator<Item = Telemetry> + '_ {
        self.telemetry.drain()
    }

    /// As [`take_telemetry`](Self::take_telemetry), but does not hold frames back for lost ones.
    pub fn take_all_telemetry(&mut self) -> impl Iterator<Item = Telemetry> + '_ {
        self.telemetry.give_up();
        self.telemetry.drain()
    }

    /// Events that were received and not taken yet, oldest first.
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
        // Older replies answer requests that were repeated and have been answered.
        self.replies.retain(|reply| reply.id > id);
        reply
    }

    async fn write(&mut self, bytes: &[u8]) -> Result<()> {
        let result = self.wire.write(bytes).await;
        result.map_err(|cause| self.lost(cause))
    }

    /// Receives something; false if nothing came until this time.
    async fn receive_until(&mut self, t_us: u64) -> Result<bool> {
        let clock = self.clock.clone();
        if clock.now_us() > t_us {
            // A port that never stops sending must not keep us for ever.
            return Ok(false);
        }
        let read = async { Some(self.wire.read().await) };
        let timeout = async {
            clock.sleep_until_us(t_us).await;
            None
        };
        let Some(bytes) = future::or(read, timeout).await else { return Ok(false) };
        let bytes = bytes.map_err(|cause| self.lost(cause))?;
        for byte in bytes {
            self.take_byte(byte)?;
        }
        if let Some(number) = self.telemetry.missing(clock.now_us()) {
            let id = self.post_request(Command::Recall { number }).await?;
            self.telemetry.mark_requested(number, id, clock.now_us());
        }
        Ok(true)
    }

    fn lost(&self, cause: std::io::Error) -> Error {
        Error::ConnectionLost { port: self.port.clone(), cause }
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
                        return Err(Error::Restarted { port: self.port.clone() });
                    }
                    Reply { id, outcome } if self.telemetry.is_request(id) => match outcome {
                        Ok(Answer::Telemetry(telemetry)) => self.telemetry.fill_gap(telemetry),
                        _ => self.telemetry.unavailable(id),
                    },
                    reply => keep(&mut self.replies, reply),
                }
            }
            Channel::Telemetry => {
                if let Some(telemetry) = frame.message::<Telemetry>() {
                    self.telemetry.push(telemetry);
                }
            }
            Channel::Event => {
                frame
                    .message::<Event>()
                    .into_iter()
                    .for_each(|event| keep(&mut self.events, event));
            }
            Channel::Request => {}
        }
        Ok(())
    }
}

fn wrong_answer(request: &'static str, answer: Answer) -> Error {
    Error::WrongAnswer { request, answer: Box::new(answer) }
}
