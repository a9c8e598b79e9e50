//! The supply voltage, through a divider and ADC1.
//!
//! Each reading returns the conversion before and starts the next one. So no task waits for the
//! converter, and a value is one control tick old.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Flex, Pin};
use embassy_stm32::pac;
use embassy_stm32::pac::adc::vals::SampleTime;
use embassy_stm32::pac::adccommon::vals::Adcpre;
use embassy_stm32::peripherals::ADC1;
use embassy_stm32::rcc;

use super::divider::Divided;
pub use super::divider::Divider;
use crate::hal::Supply;

#[cfg(any(feature = "board-nucleo-f411re", feature = "board-black-pill-f411"))]
use pac::ADC1_COMMON as COMMON;
#[cfg(any(feature = "board-nucleo-f429zi", feature = "board-nucleo-f446re"))]
use pac::ADC123_COMMON as COMMON;

/// Reads the supply on a pin of ADC1.
pub struct DividedSupply(Divided);

impl DividedSupply {
    /// Sets the converter up for a pin, one of its channels 0 to 9, and makes the first conversion.
    ///
    /// The driver uses the registers directly: it needs only these few.
    pub fn new(
        _: Peri<'static, ADC1>,
        pin: Peri<'static, impl Pin>,
        channel: u8,
        divider: Divider,
    ) -> Self {
        let mut pin = Flex::new(pin);
        pin.set_as_analog();
        core::mem::forget(pin);
        rcc::enable_and_reset::<ADC1>();
        let adc = pac::ADC1;
        // 21 MHz from the bus's 84, or 24 from 96; at most 36.
        COMMON.ccr().modify(|w| w.set_adcpre(Adcpre::DIV4));
        adc.smpr2().write(|w| w.set_smp(channel.into(), SampleTime::CYCLES480));
        adc.sqr3().write(|w| w.set_sq(0, channel));
        adc.cr2().write(|w| w.set_adon(true));
        // The converter is stable after 3 us.
        cortex_m::asm::delay(3 * (super::CORE_HZ / 1_000_000));
        adc.cr2().modify(|w| w.set_swstart(true));
        while !adc.sr().read().eoc() {}
        let mut supply = Self(Divided::new(divider));
        supply.millivolts();
        supply
    }
}

impl Supply for DividedSupply {
    #[inline(always)]
    fn millivolts(&mut self) -> u16 {
        if pac::ADC1.sr().read().eoc() {
            self.0.take(pac::ADC1.dr().read().data());
            pac::ADC1.cr2().modify(|w| w.set_swstart(true));
        }
        self.0.millivolts
    }
}
