//! What do readings by hand, after the way out and after the way back, say about radius and pull?
//!
//! Frame: the start line. psi_0 is the heading with which the robot was put there, s > 0 the length of
//! each way, y_o and y_b the offsets read after each way with errors e, a_o and a_b the tangents. On reversing,
//! a caster that swings round and play in the gears turn the robot by kappa. To first order:
//!
//! ```text
//! y_o = s psi_0 - s alpha_f / 2 + e_o,    y_b = s (alpha_f + alpha_b) / 2 + s kappa + e_b      (3)
//! a_o = alpha_f - psi_0 + e_o,            a_b = alpha_f + alpha_b + kappa - psi_0 + e_b        (4)
//! ```
//!
//! psi_0 is in y_o only: after the way back the robot is on the line again, however it was aligned. Solved for the
//! angles, the errors are
//!
//! ```text
//! offsets:   d alpha_f = -2 psi_0 - 2 e_o / s,   d alpha_b = 2 psi_0 + 2 (e_o + e_b) / s + 2 kappa   (5)
//! tangents:  d alpha_f = -psi_0 + e_o,           d alpha_b = e_b - e_o + kappa                       (6)
//! ```
//!
//! so with a ruler the part that flips has a variance of 5 sigma^2 / s^2 + 4 psi^2 + kappa^2, and the pull
//! one of sigma^2 / s^4 + kappa^2 / s^2. The angles themselves are computed on exact arcs.

use super::separation::{Leg, MeasuredBy, OutAndBack, OutAndBackError, Shared};
use crate::calibration::wheel_weight::arc::Arc;
use crate::calibration::wheel_weight::experiment::{Deviation, Experiment};
use crate::kinematics::pose::Pose;
use crate::numeric::angle::sinc;

/// How far a robot turns on reversing, kappa, one sigma \[rad\]: the simulator's scenarios without any pull read as
/// much, 0.3 to 0.8 mrad for each metre of 1.8 m. A track leaves the decimetres after a reversal out; a reading
/// cannot.
pub const REVERSAL_SIGMA_RAD: f64 = 1e-3;

impl OutAndBack {
    /// Separates radius from pull by a reading after each leg, without moving the robot by hand in between.
    ///
    /// Both readings are relative to the start line. Geometry and alignment are those of the way out.
    pub fn by_readings(out: &Experiment, back: &Experiment) -> Result<Self, OutAndBackError> {
        let reversal_variance = REVERSAL_SIGMA_RAD.powi(2);
        let start_variance = out.start_heading_sigma_rad.powi(2);
        let leg = |of: &Experiment, alpha_rad, variance: f64| Leg {
            alpha_rad,
            alpha_sigma_rad: variance.sqrt(),
            turns: of.turns,
        };
        let (forward, backward, shared) = match (out.offset(), back.offset()) {
            (Some((out_m, out_sigma_m)), Some((back_m, back_sigma_m))) => {
                let (out_arc, back_arc) = (arc(out), arc(back));
                let alpha_out = out_arc.alpha_rad(out_m).map_err(OutAndBackError::Reading)?;
                let alpha_back = way_back(&out_arc, alpha_out, &back_arc, back_m);
                let per_m = 2.0 / out_arc.length_m(alpha_out);
                let out_variance = (per_m * out_sigma_m).powi(2) + 4.0 * start_variance;
                let back_variance =
                    out_variance + (per_m * back_sigma_m).powi(2) + 4.0 * reversal_variance;
                let shared = Shared {
                    alpha_covariance_rad2: -out_variance,
                    measured_by: MeasuredBy::Offset,
                };
                (leg(out, alpha_out, out_variance), leg(back, alpha_back, back_variance), shared)
            }
            (None, None) => {
                let [(out_rad, out_sigma), (back_rad, back_sigma)] = [out.angle(), back.angle()];
                let out_variance = out_sigma * out_sigma + start_variance;
                let back_variance =
                    back_sigma * back_sigma + out_sigma * out_sigma + reversal_variance;
                let shared = Shared {
                    alpha_covariance_rad2: -out_sigma * out_sigma,
                    measured_by: MeasuredBy::Angle,
                };
                let alpha_back = back_rad - out_rad;
                (leg(out, out_rad, out_variance), leg(back, alpha_back, back_variance), shared)
            }
            _ => return Err(OutAndBackError::Mixed),
        };
        Self::new(forward, backward, shared, &out.geometry)
    }
}

impl Experiment {
    /// The lateral offset with its sigma, if it was read.
    fn offset(&self) -> Option<(f64, f64)> {
        match self.deviation {
            Deviation::LateralOffset { y_m, sigma_m } => Some((y_m, sigma_m)),
            _ => None,
        }
    }

    /// The turn from the line, clockwise positive, with its sigma; meaningless for an offset.
    fn angle(&self) -> (f64, f64) {
        match self.deviation {
            Deviation::Tangent { dx_m, dy_m, sigma_m } => {
                (dy_m.atan2(dx_m), sigma_m / dx_m.hypot(dy_m))
            }
            Deviation::Heading { heading_rad, sigma_rad } => (-heading_rad, sigma_rad),
            Deviation::LateralOffset { .. } => (f64::NAN, f64::NAN),
        }
    }
}

fn arc(experiment: &Experiment) -> Arc {
    Arc {
        travel_left_m: experiment.geometry.wheel_radius_m * experiment.turns.left,
        track_width_m: experiment.geometry.track_width_m,
    }
}

/// The end of an arc in the frame of its start; clockwise is a negative heading.
fn end(arc: &Arc, alpha_rad: f64) -> Pose {
    Pose::new(arc.length_m(alpha_rad) * sinc(alpha_rad), arc.offset_m(alpha_rad), -alpha_rad)
}

/// The angle of the way back that ends `y_m` off the line, after a way out of this angle.
fn way_back(out: &Arc, alpha_out_rad: f64, back: &Arc, y_m: f64) -> f64 {
    let turned = end(out, alpha_out_rad);
    let mut alpha_rad = -alpha_out_rad;
    // y falls by s / 2 per radian, with s negative backwards. The slope is off by the order of alpha^2, so each
    // round leaves less than a tenth of the error.
    for _ in 0..20 {
        let miss_m = turned.compose(end(back, alpha_rad)).y_m - y_m;
        alpha_rad += 2.0 * miss_m / back.length_m(alpha_rad);
    }
    alpha_rad
}
