//! What can be wrong with a wheel.

use shared_proto::{Fault, Wheel};

/// What a monitor finds; in the order of [`Fault`], which spares a table.
#[derive(Clone, Copy, Debug)]
pub enum WheelFault {
    FollowingError,
    Stall,
    EncoderDead,
    EncoderReversed,
    CountRate,
    NoResponse,
}

impl WheelFault {
    /// The fault of this wheel.
    #[cold]
    #[inline(never)]
    pub fn of(self, wheel: Wheel) -> Fault {
        match self {
            Self::CountRate => Fault::CountRate(wheel),
            Self::EncoderDead => Fault::EncoderDead(wheel),
            Self::EncoderReversed => Fault::EncoderReversed(wheel),
            Self::Stall => Fault::Stall(wheel),
            Self::FollowingError => Fault::FollowingError(wheel),
            Self::NoResponse => Fault::NoResponse(wheel),
        }
    }
}
