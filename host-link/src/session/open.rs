//! Shaking hands.

use shared_proto::Hello;

use super::{GIVE_UP_AFTER, RETRY_AFTER, Session};
use crate::error::{Error, Result};
use crate::robot_clock::RobotClock;
use crate::statistics::HostStatistics;

impl Session {
    /// Shakes hands: both ends must speak the same version with the same message layouts, and have the same key.
    pub async fn open(&mut self) -> Result<()> {
        let ours = Hello::of_this_build(self.number);
        // The robot may have restarted since.
        self.robot_clock = RobotClock::default();
        self.close();
        let give_up = self.clock.now_us() + GIVE_UP_AFTER.as_micros() as u64;
        while self.clock.now_us() < give_up {
            self.write_greeting(ours).await?;
            let until = self.clock.now_us() + RETRY_AFTER.as_micros() as u64;
            loop {
                match self.receive_until(until).await {
                    Ok(true) => {}
                    Ok(false) => {
                        self.statistics.retries += 1;
                        break;
                    }
                    // To a request of before.
                    Err(Error::Restarted { .. } | Error::Forgotten { .. }) => continue,
                    Err(error) => return Err(error),
                }
                if let Some(theirs) = self.hello {
                    self.agrees(ours, theirs)?;
                    if !self.has_to_open() {
                        return Ok(());
                    }
                }
                if self.may_greet() {
                    break;
                }
            }
        }
        let port = self.port.clone();
        match self.statistics {
            HostStatistics { frames_damaged: 0, frames_received: 0, .. } => {
                Err(Error::NoAnswer { port })
            }
            HostStatistics { frames_damaged: damaged, .. } => {
                Err(Error::NotARobot { port, damaged })
            }
        }
    }

    /// Sends the answer to the robot's challenge, or else a hello.
    ///
    /// A zero first ends whatever noise the robot has received so far, so that it is not part of our frame.
    pub(super) async fn write_greeting(&mut self, ours: Hello) -> Result<()> {
        let frame = match self.answer_to_challenge(ours) {
            Some(frame) => frame,
            None => self.encoder.hello(ours),
        };
        self.write(&[&[0], &*frame].concat()).await
    }
}
