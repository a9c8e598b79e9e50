//! The robot's end of a session: which hosts it listens to.
//!
//! Without a key, those whose hello agreed. With one, those that have answered a challenge under it. There is one
//! challenge at a time, for everybody, and an answer uses it up: an answer that was recorded opens nothing, and
//! strangers, however many say hello, take no memory.

use crate::hello::Hello;
use crate::key::{Key, Nonce, Open, Opened};
use crate::received::Received;

/// An answer to a host that begins a session.
pub enum Greeting {
    /// The robot's hello; with a key, its challenge.
    Hello(Hello, Option<Nonce>),
    /// The host holds the key, and its session has this one.
    Opened {
        /// Session and start of the robot. The transmitter adds the counter.
        opened: Opened,
        /// The session's key.
        session_key: Key,
    },
}

/// Whom the robot obeys.
#[derive(Clone, Copy)]
pub enum Access {
    /// Nobody: the store has not been read yet, or cannot be trusted.
    Nobody,
    /// Whoever reaches the line: there is no key.
    Everybody,
    /// Those who hold the key.
    Holders {
        /// The pre-shared key.
        key: Key,
        /// Differs for each start of the robot, and each change of the key.
        boot: Nonce,
    },
}

impl Access {
    /// Since when: no two ways of access have the same.
    pub fn boot(&self) -> Option<Nonce> {
        match self {
            Access::Nobody => None,
            Access::Everybody => Some([0; 16]),
            Access::Holders { boot, .. } => Some(*boot),
        }
    }
}

/// Why a frame is not obeyed, and whom to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// The sender does not show that it holds the key.
    Stranger(u32),
    /// The sender does not answer the challenge as a holder of the key does.
    WrongKey(u32),
    /// It is sealed, but there is no such session.
    Gone(u32),
    /// It came before, or is older than one that came before. Nobody is told.
    Again,
    /// There is no such session.
    HelloFirst(u32),
    /// It could not be read.
    Unreadable,
}

/// So many hosts may talk at once, behind one line: a driver, pages that watch, and commands that come and go.
const SESSIONS: usize = 8;

/// The hosts with which the robot has agreed on the protocol.
pub struct Sessions {
    known: [Option<Session>; SESSIONS],
    /// Counts what was received.
    now: u32,
    /// For which access, see [`Access::boot`].
    boot: Option<Nonce>,
    /// So many challenges have been answered.
    answered: u64,
}

#[derive(Clone, Copy)]
struct Session {
    number: u32,
    /// The id of the latest request that changed something.
    latest: u32,
    /// Of all that was received, the last that was its own.
    heard: u32,
    /// With a key.
    sealed: Option<Sealed>,
}

#[derive(Clone, Copy)]
struct Sealed {
    key: Key,
    /// The counter of the last frame.
    counter: u64,
}

/// Who has sent a request.
pub enum Sender {
    /// There is no key.
    Anybody,
    /// A host that holds the key, in a session with this one.
    Holder(Key),
}

impl Default for Sessions {
    fn default() -> Self {
        Self::new()
    }
}

impl Sessions {
    /// Nobody is known.
    pub const fn new() -> Self {
        Self { known: [None; SESSIONS], now: 0, boot: None, answered: 0 }
    }

    /// Whether the robot understands this session's requests.
    pub fn knows(&self, number: u32) -> bool {
        self.known.iter().flatten().any(|session| session.number == number)
    }

    /// Whether a request that changes something comes in its turn: a line may hold back a copy of an earlier one, whose host
    /// has gone on meanwhile. A host numbers its requests, and repeats one under its number.
    pub fn accept_in_order(&mut self, number: u32, id: u32) -> bool {
        let mut known = self.known.iter_mut().flatten();
        let Some(session) = known.find(|session| session.number == number) else { return true };
        let in_order = id >= session.latest;
        session.latest = session.latest.max(id);
        in_order
    }

    /// Forgets all sessions if another key is in use than before.
    fn follow(&mut self, access: &Access) {
        if access.boot() != self.boot {
            *self = Self { boot: access.boot(), ..Self::new() };
        }
    }

    /// Notes whether this host speaks our version, and answers with ours.
    ///
    /// `driver` is the session that drives the robot.
    #[inline(never)]
    pub fn greet(&mut self, access: Access, host: Hello, driver: Option<u32>) -> Option<Greeting> {
        self.follow(&access);
        let robot = Hello::of_this_build(host.session);
        match access {
            Access::Nobody => None,
            Access::Everybody => {
                if !host.agrees_with(&robot) {
                    self.forget(host.session);
                } else if !self.knows(host.session) {
                    self.insert(host.session, None, driver);
                }
                Some(Greeting::Hello(robot, None))
            }
            Access::Holders { key, boot } => {
                Some(Greeting::Hello(robot, Some(key.challenge(&boot, self.answered))))
            }
        }
    }

