//! Both wheels' encoders: two timers in encoder mode, four counts for each line of the disc.

use embassy_stm32::Peri;
use embassy_stm32::gpio::Pull;
use embassy_stm32::pac::TIM3 as LEFT;
use embassy_stm32::pac::TIM4 as RIGHT;
use embassy_stm32::pac::timer::vals::FilterValue;
use embassy_stm32::peripherals::{TIM3, TIM4};
use embassy_stm32::timer::qei::{Config, Qei};
use embassy_stm32::timer::{Ch1, Ch2, TimerPin};
use shared_proto::WheelPair;

use crate::encoder::CounterExtender;
use crate::hal::Encoders;

/// Eight samples in a row, one each 32 cycles of the timer's 84 to 96 MHz, must agree: a level counts after 3 us, and
/// what the motors' leads induce on the encoders' does not (RM0090, 18.4.7). At 160,000 counts a second edges
/// are twice as far apart. On a G4 the filters have half of the timer's 170 MHz (RM0440, 30.5.1).
const FILTER: FilterValue = FilterValue::FDTS_DIV32_N8;

/// Left on TIM3, right on TIM4. Their 16-bit counters are extended to 64 bits here.
pub struct TimerEncoders {
    left: Qei<'static, TIM3>,
    right: Qei<'static, TIM4>,
    extenders: WheelPair<CounterExtender>,
}

impl TimerEncoders {
    /// Starts both timers.
    ///
    /// Pins without pull-ups bear an encoder of 5 V; with one a pin must stay below 3.6 V (the data sheet's
    /// table of general operating conditions). An open collector needs a resistor to 3.3 V of its own.
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
        let config = Config { ch1_pull: Pull::None, ch2_pull: Pull::None, ..Config::default() };
        let left = Qei::new(left.0, left.1, left.2, config);
        let right = Qei::new(right.0, right.1, right.2, config);
        for timer in [LEFT, RIGHT] {
            #[cfg(feature = "board-nucleo-g474re")]
            timer.cr1().modify(|w| w.set_ckd(embassy_stm32::pac::timer::vals::Ckd::DIV2));
            timer.ccmr_input(0).modify(|w| {
                w.set_icf(0, FILTER);
                w.set_icf(1, FILTER);
            });
        }
        let hardware = WheelPair { left: left.count(), right: right.count() };
        // Capture applies the configured signs.
        Self { left, right, extenders: hardware.map(CounterExtender::new) }
    }
}

impl Encoders for TimerEncoders {
    fn counts(&mut self) -> WheelPair<i64> {
        let hardware = WheelPair { left: self.left.count(), right: self.right.count() };
        super::check_in::alive(super::check_in::CheckedTask::Capture);
        self.extenders.as_mut().zip(hardware).map(|(extender, count)| extender.extend(count))
    }
}
