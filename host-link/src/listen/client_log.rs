//! What is said of clients, in lines that a crowd cannot make endless.

use std::fmt;
use std::time::{Duration, Instant};

use super::client::ClientEvent;

/// So many lines in a second: whoever reads them is no slower, and a log stays a log.
const LINES_MAX: u32 = 10;
const SECOND: Duration = Duration::from_secs(1);

impl fmt::Display for ClientEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Connected => "a client connected",
            Self::Disconnected => "a client disconnected",
            Self::Stranger => "a program that does not speak Beeline's protocol was cut off",
            Self::NotReading => "a client that did not read was cut off",
            Self::NoKey => "a client that does not hold the key was cut off",
        })
    }
}

/// The lines about clients of one server.
#[derive(Debug)]
pub struct ClientLog {
    since: Instant,
    said: u32,
    unsaid: u32,
}

impl Default for ClientLog {
    fn default() -> Self {
        Self { since: Instant::now(), said: 0, unsaid: 0 }
    }
}

impl ClientLog {
    /// The line about this event, now. In a crowd there is none, and a later line says how many there were.
    pub fn line(&mut self, event: ClientEvent) -> Option<String> {
        self.line_at(event, Instant::now())
    }

    fn line_at(&mut self, event: ClientEvent, now: Instant) -> Option<String> {
        if now.saturating_duration_since(self.since) >= SECOND {
            (self.since, self.said) = (now, 0);
        }
        if self.said == LINES_MAX {
            self.unsaid += 1;
            return None;
        }
        self.said += 1;
        Some(match std::mem::take(&mut self.unsaid) {
            0 => event.to_string(),
            unsaid => format!("{event}; {unsaid} more came and went before"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crowd_gives_ten_lines_a_second_and_a_count() {
        let mut log = ClientLog::default();
        let begin = log.since;
        let lines = (0..5000).filter_map(|k| {
            log.line_at(ClientEvent::Stranger, begin + Duration::from_micros(100 * k))
        });
        assert_eq!(lines.count(), 10);
        let next = log.line_at(ClientEvent::Connected, begin + SECOND);
        assert_eq!(next.as_deref(), Some("a client connected; 4990 more came and went before"));
        let next = log.line_at(ClientEvent::Disconnected, begin + SECOND);
        assert_eq!(next.as_deref(), Some("a client disconnected"));
    }
}
