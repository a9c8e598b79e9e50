//! The hardware interface that a board, or the simulator, implements for the tasks.
//!
//! The emergency stop and the motor driver's fault line are `embedded_hal_async::digital::Wait`
//! pins (any [`Level`] becomes one as a [`WaitPin`]), and the link is an `embedded_io_async` reader and
//! writer; the traits here cover what the ecosystem has no trait for.

use core::convert::Infallible;
use core::future::Future;

use embedded_hal::digital::ErrorType;
use embedded_hal_async::digital::Wait;
use shared_proto::{Config, DriverConfig, Key, Name, Nonce, ResetCause, WheelPair};

use crate::units::Duty;

/// The timer behind the control tick.
pub trait ControlTimer {
    /// Waits for the next tick. Ticks come [`CONTROL_HZ`](crate::units::CONTROL_HZ) times a second, without drift.
    fn next(&mut self) -> impl Future<Output = ()>;
}

/// Both wheels' quadrature counters.
pub trait Encoders {
    /// Absolute counts since power-on, as wired: capture applies the configured signs.
    ///
    /// [`crate::encoder::CounterExtender`] extends a narrower counter.
    fn counts(&mut self) -> WheelPair<i64>;
}

/// Both wheels' motor drivers.
pub trait Motors {
    /// Takes on a driver, and leaves it off. Called before all else, and again when another one is configured.
    fn configure(&mut self, driver: &DriverConfig);
    /// Sets the mean voltage of each motor as a share of the supply, as wired. Nothing while the drivers are off.
    fn set_duty(&mut self, duty: WheelPair<Duty>);
    /// Switches the drivers on or off. While they are off, the wheels roll freely, if the driver can let them.
    fn enable(&mut self, on: bool);
}

/// The supply's voltage.
pub trait Supply {
    /// The latest measurement \[mV\].
    fn millivolts(&mut self) -> u16;
}

/// An input whose level can be read and waited for.
pub trait Level {
    /// Whether it is low now.
    fn is_low(&self) -> bool;
    /// Waits until it is low, or high.
    fn wait_until(&self, low: bool) -> impl Future<Output = ()>;
}

/// A [`Level`] as a pin that can be waited for.
pub struct WaitPin<L>(pub L);

impl<L> ErrorType for WaitPin<L> {
    type Error = Infallible;
}

impl<L: Level> Wait for WaitPin<L> {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        self.0.wait_until(false).await;
        Ok(())
    }

    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        self.0.wait_until(true).await;
        Ok(())
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), Infallible> {
        self.wait_for_low().await?;
        self.wait_for_high().await
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), Infallible> {
        self.wait_for_high().await?;
        self.wait_for_low().await
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), Infallible> {
        self.0.wait_until(!self.0.is_low()).await;
        Ok(())
    }
}

/// What survives power-off: a configuration, a key, and a count of starts.
pub trait Store {
    /// The configuration saved last; `Ok(None)` if none ever was.
    fn load(&mut self) -> impl Future<Output = Result<Option<Config>, StoreError>>;
    /// Saves, reads back and compares. If this fails, the earlier configuration is still there.
    fn save(&mut self, config: &Config) -> impl Future<Output = Result<(), StoreError>>;
    /// Keeps another key for the link, or none, if there is a change; tells which there is then, and counts.
    ///
    /// If this fails, the earlier key is still there.
    fn link(
        &mut self,
        change: Option<Option<Key>>,
    ) -> impl Future<Output = Result<LinkRecord, StoreError>>;
}

/// What the store holds for the link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkRecord {
    /// The key, if there is one.
    pub key: Option<Key>,
    /// With a key: a number that was never told before, whatever happened to the power. None if it could not be kept.
    pub count: Option<u64>,
}

/// Why a configuration could not be loaded or saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StoreError {
    /// What is stored is damaged, or of an unknown layout.
    Damaged,
    /// The memory could not be written, or read back differently.
    Write,
    /// A key is there, but of a layout that this firmware does not know.
    UnknownKey,
}

/// Facts about the board.
#[derive(Clone, Debug)]
pub struct BoardInfo {
    /// The board's name, as in its user manual.
    pub board: Name,
    /// The chip's unique number.
    pub uid: [u8; 12],
    /// Why the board started.
    pub reset_cause: ResetCause,
    /// Drawn anew at each start, on a board that has a source of random numbers.
    pub random: Option<Nonce>,
}
