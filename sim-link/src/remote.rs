//! The testbed of a robot that another thread serves.

use std::fmt;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel, sync_channel};
use std::time::Duration;

use sim_target::Testbed;

/// What is asked of a testbed.
type Request = Box<dyn FnOnce(&Testbed) + Send>;

/// A server answers every millisecond; one that is this late has ended.
const PATIENCE: Duration = Duration::from_secs(5);

/// A testbed in another thread. What is asked is done there, between two steps of the simulation.
#[derive(Clone)]
pub struct RemoteTestbed(Arc<Sender<Request>>);

/// The thread with the robot has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RobotEnded;

impl RemoteTestbed {
    /// A testbed, and what [serves](crate::ServeOptions::requests) it.
    pub fn new() -> (Self, TestbedRequests) {
        let (sender, receiver) = channel();
        (Self(Arc::new(sender)), TestbedRequests(receiver))
    }

    /// Asks the testbed, and waits for what it answers.
    pub fn ask<T: Send + 'static>(
        &self,
        question: impl FnOnce(&Testbed) -> T + Send + 'static,
    ) -> Result<T, RobotEnded> {
        let (sender, answer) = sync_channel(1);
        let request = move |testbed: &Testbed| {
            // Nobody waits any more, if that is an error.
            let _ = sender.send(question(testbed));
        };
        self.0.send(Box::new(request)).map_err(|_| RobotEnded)?;
        answer.recv_timeout(PATIENCE).map_err(|_| RobotEnded)
    }
}

impl PartialEq for RemoteTestbed {
    /// Whether both are the testbed of one robot.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl fmt::Debug for RemoteTestbed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("RemoteTestbed")
    }
}

/// What is asked of a testbed from other threads.
pub struct TestbedRequests(Receiver<Request>);

impl TestbedRequests {
    /// Does what has been asked since the last call.
    pub(crate) fn carry_out(&self, testbed: &Testbed) {
        self.0.try_iter().for_each(|request| request(testbed));
    }
}
