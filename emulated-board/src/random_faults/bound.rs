//! Names, and bounds on how soon the motors are off.

use shared_proto::{Fault, ResetCause};

/// A true name of what happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Name {
    /// The robot latched this fault.
    Fault(Fault),
    /// The board restarted and gives this as the cause.
    Restart(ResetCause),
    /// Neither: it was harmless. The motion came to its end, or none was commanded.
    Harmless,
}

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Name::Fault(fault) => write!(f, "{fault}"),
            Name::Restart(cause) => {
                write!(f, "restart ({})", format!("{cause:?}").to_lowercase())
            }
            Name::Harmless => f.write_str("harmless"),
        }
    }
}

/// How soon the motors are off, from what happened, or from the first duty after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotorsOff {
    /// It need not stop the robot.
    NotNeeded,
    /// Zero duty within this time \[ms\].
    Within(f64),
    /// The same, or later but before a wheel has turned this far \[mm\].
    WithinOrTravel(f64, f64),
}
