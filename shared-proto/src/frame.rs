//! Framing: COBS and CRC-32 around a channel, a sequence number and a payload.

use crate::channel::{Channel, Message, SEALED};
use crate::crc::Crc32;
use crate::hello::Hello;
use crate::key::{Key, Nonce, Open, Opened, Seal};
use crate::message::{Event, Reply};
use crate::received::Received;
use crate::telemetry::Telemetry;

const HEADER_LEN: usize = 3;
const CRC_LEN: usize = 4;

/// Longest payload of a frame in bytes.
pub const PAYLOAD_LEN_MAX: usize = 384;

/// Longest frame before COBS.
const RAW_LEN_MAX: usize = HEADER_LEN + PAYLOAD_LEN_MAX + CRC_LEN;

/// Longest frame on the wire in bytes, the final zero included.
pub const FRAME_LEN_MAX: usize = frame_len_max(PAYLOAD_LEN_MAX);

/// Longest frame on the wire that a payload of this length makes, the final zero included.
pub(crate) const fn frame_len_max(payload_len: usize) -> usize {
    cobs::max_encoding_length(HEADER_LEN + payload_len + CRC_LEN) + 1
}

/// Turns messages into frames and counts them.
#[derive(Clone, Debug, Default)]
pub struct Encoder {
    sequence: u16,
}

impl Encoder {
    /// An encoder whose first frame has sequence number 0.
    pub const fn new() -> Self {
        Self { sequence: 0 }
    }

    /// The frame of a message.
    ///
    /// A message that might be longer than [`PAYLOAD_LEN_MAX`] does not compile.
    pub fn message<M: Message>(&mut self, message: &M) -> Frame {
        self.sealed_message(message, None)
    }

    /// As [`message`](Self::message), sealed by a key with the counter of this frame.
    pub fn sealed_message<M: Message>(&mut self, message: &M, by: Option<(&Key, u64)>) -> Frame {
        const { assert!(M::LEN_MAX + Seal::LEN <= PAYLOAD_LEN_MAX) };
        let mut raw = Raw::BLANK;
        let payload = postcard::to_slice(message, raw.room()).expect("LEN_MAX is a bound");
        let len = payload.len();
        self.seal_frame(M::CHANNEL, raw, len, by)
    }

    /// [`sealed_message`](Self::sealed_message) for a robot, compiled here: for size, as this crate is on a board.
    #[inline(never)]
    pub fn reply(&mut self, reply: &Reply, by: Option<(&Key, u64)>) -> Frame {
        self.sealed_message(reply, by)
    }

    /// As [`reply`](Self::reply).
    #[inline(never)]
    pub fn event(&mut self, event: &Event, by: Option<(&Key, u64)>) -> Frame {
        self.sealed_message(event, by)
    }

    /// As [`reply`](Self::reply).
    #[inline(never)]
    pub fn telemetry(&mut self, telemetry: &Telemetry, by: Option<(&Key, u64)>) -> Frame {
        self.sealed_message(telemetry, by)
    }

    /// The frame of a hello.
    pub fn hello(&mut self, hello: Hello) -> Frame {
        self.parts(Channel::Hello, &[&hello.to_bytes()], None)
    }

    /// The frame of a hello of a robot with a key.
    pub fn challenge(&mut self, hello: Hello, challenge: Nonce) -> Frame {
        self.parts(Channel::Hello, &[&hello.to_bytes(), &challenge], None)
    }

    /// The frame of a host's answer to a challenge.
    pub fn open(&mut self, open: Open, session_key: &Key) -> Frame {
        let parts: &[&[u8]] = &[&open.session.to_le_bytes(), &open.nonce];
        self.parts(Channel::Open, parts, Some((session_key, 0)))
    }

    /// The frame of a robot's answer to [`Open`].
    pub fn opened(&mut self, opened: Opened, session_key: &Key) -> Frame {
        let parts: &[&[u8]] = &[&opened.session.to_le_bytes(), &opened.boot];
        self.parts(Channel::Opened, parts, Some((session_key, opened.counter)))
    }

    /// The frame of a payload in parts, which are short.
    #[inline(never)]
    fn parts(&mut self, channel: Channel, parts: &[&[u8]], by: Option<(&Key, u64)>) -> Frame {
        let mut raw = Raw::BLANK;
        let mut len = 0;
        for part in parts {
            raw.room()[len..len + part.len()].copy_from_slice(part);
            len += part.len();
        }
        self.seal_frame(channel, raw, len, by)
    }

    /// Adds the seal to a payload of this length, if there is a key.
    #[inline(never)]
    fn seal_frame(
        &mut self,
        channel: Channel,
        mut raw: Raw,
        payload_len: usize,
        by: Option<(&Key, u64)>,
    ) -> Frame {
        let Some((key, counter)) = by else { return self.frame(channel as u8, raw, payload_len) };
        let channel = channel as u8 | SEALED;
        let (payload, rest) = raw.room().split_at_mut(payload_len);
        rest[..Seal::LEN].copy_from_slice(&Seal::new(key, channel, payload, counter).to_bytes());
        self.frame(channel, raw, payload_len + Seal::LEN)
    }

