//! The clock trees of the STM32F4 boards.

use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllQDiv, PllSource,
    Sysclk,
};

use super::external_clock;

/// What a NUCLEO board gets from its ST-LINK.
#[cfg(not(feature = "board-black-pill-f411"))]
pub(super) const FROM_ST_LINK: Hse =
    Hse { freq: embassy_stm32::time::mhz(8), mode: HseMode::Bypass };

/// How the core's clock is made: half of what the loop gives.
pub(super) struct Tree {
    /// The clock from outside.
    pub external: Hse,
    /// Divides the external clock for the loop, and the chip's own 16 MHz: both to the same frequency.
    pub dividers: (PllPreDiv, PllPreDiv),
    /// The loop's multiplier.
    pub multiplier: PllMul,
    /// The core's clock is divided by these for APB1 and APB2.
    pub buses: (APBPrescaler, APBPrescaler),
    /// Divides the loop's clock for the USB peripheral, where there is one.
    pub usb: Option<PllQDiv>,
}

/// 8 MHz / 4 x 168 / 2 = 168 MHz for the core, a quarter of it for APB1 and half of it for APB2. `usb` divides the
/// loop's 336 MHz.
#[cfg(any(feature = "board-nucleo-f429zi", feature = "board-nucleo-f446re"))]
#[inline(always)] // An image has one call of it.
pub(super) fn clocks_of_168_mhz(usb: Option<PllQDiv>) -> embassy_stm32::Config {
    clocks(&Tree {
        external: FROM_ST_LINK,
        dividers: (PllPreDiv::DIV4, PllPreDiv::DIV8),
        multiplier: PllMul::MUL168,
        buses: (APBPrescaler::DIV4, APBPrescaler::DIV2),
        usb,
    })
}

/// 1 MHz x 192 / 2 = 96 MHz for the core and APB2, half of it for APB1. `divider` makes 1 MHz of the external clock.
#[cfg(any(feature = "board-nucleo-f411re", feature = "board-black-pill-f411"))]
#[inline(always)]
pub(super) fn clocks_of_96_mhz(external: Hse, divider: PllPreDiv) -> embassy_stm32::Config {
    clocks(&Tree {
        external,
        dividers: (divider, PllPreDiv::DIV16),
        multiplier: PllMul::MUL192,
        buses: (APBPrescaler::DIV2, APBPrescaler::DIV1),
        usb: None,
    })
}

#[inline(always)]
fn clocks(tree: &Tree) -> embassy_stm32::Config {
    let mut config = embassy_stm32::Config::default();
    let external = external_clock::starts(matches!(tree.external.mode, HseMode::Bypass));
    if external {
        config.rcc.hse = Some(tree.external);
        config.rcc.pll_src = PllSource::HSE;
    } else {
        config.rcc.pll_src = PllSource::HSI;
        defmt::error!("the external clock does not start: times are 1 % exact");
    }
    config.rcc.pll = Some(Pll {
        prediv: if external { tree.dividers.0 } else { tree.dividers.1 },
        mul: tree.multiplier,
        divp: Some(PllPDiv::DIV2),
        divq: tree.usb,
        divr: None,
    });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    (config.rcc.apb1_pre, config.rcc.apb2_pre) = tree.buses;
    config
}
