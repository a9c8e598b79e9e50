//! The supply voltage, through a divider and ADC1.
//!
//! Each reading returns the conversion before and starts the next one. So no task waits for the
//! converter, and a value is one control tick old.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Flex, Pin};
use embassy_stm32::pac::adc::vals::{Adcaldif, SampleTime};
use embassy_stm32::pac::adccommon::vals::Ckmode;
use embassy_stm32::pac::{ADC1 as CONVERTER, ADC12_COMMON as COMMON};
use embassy_stm32::peripherals::ADC1;
use embassy_stm32::rcc;

use crate::board::CORE_HZ;
use crate::board::divider::Divided;
pub use crate::board::divider::Divider;
use crate::hal::Supply;

/// The core's cycles in a microsecond.
const MICROSECOND: u32 = CORE_HZ / 1_000_000;

/// Reads the supply on a pin of ADC1.
pub struct DividedSupply(Divided);

impl DividedSupply {
    /// Sets the converter up for a pin, one of its channels 1 to 9, and makes the first conversion.
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
        // 42.5 MHz from the bus's 170; at most 60 (DS12288, table 66).
        COMMON.ccr().modify(|w| w.set_ckmode(Ckmode::SYNC_DIV4));
        power_on();
        // 15 us, for a source of up to 33 kohm (table 67).
        CONVERTER.smpr().write(|w| w.set_smp(channel.into(), SampleTime::CYCLES640_5));
        CONVERTER.sqr1().write(|w| w.set_sq(0, channel));
        start();
        while !CONVERTER.isr().read().eoc() {}
        let mut supply = Self(Divided::new(divider));
        supply.millivolts();
        supply
    }
}

/// Regulator, calibration, converter: in this order, each once the one before it is ready (21.4.6, 21.4.8, 21.4.9).
fn power_on() {
    CONVERTER.cr().modify(|w| w.set_deeppwd(false));
    CONVERTER.cr().modify(|w| w.set_advregen(true));
    // DS12288, table 66.
    cortex_m::asm::delay(20 * MICROSECOND);
    CONVERTER.cr().modify(|w| {
        w.set_adcaldif(Adcaldif::SINGLE_ENDED);
        w.set_adcal(true);
    });
    while CONVERTER.cr().read().adcal() {}
    // Four cycles of the converter's clock must pass before it is switched on.
    cortex_m::asm::delay(MICROSECOND);
    CONVERTER.isr().write(|w| w.set_adrdy(true));
    CONVERTER.cr().modify(|w| w.set_aden(true));
    while !CONVERTER.isr().read().adrdy() {}
}

/// Starts a conversion.
fn start() {
    CONVERTER.cr().modify(|w| w.set_adstart(true));
}

impl Supply for DividedSupply {
    #[inline(always)]
    fn millivolts(&mut self) -> u16 {
        if CONVERTER.isr().read().eoc() {
            // Reading the value clears the flag.
            self.0.take(CONVERTER.dr().read().rdata());
            start();
        }
        self.0.millivolts
    }
}
