//! The key in a session: the robot's challenge is answered, and requests are sealed.

use shared_proto::{Command, Hello, Key, Open, Request};

use super::Session;
use super::sealing::{HostKey, Opening, Sealing};
use crate::error::{Error, Result};

/// After so many refused answers to challenges the key is the wrong one. One may be refused because another host
/// was quicker.
const REFUSALS_MAX: u32 = 5;

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
                Error::Restarted { .. }
                | Error::Forgotten { .. }
                | Error::StoppedAnswering { .. }
                | Error::KeyNeeded { .. },
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
