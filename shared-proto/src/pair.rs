//! The two driven wheels, side by side.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// One value for each driven wheel.
///
/// Left and right as seen from the robot, looking forward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(deny_unknown_fields)]
pub struct WheelPair<T> {
    /// The left wheel's value.
    pub left: T,
    /// The right wheel's value.
    pub right: T,
}

impl<T> WheelPair<T> {
    /// A pair from its two values.
    pub const fn new(left: T, right: T) -> Self {
        Self { left, right }
    }

    /// Computes each wheel's value from its own.
    pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> WheelPair<U> {
        WheelPair { left: f(self.left), right: f(self.right) }
    }

    /// Puts two pairs together, wheel by wheel.
    pub fn zip<U>(self, other: WheelPair<U>) -> WheelPair<(T, U)> {
        WheelPair { left: (self.left, other.left), right: (self.right, other.right) }
    }

    /// A pair of references.
    pub const fn as_ref(&self) -> WheelPair<&T> {
        WheelPair { left: &self.left, right: &self.right }
    }

    /// A pair of mutable references.
    pub const fn as_mut(&mut self) -> WheelPair<&mut T> {
        WheelPair { left: &mut self.left, right: &mut self.right }
    }

    /// The value of one wheel.
    pub const fn get(&self, wheel: Wheel) -> &T {
        match wheel {
            Wheel::Left => &self.left,
            Wheel::Right => &self.right,
        }
    }

    /// The value of one wheel, to change it.
    pub const fn get_mut(&mut self, wheel: Wheel) -> &mut T {
        match wheel {
            Wheel::Left => &mut self.left,
            Wheel::Right => &mut self.right,
        }
    }

    /// The pair with left and right exchanged.
    pub fn swapped(self) -> Self {
        Self { left: self.right, right: self.left }
    }

    /// True if `f` holds for both wheels.
    pub fn all(self, mut f: impl FnMut(T) -> bool) -> bool {
        f(self.left) && f(self.right)
    }

    /// True if `f` holds for at least one wheel.
    pub fn any(self, mut f: impl FnMut(T) -> bool) -> bool {
        f(self.left) || f(self.right)
    }
}

impl<T: Copy> WheelPair<T> {
    /// The same value for both wheels.
    pub const fn both(value: T) -> Self {
        Self { left: value, right: value }
    }
}

impl<T, E> WheelPair<Result<T, E>> {
    /// Both values, or the first error, the left wheel's before the right one's.
    pub fn transpose(self) -> Result<WheelPair<T>, E> {
        Ok(WheelPair { left: self.left?, right: self.right? })
    }
}

impl<T> WheelPair<Option<T>> {
    /// The wheel that has a value, the left one before the right one.
    pub fn first_some(self) -> Option<(Wheel, T)> {
        match (self.left, self.right) {
            (Some(value), _) => Some((Wheel::Left, value)),
            (None, Some(value)) => Some((Wheel::Right, value)),
            (None, None) => None,
        }
    }
}

/// Which of the two driven wheels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "snake_case")]
pub enum Wheel {
    /// The wheel on the left.
    Left,
    /// The wheel on the right.
    Right,
}

impl Wheel {
    /// Both wheels, left first.
    pub const BOTH: [Wheel; 2] = [Wheel::Left, Wheel::Right];

    /// The other wheel.
    pub const fn other(self) -> Self {
        match self {
            Wheel::Left => Wheel::Right,
            Wheel::Right => Wheel::Left,
        }
    }

    /// `"left"` or `"right"`.
    pub const fn name(self) -> &'static str {
        match self {
            Wheel::Left => "left",
            Wheel::Right => "right",
        }
    }
}
