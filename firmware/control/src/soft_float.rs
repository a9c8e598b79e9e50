//! Small double-precision routines for a core without double-precision hardware.
//!
//! Configurations and commands are in `f64`, and motions are planned in `f64`. Each of the compiler's own
//! conversions to integers takes a hundred bytes, and `core` has no square root.

pub use shared_proto::is_above;

/// A value in steps of 2^-bits, towards zero; saturates.
#[inline]
pub fn truncate(value: f64, bits: u32) -> i64 {
    steps(value, bits, 0)
}

/// A value in steps of 2^-bits, to the nearest, halves away from zero; saturates.
#[inline]
pub fn nearest(value: f64, bits: u32) -> i64 {
    steps(value, bits, 1)
}

/// Rounds towards zero after adding `half` a step. NaN counts as infinite.
#[inline(never)]
fn steps(value: f64, bits: u32, half: u64) -> i64 {
    const MANTISSA_BITS: u32 = 52;
    let raw = value.to_bits();
    let negative = value.is_sign_negative();
    let mantissa = (raw & ((1 << MANTISSA_BITS) - 1)) | (1 << MANTISSA_BITS);
    // The mantissa as a whole number times 2^shift is the value in steps.
    let shift = ((raw >> MANTISSA_BITS) & 0x7FF) as i32 - 1075 + bits as i32;
    let magnitude = if shift > 10 {
        return if negative { i64::MIN } else { i64::MAX };
    } else if shift >= 0 {
        mantissa << shift
    } else if shift >= -53 {
        ((mantissa >> (-shift - 1)) + half) >> 1
    } else {
        0
    } as i64;
    if negative { -magnitude } else { magnitude }
}

/// An integer as `f64`, rounded if it has more than 53 bits.
#[inline(never)]
pub fn to_f64(whole: i64) -> f64 {
    whole as f64
}

/// The larger one.
#[inline(never)]
pub fn max(a: f64, b: f64) -> f64 {
    if is_above(a, b) { a } else { b }
}

/// The smaller one.
#[inline(never)]
pub fn min(a: f64, b: f64) -> f64 {
    if is_above(b, a) { a } else { b }
}

/// The square root, to the last bit or the one before; 0 of what is not above 2^-1022.
#[inline]
pub fn sqrt(value: f64) -> f64 {
    // Halving the exponent gives 6 % accuracy, and each Newton step doubles the digits.
    const HALF_THE_BIAS: u64 = 1023 << 51;
    if value.is_sign_positive() && value.is_normal() {
        let mut root = f64::from_bits((value.to_bits() >> 1) + HALF_THE_BIAS);
        for _ in 0..5 {
            root = 0.5 * (root + value / root);
        }
        root
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_step_is_the_librarys() {
        use fixed::types::{I2F30, I3F61, I8F24};
        for value in [0.0, 0.3, -0.3, 2.5e-4, 1e-6, 0.1, 1.25, -1.5, 1.999_999_999, 0.000_251_327] {
            assert_eq!(nearest(value, 30), i64::from(I2F30::saturating_from_num(value).to_bits()));
            let [wide, narrow] = [61, 24].map(|bits| nearest(value, bits));
            assert_eq!(wide, I3F61::saturating_from_num(value).to_bits());
            assert_eq!(narrow, i64::from(I8F24::saturating_from_num(value).to_bits()));
        }
        assert_eq!((nearest(1e30, 30), nearest(-1e30, 30)), (i64::MAX, i64::MIN));
        assert_eq!([0.25, 0.5, -0.5, 0.75, 1.5].map(|v| nearest(v, 0)), [0, 1, -1, 1, 2]);
        // The largest double below a half is not a half.
        assert_eq!(nearest(0.5f64.next_down(), 0), 0);
    }

    #[test]
    fn whole_steps_are_the_languages() {
        let powers = (-70..70).map(|exponent| 2f64.powi(exponent));
        for value in powers.flat_map(|p| [p, 1.7 * p, p.next_down(), p.next_up(), -1.1 * p]) {
            assert_eq!(truncate(value, 0), value as i64, "{value}");
            let scaled = value * 18_446_744_073_709_551_616.0;
            assert_eq!(truncate(value, 64), scaled as i64, "{value}");
        }
        assert_eq!([0.0, -0.0, f64::MIN_POSITIVE].map(|v| truncate(v, 64)), [0; 3]);
    }

    #[test]
    fn the_root_is_the_librarys_or_its_neighbour() {
        let powers = (-900..900).map(|exponent| 2f64.powi(exponent));
        for value in powers.flat_map(|p| [p, 1.3 * p, 1.999 * p, p.next_down()]) {
            let root = value.sqrt();
            assert!((root.next_down()..=root.next_up()).contains(&sqrt(value)), "{value}");
        }
        assert_eq!([0.0, -1.0, f64::NAN].map(sqrt), [0.0; 3]);
    }
}
