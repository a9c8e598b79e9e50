//! The hardware seam: what a board, or the simulator, gives to the tasks.
//!
//! The emergency stop and the motor driver's fault line are `embedded_hal_async::digital::Wait`
//! pins, and the link is an `embedded_io_async` reader and writer; the traits here are for what the
//! ecosystem has no trait for.

use core::future::Future;

use shared_proto::{Config, Name, ResetCause, WheelPair};

use crate::units::Duty;

/// What the control tick goes by.
pub trait ControlTimer {
    /// Waits for the next tick: [`CONTROL_HZ`](crate::units::CONTROL_HZ) times a second, and on time.
    fn next(&mut self) -> impl Future<Output = ()>;
}

/// Both wheels' quadrature counters.
pub trait Encoders {
    /// Absolute counts since power-on, as wired: sign corrections are the configuration's.
    ///
    /// A counter narrower than this is extended by [`crate::encoder::Extender`].
    fn counts(&mut self) -> WheelPair<i64>;
}

/// Both wheels' motor drivers.
pub trait Motors {
    /// Sets the mean voltage of each motor as a share of the supply, as wired.
    fn set_duty(&mut self, duty: WheelPair<Duty>);
    /// Switches the drivers on or off; off, the wheels roll freely.
    fn enable(&mut self, on: bool);
}

/// The supply's voltage.
pub trait Supply {
    /// The latest measurement \[mV\].
    fn millivolts(&mut self) -> u16;
}

/// A configuration that survives power-off.
pub trait Store {
    /// The configuration saved last; `Ok(None)` if none ever was.
    fn load(&mut self) -> impl Future<Output = Result<Option<Config>, StoreError>>;
    /// Saves, reads back and compares. If this fails, the one saved before is still there.
    fn save(&mut self, config: &Config) -> impl Future<Output = Result<(), StoreError>>;
}

/// Why a store gave or took no configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StoreError {
    /// What is stored is damaged, or of an unknown layout.
    Damaged,
    /// The memory refused to be written, or read back differently.
    Write,
}

/// What the board knows about itself.
#[derive(Clone, Debug)]
pub struct BoardInfo {
    /// The board's name, as in its user manual.
    pub board: Name,
    /// The chip's unique number.
    pub uid: [u8; 12],
    /// Why it started.
    pub reset_cause: ResetCause,
}
