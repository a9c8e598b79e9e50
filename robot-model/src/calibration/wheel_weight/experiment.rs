//! What does a reading at the end of a run say about W_T, and how does its uncertainty propagate?

use super::arc::{Arc, versine_over_angle};
use super::error::WheelWeightError;
use super::uncertainty::{Contribution, Source};
use super::weight::{Angle, WheelWeight};
use crate::kinematics::geometry::Geometry;
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::angle::sinc;

/// What was read at the end of a run, relative to the line along which the robot set out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Deviation {
    /// The paper's reading, (3-2): the tangent of the trace at its end.
    Tangent {
        /// Base along the line, dx \[m\], above zero.
        dx_m: f64,
        /// Rise over that base, dy_A \[m\], **to the right positive**, as in the paper.
        dy_m: f64,
        /// Uncertainty of each of the two readings \[m\].
        sigma_m: f64,
    },
    /// The distance of the end from the line.
    LateralOffset {
        /// Offset, **to the left positive** \[m\].
        y_m: f64,
        /// Its uncertainty \[m\].
        sigma_m: f64,
    },
    /// The heading at the end.
    Heading {
        /// Heading, **counter-clockwise positive** \[rad\].
        heading_rad: f64,
        /// Its uncertainty \[rad\].
        sigma_rad: f64,
    },
}

/// A run and what was measured at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// The reading.
    pub deviation: Deviation,
    /// How far the wheels turned.
    pub turns: WheelPair<f64>,
    /// The nominal robot.
    pub geometry: Geometry,
    /// How well the robot was aligned with the line at the start, one sigma \[rad\].
    pub start_heading_sigma_rad: f64,
}

impl Experiment {
    /// W_T with its uncertainty, without advice.
    pub(crate) fn propagate(&self) -> Result<WheelWeight, WheelWeightError> {
        self.validate()?;
        let Self { turns, geometry, .. } = *self;
        let WheelPair { left: phi_left_rad, right: phi_right_rad } = turns;
        let (radius_m, track_m) = (geometry.wheel_radius_m, geometry.track_width_m);
        let alpha = self.alpha()?;
        let right_m = radius_m * phi_right_rad;
        let value = (radius_m * phi_left_rad - track_m * alpha.rad) / right_m;
        if !(value > 0.0 && value.is_finite()) {
            return Err(WheelWeightError::Impossible { value });
        }

        // Partial derivatives of the general (3-6), alpha being a function of dS_L and b as well.
        let by_alpha = -track_m / right_m;
        let by_phi_left = (1.0 - track_m * alpha.by_travel_left) / phi_right_rad;
        let by_phi_right = -value / phi_right_rad;
        let by_track = -alpha.rad / right_m + by_alpha * alpha.by_track;
        let by_radius = track_m * alpha.rad / (radius_m * right_m)
            + by_alpha * alpha.by_travel_left * phi_left_rad;

        let phi_sigma_rad = phi_sigma_rad(&geometry);
        let contributions = vec![
            Contribution { source: Source::Reading, sigma: by_alpha * alpha.reading_sigma },
            Contribution { source: Source::StartHeading, sigma: by_alpha * alpha.start_sigma },
            Contribution {
                source: Source::TrackWidth,
                sigma: by_track * geometry.track_width_sigma_m,
            },
            Contribution {
                source: Source::WheelRadius,
                sigma: by_radius * geometry.wheel_radius_sigma_m,
            },
            Contribution {
                source: Source::EncoderQuantisation,
                sigma: by_phi_left.hypot(by_phi_right) * phi_sigma_rad,
            },
        ];
        let alpha_sigma_rad = [
            alpha.reading_sigma,
            alpha.start_sigma,
            alpha.by_track * geometry.track_width_sigma_m,
            alpha.by_travel_left * phi_left_rad * geometry.wheel_radius_sigma_m,
            alpha.by_travel_left * radius_m * phi_sigma_rad,
        ]
        .into_iter()
        .fold(0.0, f64::hypot);
        let alpha = Angle { rad: alpha.rad, sigma_rad: alpha_sigma_rad };
        Ok(WheelWeight::from_parts(value, alpha, turns, contributions))
    }

