//! The floor.

use serde::{Deserialize, Serialize};

use super::range_check::{ParameterError, RangeCheck};

/// The floor's slope, friction, pile, wet patch and bump.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FloorParameters {
    /// Acceleration of gravity, g \[m/s^2\].
    pub gravity_mps2: f64,
    /// Grip of every wheel, mu: the largest contact force as a share of the load.
    pub friction: f64,
    /// Slope \[rad\].
    pub slope_rad: f64,
    /// Downhill direction, counter-clockwise from the x axis \[rad\].
    pub downhill_rad: f64,
    /// How far a carpet's leaning pile carries a tyre per distance rolled.
    pub pile_drift: f64,
    /// Direction in which the pile leans, counter-clockwise from the x axis \[rad\].
    pub pile_direction_rad: f64,
    /// A wet patch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wet: Option<WetPatch>,
    /// A bump.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bump: Option<Bump>,
}

/// A round patch of the floor with another grip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WetPatch {
    /// Its middle along the x axis \[m\].
    pub x_m: f64,
    /// Its middle along the y axis \[m\].
    pub y_m: f64,
    /// Its radius \[m\].
    pub radius_m: f64,
    /// Grip within the patch, mu.
    pub friction: f64,
}

/// A round bump: a cable under the carpet, a raised tile.
///
/// ```text
/// z = h (1 - (r/a)^2)^2 within its radius a            (1)
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bump {
    /// Its middle along the x axis \[m\].
    pub x_m: f64,
    /// Its middle along the y axis \[m\].
    pub y_m: f64,
    /// Its radius, a \[m\].
    pub radius_m: f64,
    /// Its height, h \[m\].
    pub height_m: f64,
}

impl Default for FloorParameters {
    /// Rubber on a smooth hard floor.
    fn default() -> Self {
        Self {
            gravity_mps2: 9.81,
            friction: 0.7,
            slope_rad: 0.0,
            downhill_rad: 0.0,
            pile_drift: 0.0,
            pile_direction_rad: 0.0,
            wet: None,
            bump: None,
        }
    }
}

impl FloorParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("gravity_mps2", self.gravity_mps2, 0.1, 30.0)?;
        check.within("friction", self.friction, 0.0, 3.0)?;
        check.within("slope_rad", self.slope_rad, 0.0, 0.2)?;
        check.within("downhill_rad", self.downhill_rad, -7.0, 7.0)?;
        check.within("pile_drift", self.pile_drift, 0.0, 0.2)?;
        check.within("pile_direction_rad", self.pile_direction_rad, -7.0, 7.0)?;
        if let Some(wet) = &self.wet {
            check.within("wet.x_m", wet.x_m, -1e3, 1e3)?;
            check.within("wet.y_m", wet.y_m, -1e3, 1e3)?;
            check.within("wet.radius_m", wet.radius_m, 0.0, 1e3)?;
            check.within("wet.friction", wet.friction, 0.0, 3.0)?;
        }
        if let Some(bump) = &self.bump {
            check.within("bump.x_m", bump.x_m, -1e3, 1e3)?;
            check.within("bump.y_m", bump.y_m, -1e3, 1e3)?;
            check.within("bump.radius_m", bump.radius_m, 0.005, 10.0)?;
            // The steepest slope is 1.54 h/a: below 0.5 with this bound.
            check.within("bump.height_m", bump.height_m, 0.0, 0.3 * bump.radius_m)?;
        }
        Ok(())
    }

    /// True for a floor that is level and uniform.
    pub(super) fn is_ideal(&self) -> bool {
        self.slope_rad == 0.0
            && self.pile_drift == 0.0
            && self.wet.is_none()
            && self.bump.is_none_or(|bump| bump.height_m == 0.0)
    }

    /// Grip at a place.
    #[inline]
    pub(super) fn friction_at(&self, (x_m, y_m): (f64, f64)) -> f64 {
        match &self.wet {
            Some(wet)
                if (x_m - wet.x_m).powi(2) + (y_m - wet.y_m).powi(2)
                    < wet.radius_m * wet.radius_m =>
            {
                wet.friction
            }
            _ => self.friction,
        }
    }

    /// The floor's gradient at a place, in the fixed frame, uphill positive; from the bump's (1).
    #[inline]
    pub(super) fn gradient_at(&self, (x_m, y_m): (f64, f64)) -> (f64, f64) {
        let Some(bump) = &self.bump else { return (0.0, 0.0) };
        let (x, y) = (x_m - bump.x_m, y_m - bump.y_m);
        let square = bump.radius_m * bump.radius_m;
        let inside = 1.0 - (x * x + y * y) / square;
        if inside <= 0.0 {
            return (0.0, 0.0);
        }
        let steep = -4.0 * bump.height_m * inside / square;
        (steep * x, steep * y)
    }
}
