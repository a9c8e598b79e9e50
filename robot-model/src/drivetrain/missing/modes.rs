//! What is left, in two modes: what both wheels share, and what sets them apart.
//!
//! ```text
//! common = (L + R) / sqrt 2,   differential = (L - R) / sqrt 2        L^2 + R^2 = common^2 + differential^2     (1)
//! ```
//!
//! A caster that swings round, or a bump under one wheel, turns the robot more than it holds it back: the differential mode is
//! noisier. So each mode has its own variance, which is that of the model at hand, and counts by its inverse.

use nalgebra::{DMatrix, DVector};

/// One number for each mode.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Modes {
    pub common: f64,
    pub differential: f64,
}

impl Modes {
    /// Both alike.
    pub const EQUAL: Self = Self { common: 1.0, differential: 1.0 };

    /// One number for both.
    pub fn both(value: f64) -> Self {
        Self { common: value, differential: value }
    }

    /// Mode by mode.
    pub fn zip(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            common: of(self.common, other.common),
            differential: of(self.differential, other.differential),
        }
    }

    /// The sum of both.
    pub fn sum(self) -> f64 {
        self.common + self.differential
    }

    /// The sums of the squares in a vector of alternately common and differential numbers.
    pub fn squares(of: &DVector<f64>) -> Self {
        let mut squares = Self::default();
        for pair in of.as_slice().chunks_exact(2) {
            squares.common += pair[0] * pair[0];
            squares.differential += pair[1] * pair[1];
        }
        squares
    }

    /// Both wheels' numbers in modes (1), each times the root of its weight.
    pub fn weighted(self, left: f64, right: f64) -> [f64; 2] {
        [
            (0.5 * self.common).sqrt() * (left + right),
            (0.5 * self.differential).sqrt() * (left - right),
        ]
    }

    /// A matrix whose rows are alternately of the common and of the differential mode, each times its number.
    pub fn times(self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(rows.nrows(), rows.ncols(), |row, column| {
            rows[(row, column)] * if row % 2 == 0 { self.common } else { self.differential }
        })
    }

    /// Weights by the inverse of these variances, 1 for the quieter mode. Neither mode is quieter than `floor`.
    pub fn inverse(self, floor: f64) -> Self {
        let variance = self.zip(Self::both(floor), f64::max);
        let least = variance.common.min(variance.differential);
        if least > 0.0 && variance.sum().is_finite() {
            Self::both(least).zip(variance, |least, variance| least / variance)
        } else {
            Self::EQUAL
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_modes_keep_the_sum_of_squares_and_the_noisier_one_counts_less() {
        let both = DVector::from_row_slice(&Modes::EQUAL.weighted(0.3, -0.1));
        assert!((Modes::squares(&both).sum() - 0.1).abs() < 1e-12, "{both}");
        let weights = Modes { common: 1.0, differential: 4.0 }.inverse(0.5);
        assert_eq!(weights, Modes { common: 1.0, differential: 0.25 });
        let squares = Modes::squares(&DVector::from_row_slice(&weights.weighted(0.3, -0.1)));
        assert!((squares.common - 0.02).abs() < 1e-12, "{squares:?}");
        assert!((squares.differential - 0.25 * 0.08).abs() < 1e-12, "{squares:?}");
        assert_eq!(Modes::both(0.0).inverse(0.0), Modes::EQUAL);
    }
}
