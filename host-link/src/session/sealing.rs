//! The key in a session: the robot's challenge is answered, what the host sends is sealed, and what the robot has not
//! sealed is not believed.

use shared_proto::{Channel, Command, Hello, Key, Nonce, Open, Received, Refusal, Reply, Request};

use super::Session;
use crate::error::{Error, Result};

/// After so many refused answers to challenges the key is the wrong one. One may be refused because another host
/// was quicker.
const REFUSALS_MAX: u32 = 5;

/// What a host knows of the key, and of the session under it.
#[derive(Default)]
pub(super) struct Sealing {
    key: Option<HostKey>,
    /// Once the robot has been challenged, and has answered.
    session: Option<Sealed>,
    /// The session that is being opened.
    opening: Option<Opening>,
    refusals: u32,
    /// The last answer was refused, and a new challenge is needed.
    refused: bool,
    /// A robot without a key will do.
    any_robot: bool,
}

struct HostKey {
    key: Key,
    /// From which the host's nonces come.
    nonces: Key,
    drawn: u64,
}

#[derive(Clone, Copy)]
struct Opening {
    challenge: Nonce,
    nonce: Nonce,
    session_key: Key,
    /// The last frame's.
    counter: u64,
}

struct Sealed {
    session_key: Key,
    /// The host's last frame's.
    counter: u64,
    robot_key: Key,
    /// The robot's last frame's.
    heard: u64,
}

impl Sealing {
    /// Key and counter for the next request.
    pub fn next(&mut self) -> Option<(&Key, u64)> {
        let (key, counter) = match (&mut self.opening, &mut self.session) {
            (Some(opening), _) => (&opening.session_key, &mut opening.counter),
            (None, Some(session)) => (&session.session_key, &mut session.counter),
            (None, None) => return None,
        };
        *counter += 1;
        Some((key, *counter))
    }

    /// Whether a frame is the robot's: with a key, only if it is sealed by it and new.
    pub fn believes(&mut self, frame: &Received<'_>) -> bool {
        match (&mut self.session, &self.key, frame.seal) {
            (Some(session), _, Some(seal)) => {
                let new = seal.counter > session.heard && frame.is_sealed_by(&session.robot_key);
                if new {
                    session.heard = seal.counter;
                }
                new
            }
            (None, None, None) => true,
            (None, Some(_), None) => self.any_robot,
            _ => false,
        }
    }

    /// Takes what the robot says while a session is opened; false if it is something else.
    pub fn hear(&mut self, frame: &Received<'_>, number: u32) -> bool {
        match frame.channel {
            Channel::Opened => {
                let opened = frame.opened().filter(|opened| opened.session == number);
                if let (Some(opened), Some(opening), Some(HostKey { key, .. })) =
                    (opened, self.opening, &self.key)
                    && frame.is_sealed_by(&opening.session_key)
                {
                    self.session = Some(Sealed {
                        session_key: opening.session_key,
                        counter: opening.counter,
                        robot_key: key.of_robot(&opened.boot),
                        heard: opened.counter,
                    });
                    self.opening = None;
                    self.refusals = 0;
                }
                true
            }
            Channel::Reply if self.opening.is_some() => {
                let refused = frame.message::<Reply>().is_some_and(|reply| {
                    reply.session == number
                        && reply.id == 0
                        && reply.outcome == Err(Refusal::WrongKey)
                });
                if refused {
                    self.opening = None;
                    self.refusals += 1;
                    self.refused = true;
                }
                refused
            }
            _ => false,
        }
    }

    /// Whether this host seals what it says.
    pub fn has_key(&self) -> bool {
        self.key.is_some()
    }

    fn forget(&mut self) {
        (self.session, self.opening) = (None, None);
    }
}

impl Session {
    /// Talks only to a robot that has this key. `secret` must be random, and new for each session: the host's
    /// own nonces come from it.
    pub fn use_key(&mut self, key: Key, secret: Key) {
        let key = Some(HostKey { key, nonces: secret, drawn: 0 });
        self.sealing = Sealing { key, ..Sealing::default() };
    }

    /// As [`use_key`](Self::use_key), but a robot without a key will do as well: for one that nobody else can reach.
    pub fn offer_key(&mut self, key: Key, secret: Key) {
        self.use_key(key, secret);
        self.sealing.any_robot = true;
    }