    fn validate(&self) -> Result<(), WheelWeightError> {
        self.geometry.validate()?;
        let finite = |name, value: f64| match value.is_finite() {
            true => Ok(()),
            false => Err(WheelWeightError::BadNumber { name, value }),
        };
        let not_negative = |name, value: f64| match value >= 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(WheelWeightError::BadNumber { name, value }),
        };
        match self.deviation {
            Deviation::Tangent { dx_m, dy_m, sigma_m } => {
                if !(dx_m > 0.0 && dx_m.is_finite()) {
                    return Err(WheelWeightError::BadNumber { name: "dx", value: dx_m });
                }
                finite("dy", dy_m)?;
                not_negative("the uncertainty of dx and dy", sigma_m)?;
            }
            Deviation::LateralOffset { y_m, sigma_m } => {
                finite("the lateral offset", y_m)?;
                not_negative("the uncertainty of the lateral offset", sigma_m)?;
            }
            Deviation::Heading { heading_rad, sigma_rad } => {
                finite("the heading", heading_rad)?;
                not_negative("the uncertainty of the heading", sigma_rad)?;
            }
        }
        not_negative("the uncertainty of the start heading", self.start_heading_sigma_rad)?;
        finite("the left wheel's angle", self.turns.left)?;
        finite("the right wheel's angle", self.turns.right)?;
        match self.turns.left * self.turns.right > 0.0 {
            true => Ok(()),
            false => Err(WheelWeightError::NoTravel),
        }
    }

    /// The deviation angle that the reading stands for.
    fn alpha(&self) -> Result<AlphaReading, WheelWeightError> {
        let direct = |rad, reading_sigma| AlphaReading {
            rad,
            reading_sigma,
            start_sigma: self.start_heading_sigma_rad,
            by_travel_left: 0.0,
            by_track: 0.0,
        };
        match self.deviation {
            // d alpha/d dy and d alpha/d dx in quadrature make 1 / hypot(dx, dy).
            Deviation::Tangent { dx_m, dy_m, sigma_m } => {
                Ok(direct(dy_m.atan2(dx_m), sigma_m / dx_m.hypot(dy_m)))
            }
            Deviation::Heading { heading_rad, sigma_rad } => Ok(direct(-heading_rad, sigma_rad)),
            Deviation::LateralOffset { y_m, sigma_m } => {
                let arc = Arc {
                    travel_left_m: self.geometry.wheel_radius_m * self.turns.left,
                    track_width_m: self.geometry.track_width_m,
                };
                let rad = arc.alpha_rad(y_m)?;
                let by_offset = 1.0 / arc.offset_by_alpha(rad);
                // A start turned by psi0 shifts the end by x_end psi0.
                let x_end_m = arc.length_m(rad) * sinc(rad);
                Ok(AlphaReading {
                    rad,
                    reading_sigma: by_offset * sigma_m,
                    start_sigma: by_offset * x_end_m * self.start_heading_sigma_rad,
                    by_travel_left: by_offset * versine_over_angle(rad),
                    by_track: -by_offset * versine_over_angle(rad) * rad / 2.0,
                })
            }
        }
    }
}

/// Sigma of a wheel's angle \[rad\]: the difference of two counts, each rounded to a whole one,
/// which is uniform over one count and so has a variance of 1/12.
fn phi_sigma_rad(geometry: &Geometry) -> f64 {
    geometry.rad_per_count() / 6_f64.sqrt()
}

/// alpha as read, with the sigmas and partial derivatives that belong to it.
struct AlphaReading {
    rad: f64,
    reading_sigma: f64,
    start_sigma: f64,
    /// d alpha / d dS_L \[rad/m\].
    by_travel_left: f64,
    /// d alpha / d b \[rad/m\].
    by_track: f64,
}
