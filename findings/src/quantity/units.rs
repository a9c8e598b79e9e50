//! Which units are known.

use std::f64::consts::TAU;

/// Names of units, and the value of each in SI units.
pub(super) type Units = &'static [(&'static str, f64)];

pub(super) const LENGTH: Units = &[
    ("m", 1.0),
    ("cm", 0.01),
    ("mm", 0.001),
    ("um", 1e-6),
    ("km", 1e3),
    ("in", 0.0254),
    ("ft", 0.3048),
];
pub(super) const ANGLE: Units =
    &[("rad", 1.0), ("mrad", 1e-3), ("deg", TAU / 360.0), ("°", TAU / 360.0), ("rev", TAU)];
pub(super) const TIME: Units =
    &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("min", 60.0), ("h", 3600.0)];
pub(super) const GROUND_SPEED: Units =
    &[("m/s", 1.0), ("cm/s", 0.01), ("mm/s", 0.001), ("km/h", 1.0 / 3.6)];
pub(super) const WHEEL_SPEED: Units =
    &[("rev/s", TAU), ("rad/s", 1.0), ("deg/s", TAU / 360.0), ("rpm", TAU / 60.0)];
pub(super) const GROUND_ACCELERATION: Units =
    &[("m/s^2", 1.0), ("m/s2", 1.0), ("m/s²", 1.0), ("cm/s^2", 0.01), ("mm/s^2", 0.001)];
pub(super) const WHEEL_ACCELERATION: Units = &[
    ("rev/s^2", TAU),
    ("rev/s2", TAU),
    ("rev/s²", TAU),
    ("rad/s^2", 1.0),
    ("rad/s2", 1.0),
    ("rad/s²", 1.0),
    ("deg/s^2", TAU / 360.0),
];
