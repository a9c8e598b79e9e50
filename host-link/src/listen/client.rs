//! One client on TCP: its frames to the robot, and the robot's bytes to it.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::time::Duration;

use shared_proto::{Channel, Decoder, Encoder, Frame, LengthBound, Received, Reply};

/// What has become of the clients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClientEvent {
    /// A client has said hello.
    Connected,
    /// A client that had said hello went away.
    Disconnected,
    /// A program that does not speak the protocol was cut off.
    Stranger,
    /// A client that did not read was cut off.
    NotReading,
    /// A client that did not show the robot's key was cut off.
    NoKey,
}

/// The first byte of a hello's frame: COBS for a zero at once.
const HELLO_FIRST: u8 = 1;

/// A client that has not said hello by then is none, and one that has not shown the robot's key may not have it.
const GREETING_MAX: Duration = Duration::from_secs(2);

/// A client says hello again no sooner: each costs the robot an answer, and its line has not room for a crowd's.
const BETWEEN_HELLOS: Duration = Duration::from_millis(20);

/// A client may leave this much of what the robot says unread \[bytes\]: two seconds of the quickest line.
pub(super) const UNREAD_MAX: usize = 256 * 1024;

/// So many bytes of a client are held until the line takes them: a few of the longest frames.
pub(super) const HELD_MAX: usize = 1024;

/// No stop is longer \[bytes\].
const SHORT: usize = 24;

/// A client behind a stream that does not block. Times are those of the server, since it began.
pub(super) struct Client<S> {
    stream: S,
    since: Duration,
    /// Since its hello.
    session: Option<u32>,
    /// When its last hello was passed on.
    hello_at: Option<Duration>,
    /// The robot has let its session in.
    let_in: bool,
    /// Its answer to the challenge is on its way, and one short frame may go with it: an emergency stop does not wait.
    opening: bool,
    decoder: Decoder,
    /// Received, and not passed on yet.
    held: VecDeque<u8>,
    /// For the client, and not sent yet.
    unsent: VecDeque<u8>,
    /// The stream has ended; what is held is passed on all the same.
    ended: bool,
}

impl<S: Read + Write> Client<S> {
    /// A client that has connected.
    pub fn new(stream: S, now: Duration) -> Self {
        Self {
            stream,
            since: now,
            session: None,
            hello_at: None,
            let_in: false,
            opening: false,
            decoder: Decoder::new(),
            held: VecDeque::new(),
            unsent: VecDeque::new(),
            ended: false,
        }
    }

    /// What is held of it and for it \[bytes\].
    pub fn waiting(&self) -> usize {
        self.held.len() + self.unsent.len()
    }

    /// How long it has been here.
    pub fn age(&self, now: Duration) -> Duration {
        now.saturating_sub(self.since)
    }

    /// Its session, once it has said hello.
    pub fn session(&self) -> Option<u32> {
        self.session
    }

    /// Whether the robot has let it in.
    pub fn is_let_in(&self) -> bool {
        self.let_in
    }

    /// What is said of it if it has to go.
    pub fn leaving_event(&self) -> ClientEvent {
        match self.session {
            None => ClientEvent::Stranger,
            Some(_) if self.let_in => ClientEvent::Disconnected,
            Some(_) => ClientEvent::NoKey,
        }
    }

    /// Takes from the network what there is room for; false if the client is to be forgotten.
    pub fn receive(
        &mut self,
        now: Duration,
        robot_has_key: bool,
        tell: &mut dyn FnMut(ClientEvent),
    ) -> bool {
        let here = self.age(now);
        if !self.ended && self.held.len() < HELD_MAX {
            let mut buffer = [0; HELD_MAX];
            match self.stream.read(&mut buffer[self.held.len()..]) {
                Ok(0) => self.ended = true,
                Ok(len) => {
                    let from = self.held.len();
                    self.held.extend(&buffer[from..from + len]);
                }
                Err(error) if is_pause(&error) => {}
                Err(_) => self.ended = true,
            }
        }
        if self.session.is_none() {
            match self.greeting() {
                Greeting::None if here < GREETING_MAX && !self.ended => {}
                Greeting::Hello(session) => {
                    self.session = Some(session);
                    tell(ClientEvent::Connected);
                }
                // Whoever connects and leaves without a word is not worth one.
                Greeting::None if self.ended && self.held.is_empty() => return false,
                Greeting::None | Greeting::Other => {
                    tell(ClientEvent::Stranger);
                    return false;
                }
            }
        }
        if self.ended && self.held.is_empty() {
            tell(ClientEvent::Disconnected);
            return false;
        }
        let slow = here > GREETING_MAX && robot_has_key && !self.let_in;
        if slow {
            tell(ClientEvent::NoKey);
        }
        !slow
    }

