//! The firmware's hardware interface, on the plant and the virtual clock.

use core::cell::RefCell;
use std::rc::Rc;

use embassy_time::{Duration, Ticker};
use firmware::hal::{ControlTimer, Encoders, Motors, Supply};
use firmware::units::{CONTROL_PERIOD_US, Duty};
use shared_proto::WheelPair;

use crate::world::World;

/// The control timer, on the virtual clock.
pub(crate) struct VirtualControlTimer(Ticker);

impl VirtualControlTimer {
    /// A timer whose first tick is one period from now.
    pub(crate) fn new() -> Self {
        Self(Ticker::every(Duration::from_micros(CONTROL_PERIOD_US.into())))
    }
}

impl ControlTimer for VirtualControlTimer {
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
