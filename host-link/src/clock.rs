//! The clock of a session: real time, or a simulator's virtual time.

use std::rc::Rc;
use std::time::{Duration, Instant};

use crate::wire::Waiting;

/// A source of time.
pub trait TimeSource {
    /// Time on this clock \[us\].
    fn now_us(&self) -> u64;

    /// Waits until the clock shows this time.
    fn sleep_until_us(&self, t_us: u64) -> Waiting<'_, ()>;

    /// Whether the clock advances only while somebody waits for it.
    fn is_virtual(&self) -> bool;
}

/// The clock of a session; clones show the same time.
#[derive(Clone)]
pub struct Clock(Rc<dyn TimeSource>);

impl Clock {
    /// A clock with this source of time.
    pub fn new(source: impl TimeSource + 'static) -> Self {
        Self(Rc::new(source))
    }

    /// Real time, counted from now.
    pub fn real() -> Self {
        Self::new(Real(Instant::now()))
    }

    /// Time on this clock \[us\].
    pub fn now_us(&self) -> u64 {
        self.0.now_us()
    }

    /// Waits until the clock shows this time.
    pub async fn sleep_until_us(&self, t_us: u64) {
        self.0.sleep_until_us(t_us).await;
    }

    /// Waits this long.
    pub async fn sleep(&self, duration: Duration) {
        self.sleep_until_us(self.now_us() + duration.as_micros() as u64).await;
    }

    /// Whether the clock advances only while somebody waits for it.
    pub fn is_virtual(&self) -> bool {
        self.0.is_virtual()
    }
}

/// Real time, counted from this instant.
struct Real(Instant);

impl TimeSource for Real {
    fn now_us(&self) -> u64 {
        self.0.elapsed().as_micros() as u64
    }

    fn sleep_until_us(&self, t_us: u64) -> Waiting<'_, ()> {
        Box::pin(async move {
            async_io::Timer::at(self.0 + Duration::from_micros(t_us)).await;
        })
    }

    fn is_virtual(&self) -> bool {
        false
    }
}