    /// What the client's first frame is. Zeros before it are silence.
    fn greeting(&mut self) -> Greeting {
        while self.held.front() == Some(&0) {
            self.held.pop_front();
        }
        // A hello's frame begins with the code of its channel, which is zero.
        if self.held.front().is_some_and(|&first| first != HELLO_FIRST) {
            return Greeting::Other;
        }
        let Some(end) = self.held.iter().position(|&byte| byte == 0) else {
            let longest = LengthBound::ALL[Channel::Hello as usize].frame_len;
            return if self.held.len() > longest { Greeting::Other } else { Greeting::None };
        };
        let mut decoder = Decoder::new();
        for &byte in self.held.iter().take(end + 1) {
            if let Some(Ok(frame)) = decoder.push(byte)
                && let Some(hello) = frame.hello()
            {
                return Greeting::Hello(hello.session);
            }
        }
        Greeting::Other
    }

    /// The client's next whole frame, counted by this encoder. Of a client that a robot with a key has not let in, only
    /// what may change that.
    pub fn next_frame(
        &mut self,
        now: Duration,
        robot_has_key: bool,
        encoder: &mut Encoder,
    ) -> Option<Frame> {
        self.session?;
        while let Some(byte) = self.held.pop_front() {
            // A damaged frame is dropped here: between client and robot there is a second checksum.
            let Some(Ok(frame)) = self.decoder.push(byte) else { continue };
            let its_own = frame.session() == self.session;
            match frame.channel {
                // One connection, one session: nobody speaks for another host.
                _ if !its_own => {}
                Channel::Hello
                    if self.hello_at.is_some_and(|at| now.saturating_sub(at) < BETWEEN_HELLOS) => {}
                channel @ (Channel::Hello | Channel::Open) => {
                    self.opening = channel == Channel::Open;
                    if channel == Channel::Hello {
                        self.hello_at = Some(now);
                    }
                    return Some(encoder.relay(&frame));
                }
                _ if self.let_in || !robot_has_key => return Some(encoder.relay(&frame)),
                _ if std::mem::take(&mut self.opening) && frame.payload.len() <= SHORT => {
                    return Some(encoder.relay(&frame));
                }
                _ => {}
            }
        }
        None
    }

    /// The robot has a key from now on.
    pub fn shut_out(&mut self, now: Duration) {
        self.let_in = false;
        self.since = now;
    }

    /// Takes what the robot says, as far as it is for this client.
    pub fn hear(&mut self, bytes: &[u8], frame: Option<&Received<'_>>) {
        let its_own = frame.is_some_and(|frame| frame.session() == self.session);
        let for_it = match frame {
            _ if self.session.is_none() || self.ended => false,
            Some(frame) if frame.channel == Channel::Hello => {
                // One without a challenge lets everybody in.
                self.let_in |= its_own && frame.challenge().is_none();
                its_own
            }
            Some(frame) if frame.channel == Channel::Opened => {
                self.let_in |= its_own;
                its_own
            }
            // Only a refusal answers who was not let in.
            Some(frame) if frame.channel == Channel::Reply && !self.let_in => {
                let refusal = |reply: Reply| reply.id == 0 && reply.outcome.is_err();
                its_own && frame.message().is_some_and(refusal)
            }
            _ => self.let_in,
        };
        if for_it {
            self.unsent.extend(bytes);
        }
    }

    /// Sends as much as the client takes; false if the client is to be forgotten.
    pub fn send(&mut self, tell: &mut dyn FnMut(ClientEvent)) -> bool {
        if self.ended {
            return true;
        }
        let sent = self.send_unsent();
        if sent.is_err() {
            tell(ClientEvent::Disconnected);
            return false;
        }
        if self.unsent.len() > UNREAD_MAX {
            tell(ClientEvent::NotReading);
            return false;
        }
        true
    }

    fn send_unsent(&mut self) -> io::Result<()> {
        while !self.unsent.is_empty() {
            match self.stream.write(self.unsent.as_slices().0) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(len) => drop(self.unsent.drain(..len)),
                Err(error) if is_pause(&error) => break,
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

/// Whether a stream is as good as before.
fn is_pause(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

enum Greeting {
    None,
    Hello(u32),
    Other,
}
