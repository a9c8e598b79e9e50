//! What a robot says, frame by frame, for a server that passes it on.

use shared_proto::{Channel, Decoder, FRAME_LEN_MAX, Received};

/// The robot's bytes, cut into frames.
#[derive(Default)]
pub(super) struct FromRobot {
    decoder: Decoder,
    /// The bytes of the frame that is under way.
    bytes: Vec<u8>,
    has_key: bool,
}

impl FromRobot {
    /// Whether the robot said in its last hello that it has a key.
    pub fn has_key(&self) -> bool {
        self.has_key
    }

    /// Takes bytes; calls `pass_on` with those of each frame, and what it is, unless it is damaged.
    pub fn push(&mut self, bytes: &[u8], pass_on: &mut dyn FnMut(&[u8], Option<&Received<'_>>)) {
        for &byte in bytes {
            self.bytes.push(byte);
            match self.decoder.push(byte) {
                Some(Ok(frame)) => {
                    if frame.channel == Channel::Hello {
                        self.has_key = frame.challenge().is_some();
                    }
                    pass_on(&self.bytes, Some(&frame));
                }
                // Noise, or a lone zero.
                Some(Err(_)) => pass_on(&self.bytes, None),
                None if byte == 0 || self.bytes.len() > FRAME_LEN_MAX => pass_on(&self.bytes, None),
                None => continue,
            }
            self.bytes.clear();
        }
    }
}
