//! The clocks of an STM32F4 on a NUCLEO board, which gets 8 MHz from its ST-LINK.

use embassy_stm32::pac::RCC;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllQDiv, PllSource,
    Sysclk,
};
use embassy_stm32::time::mhz;

/// Turns of a loop of four to ten cycles at 16 MHz: 4 to 9 ms. A crystal takes 2, and the watchdog waits for 21.
const CRYSTAL_TURNS_MAX: u32 = 15_000;

/// 8 MHz / 4 x 168 / 2 = 168 MHz for the core, a quarter of it for APB1 and half of it for APB2. `usb` divides the
/// loop's 336 MHz for the USB peripheral, where there is one.
#[inline(always)] // An image has one call of it.
pub(super) fn clocks_of_168_mhz(usb: Option<PllQDiv>) -> embassy_stm32::Config {
    let mut config = embassy_stm32::Config::default();
    let external = external_clock_starts(true);
    if external {
        config.rcc.hse = Some(Hse { freq: mhz(8), mode: HseMode::Bypass });
        config.rcc.pll_src = PllSource::HSE;
    } else {
        config.rcc.pll_src = PllSource::HSI;
        defmt::error!("the external clock does not start: times are 1 % exact");
    }
    config.rcc.pll = Some(Pll {
        prediv: if external { PllPreDiv::DIV4 } else { PllPreDiv::DIV8 },
        mul: PllMul::MUL168,
        divp: Some(PllPDiv::DIV2),
        divq: usb,
        divr: None,
    });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = APBPrescaler::DIV4;
    config.rcc.apb2_pre = APBPrescaler::DIV2;
    config
}

/// Whether the external clock starts. Without it the chip runs from its own oscillator, 1 % exact: times
/// and speeds are off by that much, distances are not.
fn external_clock_starts(bypass: bool) -> bool {
    RCC.cr().modify(|w| w.set_hsebyp(bypass));
    RCC.cr().modify(|w| w.set_hseon(true));
    (0..CRYSTAL_TURNS_MAX).any(|_| RCC.cr().read().hserdy())
}
