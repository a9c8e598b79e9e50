//! Both wheels' encoders: two timers in encoder mode, four counts for each line of the disc.

use embassy_stm32::Peri;
use embassy_stm32::gpio::Pull;
use embassy_stm32::peripherals::{TIM3, TIM4};
use embassy_stm32::timer::qei::{Config, Qei};
use embassy_stm32::timer::{Ch1, Ch2, TimerPin};
use shared_proto::WheelPair;

use crate::encoder::Extender;
use crate::hal::Encoders;

/// Left on TIM3, right on TIM4. Their 16-bit counters are extended to 64 bits here.
pub struct TimerEncoders {
    left: Qei<'static, TIM3>,
    right: Qei<'static, TIM4>,
    extenders: WheelPair<Extender>,
}

impl TimerEncoders {
    /// Starts both timers. Pulled up: most encoders' outputs are open collectors.
    pub fn new(
        left: (
            Peri<'static, TIM3>,
            Peri<'static, impl TimerPin<TIM3, Ch1>>,
            Peri<'static, impl TimerPin<TIM3, Ch2>>,
        ),
        right: (
            Peri<'static, TIM4>,
            Peri<'static, impl TimerPin<TIM4, Ch1>>,
            Peri<'static, impl TimerPin<TIM4, Ch2>>,
        ),
    ) -> Self {
        let config = Config { ch1_pull: Pull::Up, ch2_pull: Pull::Up, ..Config::default() };
        let left = Qei::new(left.0, left.1, left.2, config);
        let right = Qei::new(right.0, right.1, right.2, config);
        let hardware = WheelPair { left: left.count(), right: right.count() };
        // Capture applies the configured signs.
        Self { left, right, extenders: hardware.map(Extender::new) }
    }
}

impl Encoders for TimerEncoders {
    fn counts(&mut self) -> WheelPair<i64> {
        let hardware = WheelPair { left: self.left.count(), right: self.right.count() };
        super::guard::alive(super::guard::Part::Capture);
        self.extenders.as_mut().zip(hardware).map(|(extender, count)| extender.extend(count))
    }
}
