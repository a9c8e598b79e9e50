//! The supply voltage, by way of a divider and the first converter.
//!
//! A conversion is started at every look and read at the next one, so that nobody waits for it: a
//! value is one control tick old.

use embassy_stm32::Peri;
use embassy_stm32::adc::{Adc, AdcChannel};
use embassy_stm32::pac;
use embassy_stm32::peripherals::ADC1;

use crate::hal::Supply;

/// The converter's reference is the board's 3.3 V.
const REFERENCE_MV: u32 = 3300;

/// Twelve bits.
const FULL_SCALE: u32 = 4095;

/// The resistors between supply, pin and ground.
#[derive(Clone, Copy)]
pub struct Divider {
    /// From the supply to the pin \[ohm\].
    pub upper_ohm: u32,
    /// From the pin to ground \[ohm\].
    pub lower_ohm: u32,
}

/// Reads the supply on a pin of ADC1.
pub struct DividedSupply {
    /// The supply at full scale \[mV\].
    full_scale_mv: u32,
    millivolts: u16,
}

impl DividedSupply {
    /// Sets the converter up and makes the first conversion.
    pub fn new<'d>(
        adc: Peri<'static, ADC1>,
        pin: impl AdcChannel<ADC1> + 'd,
        divider: Divider,
    ) -> Self {
        let mut adc = Adc::new(adc);
        let mut channel = pin.degrade_adc();
        // Configures sequence and sampling time; what follows starts the same conversion again.
        let sample = adc.blocking_read(&mut channel, embassy_stm32::adc::SampleTime::CYCLES480);
        core::mem::forget(adc);
        let Divider { upper_ohm, lower_ohm } = divider;
        let full_scale_mv = REFERENCE_MV * (upper_ohm + lower_ohm) / lower_ohm;
        let mut supply = Self { full_scale_mv, millivolts: 0 };
        supply.take(sample);
        pac::ADC1.cr2().modify(|w| {
            w.set_adon(true);
            w.set_swstart(true);
        });
        supply
    }

    fn take(&mut self, sample: u16) {
        self.millivolts = (u32::from(sample) * self.full_scale_mv / FULL_SCALE) as u16;
    }
}

impl Supply for DividedSupply {
    fn millivolts(&mut self) -> u16 {
        if pac::ADC1.sr().read().eoc() {
            self.take(pac::ADC1.dr().read().data());
            pac::ADC1.cr2().modify(|w| w.set_swstart(true));
        }
        self.millivolts
    }
}
