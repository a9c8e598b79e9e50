//! The clock tree of the STM32G4 boards.

use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk,
};

use crate::board::external_clock;

/// 4 MHz x 85 / 2 = 170 MHz for the core and both buses. `divider` makes 4 MHz of the external clock; without that clock
/// the chip's own 16 MHz are divided. Above 150 MHz the core's regulator is in its boost mode (6.1.5), and the flash has
/// four wait states (3.3.3). The generator of random numbers runs on the chip's own 48 MHz.
#[inline(always)] // An image has one call of it.
pub(in crate::board) fn clocks_of_170_mhz(
    external: Hse,
    divider: PllPreDiv,
) -> embassy_stm32::Config {
    let mut config = embassy_stm32::Config::default();
    let starts = external_clock::starts(matches!(external.mode, HseMode::Bypass));
    if !starts {
        defmt::error!("the external clock does not start: times are 1 % exact");
    }
    config.rcc.hse = starts.then_some(external);
    config.rcc.pll = Some(Pll {
        source: if starts { PllSource::HSE } else { PllSource::HSI },
        prediv: if starts { divider } else { PllPreDiv::DIV4 },
        mul: PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.boost = true;
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = APBPrescaler::DIV1;
    config.rcc.apb2_pre = APBPrescaler::DIV1;
    // PB6 would have a pull-down of 5.1 kohm whenever PA9 is high, which is a PWM line (DS12288, table 12, note 6).
    config.enable_ucpd1_dead_battery = false;
    config
}
