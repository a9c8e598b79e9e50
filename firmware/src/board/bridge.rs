//! Two motor drivers: PWM on TIM1, three lines a wheel, one enable for both.
//!
//! ```text
//! line    pin                     what drives it
//! A, B    TIM1 channels 1 to 4    the timer: low, high, or a pulse in each period
//! C       any pin                 low or high; few drivers have this line
//! enable  any pin                 left floating until the driver is known, so that its resistor holds it off
//! ```
//!
//! What the lines do with which driver is [`Lines::at`]; which driver it is, the configuration says.
//!
//! The stop line is TIM1's break input: while the line is open, the timer itself holds every line A and B low,
//! whatever the program does (RM0090, 17.3.12; RM0440, 29.3.18). The line is high when open, so a cut wire stops the robot. The
//! outputs stay off until the motors are enabled anew, which takes a reset of the fault and an arming.
//! A debugger's halt has the same effect ([`super::power_on`]).

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, Flex, Level, Output, OutputType, Pin, Pull, Speed};
use embassy_stm32::pac;
use embassy_stm32::pac::timer::vals::{Bkp, Lock, Ossi};
use embassy_stm32::peripherals::TIM1;
use embassy_stm32::timer::low_level::{OutputCompareMode, Timer};
use embassy_stm32::timer::simple_pwm::PwmPin;
use embassy_stm32::timer::{BkIn1, BreakInputPin, Ch1, Ch2, Ch3, Ch4, Channel, TimerPin};
use shared_proto::{DriverConfig, Inputs, WheelPair};

use super::check_in::{self, CheckedTask};
use crate::hal::{self, Motors};
use crate::lines::Lines;
use crate::soft_float::truncate;
use crate::units::Duty;

/// Whether the enable line is high while the driver is disabled.
static DISABLED_IS_HIGH: AtomicBool = AtomicBool::new(false);

/// A wheel's line C.
struct LineC {
    pin: Output<'static>,
    high: bool,
}

/// The lines of both wheels and their enable.
pub struct Bridge {
    lines_c: WheelPair<LineC>,
    enable: Flex<'static>,
    enabled: bool,
    inputs: Inputs,
    /// The timer's clock \[Hz\].
    clock_hz: u32,
    /// Timer ticks of a whole period.
    period: u32,
}

/// The left wheel's lines A and B are TIM1's channels 1 and 2, the right wheel's 3 and 4.
pub struct Pins<A1: Pin, A2: Pin, A3: Pin, A4: Pin, E: Pin, S: Pin, C1: Pin, C2: Pin> {
    /// The left wheel's line A.
    pub left_a: Peri<'static, A1>,
    /// The left wheel's line B.
    pub left_b: Peri<'static, A2>,
    /// The left wheel's line C.
    pub left_c: Peri<'static, C1>,
    /// The right wheel's line A.
    pub right_a: Peri<'static, A3>,
    /// The right wheel's line B.
    pub right_b: Peri<'static, A4>,
    /// The right wheel's line C.
    pub right_c: Peri<'static, C2>,
    /// The driver's enable. Add a resistor that holds it off: during a reset every pin floats.
    pub enable: Peri<'static, E>,
    /// The stop line: a switch to ground that opens when pressed. Pulled up.
    pub stop: Peri<'static, S>,
}

impl Bridge {
    /// All lines are low and the enable line floats until [`Motors::configure`].
    pub fn new<A1, A2, A3, A4, E, S, C1, C2>(
        timer: Peri<'static, TIM1>,
        pins: Pins<A1, A2, A3, A4, E, S, C1, C2>,
    ) -> (Self, StopLine)
    where
        A1: TimerPin<TIM1, Ch1>,
        A2: TimerPin<TIM1, Ch2>,
        A3: TimerPin<TIM1, Ch3>,
        A4: TimerPin<TIM1, Ch4>,
        E: Pin,
        S: BreakInputPin<TIM1, BkIn1> + Pin,
        C1: Pin,
        C2: Pin,
    {
        let function = AfType::input(Pull::Up);
        let number = pins.stop.af_num();
        let mut stop = Flex::new(pins.stop);
        stop.set_as_af_unchecked(number, function);
        // Dropping the pins would reconfigure them.
        core::mem::forget(PwmPin::new(pins.left_a, OutputType::PushPull));
        core::mem::forget(PwmPin::new(pins.left_b, OutputType::PushPull));
        core::mem::forget(PwmPin::new(pins.right_a, OutputType::PushPull));
        core::mem::forget(PwmPin::new(pins.right_b, OutputType::PushPull));
        let low = |pin| LineC { pin, high: false };
        let bridge = Self {
            lines_c: WheelPair {
                left: low(Output::new(pins.left_c, Level::Low, Speed::Low)),
                right: low(Output::new(pins.right_c, Level::Low, Speed::Low)),
            },
            enable: Flex::new(pins.enable),
            enabled: false,
            inputs: Inputs::PwmDirection,
            clock_hz: start(timer),
            period: 0,
        };
        (bridge, StopLine(stop))
    }

