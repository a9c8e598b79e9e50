//! What is around the chip: the plant and the host, in step with it.

use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Wake, Waker};

use rigless::time::VirtualNanos;
use shared_proto::Wheel;
use sim_target::Chassis;

use crate::board::Nucleo;
use crate::monitor::BoardMonitor;
use crate::motor_driver::Wiring;

/// Plant and host. They run on the core's thread, because their clock belongs to a thread.
pub(crate) struct PlantAndHost {
    pub chassis: Chassis,
    wiring: Wiring,
    pub monitor: BoardMonitor,
    host: Pin<Box<dyn Future<Output = ()>>>,
    awake: Arc<Awake>,
}

impl PlantAndHost {
    /// Both at power-on.
    pub fn new(
        chassis: Chassis,
        wiring: Wiring,
        monitor: BoardMonitor,
        host: Pin<Box<dyn Future<Output = ()>>>,
    ) -> Self {
        let awake = Arc::new(Awake(AtomicBool::new(true)));
        Self { chassis, wiring, monitor, host, awake }
    }

    /// Advances the plant to the chip's time and exchanges their signals.
    pub fn meet(&mut self, board: &mut Nucleo, at: VirtualNanos) {
        self.chassis.advance_to(at.0 / 1000);
        if let Some(wiring) = self.monitor.0.borrow_mut().soldered.take() {
            self.wiring = wiring;
        }
        for wheel in Wheel::BOTH {
            let count = self.chassis.encoder_step(wheel).count_after;
            let levels = self.monitor.0.borrow_mut().lines.levels(wheel, count);
            if let Some(levels) = levels {
                board.turn_encoder(at, wheel, levels);
            }
        }
        // First: a reset makes the chip forget what its pins are driven to.
        let (button, fault) =
            self.chassis.testbed().plant(|plant| (plant.estop_line(), plant.driver_fault_line()));
        let fault_line_high = self.wiring.fault_line_high(fault);
        board.set_safety_inputs(at, button, fault_line_high, self.wiring.enable_inverted);
        let lines = board.motor_lines();
        let effect = self.wiring.effect(&lines);
        let (duty, enabled) = (effect.map(|effect| effect.duty()), effect.any(|e| e.coast < 1.0));
        {
            let mut outside = self.monitor.0.borrow_mut();
            (outside.duty, outside.enabled) = (duty, enabled);
            outside.motors = (lines, effect, board.pwm_period_ns());
            if enabled && duty.any(|duty| duty != 0.0) {
                let angles_rad = self.chassis.testbed().plant(|plant| plant.wheel_angles_rad());
                outside.note_powered(at.0 / 1000, angles_rad);
            }
        }
        self.chassis.drive(duty, enabled);
        self.act_on_chip(board, at);
        board.set_supply_v(self.chassis.supply_v());
        let bytes = board.line().take();
        if !bytes.is_empty() {
            self.chassis.give_to_host(&bytes);
        }
    }

    /// What the procedure does to the chip itself.
    fn act_on_chip(&mut self, board: &mut Nucleo, at: VirtualNanos) {
        let mut outside = self.monitor.0.borrow_mut();
        board.set_stop_line(at, outside.stop_line_open);
        if std::mem::take(&mut outside.clock_fails) {
            board.fail_clock(at);
        }
        let asked = std::mem::take(&mut outside.asked);
        if !asked.is_empty() {
            let read = |address| (address, board.register(at, address));
            outside.registers = asked.into_iter().map(read).collect();
        }
    }

    /// Runs the host until it waits; true if the host has finished.
    pub fn poll_host(&mut self) -> bool {
        let waker = Waker::from(self.awake.clone());
        while self.awake.0.swap(false, Ordering::Relaxed) {
            if self.host.as_mut().poll(&mut Context::from_waker(&waker)).is_ready() {
                return true;
            }
        }
        false
    }

    /// Puts the host's bytes on the line.
    pub fn hand_over(&mut self, board: &mut Nucleo) {
        let mut buffer = [0; 512];
        loop {
            let len = self.chassis.take_from_host(&mut buffer);
            if len == 0 {
                break;
            }
            board.line().send(&buffer[..len]);
        }
        self.monitor.0.borrow_mut().waiting = board.line().waiting();
    }
}

struct Awake(AtomicBool);

impl Wake for Awake {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}