    /// Begins a session under the key, if this answers the challenge.
    #[inline(never)]
    pub fn open(
        &mut self,
        access: Access,
        open: Open,
        frame: &Received<'_>,
        driver: Option<u32>,
    ) -> Result<Greeting, Refused> {
        self.follow(&access);
        let number = open.session;
        let Access::Holders { key, boot } = access else { return Err(Refused::WrongKey(number)) };
        // The host has not heard that its session is open.
        let again = self.find(number).and_then(|session| session.sealed).map(|sealed| sealed.key);
        let session_key = match again.filter(|key| frame.is_sealed_by(key)) {
            Some(session_key) => session_key,
            None => {
                let challenge = key.challenge(&boot, self.answered);
                let hello = Hello::of_this_build(number);
                let session_key = key.of_session(&hello.to_bytes(), &open.nonce, &challenge);
                if !frame.is_sealed_by(&session_key) {
                    return Err(Refused::WrongKey(number));
                }
                self.answered = self.answered.wrapping_add(1);
                self.forget(number);
                let sealed = Some(Sealed { key: session_key, counter: 0 });
                self.insert(number, sealed, driver);
                session_key
            }
        };
        let opened = Opened { session: number, boot, counter: 0 };
        Ok(Greeting::Opened { opened, session_key })
    }

    /// Whether a request may be read: with a key, if it is sealed, and newer than all of its session before.
    #[inline(never)]
    pub fn check(&mut self, access: Access, frame: &Received<'_>) -> Result<Sender, Refused> {
        self.follow(&access);
        let number = frame.session().ok_or(Refused::Unreadable)?;
        self.now = self.now.wrapping_add(1);
        if !matches!(access, Access::Holders { .. }) {
            return match self.known.iter().all(Option::is_none) {
                // A request of another protocol version is not decoded.
                true => Err(Refused::HelloFirst(0)),
                // From before the key was cleared.
                false if frame.seal.is_some() => Err(Refused::HelloFirst(number)),
                false => {
                    self.hear(number);
                    Ok(Sender::Anybody)
                }
            };
        }
        let Some(seal) = frame.seal else { return Err(Refused::Stranger(number)) };
        let session = self.known.iter_mut().flatten().find(|session| session.number == number);
        let Some(Session { sealed: Some(sealed), .. }) = session else {
            return Err(Refused::Gone(number));
        };
        if !frame.is_sealed_by(&sealed.key) {
            return Err(Refused::Stranger(number));
        }
        if seal.counter <= sealed.counter {
            return Err(Refused::Again);
        }
        sealed.counter = seal.counter;
        let key = sealed.key;
        self.hear(number);
        Ok(Sender::Holder(key))
    }

    fn find(&self, number: u32) -> Option<&Session> {
        self.known.iter().flatten().find(|session| session.number == number)
    }

    fn forget(&mut self, number: u32) {
        for known in &mut self.known {
            known.take_if(|session| session.number == number);
        }
    }

    /// Notes that a session is in use.
    fn hear(&mut self, number: u32) {
        let mut known = self.known.iter_mut().flatten();
        if let Some(session) = known.find(|session| session.number == number) {
            session.heard = self.now;
        }
    }

    /// Begins a session, in the place of the one that was silent for longest. Nobody can push the driver out by coming often.
    fn insert(&mut self, number: u32, sealed: Option<Sealed>, driver: Option<u32>) {
        let now = self.now.wrapping_add(1);
        let silence = |known: &&mut Option<Session>| match known {
            None => u64::MAX,
            Some(session) if Some(session.number) == driver => 0,
            Some(session) => u64::from(now.wrapping_sub(session.heard)),
        };
        if let Some(place) = self.known.iter_mut().max_by_key(silence) {
            *place = Some(Session { number, latest: 0, heard: now, sealed });
        }
        self.now = now;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn greet(sessions: &mut Sessions, number: u32, driver: Option<u32>) {
        sessions.greet(Access::Everybody, Hello::of_this_build(number), driver);
    }

    #[test]
    fn a_further_host_replaces_the_one_that_was_silent_for_longest_and_never_the_driver() {
        let mut sessions = Sessions::new();
        for number in 1..=SESSIONS as u32 {
            greet(&mut sessions, number, None);
        }
        assert!((1..=SESSIONS as u32).all(|number| sessions.knows(number)));
        sessions.hear(2);
        greet(&mut sessions, 100, Some(1));
        assert!(!sessions.knows(3) && [1, 2, 4, 100].iter().all(|known| sessions.knows(*known)));
        // However many come, the driver stays, and so does whoever speaks now and then.
        for number in 1000..1000 + 4 * SESSIONS as u32 {
            sessions.now = sessions.now.wrapping_add(1);
            sessions.hear(2);
            greet(&mut sessions, number, Some(1));
        }
        assert!(sessions.knows(1) && sessions.knows(2) && !sessions.knows(100));
    }

    #[test]
    fn the_count_may_begin_anew() {
        let mut sessions = Sessions { now: u32::MAX - 4, ..Sessions::new() };
        for number in 1..=2 * SESSIONS as u32 {
            greet(&mut sessions, number, None);
        }
        assert!((SESSIONS as u32 + 1..=2 * SESSIONS as u32).all(|number| sessions.knows(number)));
    }
}
