//! Faults to plant, so that the bench is seen to find what it looks for.
//!
//! Each makes robot and line together behave as a robot with that fault would, from outside: no firmware has test code in it.

use shared_proto::{Command, Encoder, Request};

use super::witness::{Witness, requests};

/// A fault in the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plant {
    /// None.
    #[default]
    Nothing,
    /// A command is obeyed however late it comes: each arrives with a lease from now.
    NoLateCheck,
    /// Whoever arms the robot drives it: nobody is asked whether somebody else does.
    NoSessionCheck,
    /// A fault is latched no longer than until it has been reported.
    NoLatch,
}

impl Plant {
    /// All of them, by the names of the command line.
    pub const ALL: [(&'static str, Self); 3] = [
        ("no-late-check", Self::NoLateCheck),
        ("no-session-check", Self::NoSessionCheck),
        ("no-latch", Self::NoLatch),
    ];

    /// What arrives in place of these bytes.
    pub(crate) fn on_the_way(self, bytes: &[u8], witness: &Witness) -> Option<Vec<u8>> {
        let change = |request: &mut Request| match self {
            Self::NoLateCheck if request.command.needs_lease() => {
                request.until_ms = witness.robot_ms() + 200;
                true
            }
            Self::NoSessionCheck => match &mut request.command {
                Command::Arm { take } => !std::mem::replace(take, true),
                _ => false,
            },
            _ => false,
        };
        let mut changed = requests(bytes);
        // In one write there is one request, perhaps after a hello, which goes through as it is.
        let request = changed.first_mut().filter(|_| bytes.first() != Some(&0))?;
        change(request).then(|| Encoder::new().message(request).to_vec())
    }

    /// What the robot does by itself.
    pub(crate) fn of_its_own(self, witness: &Witness) -> Option<Vec<u8>> {
        let (number, session) = (witness.fault()?, witness.driver()?);
        (self == Self::NoLatch).then(|| {
            let command = Command::ClearFault { number };
            let until_ms = witness.robot_ms() + 200;
            let request = Request { session, id: u32::MAX, until_ms, command };
            Encoder::new().message(&request).to_vec()
        })
    }
}
