//! An input that works the other way round: the tasks want their inputs active low.

use embedded_hal::digital::ErrorType;
use embedded_hal_async::digital::Wait;

/// Low where the pin is high.
pub struct Inverted<P>(pub P);

impl<P: ErrorType> ErrorType for Inverted<P> {
    type Error = P::Error;
}

impl<P: Wait> Wait for Inverted<P> {
    async fn wait_for_high(&mut self) -> Result<(), P::Error> {
        self.0.wait_for_low().await
    }

    async fn wait_for_low(&mut self) -> Result<(), P::Error> {
        self.0.wait_for_high().await
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), P::Error> {
        self.0.wait_for_falling_edge().await
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), P::Error> {
        self.0.wait_for_rising_edge().await
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), P::Error> {
        self.0.wait_for_any_edge().await
    }
}
