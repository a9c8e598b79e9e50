//! A robot without its controller, for a controller that runs elsewhere, such as an image on an emulated
//! chip.
//!
//! Time stands still until [`Chassis::advance_to`] advances the clock. The last duty holds until the
//! controller sets another one.

use core::cell::RefCell;
use std::rc::Rc;

use shared_proto::{Wheel, WheelPair};

use crate::clock;
use crate::flash::Flash;
use crate::pin::Pin;
use crate::plant::EncoderStep;
use crate::robot_task::StoppedTasks;
use crate::scenario::Scenario;
use crate::testbed::Testbed;
use crate::wire::{HostWire, Wire, WireParameters};
use crate::world::World;

/// Plant, testbed and serial line on this thread's virtual clock. One at a time per thread.
pub struct Chassis {
    testbed: Testbed,
    to_robot: Wire,
    to_host: Wire,
}

impl Chassis {
    /// A robot on its start line. The thread's virtual clock starts at zero.
    ///
    /// The line takes no time and loses nothing: the controller's UART models the baud rate.
    ///
    /// # Panics
    /// If the thread has a simulated robot already.
    pub fn new(scenario: &Scenario) -> Self {
        clock::claim();
        let world = World::new(scenario, scenario.set_up(), Pin::default(), Pin::default());
        let flash = Flash::new(None).expect("no file is read");
        let line = WireParameters { baud: 0, frame_loss: 0.0, bit_error: 0.0 };
        Self {
            testbed: Testbed {
                world: Rc::new(RefCell::new(world)),
                flash,
                stopped: StoppedTasks::default(),
            },
            to_robot: Wire::new(line, 0),
            to_host: Wire::new(line, 0),
        }
    }

    /// The testbed round the robot.
    pub fn testbed(&self) -> Testbed {
        self.testbed.clone()
    }

    /// The host's end of the serial line.
    pub fn host_wire(&self) -> HostWire {
        HostWire { to_robot: self.to_robot.clone(), to_host: self.to_host.clone() }
    }

    /// When the next event is due that does not come from the controller \[us\].
    pub fn next_us(&self) -> u64 {
        let world = self.testbed.world.borrow().next_event_us();
        clock::next_alarm_us().map_or(world, |alarm| alarm.min(world))
    }

    /// Advances plant and clock. A time in the past changes nothing.
    pub fn advance_to(&self, t_us: u64) {
        if t_us > clock::now_us() {
            // The plant first, so that the encoders' step covers the whole advance.
            self.testbed.world.borrow_mut().advance_plant_to(t_us);
            clock::advance_to(t_us);
            self.testbed.world.borrow_mut().act();
        }
    }

    /// Sets the motor drivers: mean voltages as shares of the supply.
    pub fn drive(&self, duty: WheelPair<f64>, enabled: bool) {
        let mut world = self.testbed.world.borrow_mut();
        let plant = world.plant_now();
        plant.set_enabled(enabled);
        plant.set_duty(duty);
    }

    /// What an encoder did during the last [`advance_to`](Self::advance_to).
    pub fn encoder_step(&self, wheel: Wheel) -> EncoderStep {
        self.testbed.plant(|plant| plant.encoder_step(wheel))
    }

    /// The measured supply, noise included \[V\].
    pub fn supply_v(&self) -> f64 {
        self.testbed.world.borrow_mut().plant_now().supply_v()
    }

    /// Takes the bytes that the host has sent.
    pub fn take_from_host(&self, buffer: &mut [u8]) -> usize {
        self.to_robot.read_now(buffer)
    }

    /// Gives the host bytes.
    pub fn give_to_host(&self, bytes: &[u8]) {
        self.to_host.write_now(bytes);
    }
}

impl Drop for Chassis {
    fn drop(&mut self) {
        clock::release();
    }
}
