//! A pair of values, one for each wheel.

use serde::Serialize;

/// Left and right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct WheelPair<T> {
    /// Of the left wheel.
    pub left: T,
    /// Of the right wheel.
    pub right: T,
}

impl<T> WheelPair<T> {
    /// A pair.
    pub const fn new(left: T, right: T) -> Self {
        Self { left, right }
    }

    /// The same for both.
    pub const fn both(value: T) -> Self
    where
        T: Copy,
    {
        Self { left: value, right: value }
    }

    /// Each side by itself.
    pub fn map<U>(self, mut change: impl FnMut(T) -> U) -> WheelPair<U> {
        WheelPair { left: change(self.left), right: change(self.right) }
    }

    /// Side by side with another pair.
    pub fn zip<U>(self, other: WheelPair<U>) -> WheelPair<(T, U)> {
        WheelPair { left: (self.left, other.left), right: (self.right, other.right) }
    }
}

impl WheelPair<f64> {
    /// Half the sum.
    pub fn mean(self) -> f64 {
        (self.left + self.right) / 2.0
    }

    /// Right less left.
    pub fn difference(self) -> f64 {
        self.right - self.left
    }

    /// Each side less that of an earlier pair.
    pub fn since(self, earlier: Self) -> Self {
        self.zip(earlier).map(|(now, before)| now - before)
    }

    /// A share of the way to another pair: 0 here, 1 there.
    pub fn toward(self, other: Self, share: f64) -> Self {
        self.zip(other).map(|(here, there)| here + share * (there - here))
    }
}
