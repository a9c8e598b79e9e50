//! Several numbers that go through the same arithmetic beside each other, a few with each instruction.

use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A number, or one number in each lane.
pub(crate) trait Number:
    Copy
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// This number, in every lane.
    fn of(number: f64) -> Self;

    /// A function of each lane.
    fn each(self, function: impl Fn(f64) -> f64) -> Self;

    /// Each lane, raised to the least and lowered to the most that it may be.
    fn within(self, least: Self, most: Self) -> Self;

    /// Whether every lane is equal to the other's.
    fn equals(self, other: Self) -> bool;

    /// Sine and cosine of each lane.
    fn sin_cos(self) -> (Self, Self);

    /// The largest absolute value of any lane.
    fn largest(self) -> f64;
}

impl Number for f64 {
    fn of(number: f64) -> Self {
        number
    }

    fn each(self, function: impl Fn(f64) -> f64) -> Self {
        function(self)
    }

    #[inline(always)]
    fn within(self, least: Self, most: Self) -> Self {
        // A processor has an instruction for each of these, and none for `max` and `min`, which ask for what is no number.
        let raised = if self > least { self } else { least };
        if raised < most { raised } else { most }
    }

    fn equals(self, other: Self) -> bool {
        self == other
    }

    fn sin_cos(self) -> (Self, Self) {
        self.sin_cos()
    }

    fn largest(self) -> f64 {
        self.abs()
    }
}

/// So many lanes: whole registers of a processor, of two numbers or of four.
pub(crate) const LANES: usize = 12;

/// One number in each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub(crate) struct Lanes(pub [f64; LANES]);

impl Number for Lanes {
    fn of(number: f64) -> Self {
        Self([number; LANES])
    }

    fn each(self, function: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(function))
    }

    #[inline(always)]
    fn within(mut self, least: Self, most: Self) -> Self {
        for ((lane, least), most) in self.0.iter_mut().zip(least.0).zip(most.0) {
            *lane = lane.within(least, most);
        }
        self
    }

    #[inline(always)]
    fn equals(self, other: Self) -> bool {
        // Without an end before the last lane, which would be a branch for each.
        self.0.into_iter().zip(other.0).fold(true, |equal, (a, b)| equal & (a == b))
    }

    fn sin_cos(self) -> (Self, Self) {
        let each = self.0.map(f64::sin_cos);
        (Self(each.map(|(sin, _)| sin)), Self(each.map(|(_, cos)| cos)))
    }

    fn largest(self) -> f64 {
        self.0.into_iter().fold(0.0, |largest, lane| lane.abs().max(largest))
    }
}

impl Neg for Lanes {
    type Output = Self;

    fn neg(self) -> Self {
        Self(self.0.map(|a| -a))
    }
}

/// An operator, and with it the one that assigns.
macro_rules! operator {
    ($operator:ident, $name:ident, $assigning:ident, $assign:ident) => {
        impl $assigning for Lanes {
            #[inline(always)]
            fn $assign(&mut self, other: Self) {
                for (a, b) in self.0.iter_mut().zip(other.0) {
                    *a = a.$name(b);
                }
            }
        }

        impl $operator for Lanes {
            type Output = Self;

            #[inline(always)]
            fn $name(mut self, other: Self) -> Self {
                self.$assign(other);
                self
            }
        }
    };
}

operator!(Add, add, AddAssign, add_assign);
operator!(Sub, sub, SubAssign, sub_assign);
operator!(Mul, mul, MulAssign, mul_assign);
operator!(Div, div, DivAssign, div_assign);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_lane_is_reckoned_like_a_number_alone() {
        fn reckoned<T: Number>(a: T, b: T) -> T {
            let mut sum = (a + b) * -a - b / a;
            sum += a.each(f64::sin);
            sum -= b;
            sum *= T::of(3.0);
            sum.within(b, a)
        }
        let of = |from: f64| core::array::from_fn(|lane| from + lane as f64 / 7.0);
        let (a, b): ([f64; LANES], [f64; LANES]) = (of(1.0), of(-2.0));
        let alone = core::array::from_fn(|lane| reckoned(a[lane], b[lane]));
        assert_eq!(reckoned(Lanes(a), Lanes(b)), Lanes(alone));
        let mut other = a;
        assert!(Lanes(a).equals(Lanes(other)));
        other[LANES - 1] = 0.0;
        assert!(!Lanes(a).equals(Lanes(other)));
    }
}
