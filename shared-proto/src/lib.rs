//! The protocol between a robot and its host: messages, framing and configuration.
//!
//! # A frame
//!
//! ```text
//! channel u8 | sequence u16 LE | payload ... | seal ... | CRC-32 u32 LE      COBS-encoded, then 0x00
//! ```
//!
//! The CRC (ISO-HDLC, as in Ethernet and zlib) covers all that precedes it, the seal too. A zero byte
//! never occurs inside a frame, so after any damage the receiver synchronises at the next zero.
//! Each direction counts its frames in `sequence`; a gap tells the receiver what was lost. Only between holders of a
//! pre-shared key a frame has a seal ([`Seal`]), which 0x80 in its channel announces: [`Key`] shows how.
//!
//! # The messages
//!
//! | channel | direction | payload | |
//! | --- | --- | --- | --- |
//! | 0 `Hello` | both ways | [`Hello`], a layout that never changes | first of all, answered by the robot's own |
//! | 1 `Request` | to the robot | [`Request`], postcard | answered each time it arrives, unless the line is full: then the host asks again |
//! | 2 `Reply` | to the host | [`Reply`], postcard | carries the request's id |
//! | 3 `Telemetry` | to the host | [`Telemetry`], postcard | as subscribed; the first to be dropped on a busy line |
//! | 4 `Event` | to the host | [`Event`], postcard | may be lost; [`Status`] tells the same on request |
//! | 5 `Open` | to the robot | [`Open`] | a host shows that it holds the key |
//! | 6 `Opened` | to the host | [`Opened`] | so does the robot |
//!
//! # Longest frames
//!
//! In bytes on the wire, the final zero included. A board can size its buffers by these.
//!
//! | channel | payload at most | frame at most |
//! | --- | --- | --- |
//! | 0 `Hello` | 34 | 43 |
//! | 1 `Request` | 342 | 352 |
//! | 2 `Reply` | 343 | 353 |
//! | 3 `Telemetry` | 184 | 193 |
//! | 4 `Event` | 50 | 59 |
//! | 5 `Open` | 36 | 45 |
//! | 6 `Opened` | 36 | 45 |
//!
//! A seal makes a payload, and a frame, 16 bytes longer; here `Open` and `Opened` have theirs.
//!
//! A receiver takes payloads of up to [`PAYLOAD_LEN_MAX`] bytes, which leaves room for later messages.
//!
//! # Compatibility
//!
//! Two ends talk if protocol version and schema hash in their hellos are equal; otherwise each
//! names both versions and refuses. Any change to a message changes the schema hash by itself; a
//! change in meaning alone raises [`PROTOCOL_VERSION`].
//!
//! # Retries
//!
//! Every command is idempotent. A motion carries its [`MotionId`], the clearing of a fault the
//! fault's number, and everything else sets a state rather than changes one. A host that hears no
//! reply sends the same request again.
//!
//! # Leases
//!
//! What changes something carries the end of its lease on the robot's clock, [`Request::until_ms`], and is
//! refused after it: whatever held a frame up on its way, what arrives late moves nothing. Every reply tells
//! the robot's clock.
//!
//! `docs/protocol.md` describes the protocol for hosts in other languages.
#![cfg_attr(not(test), no_std)]

mod channel;
mod config;
mod config_bytes;
mod config_check;
mod crc;
mod driver;
mod encoded_len;
mod fault;
mod float_order;
mod frame;
mod hello;
mod key;
mod message;
mod message_bounds;
mod motion;
mod name;
mod pair;
mod readable;
mod received;
mod sessions;
mod state;
mod telemetry;
mod voltage;

pub use channel::{Channel, Message};
pub use config::*;
pub use config_check::ConfigError;
pub use crc::Crc32;
pub use driver::*;
pub use fault::*;
pub use float_order::is_above;
pub use frame::*;
pub use hello::*;
pub use key::*;
pub use message::*;
pub use message_bounds::LengthBound;
pub use motion::*;
pub use name::*;
pub use pair::*;
pub use readable::Readable;
pub use received::*;
pub use sessions::*;
pub use state::State;
pub use telemetry::*;
pub use voltage::*;