    /// Makes the robot obey only holders of another key from now on, or everybody, and opens the session again.
    ///
    /// `secret` is as for [`use_key`](Self::use_key).
    pub async fn set_key(&mut self, key: Option<Key>, secret: Key) -> Result<()> {
        let new = key;
        match self.request(Command::SetKey { key }).await {
            // The answer may have been sealed by a key that is not ours any more.
            Ok(_)
            | Err(
                Error::Restarted { .. } | Error::StoppedAnswering { .. } | Error::KeyNeeded { .. },
            ) => {}
            Err(error) => return Err(error),
        }
        match new {
            Some(key) => self.use_key(key, secret),
            None => self.sealing = Sealing::default(),
        }
        // What tells whether the robot has the new key is that it knows it.
        self.open().await
    }

    /// A request's frame.
    pub(super) fn frame(&mut self, request: &Request) -> shared_proto::Frame {
        let by = self.sealing.next();
        let Some((session_key, counter)) = by else { return self.encoder.message(request) };
        if let Command::SetKey { key: Some(key) } = &request.command {
            let key = Some(session_key.masked(key, request.id));
            let request = Request { command: Command::SetKey { key }, ..*request };
            return self.encoder.sealed_message(&request, Some((session_key, counter)));
        }
        self.encoder.sealed_message(request, Some((session_key, counter)))
    }

    /// Forgets the session that was open: the robot may have restarted since.
    pub(super) fn close(&mut self) {
        self.sealing.forget();
        self.sealing.refusals = 0;
        (self.hello, self.challenge) = (None, None);
    }

    /// Ends a session under the key, which the robot no longer knows.
    pub(super) fn close_if_open(&mut self) {
        if self.sealing.session.is_some() {
            self.close();
        }
    }

    /// Whether host and robot agree on version and key, as far as the robot's hello tells.
    pub(super) fn agrees(&self, ours: Hello, theirs: Hello) -> Result<()> {
        let port = || self.port.clone();
        match (&self.sealing.key, self.challenge) {
            _ if !ours.agrees_with(&theirs) => Err(Error::VersionsDiffer { ours, theirs }),
            (None, Some(_)) => Err(Error::KeyNeeded { port: port() }),
            (Some(_), None) if !self.sealing.any_robot => {
                Err(Error::RobotWithoutKey { port: port() })
            }
            (Some(_), Some(_)) if self.sealing.refusals >= REFUSALS_MAX => {
                Err(Error::WrongKey { port: port() })
            }
            _ => Ok(()),
        }
    }

    /// Whether the robot still has to be shown the key.
    pub(super) fn has_to_open(&self) -> bool {
        self.sealing.key.is_some() && self.challenge.is_some() && self.sealing.session.is_none()
    }

    /// Whether it is time to write the next greeting.
    pub(super) fn may_greet(&mut self) -> bool {
        if std::mem::take(&mut self.sealing.refused) {
            (self.hello, self.challenge) = (None, None);
            return true;
        }
        self.may_answer()
    }

    /// Whether there is a challenge that was not answered yet.
    fn may_answer(&self) -> bool {
        self.has_to_open()
            && self.sealing.opening.is_none_or(|opening| self.challenge != Some(opening.challenge))
    }

    /// The frame that answers the robot's challenge, where there is one to answer.
    pub(super) fn answer_to_challenge(&mut self, ours: Hello) -> Option<shared_proto::Frame> {
        if !self.has_to_open() {
            return None;
        }
        let (host, challenge) = (self.sealing.key.as_mut()?, self.challenge?);
        let opening = match self.sealing.opening {
            Some(opening) if opening.challenge == challenge => opening,
            _ => {
                let nonce = host.nonces.host_nonce(host.drawn);
                host.drawn += 1;
                let session_key = host.key.of_session(&ours.to_bytes(), &nonce, &challenge);
                Opening { challenge, nonce, session_key, counter: 0 }
            }
        };
        self.sealing.opening = Some(opening);
        let open = Open { session: self.number, nonce: opening.nonce };
        Some(self.encoder.open(open, &opening.session_key))
    }
}
