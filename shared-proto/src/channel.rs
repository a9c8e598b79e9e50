//! The kinds of message, and their numbers on the wire.

use postcard_schema::Schema;
use serde::{Serialize, de::DeserializeOwned};

use crate::encoded_len::postcard_len_max;
use crate::message::{Event, Reply, Request};
use crate::telemetry::Telemetry;

/// In the channel's byte: the payload ends with a [`Seal`](crate::Seal).
pub(crate) const SEALED: u8 = 0x80;

/// What kind of message a frame carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Channel {
    /// [`Hello`](crate::Hello).
    Hello = 0,
    /// [`Request`].
    Request = 1,
    /// [`Reply`].
    Reply = 2,
    /// [`Telemetry`].
    Telemetry = 3,
    /// [`Event`].
    Event = 4,
    /// [`Open`](crate::Open).
    Open = 5,
    /// [`Opened`](crate::Opened).
    Opened = 6,
}

impl Channel {
    /// The channel of a number, if there is one.
    pub const fn from_number(number: u8) -> Option<Self> {
        Some(match number {
            0 => Channel::Hello,
            1 => Channel::Request,
            2 => Channel::Reply,
            3 => Channel::Telemetry,
            4 => Channel::Event,
            5 => Channel::Open,
            6 => Channel::Opened,
            _ => return None,
        })
    }
}

/// A message that travels as postcard on a channel of its own.
pub trait Message: Serialize + DeserializeOwned + Schema {
    /// Its channel.
    const CHANNEL: Channel;
    /// Longest payload \[bytes\].
    const LEN_MAX: usize = postcard_len_max(Self::SCHEMA);
}

impl Message for Request {
    const CHANNEL: Channel = Channel::Request;
}
impl Message for Reply {
    const CHANNEL: Channel = Channel::Reply;
}
impl Message for Telemetry {
    const CHANNEL: Channel = Channel::Telemetry;
}
impl Message for Event {
    const CHANNEL: Channel = Channel::Event;
}
