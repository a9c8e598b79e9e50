//! How long each kind of message can get.

use crate::channel::{Channel, Message};
use crate::frame::{FRAME_LEN_MAX, PAYLOAD_LEN_MAX, frame_len_max};
use crate::hello::Hello;
use crate::key::{Nonce, Open, Opened, Seal};
use crate::message::{Event, Reply, Request};
use crate::telemetry::Telemetry;

/// How long one kind of message can get.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LengthBound {
    /// The kind.
    pub channel: Channel,
    /// Longest payload \[bytes\].
    pub payload_len: usize,
    /// Longest frame on the wire, the final zero included \[bytes\].
    pub frame_len: usize,
}

impl LengthBound {
    /// Every kind of message, in the order of the channels' numbers.
    pub const ALL: [LengthBound; 7] = [
        LengthBound::new(Channel::Hello, Hello::LEN + size_of::<Nonce>()),
        LengthBound::new(Channel::Request, Request::LEN_MAX),
        LengthBound::new(Channel::Reply, Reply::LEN_MAX),
        LengthBound::new(Channel::Telemetry, Telemetry::LEN_MAX),
        LengthBound::new(Channel::Event, Event::LEN_MAX),
        LengthBound::new(Channel::Open, Open::LEN + Seal::LEN),
        LengthBound::new(Channel::Opened, Opened::LEN + Seal::LEN),
    ];

    const fn new(channel: Channel, payload_len: usize) -> Self {
        Self { channel, payload_len, frame_len: frame_len_max(payload_len) }
    }
}

// Every message fits into a frame.
const _: () = {
    let mut i = 0;
    while i < LengthBound::ALL.len() {
        assert!(LengthBound::ALL[i].channel as usize == i);
        assert!(LengthBound::ALL[i].payload_len <= PAYLOAD_LEN_MAX);
        assert!(LengthBound::ALL[i].frame_len <= FRAME_LEN_MAX);
        i += 1;
    }
};
