//! Two motor drivers: a PWM slice for lines A and B of each wheel, a pin for line C, one enable for both.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_rp::gpio::{Flex, Output};
use embassy_rp::pwm::{self, Pwm};
use firmware::hal::Motors;
use firmware::lines::Lines;
use firmware::units::Duty;
use shared_proto::{DriverConfig, Inputs, WheelPair};

/// The motors were written since the watchdog was fed last.
pub static CONTROL_ALIVE: AtomicBool = AtomicBool::new(false);

/// One wheel's lines.
pub struct Wheel {
    /// Lines A and B.
    pub pwm: Pwm<'static>,
    /// Line C.
    pub c: Output<'static>,
}

/// Both wheels' lines and their enable.
pub struct Bridge {
    wheels: WheelPair<Wheel>,
    enable: Flex<'static>,
    enable_inverted: bool,
    enabled: bool,
    inputs: Inputs,
    period: u32,
}

impl Bridge {
    /// All lines are low and the enable line floats until [`Motors::configure`].
    pub fn new(wheels: WheelPair<Wheel>, enable: Flex<'static>) -> Self {
        Self {
            wheels,
            enable,
            enable_inverted: false,
            enabled: false,
            inputs: Inputs::PwmDirection,
            period: 1,
        }
    }

    fn set(&mut self, lines: WheelPair<Lines>) {
        let period = self.period;
        for (wheel, lines) in
            [(&mut self.wheels.left, lines.left), (&mut self.wheels.right, lines.right)]
        {
            let mut config = pwm::Config::default();
            config.top = (period - 1) as u16;
            (config.compare_a, config.compare_b) = (lines.a as u16, lines.b as u16);
            wheel.pwm.set_config(&config);
            wheel.c.set_level(lines.c.into());
        }
    }
}

impl Motors for Bridge {
    fn configure(&mut self, driver: &DriverConfig) {
        self.enabled = false;
        self.inputs = driver.name.facts().inputs;
        self.enable_inverted = driver.enable_inverted;
        self.period = embassy_rp::clocks::clk_sys_freq() / driver.pwm_hz as u32;
        self.set(WheelPair::both(Lines::LOW));
        self.enable.set_level(self.enable_inverted.into());
        self.enable.set_as_output();
    }

    fn set_duty(&mut self, duty: WheelPair<Duty>) {
        let lines = Lines::at_both(self.inputs, duty, self.period);
        self.set(if self.enabled { lines } else { WheelPair::both(Lines::LOW) });
        CONTROL_ALIVE.store(true, Ordering::Relaxed);
    }

    fn enable(&mut self, on: bool) {
        self.enabled = on;
        self.enable.set_level((on != self.enable_inverted).into());
    }
}
