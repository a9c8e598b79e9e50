//! What the robot sends unasked: telemetry, one's own or another host's, and events.

use shared_proto::{Event, Telemetry};

use super::{Listening, Session};

impl Session {
    /// Takes the telemetry that another host has requested.
    pub fn overhear(&mut self) {
        if self.listening != Listening::Overhearing {
            self.telemetry.restart();
            self.listening = Listening::Overhearing;
        }
    }

    /// Whether it takes another host's telemetry.
    pub fn overhears(&self) -> bool {
        self.listening == Listening::Overhearing
    }

    /// Telemetry that was received and not taken yet, oldest first, each frame once.
    ///
    /// Frames after a lost one are held back until that one has been received.
    pub fn take_telemetry(&mut self) -> impl Iterator<Item = Telemetry> + '_ {
        self.telemetry.drain()
    }

    /// As [`take_telemetry`](Self::take_telemetry), but does not hold frames back for lost ones.
    pub fn take_all_telemetry(&mut self) -> impl Iterator<Item = Telemetry> + '_ {
        self.telemetry.give_up();
        self.telemetry.drain()
    }

    /// Events that were received and not taken yet, oldest first.
    pub fn take_events(&mut self) -> impl Iterator<Item = Event> + '_ {
        self.events.drain(..)
    }
}
