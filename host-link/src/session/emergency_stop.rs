//! The emergency stop: it needs no open session, and gets through on a busy line.

use shared_proto::{Command, Hello};

use super::{GIVE_UP_AFTER, RETRY_AFTER, Session};
use crate::error::{Error, Result};

impl Session {
    /// Cuts the motors, for a session that need not be open.
    ///
    /// Hello and command are sent together, again and again until an answer comes: on a line that others keep busy, the
    /// robot acts before an answer finds room. A robot with a key acts as soon as its challenge is answered: answer and
    /// command are sent together as well.
    pub async fn emergency_stop(&mut self) -> Result<()> {
        let ours = Hello::of_this_build(self.number);
        let give_up = self.clock.now_us() + GIVE_UP_AFTER.as_micros() as u64;
        while self.clock.now_us() < give_up {
            self.write_greeting(ours).await?;
            let id = self.post_until(Command::EmergencyStop, 0).await?;
            let until = self.clock.now_us() + RETRY_AFTER.as_micros() as u64;
            loop {
                match self.receive_until(until).await {
                    Ok(true) => {}
                    Ok(false) => break,
                    // To a request of before the hello, or the session is over.
                    Err(Error::Restarted { .. } | Error::Forgotten { .. }) => {
                        self.close_if_open();
                        continue;
                    }
                    Err(error) => return Err(error),
                }
                if self.take_reply(id).is_some_and(|reply| reply.outcome.is_ok()) {
                    return Ok(());
                }
                if let Some(theirs) = self.hello {
                    self.agrees(ours, theirs)?;
                }
                if self.may_greet() {
                    break;
                }
            }
        }
        Err(Error::NoAnswer { port: self.port.clone() })
    }
}