    #[inline(always)]
    fn set(&mut self, lines: WheelPair<Lines>) {
        let WheelPair { left, right } = lines;
        // Numbers, not [`Channel`]s: each is one store.
        set_pulse(0, left.a);
        set_pulse(1, left.b);
        set_pulse(2, right.a);
        set_pulse(3, right.b);
        self.lines_c.left.set(left.c);
        self.lines_c.right.set(right.c);
    }
}

/// Starts the timer with all lines low; returns its clock \[Hz\].
fn start(timer: Peri<'static, TIM1>) -> u32 {
    let timer = Timer::new(timer);
    pac::TIM1.psc().write_value(0);
    for channel in [Channel::Ch1, Channel::Ch2, Channel::Ch3, Channel::Ch4] {
        timer.set_output_compare_mode(channel, OutputCompareMode::PwmMode1);
        timer.set_output_compare_preload(channel, true);
        timer.enable_channel(channel, true);
    }
    timer.set_autoreload_preload(true);
    // No automatic restart after a break, and off means low. Locked until a reset of the chip (17.4.18).
    pac::TIM1.bdtr().write(|w| {
        w.set_bke(0, true);
        w.set_bkp(0, Bkp::ACTIVE_HIGH);
        w.set_ossi(Ossi::IDLE_LEVEL);
        w.set_lock(Lock::LEVEL1);
    });
    timer.start();
    let clock_hz = timer.get_clock_frequency().0;
    // Dropping the timer would stop it.
    core::mem::forget(timer);
    clock_hz
}

/// Lets the PWM out to the pins; while the stop line is open, the timer refuses.
fn outputs_on() {
    pac::TIM1.bdtr().modify(|w| w.set_moe(true));
}

/// Every line A and B low, and the driver disabled. Writes registers only, without a lock, so that any
/// interrupt can call it.
pub(super) fn off() {
    for channel in 0..4 {
        pac::TIM1.ccr(channel).write(|w| w.set_ccr(0));
    }
    super::set_enable_pin(DISABLED_IS_HIGH.load(Ordering::Relaxed));
}

/// The stop line, for the task that names what the timer has done already.
pub struct StopLine(Flex<'static>);

impl hal::Level for StopLine {
    /// Low stands for pressed, as with the other inputs: the line is open, or was since the last call.
    fn is_low(&self) -> bool {
        let broken = pac::TIM1.sr().read().bif(0);
        if broken {
            // The flags are cleared by writing 0; all others are written as 1, which changes nothing. The
            // timer keeps the flag while the line is open.
            let mut flags = pac::timer::regs::SrAdv(u32::MAX);
            flags.set_bif(0, false);
            pac::TIM1.sr().write_value(flags);
        }
        broken || self.0.is_high()
    }

    async fn wait_until(&self, low: bool) {
        while self.is_low() != low {
            embassy_time::Timer::after_millis(super::input::POLL_MS).await;
        }
    }
}

#[inline(always)]
fn set_pulse(channel: usize, ticks: u32) {
    pac::TIM1.ccr(channel).write(|w| w.set_ccr(ticks as u16));
}

impl LineC {
    #[inline(always)]
    fn set(&mut self, high: bool) {
        if self.high != high {
            self.high = high;
            self.pin.set_level(high.into());
        }
    }
}

impl Motors for Bridge {
    fn configure(&mut self, driver: &DriverConfig) {
        self.enabled = false;
        self.set(WheelPair::both(Lines::LOW));
        // Still the old driver's: until here nothing was known of a new one.
        off();
        DISABLED_IS_HIGH.store(driver.enable_inverted, Ordering::Relaxed);
        off();
        self.enable.set_as_output(Speed::Low);
        self.inputs = driver.name.facts().inputs;
        self.period = self.clock_hz / truncate(driver.pwm_hz, 0) as u32;
        pac::TIM1.arr().write(|w| w.set_arr((self.period - 1) as u16));
        // Loads the period at once; a timer without one does not run.
        pac::TIM1.egr().write(|w| w.set_ug(true));
    }

    fn set_duty(&mut self, duty: WheelPair<Duty>) {
        // Once the guard has switched the motors off, only a restart switches them on again.
        let lines = if self.enabled && !check_in::tripped() {
            Lines::at_both(self.inputs, duty, self.period)
        } else {
            WheelPair::both(Lines::LOW)
        };
        self.set(lines);
        check_in::alive(CheckedTask::Pid);
    }

    fn enable(&mut self, on: bool) {
        let on = on && !check_in::tripped();
        if self.enabled != on {
            self.enabled = on;
            if on {
                outputs_on();
            }
            super::set_enable_pin(on != DISABLED_IS_HIGH.load(Ordering::Relaxed));
        }
    }
}
