//! A two-channel H-bridge: 20 kHz PWM on TIM1, two lines a wheel, one enable for both.
//!
//! ```text
//! mode             line A          line B            both lines low
//! sign-magnitude   PWM  |duty|     level: direction  the motor brakes
//! IN1/IN2          PWM  forward    PWM  backward     the motor coasts between the pulses
//! ```
//!
//! Both modes use the same pins. The driver's data sheet says which mode it needs.
//!
//! The stop line is TIM1's break input: while the line is open, the timer itself holds every PWM line low,
//! whatever the program does (RM0090, 17.3.12). The line is high when open, so a cut wire stops the robot. The
//! outputs stay off until the motors are enabled anew, which takes a reset of the fault and an arming.
//! A debugger's halt has the same effect ([`super::power_on`]).

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, Flex, Level, Output, OutputType, Pin, Pull, Speed};
use embassy_stm32::pac;
use embassy_stm32::pac::timer::vals::{Bkp, Lock, Ossi};
use embassy_stm32::peripherals::TIM1;
use embassy_stm32::timer::low_level::{OutputCompareMode, Timer};
use embassy_stm32::timer::simple_pwm::PwmPin;
use embassy_stm32::timer::{BkIn1, BreakInputPin, Ch1, Ch2, Ch3, Ch4, Channel, TimerPin};
use shared_proto::WheelPair;

use super::guard;
use crate::hal::{self, Motors};
use crate::units::Duty;

/// Above the audible range, within what common drivers can switch.
const PWM_KHZ: u32 = 20;

/// The second line of one wheel.
enum LineB {
    Direction(Output<'static>),
    Pwm(Channel),
}

/// The lines of one wheel.
struct Wheel {
    a: Channel,
    b: LineB,
    /// The direction line's present level.
    backward: bool,
}

/// The lines of both wheels and their enable.
pub struct Bridge {
    wheels: WheelPair<Wheel>,
    enable: Output<'static>,
    enabled: bool,
    /// Timer ticks of a whole period.
    period: u32,
}

/// The left wheel's lines are TIM1's channels 1 and 2, the right wheel's 3 and 4.
pub struct Pins<A1, A2, A3, A4, E, S>
where
    A1: TimerPin<TIM1, Ch1>,
    A2: TimerPin<TIM1, Ch2> + Pin,
    A3: TimerPin<TIM1, Ch3>,
    A4: TimerPin<TIM1, Ch4> + Pin,
    E: Pin,
    S: BreakInputPin<TIM1, BkIn1> + Pin,
{
    /// The left wheel's line A.
    pub left_a: Peri<'static, A1>,
    /// The left wheel's line B.
    pub left_b: Peri<'static, A2>,
    /// The right wheel's line A.
    pub right_a: Peri<'static, A3>,
    /// The right wheel's line B.
    pub right_b: Peri<'static, A4>,
    /// The driver's enable, active high. Add a pull-down: during a reset every pin floats.
    pub enable: Peri<'static, E>,
    /// The stop line: a switch to ground that opens when pressed. Pulled up.
    pub stop: Peri<'static, S>,
}

/// What the driver's data sheet asks of the two lines of a wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// A PWM line and a direction line.
    SignMagnitude,
    /// A PWM line for each direction.
    In1In2,
}

