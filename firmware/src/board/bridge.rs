//! A two-channel H-bridge: 20 kHz PWM on TIM1, two lines a wheel, one enable for both.
//!
//! ```text
//! mode             line A          line B            both lines low
//! sign-magnitude   PWM  |duty|     level: direction  the motor brakes
//! IN1/IN2          PWM  forward    PWM  backward     the motor coasts between the pulses
//! ```
//!
//! Both modes use the same pins: which one, the driver board's data sheet says.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, OutputType, Pin, Speed};
use embassy_stm32::peripherals::TIM1;
use embassy_stm32::time::khz;
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm, SimplePwmChannel};
use embassy_stm32::timer::{Ch1, Ch2, Ch3, Ch4, TimerPin};
use shared_proto::WheelPair;

use super::guard;
use crate::hal::Motors;
use crate::units::Duty;

/// Above what people hear, below what a common driver can switch.
const PWM_KHZ: u32 = 20;

/// The second line of one wheel.
enum LineB {
    Direction(Output<'static>),
    Pwm(SimplePwmChannel<'static, TIM1>),
}

/// The lines of one wheel.
struct Wheel {
    a: SimplePwmChannel<'static, TIM1>,
    b: LineB,
}

/// The lines of both wheels and their enable.
pub struct Bridge {
    wheels: WheelPair<Wheel>,
    enable: Output<'static>,
    /// Timer ticks of a whole period.
    period: u32,
}

/// The left wheel's lines are TIM1's channels 1 and 2, the right wheel's 3 and 4.
pub struct Pins<A1, A2, A3, A4, E>
where
    A1: TimerPin<TIM1, Ch1>,
    A2: TimerPin<TIM1, Ch2> + Pin,
    A3: TimerPin<TIM1, Ch3>,
    A4: TimerPin<TIM1, Ch4> + Pin,
    E: Pin,
{
    /// The left wheel's line A.
    pub left_a: Peri<'static, A1>,
    /// The left wheel's line B.
    pub left_b: Peri<'static, A2>,
    /// The right wheel's line A.
    pub right_a: Peri<'static, A3>,
    /// The right wheel's line B.
    pub right_b: Peri<'static, A4>,
    /// The driver's enable, active high. Give it a pull-down: at a reset every pin floats.
    pub enable: Peri<'static, E>,
}

impl Bridge {
    /// A PWM line and a direction line for each wheel.
    pub fn sign_magnitude<A1, A2, A3, A4, E>(
        timer: Peri<'static, TIM1>,
        pins: Pins<A1, A2, A3, A4, E>,
    ) -> Self
    where
        A1: TimerPin<TIM1, Ch1>,
        A2: TimerPin<TIM1, Ch2> + Pin,
        A3: TimerPin<TIM1, Ch3>,
        A4: TimerPin<TIM1, Ch4> + Pin,
        E: Pin,
    {
        let enable = Output::new(pins.enable, Level::Low, Speed::Low);
        let pwm = SimplePwm::new(
            timer,
            Some(PwmPin::new(pins.left_a, OutputType::PushPull)),
            None,
            Some(PwmPin::new(pins.right_a, OutputType::PushPull)),
            None,
            khz(PWM_KHZ),
            CountingMode::EdgeAlignedUp,
        );
        let period = pwm.max_duty_cycle();
        let channels = pwm.split();
        let mut wheels = WheelPair {
            left: Wheel {
                a: channels.ch1,
                b: LineB::Direction(Output::new(pins.left_b, Level::Low, Speed::Low)),
            },
            right: Wheel {
                a: channels.ch3,
                b: LineB::Direction(Output::new(pins.right_b, Level::Low, Speed::Low)),
            },
        };
        wheels.left.a.enable();
        wheels.right.a.enable();
        Self { wheels, enable, period }
    }

    /// A PWM line for each direction of each wheel.
    pub fn in1_in2<A1, A2, A3, A4, E>(
        timer: Peri<'static, TIM1>,
        pins: Pins<A1, A2, A3, A4, E>,
    ) -> Self
    where
        A1: TimerPin<TIM1, Ch1>,
        A2: TimerPin<TIM1, Ch2> + Pin,
        A3: TimerPin<TIM1, Ch3>,
        A4: TimerPin<TIM1, Ch4> + Pin,
        E: Pin,
    {
        let enable = Output::new(pins.enable, Level::Low, Speed::Low);
        let pwm = SimplePwm::new(
            timer,
            Some(PwmPin::new(pins.left_a, OutputType::PushPull)),
            Some(PwmPin::new(pins.left_b, OutputType::PushPull)),
            Some(PwmPin::new(pins.right_a, OutputType::PushPull)),
            Some(PwmPin::new(pins.right_b, OutputType::PushPull)),
            khz(PWM_KHZ),
            CountingMode::EdgeAlignedUp,
        );
        let period = pwm.max_duty_cycle();
        let channels = pwm.split();
        let pair = |mut a: SimplePwmChannel<'static, TIM1>,
                    mut b: SimplePwmChannel<'static, TIM1>| {
            a.enable();
            b.enable();
            Wheel { a, b: LineB::Pwm(b) }
        };
        let wheels = WheelPair {
            left: pair(channels.ch1, channels.ch2),
            right: pair(channels.ch3, channels.ch4),
        };
        Self { wheels, enable, period }
    }
}

impl Wheel {
    fn set(&mut self, Duty(duty): Duty, period: u32) {
        let bits = duty.to_bits();
        // Steps of 2^-30 to timer ticks, to the nearest; a duty is 1 at most.
        let pulse = (u64::from(bits.unsigned_abs()) * u64::from(period) + (1 << 29)) >> 30;
        let pulse = (pulse as u32).min(period);
        let backward = bits < 0;
        match &mut self.b {
            LineB::Direction(pin) => {
                pin.set_level(if backward { Level::High } else { Level::Low });
                self.a.set_duty_cycle(pulse);
            }
            LineB::Pwm(b) => {
                self.a.set_duty_cycle(if backward { 0 } else { pulse });
                b.set_duty_cycle(if backward { pulse } else { 0 });
            }
        }
    }
}

impl Motors for Bridge {
    fn set_duty(&mut self, duty: WheelPair<Duty>) {
        // Once the guard has switched off, nothing but a restart switches on again.
        let duty = if guard::tripped() { WheelPair::both(Duty::ZERO) } else { duty };
        self.wheels.left.set(duty.left, self.period);
        self.wheels.right.set(duty.right, self.period);
        guard::alive(guard::Part::Pid);
    }

    fn enable(&mut self, on: bool) {
        self.enable.set_level(if on && !guard::tripped() { Level::High } else { Level::Low });
    }
}
