//! The testbed of a simulated robot: in this thread, or in the one that serves the robot.

use sim_link::RemoteTestbed;
use sim_target::Testbed;

use crate::error::{Error, Result};

/// The testbed of a simulated robot.
#[derive(Clone)]
pub enum Bench {
    /// Of this command's own robot, in virtual time.
    Here(Testbed),
    /// Of a robot that another thread of this program serves, in real time.
    Served(RemoteTestbed),
}

impl From<Testbed> for Bench {
    fn from(testbed: Testbed) -> Self {
        Self::Here(testbed)
    }
}

impl Bench {
    /// Measures, or handles the robot.
    pub fn with<T: Send + 'static>(
        &self,
        act: impl FnOnce(&Testbed) -> T + Send + 'static,
    ) -> Result<T> {
        match self {
            Self::Here(testbed) => Ok(act(testbed)),
            Self::Served(testbed) => {
                testbed.ask(act).map_err(|_| Error::new("the simulated robot has ended"))
            }
        }
    }

    /// Whether the robot belongs to this command alone: it is new, with its clock at zero.
    pub fn is_own(&self) -> bool {
        matches!(self, Self::Here(_))
    }
}
