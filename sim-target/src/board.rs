//! The simulated board: the firmware's hardware seam, on the plant.

use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use core::future::poll_fn;
use core::task::{Poll, Waker};
use std::io::Write as _;
use std::path::PathBuf;
use std::rc::Rc;

use embassy_time::{Duration, Ticker};
use embedded_hal::digital::ErrorType;
use embedded_hal_async::digital::Wait;
use firmware::hal::{Beat, Encoders, Motors, Store, StoreError, Supply};
use firmware::units::{CONTROL_PERIOD_US, Duty};
use shared_proto::{Config, WheelPair};

use crate::target::World;

/// The control tick's beat, by the virtual clock.
pub(crate) struct ClockBeat(Ticker);

impl ClockBeat {
    /// Beats from now on.
    pub(crate) fn new() -> Self {
        Self(Ticker::every(Duration::from_micros(CONTROL_PERIOD_US.into())))
    }
}

impl Beat for ClockBeat {
    async fn next(&mut self) {
        self.0.next().await;
    }
}

/// The encoder counters, motor drivers and supply divider of the simulated robot.
#[derive(Clone)]
pub(crate) struct Hardware(pub(crate) Rc<RefCell<World>>);

impl Encoders for Hardware {
    fn counts(&mut self) -> WheelPair<i64> {
        self.0.borrow_mut().plant_now().counts()
    }
}

impl Motors for Hardware {
    fn set_duty(&mut self, duty: WheelPair<Duty>) {
        self.0.borrow_mut().plant_now().set_duty(duty.map(Duty::to_si));
    }

    fn enable(&mut self, on: bool) {
        self.0.borrow_mut().plant_now().set_enabled(on);
    }
}

impl Supply for Hardware {
    fn millivolts(&mut self) -> u16 {
        let volts = self.0.borrow_mut().plant_now().supply_v();
        (volts * 1000.0).round().clamp(0.0, f64::from(u16::MAX)) as u16
    }
}

/// An active-low input that the simulation pulls.
#[derive(Clone, Default)]
pub(crate) struct Pin(Rc<PinState>);

#[derive(Default)]
struct PinState {
    low: Cell<bool>,
    waker: RefCell<Option<Waker>>,
}

impl Pin {
    pub(crate) fn set_low(&self, low: bool) {
        if self.0.low.replace(low) != low
            && let Some(waker) = self.0.waker.take()
        {
            waker.wake();
        }
    }

    /// Wakes nobody any more: who waits is about to be freed.
    pub(crate) fn forget_waiter(&self) {
        self.0.waker.take();
    }

    async fn wait_for(&self, mut ready: impl FnMut(bool) -> bool) {
        poll_fn(|context| {
            if ready(self.0.low.get()) {
                return Poll::Ready(());
            }
            *self.0.waker.borrow_mut() = Some(context.waker().clone());
            Poll::Pending
        })
        .await;
    }
}

impl ErrorType for Pin {
    type Error = Infallible;
}

impl Wait for Pin {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        self.wait_for(|low| !low).await;
        Ok(())
    }

    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        self.wait_for(|low| low).await;
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
        let before = self.0.low.get();
        self.wait_for(|low| low != before).await;
        Ok(())
    }
}

/// The simulated flash. Without a file it forgets when the simulation ends.
#[derive(Clone)]
pub(crate) struct Flash(Rc<RefCell<FlashState>>);

struct FlashState {
    content: Option<String>,
    file: Option<PathBuf>,
    write_protected: bool,
}

impl Flash {
    /// A blank flash, or what the file holds, if there is one.
    pub(crate) fn new(file: Option<PathBuf>) -> std::io::Result<Self> {
        let content = match &file {
            Some(path) => match std::fs::read_to_string(path) {
                Ok(text) if text.is_empty() || text.starts_with(HEADER) => Some(text),
                // Somebody's scenario or notes: it would be overwritten.
                Ok(_) => {
                    return Err(std::io::Error::other("it is not the flash of a simulated robot"));
                }
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => None,
                Err(error) => return Err(error),
            },
            None => None,
        };
        Ok(Self(Rc::new(RefCell::new(FlashState { content, file, write_protected: false }))))
    }

    pub(crate) fn put(&self, config: &Config) {
        self.0.borrow_mut().content = to_text(config);
    }

    pub(crate) fn content(&self) -> Option<String> {
        self.0.borrow().content.clone()
    }

    pub(crate) fn set_write_protected(&self, on: bool) {
        self.0.borrow_mut().write_protected = on;
    }
}

impl Store for Flash {
    async fn load(&mut self) -> Result<Option<Config>, StoreError> {
        match &self.0.borrow().content {
            None => Ok(None),
            Some(text) if text.is_empty() => Ok(None),
            Some(text) => toml::from_str(text).map(Some).map_err(|_| StoreError::Damaged),
        }
    }

    async fn save(&mut self, config: &Config) -> Result<(), StoreError> {
        // Erasing and writing takes a real flash about this long.
        embassy_time::Timer::after_millis(5).await;
        let mut state = self.0.borrow_mut();
        if state.write_protected {
            return Err(StoreError::Write);
        }
        let text = to_text(config).ok_or(StoreError::Write)?;
        if let Some(path) = &state.file {
            write_whole(path, &text).map_err(|_| StoreError::Write)?;
        }
        state.content = Some(text);
        Ok(())
    }
}

/// The first line of every file that stands for a flash.
const HEADER: &str = "# The flash of a simulated robot.\n";

fn to_text(config: &Config) -> Option<String> {
    Some(format!("{HEADER}{}", toml::to_string(config).ok()?))
}

/// Writes beside the file, syncs and renames: it holds the old text or the new one, never half of it.
fn write_whole(path: &std::path::Path, text: &str) -> std::io::Result<()> {
    let beside = path.with_extension("new");
    let mut file = std::fs::File::create(&beside)?;
    // On the disk before its name is: else the name may outlive what it names.
    let written = file.write_all(text.as_bytes()).and_then(|()| file.sync_all());
    let renamed = written.and_then(|()| std::fs::rename(&beside, path));
    renamed.inspect_err(|_| drop(std::fs::remove_file(&beside)))
}
