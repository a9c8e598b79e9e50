//! What a procedure sees of the board from outside, and does to it.

use std::cell::RefCell;
use std::rc::Rc;

use host_link::session::Session;
use shared_proto::{Wheel, WheelPair};
use sim_target::{HostWire, Testbed};

use crate::bug::Bug;
use crate::flash_array::Flash;
use crate::lines::{EncoderLines, LineFault};
use crate::motor_driver::{BoardLines, Effect as MotorEffect, Wiring};

/// What a procedure on the emulated board works with.
pub struct Bench {
    /// The testbed around the robot.
    pub testbed: Testbed,
    /// The host's session; not opened yet.
    pub session: Session,
    /// The host's end of the serial line, for further sessions, or to use without a session.
    pub wire: HostWire,
    /// Observes the board, and acts on it.
    pub monitor: BoardMonitor,
}

impl Bench {
    /// Another session on the same line, not opened yet: after a restart, or of another host.
    pub fn session(&self, number: u32) -> Session {
        sim_link::session(&self.wire, number, "emulated")
    }
}

/// Observes the board from outside, and acts on it.
#[derive(Clone, Default)]
pub struct BoardMonitor(pub(crate) Rc<RefCell<BoardState>>);

#[derive(Default)]
pub(crate) struct BoardState {
    pub duty: WheelPair<f64>,
    pub enabled: bool,
    /// The lines, what the driver makes of them, and the period of the PWM \[ns\].
    pub motors: (BoardLines, WheelPair<MotorEffect>, Option<u64>),
    pub last_powered_us: Option<u64>,
    pub powered: Vec<Powered>,
    pub lines: EncoderLines,
    /// Pull the reset pin at the next step.
    pub pull_reset: bool,
    pub resets_us: Vec<u64>,
    /// Bytes that wait for their turn on the line to the robot.
    pub waiting: usize,
    pub bugs: Vec<Bug>,
    pub flash_operations: u64,
    pub power_on: Option<Flash>,
    pub soldered: Option<Wiring>,
    pub stop_line_open: bool,
    pub clock_fails: bool,
    pub random_fails: bool,
    /// Registers to read, and what was in them.
    pub asked: Vec<u64>,
    pub registers: Vec<(u64, u32)>,
}

/// A time during which a motor had a duty other than zero, with breaks of at most 2 ms (`BREAK_US`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Powered {
    /// From when \[us\].
    pub from_us: u64,
    /// Until when \[us\].
    pub to_us: u64,
    /// How far the wheels had turned at the end \[rad\].
    pub angles_rad: WheelPair<f64>,
}

/// A duty that crosses zero is no end \[us\].
pub const BREAK_US: u64 = 2_000;

impl BoardState {
    pub(crate) fn note_powered(&mut self, now_us: u64, angles_rad: WheelPair<f64>) {
        self.last_powered_us = Some(now_us);
        match self.powered.last_mut() {
            Some(last) if now_us <= last.to_us + BREAK_US => {
                (last.to_us, last.angles_rad) = (now_us, angles_rad);
            }
            _ => self.powered.push(Powered { from_us: now_us, to_us: now_us, angles_rad }),
        }
    }
}

impl BoardMonitor {
    /// The motors' present voltages, as shares of the supply; zero while the bridge is disabled.
    pub fn duty(&self) -> WheelPair<f64> {
        let outside = self.0.borrow();
        if outside.enabled { outside.duty } else { WheelPair::both(0.0) }
    }

    /// The present levels of the lines to the motor drivers.
    pub fn motor_lines(&self) -> BoardLines {
        self.0.borrow().motors.0
    }

    /// What the drivers do with both motors at present.
    pub fn motor_effect(&self) -> WheelPair<MotorEffect> {
        self.0.borrow().motors.1
    }

    /// The present period of the PWM \[ns\]; `None` while the timer lets no pulse out.
    pub fn pwm_period_ns(&self) -> Option<u64> {
        self.0.borrow().motors.2
    }

    /// When a motor last had a duty other than zero, to within a period of the PWM \[us\].
    pub fn last_powered_us(&self) -> Option<u64> {
        self.0.borrow().last_powered_us
    }

    /// When a motor had a duty other than zero, so far.
    pub fn powered(&self) -> Vec<Powered> {
        self.0.borrow().powered.clone()
    }

    /// When the board restarted \[us\].
    pub fn resets_us(&self) -> Vec<u64> {
        self.0.borrow().resets_us.clone()
    }

    /// Bytes that wait for their turn on the line to the robot, within a period of the PWM.
    pub fn waiting(&self) -> usize {
        self.0.borrow().waiting
    }

    /// Erasures and programmed words so far.
    pub fn flash_operations(&self) -> u64 {
        self.0.borrow().flash_operations
    }

    /// Switches the board off and on again, with this content in its flash; RAM loses its content.
    ///
    /// The chip sees a reset by its pin, and reports that as the cause.
    pub fn power_cycle(&self, flash: Flash) {
        self.0.borrow_mut().power_on = Some(flash);
    }

    /// Solders another motor driver to the board, in no time.
    pub fn solder(&self, wiring: Wiring) {
        self.0.borrow_mut().soldered = Some(wiring);
    }

    /// Pulls the reset pin, shortly; RAM keeps its content.
    pub fn pull_reset(&self) {
        self.0.borrow_mut().pull_reset = true;
    }

    /// From the next start on, the chip's generator of random numbers says that it is broken.
    pub fn break_random(&self) {
        self.0.borrow_mut().random_fails = true;
    }

    /// Breaks an encoder's line, or mends both.
    pub fn break_line(&self, wheel: Wheel, fault: Option<LineFault>) {
        self.0.borrow_mut().lines.set(wheel, fault);
    }

    /// Opens the stop line, as its switch or a cut wire does, or closes it.
    pub fn open_stop_line(&self, open: bool) {
        self.0.borrow_mut().stop_line_open = open;
    }

    /// Stops the clock that the chip gets from outside.
    pub fn fail_clock(&self) {
        self.0.borrow_mut().clock_fails = true;
    }

    /// Reads these registers at the next step of the run, without an effect on the chip.
    pub fn ask_registers(&self, addresses: &[u64]) {
        self.0.borrow_mut().asked = addresses.to_vec();
    }

    /// What was in the registers asked for, in their order.
    pub fn registers(&self) -> Vec<u32> {
        self.0.borrow().registers.iter().map(|(_, value)| *value).collect()
    }

    /// Injects a bug into the running program; a restart removes the bug.
    pub fn plant(&self, bug: Bug) {
        self.0.borrow_mut().bugs.push(bug);
    }
}
