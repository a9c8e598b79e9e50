//! What can an effect of the user's own change, and per what?

use crate::expression::{LeftSide, Unit};

/// What an expression changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Travel of the left wheel.
    DsLeft,
    /// Travel of the right wheel.
    DsRight,
    /// Heading.
    Dtheta,
    /// Sideways, to the left.
    Dn,
}

/// What an expression is a rate of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Per {
    /// Per second.
    Second,
    /// Per metre of travel.
    Metre,
    /// Per radian turned.
    Radian,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::DsLeft, Self::DsRight, Self::Dtheta, Self::Dn];

    /// What an equation of it, per this, is of.
    pub(super) fn left_side(self, per: Per) -> LeftSide {
        let metre = match self {
            Self::Dtheta => 0.0,
            Self::DsLeft | Self::DsRight | Self::Dn => 1.0,
        };
        let (per_metre, per_second) = match per {
            Per::Second => (0.0, 1.0),
            Per::Metre => (1.0, 0.0),
            Per::Radian => (0.0, 0.0),
        };
        let unit = Unit([metre - per_metre, -per_second, 0.0, 0.0]);
        LeftSide { quantity: self.name(), per: Some(per.name()), unit }
    }

    /// Its name in an expression.
    pub const fn name(self) -> &'static str {
        match self {
            Self::DsLeft => "ds_left",
            Self::DsRight => "ds_right",
            Self::Dtheta => "dtheta",
            Self::Dn => "dn",
        }
    }
}

impl Per {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Second, Self::Metre, Self::Radian];

    /// Its name in `model.toml`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Second => "second",
            Self::Metre => "metre",
            Self::Radian => "radian",
        }
    }
}
