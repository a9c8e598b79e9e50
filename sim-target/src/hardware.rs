//! The firmware's hardware interface, on the plant and the virtual clock.

use core::cell::RefCell;
use std::rc::Rc;

use embassy_time::{Instant, Timer};
use firmware::hal::{ControlTimer, Encoders, Motors, Supply};
use firmware::units::{CONTROL_PERIOD_US, Duty};
use shared_proto::{DriverConfig, WheelPair};

use crate::guard::{Guard, GuardedTask};
use crate::world::World;

/// The control timer, on the virtual clock. It has one flag, as a chip's has: the ticks of a stall merge.
pub(crate) struct VirtualControlTimer {
    /// The tick on the timer's grid that was taken last \[us\].
    taken_us: u64,
}

impl VirtualControlTimer {
    /// A timer whose first tick is one period from now.
    pub(crate) fn new() -> Self {
        Self { taken_us: Instant::now().as_micros() }
    }
}

impl ControlTimer for VirtualControlTimer {
    async fn next(&mut self) {
        let period_us = u64::from(CONTROL_PERIOD_US);
        Timer::at(Instant::from_micros(self.taken_us + period_us)).await;
        let since_us = Instant::now().as_micros() - self.taken_us;
        self.taken_us += since_us - since_us % period_us;
    }
}

/// The encoder counters, motor drivers and supply divider of the simulated robot.
#[derive(Clone)]
pub(crate) struct Hardware(pub(crate) Rc<RefCell<World>>);

impl Encoders for Hardware {
    fn counts(&mut self) -> WheelPair<i64> {
        let mut world = self.0.borrow_mut();
        world.check_in(GuardedTask::Capture);
        world.plant_now().counts()
    }
}

impl Motors for Hardware {
    /// Takes any driver, as if it were wired as its data sheet wants.
    fn configure(&mut self, _: &DriverConfig) {
        self.enable(false);
    }

    fn set_duty(&mut self, duty: WheelPair<Duty>) {
        let mut world = self.0.borrow_mut();
        world.check_in(GuardedTask::Pid);
        world.plant_now().set_duty(duty.map(Duty::to_si));
    }

    fn enable(&mut self, on: bool) {
        let mut world = self.0.borrow_mut();
        let tripped = world.guard.as_ref().is_some_and(Guard::tripped);
        world.plant_now().set_enabled(on && !tripped);
    }
}

impl Supply for Hardware {
    fn millivolts(&mut self) -> u16 {
        let volts = self.0.borrow_mut().plant_now().supply_v();
        (volts * 1000.0).round().clamp(0.0, f64::from(u16::MAX)) as u16
    }
}
