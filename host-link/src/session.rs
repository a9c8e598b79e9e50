//! A session with one robot: handshake, requests with retries, telemetry, events.
//!
//! It is async over a wire and a clock, so that the same procedure runs against a board in real
//! time and against the simulator in virtual time. How a motion is driven is left to
//! [`crate::motion`].

mod config;
mod emergency_stop;
mod key;
mod leases;
mod motion_ids;
mod open;
mod sealing;
mod telemetry;

use std::collections::VecDeque;
use std::time::Duration;

use futures_lite::future;
use shared_proto::{
    Answer, Channel, Command, Config, Decoder, Encoder, Event, Hello, Identity, MotionId, Nonce,
    Refusal, Reply, Request, Status, Telemetry,
};

use crate::cancel::Cancel;
use crate::clock::Clock;
use crate::error::{Error, Result, name_of};
use crate::lease::Holder;
pub use crate::lease::LEASE;
use crate::robot_clock::RobotClock;
pub use crate::statistics::HostStatistics;
use crate::stream::Stream;
use crate::validate::{KEPT_MAX, keep_latest, plain};
use crate::wire::Wire;

use self::{motion_ids::MotionIds, sealing::Sealing};

/// A request without a reply is repeated after this long: ten times a round trip over USB.
const RETRY_AFTER: Duration = Duration::from_millis(40);

/// A robot that has not answered after this long is taken to be gone.
const GIVE_UP_AFTER: Duration = Duration::from_millis(1500);

/// A save may have to erase all of the store first: four sectors of half a second.
const GIVE_UP_SAVING_AFTER: Duration = Duration::from_secs(5);

/// What moves nothing may be held up for longer: at the slowest baud rate a configuration takes 171 ms by itself.
const LEASE_AT_REST: Duration = Duration::from_secs(1);

/// Whose telemetry a session takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Listening {
    No,
    /// What it has requested itself.
    Subscribed,
    /// Another host's.
    Overhearing,
}

