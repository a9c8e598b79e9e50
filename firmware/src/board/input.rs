//! An input that is looked at, not interrupted by: a button that bounces or a line that hums costs
//! the control tasks nothing, however fast.

use core::convert::Infallible;

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Input, Level, Pin, Pull};
use embassy_time::Timer;
use embedded_hal::digital::ErrorType;
use embedded_hal_async::digital::Wait;

/// How often an input is looked at \[ms\].
const POLL_MS: u64 = 2;

/// Low where the pin is at its active level: the tasks want their inputs active low.
pub struct PolledInput {
    pin: Input<'static>,
    active: Level,
}

impl PolledInput {
    /// An input that is high when it is active, and pulled down.
    pub fn active_high(pin: Peri<'static, impl Pin>) -> Self {
        Self { pin: Input::new(pin, Pull::Down), active: Level::High }
    }

    /// An input that is low when it is active, and pulled up.
    pub fn active_low(pin: Peri<'static, impl Pin>) -> Self {
        Self { pin: Input::new(pin, Pull::Up), active: Level::Low }
    }

    async fn wait_until(&self, active: bool) {
        while (self.pin.get_level() == self.active) != active {
            Timer::after_millis(POLL_MS).await;
        }
    }
}

impl ErrorType for PolledInput {
    type Error = Infallible;
}

impl Wait for PolledInput {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        self.wait_until(false).await;
        Ok(())
    }

    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        self.wait_until(true).await;
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
        let active = self.pin.get_level() == self.active;
        self.wait_until(!active).await;
        Ok(())
    }
}
