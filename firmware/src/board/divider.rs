//! From a sample of the converter to the supply behind two resistors.

/// The converter's reference: the board's 3.3 V.
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

/// The supply as it was sampled last.
pub(super) struct Divided {
    /// At full scale \[mV\].
    full_scale_mv: u32,
    /// The last sample's.
    pub(super) millivolts: u16,
}

impl Divided {
    /// No sample yet.
    pub(super) fn new(Divider { upper_ohm, lower_ohm }: Divider) -> Self {
        let full_scale_mv = REFERENCE_MV * (upper_ohm + lower_ohm) / lower_ohm;
        Self { full_scale_mv, millivolts: 0 }
    }

    /// Takes a sample.
    #[inline(always)]
    pub(super) fn take(&mut self, sample: u16) {
        self.millivolts = (u32::from(sample) * self.full_scale_mv / FULL_SCALE) as u16;
    }
}