impl Bridge {
    /// Both motors stand still and the driver is disabled.
    // Inlined, so that an image holds one mode only.
    #[inline(always)]
    pub fn new<A1, A2, A3, A4, E, S>(
        timer: Peri<'static, TIM1>,
        pins: Pins<A1, A2, A3, A4, E, S>,
        mode: Mode,
    ) -> (Self, StopLine)
    where
        A1: TimerPin<TIM1, Ch1>,
        A2: TimerPin<TIM1, Ch2> + Pin,
        A3: TimerPin<TIM1, Ch3>,
        A4: TimerPin<TIM1, Ch4> + Pin,
        E: Pin,
        S: BreakInputPin<TIM1, BkIn1> + Pin,
    {
        let function = AfType::input(Pull::Up);
        let number = pins.stop.af_num();
        let mut stop = Flex::new(pins.stop);
        stop.set_as_af_unchecked(number, function);
        let enable = Output::new(pins.enable, Level::Low, Speed::Low);
        // Dropping the pins would reconfigure them.
        core::mem::forget(PwmPin::new(pins.left_a, OutputType::PushPull));
        core::mem::forget(PwmPin::new(pins.right_a, OutputType::PushPull));
        let (left_b, right_b) = match mode {
            Mode::SignMagnitude => (
                LineB::Direction(Output::new(pins.left_b, Level::Low, Speed::Low)),
                LineB::Direction(Output::new(pins.right_b, Level::Low, Speed::Low)),
            ),
            Mode::In1In2 => {
                core::mem::forget(PwmPin::new(pins.left_b, OutputType::PushPull));
                core::mem::forget(PwmPin::new(pins.right_b, OutputType::PushPull));
                (LineB::Pwm(Channel::Ch2), LineB::Pwm(Channel::Ch4))
            }
        };
        let wheels = WheelPair {
            left: Wheel { a: Channel::Ch1, b: left_b, backward: false },
            right: Wheel { a: Channel::Ch3, b: right_b, backward: false },
        };
        let channels: &[Channel] = match mode {
            Mode::SignMagnitude => &[Channel::Ch1, Channel::Ch3],
            Mode::In1In2 => &[Channel::Ch1, Channel::Ch2, Channel::Ch3, Channel::Ch4],
        };
        let bridge = Self { wheels, enable, enabled: false, period: start(timer, channels) };
        (bridge, StopLine(stop))
    }
}

/// Starts the PWM with zero duty; returns the timer ticks of a whole period.
fn start(timer: Peri<'static, TIM1>, channels: &[Channel]) -> u32 {
    let timer = Timer::new(timer);
    let period = timer.get_clock_frequency().0 / (1000 * PWM_KHZ);
    pac::TIM1.psc().write_value(0);
    pac::TIM1.arr().write(|w| w.set_arr((period - 1) as u16));
    for &channel in channels {
        timer.set_output_compare_mode(channel, OutputCompareMode::PwmMode1);
        timer.set_output_compare_preload(channel, true);
        timer.enable_channel(channel, true);
    }
    timer.set_autoreload_preload(true);
    timer.generate_update_event();
    // No automatic restart after a break, and off means low. Locked until a reset of the chip (17.4.18).
    pac::TIM1.bdtr().write(|w| {
        w.set_bke(0, true);
        w.set_bkp(0, Bkp::ACTIVE_HIGH);
        w.set_ossi(Ossi::IDLE_LEVEL);
        w.set_lock(Lock::LEVEL1);
    });
    timer.start();
    // Dropping the timer would stop it.
    core::mem::forget(timer);
    period
}

/// Lets the PWM out to the pins; while the stop line is open, the timer refuses.
fn outputs_on() {
    pac::TIM1.bdtr().modify(|w| w.set_moe(true));
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

fn set_pulse(channel: Channel, ticks: u32) {
    pac::TIM1.ccr(channel.index()).write(|w| w.set_ccr(ticks as u16));
}

impl Wheel {
    #[inline(always)]
    fn set(&mut self, Duty(duty): Duty, period: u32) {
        let bits = duty.to_bits();
        // Steps of 2^-30 to timer ticks, to the nearest; a duty is 1 at most.
        let pulse = (u64::from(bits.unsigned_abs()) * u64::from(period) + (1 << 29)) >> 30;
        let pulse = (pulse as u32).min(period);
        let backward = bits < 0;
        match &mut self.b {
            LineB::Direction(pin) => {
                if self.backward != backward {
                    self.backward = backward;
                    pin.set_level(if backward { Level::High } else { Level::Low });
                }
                set_pulse(self.a, pulse);
            }
            LineB::Pwm(b) => {
                set_pulse(self.a, if backward { 0 } else { pulse });
                set_pulse(*b, if backward { pulse } else { 0 });
            }
        }
    }
}

impl Motors for Bridge {
    fn set_duty(&mut self, duty: WheelPair<Duty>) {
        // Once the guard has switched the motors off, only a restart switches them on again.
        let duty = if guard::tripped() { WheelPair::both(Duty::ZERO) } else { duty };
        self.wheels.left.set(duty.left, self.period);
        self.wheels.right.set(duty.right, self.period);
        guard::alive(guard::Part::Pid);
    }

    fn enable(&mut self, on: bool) {
        let on = on && !guard::tripped();
        if self.enabled != on {
            self.enabled = on;
            if on {
                outputs_on();
            }
            self.enable.set_level(if on { Level::High } else { Level::Low });
        }
    }
}