/// A session with one robot.
pub struct Session {
    wire: Box<dyn Wire>,
    clock: Clock,
    cancel: Cancel,
    holder: Option<Holder>,
    port: String,
    number: u32,
    robot_clock: RobotClock,
    encoder: Encoder,
    decoder: Decoder,
    next_id: u32,
    motions: MotionIds,
    replies: VecDeque<Reply>,
    hello: Option<Hello>,
    challenge: Option<Nonce>,
    sealing: Sealing,
    telemetry: Stream,
    listening: Listening,
    events: VecDeque<Event>,
    statistics: HostStatistics,
    /// The configuration that this session wrote last.
    written: Option<Config>,
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
            holder: None,
            port,
            number,
            robot_clock: RobotClock::default(),
            encoder: Encoder::new(),
            decoder: Decoder::new(),
            next_id: 1,
            motions: MotionIds::of_session(number),
            replies: VecDeque::new(),
            hello: None,
            challenge: None,
            sealing: Sealing::default(),
            telemetry: Stream::default(),
            listening: Listening::No,
            events: VecDeque::new(),
            statistics: HostStatistics::default(),
            written: None,
        }
    }

    /// Its number.
    pub fn number(&self) -> u32 {
        self.number
    }

    /// Never more messages wait to be taken.
    pub const WAITING_MAX: usize = 2 * KEPT_MAX + Stream::WAITING_MAX;

    /// How many messages were received and not taken yet.
    pub fn waiting(&self) -> usize {
        self.replies.len() + self.events.len() + self.telemetry.waiting()
    }

    /// The clock of this session.
    pub fn clock(&self) -> Clock {
        self.clock.clone()
    }

    /// A number for the next motion.
    pub fn new_motion(&mut self) -> MotionId {
        self.motions.next()
    }

    /// What was received and repeated.
    pub fn statistics(&self) -> HostStatistics {
        HostStatistics {
            telemetry_recalled: self.telemetry.recalled(),
            telemetry_lost: self.telemetry.lost(),
            ..self.statistics
        }
    }

    /// Sends a request, and repeats it until the robot answers. Each copy has a lease from when it is sent.
    pub async fn ask(&mut self, command: Command) -> Result<std::result::Result<Answer, Refusal>> {
        let subscribes = match command {
            Command::Subscribe { period_ms } => Some(period_ms),
            _ => None,
        };
        let id = self.next_id;
        self.next_id += 1;
        let patience = match command {
            Command::SaveConfig => GIVE_UP_SAVING_AFTER,
            _ => GIVE_UP_AFTER,
        };
        let mut request = Request { session: self.number, id, until_ms: 0, command };
        let give_up = self.clock.now_us() + patience.as_micros() as u64;
        let mut first = true;
        let mut late = false;
        while self.clock.now_us() < give_up {
            if !std::mem::take(&mut first) {
                self.statistics.retries += 1;
            }
            if request.command.needs_lease() {
                let lease = match request.command {
                    Command::WriteConfig(_) | Command::RestoreConfig(_) => LEASE_AT_REST,
                    _ => self.lease(),
                };
                request.until_ms = self.robot_clock.lease_end_ms(lease, self.clock.now_us());
            }
            let frame = self.frame(&request);
            self.robot_clock.send(id, self.clock.now_us());
            self.write(&frame).await?;
            let until = self.clock.now_us() + RETRY_AFTER.as_micros() as u64;
            loop {
                if let Some(reply) = self.take_reply(id) {
                    if reply.outcome == Err(Refusal::Late) {
                        // The line held it up, unless this is the first that we hear of the robot's clock.
                        late |= request.until_ms > 0;
                        break;
                    }
                    if let (Some(period_ms), Ok(_)) = (subscribes, &reply.outcome) {
                        self.telemetry.restart();
                        self.listening =
                            if period_ms > 0 { Listening::Subscribed } else { Listening::No };
                    }
                    return Ok(reply.outcome);
                }
                if !self.receive_until(until).await? {
                    break;
                }
            }
        }
        if late {
            return Ok(Err(Refusal::Late));
        }
        Err(Error::StoppedAnswering { port: self.port.clone() })
    }

    /// Sends a request without waiting for the answer: for what is soon repeated anyway.
    pub async fn post(&mut self, command: Command) -> Result<()> {
        let until_ms = if command.needs_lease() { self.lease_end_ms() } else { 0 };
        self.post_until(command, until_ms).await.map(drop)
    }

    /// As [`post`](Self::post), with a lease that ends at this time of the robot's clock \[ms\]. Returns the id.
    pub async fn post_until(&mut self, command: Command, until_ms: u64) -> Result<u32> {
        let id = self.next_id;
        self.next_id += 1;
        let request = Request { session: self.number, id, until_ms, command };
        let frame = self.frame(&request);
        self.robot_clock.send(id, self.clock.now_us());
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
            Answer::Identity(identity) => Ok(Identity {
                name: plain(&identity.name),
                board: plain(&identity.board),
                ..identity
            }),
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

    /// Listens for this long.
    pub async fn listen(&mut self, duration: Duration) -> Result<()> {
        let until = self.clock.now_us() + duration.as_micros() as u64;
        while self.receive_until(until).await? {}
        Ok(())
    }

    /// The answer to what was [posted](Self::post_until), once it has been received.
    pub fn answer_to(&mut self, id: u32) -> Option<std::result::Result<Answer, Refusal>> {
        self.take_reply(id).map(|reply| reply.outcome)
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
            let id = self.post_until(Command::Recall { number }, 0).await?;
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
        if frame.channel == Channel::Hello {
            // The challenge is the same for every host.
            self.challenge = frame.challenge().or(self.challenge);
            self.hello =
                frame.hello().filter(|theirs| theirs.session == self.number).or(self.hello);
            return Ok(());
        }
        if self.sealing.hear(&frame, self.number) {
            return Ok(());
        }
        let believed = self.sealing.believes(&frame);
        match frame.channel {
            Channel::Reply => {
                if let Some(reply) = frame.message::<Reply>() {
                    self.take_answer(reply, believed)?;
                }
            }
            _ if !believed => self.statistics.frames_refused += 1,
            Channel::Telemetry => {
                if let Some(telemetry) = frame.message::<Telemetry>() {
                    self.robot_clock.hear(telemetry.t_us, None, self.clock.now_us());
                    // Without a subscription it is another host's.
                    if self.listening != Listening::No {
                        self.telemetry.push(telemetry);
                    }
                }
            }
            Channel::Event => {
                frame
                    .message::<Event>()
                    .into_iter()
                    .for_each(|event| keep_latest(&mut self.events, event));
            }
            Channel::Hello | Channel::Request | Channel::Open | Channel::Opened => {}
        }
        Ok(())
    }

    /// Takes an answer, or what is sent in the place of one.
    fn take_answer(&mut self, reply: Reply, believed: bool) -> Result<()> {
        if reply.session != self.number && (reply.session != 0 || self.sealing.has_key()) {
            // For another host on the same line.
            return Ok(());
        }
        // Neither can be sealed by a key that we know, as the robot has a new one. They claim nothing else.
        let port = || self.port.clone();
        match reply {
            Reply { id: 0, t_us, outcome: Err(Refusal::HelloFirst), .. } => {
                let goes_on = self.robot_clock.goes_on(t_us, self.clock.now_us());
                return Err(match goes_on {
                    true => Error::Forgotten { port: port() },
                    false => Error::Restarted { port: port() },
                });
            }
            Reply { id: 0, outcome: Err(Refusal::Key), .. } if !self.sealing.has_key() => {
                return Err(Error::KeyNeeded { port: port() });
            }
            _ => {}
        }
        if !believed {
            self.statistics.frames_refused += 1;
            return Ok(());
        }
        self.robot_clock.hear(reply.t_us, Some(reply.id), self.clock.now_us());
        match reply {
            Reply { id, outcome, .. } if self.telemetry.is_request(id) => match outcome {
                Ok(Answer::Telemetry(telemetry)) => self.telemetry.fill_gap(telemetry),
                _ => self.telemetry.unavailable(id),
            },
            reply => keep_latest(&mut self.replies, reply),
        }
        Ok(())
    }
}

fn wrong_answer(request: &'static str, answer: Answer) -> Error {
    Error::WrongAnswer { request, answer: Box::new(answer) }
}
