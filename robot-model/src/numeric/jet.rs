//! Numbers that carry their derivatives: forward-mode differentiation, exact to rounding.
//!
//! A [`Jet`] is a value with its partial derivatives by the parameters of one effect, of which there
//! are at most [`PARAMETERS_MAX`]. An effect computes with jets once, and gives both what it changes
//! and how that depends on its parameters: there is no second formula that could disagree.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// The most parameters that one effect has.
pub const PARAMETERS_MAX: usize = 4;

/// A value and its derivatives by the parameters of one effect.
///
/// Alignment and order are for speed: the compiler loads two derivatives at once that were stored just before. Where these
/// were stored in other pairs, the processor waits for both stores, which takes longer than the arithmetic.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(16))]
pub struct Jet {
    /// The partial derivatives.
    pub by: [f64; PARAMETERS_MAX],
    /// The value.
    pub value: f64,
}

impl Jet {
    /// Zero, whatever the parameters.
    pub const ZERO: Self = Self::constant(0.0);

    /// A number that no parameter changes.
    pub const fn constant(value: f64) -> Self {
        Self { value, by: [0.0; PARAMETERS_MAX] }
    }

    /// The parameter of this index itself.
    pub fn parameter(index: usize, value: f64) -> Self {
        let mut jet = Self::constant(value);
        jet.by[index] = 1.0;
        jet
    }

    /// The values of an effect's parameters as jets.
    pub fn parameters(values: &[f64]) -> [Self; PARAMETERS_MAX] {
        let mut jets = [Self::ZERO; PARAMETERS_MAX];
        for (index, (jet, value)) in jets.iter_mut().zip(values).enumerate() {
            *jet = Self::parameter(index, *value);
        }
        jets
    }

    /// A function of this jet, from the function's value and slope here.
    pub(crate) fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, by: self.by.map(|d| slope * d) }
    }

    /// The exponential function.
    pub fn exp(self) -> Self {
        self.chain(self.value.exp(), self.value.exp())
    }

    /// The reciprocal.
    pub fn recip(self) -> Self {
        self.chain(1.0 / self.value, -1.0 / (self.value * self.value))
    }
}

impl Add for Jet {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self.value += other.value;
        self.by.iter_mut().zip(other.by).for_each(|(a, b)| *a += b);
        self
    }
}

impl Sub for Jet {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Jet {
    type Output = Self;
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl Mul for Jet {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let mut by = [0.0; PARAMETERS_MAX];
        for (d, (a, b)) in by.iter_mut().zip(self.by.into_iter().zip(other.by)) {
            *d = a * other.value + b * self.value;
        }
        Self { value: self.value * other.value, by }
    }
}

impl Div for Jet {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let ratio = self.value / other.value;
        let mut by = [0.0; PARAMETERS_MAX];
        for (d, (a, b)) in by.iter_mut().zip(self.by.into_iter().zip(other.by)) {
            *d = (a - ratio * b) / other.value;
        }
        Self { value: ratio, by }
    }
}

impl Add<f64> for Jet {
    type Output = Self;
    fn add(mut self, other: f64) -> Self {
        self.value += other;
        self
    }
}

impl Sub<f64> for Jet {
    type Output = Self;
    fn sub(self, other: f64) -> Self {
        self + -other
    }
}

impl Mul<f64> for Jet {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, other)
    }
}

impl Div<f64> for Jet {
    type Output = Self;
    fn div(self, other: f64) -> Self {
        self.chain(self.value / other, 1.0 / other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_follow_the_rules_of_calculus() {
        let [x, y, ..] = Jet::parameters(&[0.7, -1.3]);
        // f = exp(x) y / (2 + x) - y, differentiated by hand.
        let f = x.exp() * y / (x + 2.0) - y;
        let (e, x, y) = (0.7_f64.exp(), 0.7, -1.3);
        // A few roundings of numbers of size one.
        assert!((f.value - (e * y / (2.0 + x) - y)).abs() < 1e-15);
        assert!((f.by[0] - e * y * (1.0 + x) / ((2.0 + x) * (2.0 + x))).abs() < 1e-15);
        assert!((f.by[1] - (e / (2.0 + x) - 1.0)).abs() < 1e-15);
        assert_eq!(f.by[2..], [0.0, 0.0]);
    }
}
