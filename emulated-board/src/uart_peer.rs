//! The host's end of the emulated USART.

use std::collections::VecDeque;

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::store;
use rigless::time::VirtualNanos;

/// Bytes in transit. The emulated USART models their time on the line.
#[derive(Debug, Default)]
pub(crate) struct UartPeer {
    to_robot: VecDeque<u8>,
    to_host: Vec<u8>,
}

impl UartPeer {
    /// Puts bytes on the line to the robot.
    pub fn send(&mut self, bytes: &[u8]) {
        self.to_robot.extend(bytes);
    }

    /// Bytes that wait to be sent to the robot.
    pub fn waiting(&self) -> usize {
        self.to_robot.len()
    }

    /// Takes the bytes that have arrived from the robot.
    pub fn take(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.to_host)
    }
}

store!(UartPeer { values: [to_robot, to_host], parts: [], built: [] });

impl Peer for UartPeer {
    fn receive(&mut self, word: u16, _: &mut Timeline<'_, '_>) {
        self.to_host.push(word as u8);
    }

    fn transmit(&mut self, _: VirtualNanos) -> Option<u16> {
        self.to_robot.pop_front().map(u16::from)
    }
}
