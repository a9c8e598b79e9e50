//! A polled input. An interrupt would cost the control tasks time whenever a button bounces or a line
//! picks up noise; polling does not.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Input, Level, Pin, Pull};
use embassy_time::Timer;

use crate::hal;

/// Polling period \[ms\].
pub(super) const POLL_MS: u64 = 2;

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
}

impl hal::Level for PolledInput {
    fn is_low(&self) -> bool {
        self.pin.get_level() == self.active
    }

    async fn wait_until(&self, low: bool) {
        while self.is_low() != low {
            Timer::after_millis(POLL_MS).await;
        }
    }
}
