//! A received frame, sealed or in the clear.

use crate::channel::{Channel, Message, SEALED};
use crate::hello::Hello;
use crate::key::{Key, Nonce, Open, Opened, Seal};
use crate::message::Request;

/// A good frame as received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received<'a> {
    /// The kind of message.
    pub channel: Channel,
    /// Frames that the sequence numbers show to be missing before this one.
    pub lost: u16,
    /// The message's bytes, at most [`PAYLOAD_LEN_MAX`](crate::PAYLOAD_LEN_MAX), without the seal.
    pub payload: &'a [u8],
    /// The seal of a sealed frame: [`is_sealed_by`](Self::is_sealed_by) tells whether it is genuine.
    pub seal: Option<Seal>,
}

impl Received<'_> {
    /// The message, if it has type `M` and no bytes are left over.
    pub fn message<M: Message>(&self) -> Option<M> {
        if self.channel != M::CHANNEL {
            return None;
        }
        match postcard::take_from_bytes(self.payload) {
            Ok((message, [])) => Some(message),
            _ => None,
        }
    }

    /// [`message`](Self::message) for a robot, compiled here: for size, as this crate is on a board.
    #[inline(never)]
    pub fn request(&self) -> Option<Request> {
        self.message()
    }

    /// Whether the frame is sealed, and by this key.
    pub fn is_sealed_by(&self, key: &Key) -> bool {
        self.seal.is_some_and(|seal| {
            Seal::new(key, self.channel as u8 | SEALED, self.payload, seal.counter).is(&seal)
        })
    }

    /// The session of a request, a reply, or what opens a session, from its first bytes.
    pub fn session(&self) -> Option<u32> {
        match self.channel {
            Channel::Hello => self.hello().map(|hello| hello.session),
            Channel::Open => self.open().map(|open| open.session),
            Channel::Opened => self.opened().map(|opened| opened.session),
            Channel::Request | Channel::Reply => {
                postcard::take_from_bytes(self.payload).ok().map(|(session, _)| session)
            }
            Channel::Telemetry | Channel::Event => None,
        }
    }

    /// The challenge in a hello of a robot with a key.
    pub fn challenge(&self) -> Option<Nonce> {
        self.hello()?;
        self.payload.get(Hello::LEN..)?.first_chunk().copied()
    }

    /// A host's answer to a challenge, if the frame carries one.
    pub fn open(&self) -> Option<Open> {
        let (session, nonce) = self.session_and_nonce(Channel::Open)?;
        Some(Open { session, nonce })
    }

    /// A robot's answer to [`Open`], if the frame carries one.
    pub fn opened(&self) -> Option<Opened> {
        let (session, boot) = self.session_and_nonce(Channel::Opened)?;
        Some(Opened { session, boot, counter: self.seal?.counter })
    }

    fn session_and_nonce(&self, channel: Channel) -> Option<(u32, Nonce)> {
        let (session, nonce) = self.payload.split_first_chunk()?;
        let nonce = nonce.try_into().ok()?;
        (self.channel == channel).then(|| (u32::from_le_bytes(*session), nonce))
    }

    /// The hello, if the frame carries one.
    pub fn hello(&self) -> Option<Hello> {
        if self.channel == Channel::Hello { Hello::from_bytes(self.payload) } else { None }
    }
}