    /// The frame of a message that came in another frame, counted anew: for whoever passes frames on.
    pub fn relay(&mut self, received: &Received<'_>) -> Frame {
        let mut raw = Raw::BLANK;
        let seal_len = if received.seal.is_some() { Seal::LEN } else { 0 };
        let len = received.payload.len().min(PAYLOAD_LEN_MAX - seal_len);
        raw.room()[..len].copy_from_slice(&received.payload[..len]);
        let Some(seal) = received.seal else { return self.frame(received.channel as u8, raw, len) };
        raw.room()[len..len + Seal::LEN].copy_from_slice(&seal.to_bytes());
        self.frame(received.channel as u8 | SEALED, raw, len + Seal::LEN)
    }

    /// Adds header and checksum to a payload of this length, and encodes the frame.
    #[inline(never)]
    fn frame(&mut self, channel: u8, Raw(mut raw): Raw, payload_len: usize) -> Frame {
        raw[0] = channel;
        raw[1..HEADER_LEN].copy_from_slice(&self.sequence.to_le_bytes());
        self.sequence = self.sequence.wrapping_add(1);
        let body_len = HEADER_LEN + payload_len;
        let crc = Crc32::new().over(&raw[..body_len]).value().to_le_bytes();
        raw[body_len..body_len + CRC_LEN].copy_from_slice(&crc);
        let mut frame = Frame { bytes: [0; FRAME_LEN_MAX], len: 0 };
        let encoded = cobs::encode(&raw[..body_len + CRC_LEN], &mut frame.bytes);
        // The end of the frame. `cobs` may have written there: after a whole block it begins a next one.
        frame.bytes[encoded] = 0;
        frame.len = encoded + 1;
        frame
    }
}

/// A frame before COBS.
struct Raw([u8; RAW_LEN_MAX]);

impl Raw {
    const BLANK: Self = Self([0; RAW_LEN_MAX]);

    /// Where the payload goes.
    fn room(&mut self) -> &mut [u8] {
        &mut self.0[HEADER_LEN..RAW_LEN_MAX - CRC_LEN]
    }
}

/// One frame, ready for the wire: COBS data and the zero that ends it.
#[derive(Clone)]
pub struct Frame {
    bytes: [u8; FRAME_LEN_MAX],
    len: usize,
}

impl core::ops::Deref for Frame {
    type Target = [u8];
    fn deref(&self) -> &[u8] {
        &self.bytes[..self.len]
    }
}

impl core::fmt::Debug for Frame {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Frame({:02x?})", &**self)
    }
}

/// What is wrong with a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrameError {
    /// More bytes than any frame has; skipped up to the next zero.
    TooLong,
    /// Not COBS, or too short to be a frame.
    Malformed,
    /// The checksum differs.
    Checksum,
    /// The channel is not one of ours.
    Channel,
}

/// Finds frames in a stream of bytes.
#[derive(Clone, Debug)]
pub struct Decoder {
    buffer: [u8; FRAME_LEN_MAX],
    len: usize,
    overlong: bool,
    last_sequence: Option<u16>,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// A decoder that has seen nothing yet.
    pub const fn new() -> Self {
        Self { buffer: [0; FRAME_LEN_MAX], len: 0, overlong: false, last_sequence: None }
    }

    /// Takes the next byte; returns a frame or an error when the byte ends a frame.
    ///
    /// A zero that follows another zero is no frame and no error.
    pub fn push(&mut self, byte: u8) -> Option<Result<Received<'_>, FrameError>> {
        if byte != 0 {
            match self.buffer.get_mut(self.len) {
                Some(slot) => {
                    *slot = byte;
                    self.len += 1;
                }
                None => self.overlong = true,
            }
            return None;
        }
        let len = core::mem::take(&mut self.len);
        if core::mem::take(&mut self.overlong) {
            return Some(Err(FrameError::TooLong));
        }
        if len == 0 {
            return None;
        }
        Some(self.finish(len))
    }

    fn finish(&mut self, len: usize) -> Result<Received<'_>, FrameError> {
        let raw_len =
            cobs::decode_in_place(&mut self.buffer[..len]).map_err(|_| FrameError::Malformed)?;
        if raw_len < HEADER_LEN + CRC_LEN {
            return Err(FrameError::Malformed);
        }
        // COBS leaves room for a few bytes more, but no payload may exceed PAYLOAD_LEN_MAX.
        if raw_len > RAW_LEN_MAX {
            return Err(FrameError::TooLong);
        }
        let (body, crc) = self.buffer[..raw_len].split_at(raw_len - CRC_LEN);
        if Crc32::new().over(body).value().to_le_bytes() != crc {
            return Err(FrameError::Checksum);
        }
        let channel = Channel::from_number(body[0] & !SEALED).ok_or(FrameError::Channel)?;
        let sequence = u16::from_le_bytes([body[1], body[2]]);
        // A hello starts a new count.
        let lost = match self.last_sequence {
            Some(last) if channel != Channel::Hello => {
                let gap = sequence.wrapping_sub(last).wrapping_sub(1);
                // A frame that came twice or late looks like a gap of nearly 2^16.
                if gap < 0x8000 { gap } else { 0 }
            }
            _ => 0,
        };
        self.last_sequence = Some(sequence);
        let payload = &body[HEADER_LEN..];
        let (payload, seal) = match body[0] & SEALED {
            0 => (payload, None),
            _ => payload
                .split_last_chunk()
                .ok_or(FrameError::Malformed)
                .map(|(payload, seal)| (payload, Some(Seal::from_bytes(seal))))?,
        };
        Ok(Received { channel, lost, payload, seal })
    }
}
