//! The seals of a session: what the host sends is sealed, and what the robot has not sealed is not believed.

use shared_proto::{Channel, Key, Nonce, Received, Refusal, Reply};

/// What a host knows of the key, and of the session under it.
#[derive(Default)]
pub(super) struct Sealing {
    pub(super) key: Option<HostKey>,
    /// Once the robot has been challenged, and has answered.
    pub(super) session: Option<Sealed>,
    /// The session that is being opened.
    pub(super) opening: Option<Opening>,
    pub(super) refusals: u32,
    /// The last answer was refused, and a new challenge is needed.
    pub(super) refused: bool,
    /// A robot without a key will do.
    pub(super) any_robot: bool,
}

pub(super) struct HostKey {
    pub(super) key: Key,
    /// From which the host's nonces come.
    pub(super) nonces: Key,
    pub(super) drawn: u64,
}

#[derive(Clone, Copy)]
pub(super) struct Opening {
    pub(super) challenge: Nonce,
    pub(super) nonce: Nonce,
    pub(super) session_key: Key,
    /// The last frame's.
    pub(super) counter: u64,
}

pub(super) struct Sealed {
    pub(super) session_key: Key,
    /// The host's last frame's.
    pub(super) counter: u64,
    pub(super) robot_key: Key,
    /// The robot's last frame's.
    pub(super) heard: u64,
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

    /// Forgets the session under the key.
    pub fn forget(&mut self) {
        (self.session, self.opening) = (None, None);
    }
}
