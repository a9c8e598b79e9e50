//! A polled input. An interrupt would cost the control tasks time whenever a button bounces or a line
//! picks up noise; polling does not.

use core::convert::Infallible;

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Input, Level, Pin, Pull};
use embassy_time::Timer;
use embedded_hal::digital::ErrorType;
use embedded_hal_async::digital::Wait;

/// Polling period \[ms\].
const POLL_MS: u64 = 2;

/// Reads low while the pin is at its active level: the tasks expect active-low inputs.
pub struct PolledInput {
    pin: Input<'static>,
    active: Level,
}

impl PolledInput {
    /// An active-high input with a pull-down.
    pub fn active_high(pin: Peri<'static, impl Pin>) -> Self {
        Self { pin: Input::new(pin, Pull::Down), active: Level::High }
    }

    /// An active-low input with a pull-up.
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
