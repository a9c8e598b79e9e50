//! Frames taken apart, as all tests of the wire want them.

use shared_proto::*;

use crate::samples::Any;

/// The frames that a decoder finds: what they carry, or what is wrong with them.
pub fn decode(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Result<Any, FrameError>> {
    let mut found = Vec::new();
    for &byte in bytes {
        if let Some(result) = decoder.push(byte) {
            found.push(result.map(|received| Any::read(&received).expect("a message")));
        }
    }
    found
}

/// Channel and payload of one undamaged frame.
pub fn parts(frame: &[u8]) -> (Channel, Vec<u8>) {
    let mut decoder = Decoder::new();
    let (last, rest) = frame.split_last().expect("a frame");
    assert!(rest.iter().all(|&byte| decoder.push(byte).is_none()), "a frame that ends early");
    let received = decoder.push(*last).expect("the frame's end").expect("an undamaged frame");
    (received.channel, received.payload.to_vec())
}
