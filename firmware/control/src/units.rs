//! Physical quantities in fixed point, and the control period.
//!
//! Floating point appears only where a quantity in SI units enters (configuration, commands) or
//! leaves for people (logs, tests). Everything that runs at every tick works on the raw bits.

use fixed::types::{I2F30, I8F24, I32F32, U0F64};

/// Control ticks per second.
pub const CONTROL_HZ: u32 = 1000;

/// Time between two control ticks \[us\].
pub const CONTROL_PERIOD_US: u32 = 1_000_000 / CONTROL_HZ;

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident($fixed:ty), $unit:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
        pub struct $name(pub $fixed);

        impl $name {
            #[doc = concat!("From ", $unit, ", to the nearest step; saturates at the ends of the range.")]
            ///
            /// # Panics
            /// If `value` is not a number; configurations and commands are validated before.
            pub fn from_si(value: f64) -> Self {
                Self(<$fixed>::saturating_from_num(value))
            }

            #[doc = concat!("In ", $unit, ".")]
            pub fn to_si(self) -> f64 {
                self.0.to_num()
            }
        }

        #[cfg(feature = "defmt")]
        impl defmt::Format for $name {
            fn format(&self, f: defmt::Formatter) {
                defmt::write!(f, "{=f64} {=str}", self.to_si(), $unit);
            }
        }
    };
}

quantity! {
    /// Distance that a wheel has rolled, forward positive \[m\]: to 2^31 m either way, in steps of 0.23 nm.
    Travel(I32F32), "m"
}

quantity! {
    /// Speed of a wheel, forward positive \[m/s\]: to 128 m/s in steps of 0.06 um/s.
    Speed(I8F24), "m/s"
}

quantity! {
    /// Acceleration of a wheel, forward positive \[m/s^2\]: to 128 m/s^2 in steps of 0.06 um/s^2.
    Acceleration(I8F24), "m/s^2"
}

quantity! {
    /// Distance that a wheel rolls per encoder count, Q \[m\]: below 1 m in steps of 2^-64 m.
    MetersPerCount(U0F64), "m/count"
}

quantity! {
    /// Share of the supply that a motor gets, forward positive: -1 to 1 in steps of 2^-30.
    Duty(I2F30), "of the supply"
}

impl Travel {
    /// In micrometres, as telemetry sends it.
    #[inline]
    pub fn to_um(self) -> i64 {
        // Whole metres and the fraction separately, so that no product needs more than 64 bits.
        let (whole, rest) = (self.0.to_bits() >> 32, self.0.to_bits() & 0xFFFF_FFFF);
        whole * 1_000_000 + ((rest * 1_000_000) >> 32)
    }

    /// Distance from `origin` in micrometres, saturated to 2 m either way, as telemetry sends it.
    #[inline]
    pub fn error_um_from(self, origin: Travel) -> i32 {
        ((i64::from(self.error_from(origin).to_bits()) * 1_000_000) >> 30) as i32
    }

    /// Distance from `origin` \[m\], saturated to 2 m either way in steps of 2^-30 m.
    ///
    /// Far more than any permitted following error, and narrow enough for 32-bit arithmetic. Where travel wraps, so does
    /// the setpoint: the distance between both is right there, too.
    #[inline(always)]
    pub fn error_from(self, origin: Travel) -> I2F30 {
        let way = self.0.to_bits().wrapping_sub(origin.0.to_bits());
        let metres = (way >> 32) as i32;
        // -2 to 1 whole metres.
        if (metres.wrapping_add(2) as u32) < 4 {
            I2F30::from_bits((way >> 2) as i32)
        } else if metres < 0 {
            I2F30::MIN
        } else {
            I2F30::MAX
        }
    }
}

impl MetersPerCount {
    /// In metres per count, for calculations outside the control tick.
    pub fn metres(self) -> f64 {
        const STEP_M: f64 = 1.0 / 18_446_744_073_709_551_616.0;
        // Below 2^63: Q is 0.1 m at most.
        crate::soft_float::to_f64(self.0.to_bits() as i64) * STEP_M
    }
}

impl Speed {
    /// In micrometres per second, as telemetry sends it.
    #[inline]
    pub fn to_um_s(self) -> i32 {
        ((i64::from(self.0.to_bits()) * 1_000_000) >> 24) as i32
    }
}

impl Duty {
    /// Zero duty.
    pub const ZERO: Duty = Duty(I2F30::ZERO);

    /// In 1/32767, as telemetry sends it.
    pub fn to_i16(self) -> i16 {
        duty_bits_to_i16(i64::from(self.0.to_bits()))
    }
}

/// A duty in steps of 2^-30, however large, in 1/32767; saturates.
#[inline]
pub(crate) fn duty_bits_to_i16(bits: i64) -> i16 {
    let one = 1 << 30;
    ((bits.clamp(-one, one) * 32767 + (1 << 29)) >> 30) as i16
}

/// The nearest `i32`.
#[inline(always)]
pub(crate) fn saturate_i32(wide: i64) -> i32 {
    let narrow = wide as i32;
    if i64::from(narrow) == wide {
        narrow
    } else if wide < 0 {
        i32::MIN
    } else {
        i32::MAX
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_saturate_instead_of_wrapping() {
        assert_eq!(Speed::from_si(1e9).0, I8F24::MAX);
        assert_eq!(Speed::from_si(-1e9).0, I8F24::MIN);
        let far = Travel::from_si(1e9);
        assert_eq!(far.error_from(Travel::from_si(-1e9)), I2F30::MAX);
        assert_eq!(Travel::from_si(-1e9).error_from(far), I2F30::MIN);
        for (m, error) in [(1.75, 1.75), (2.0, 2.0), (-2.0, -2.0), (-2.25, -2.0), (2.25, 2.0)] {
            let error = I2F30::saturating_from_num(error);
            assert_eq!(Travel::from_si(m).error_from(Travel::from_si(0.0)), error, "{m}");
        }
    }

    #[test]
    fn an_error_is_right_where_travel_wraps() {
        let (last, first) = (Travel(I32F32::MAX), Travel(I32F32::MIN + I32F32::from_num(0.5)));
        assert_eq!(first.error_from(last), I2F30::from_num(0.5));
        assert_eq!(last.error_from(first), I2F30::from_num(-0.5) - I2F30::DELTA);
    }

    #[test]
    fn telemetry_units_come_out_to_the_last_digit() {
        assert_eq!(Travel::from_si(-1.25).to_um(), -1_250_000);
        assert_eq!(Speed::from_si(0.5).to_um_s(), 500_000);
        assert_eq!(Duty::from_si(1.0).to_i16(), 32767);
        assert_eq!(Duty::from_si(-1.0).to_i16(), -32767);
        assert_eq!(duty_bits_to_i16(i64::MAX), 32767);
    }
}
