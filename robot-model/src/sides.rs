//! A pair of things, one for each wheel.

/// Left and right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sides<T> {
    /// Of the left wheel.
    pub left: T,
    /// Of the right wheel.
    pub right: T,
}

impl<T> Sides<T> {
    /// A pair.
    pub const fn new(left: T, right: T) -> Self {
        Self { left, right }
    }

    /// The same for both.
    pub fn both(value: T) -> Self
    where
        T: Copy,
    {
        Self { left: value, right: value }
    }

    /// Each side by itself.
    pub fn map<U>(self, mut change: impl FnMut(T) -> U) -> Sides<U> {
        Sides { left: change(self.left), right: change(self.right) }
    }

    /// Side by side with another pair.
    pub fn zip<U>(self, other: Sides<U>) -> Sides<(T, U)> {
        Sides { left: (self.left, other.left), right: (self.right, other.right) }
    }
}

impl Sides<f64> {
    /// Half the sum.
    pub fn mean(self) -> f64 {
        (self.left + self.right) / 2.0
    }

    /// Right less left.
    pub fn difference(self) -> f64 {
        self.right - self.left
    }
}
