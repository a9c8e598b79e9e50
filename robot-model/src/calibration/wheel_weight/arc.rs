//! Which arc did a run follow, and which angle belongs to its lateral offset?

use super::error::WheelWeightError;
use crate::numeric::angle::sinc;

/// (1 - cos alpha) / alpha, written as sin^2 so that nothing cancels near zero.
pub(super) fn versine_over_angle(alpha_rad: f64) -> f64 {
    alpha_rad / 2.0 * sinc(alpha_rad / 2.0).powi(2)
}

/// The exact arc on which the left wheel travels dS_L.
pub(crate) struct Arc {
    pub(crate) travel_left_m: f64,
    pub(crate) track_width_m: f64,
}

impl Arc {
    /// s = dS_L - b alpha / 2: (3-3) put into s = (dS_L + dS_R) / 2 \[m\].
    pub(crate) fn length_m(&self, alpha_rad: f64) -> f64 {
        self.travel_left_m - self.track_width_m * alpha_rad / 2.0
    }

    /// y = -s (1 - cos alpha) / alpha, to the left positive \[m\].
    pub(crate) fn offset_m(&self, alpha_rad: f64) -> f64 {
        -self.length_m(alpha_rad) * versine_over_angle(alpha_rad)
    }

    /// dy / d alpha \[m/rad\].
    pub(super) fn offset_by_alpha(&self, alpha_rad: f64) -> f64 {
        let slope = sinc(alpha_rad) - sinc(alpha_rad / 2.0).powi(2) / 2.0;
        self.track_width_m / 2.0 * versine_over_angle(alpha_rad) - self.length_m(alpha_rad) * slope
    }

    /// The angle of the arc that ends `y_m` off the line.
    ///
    /// With the angle the offset grows up to a largest one, near a third of a circle; the solution lies before that.
    pub(crate) fn alpha_rad(&self, y_m: f64) -> Result<f64, WheelWeightError> {
        if y_m == 0.0 {
            return Ok(0.0);
        }
        // The offset has the sign of -dS_L alpha.
        let side = -(y_m * self.travel_left_m).signum();
        let reach = |step: u32| self.offset_m(side * f64::from(step) * ARC_STEP_RAD).abs();
        let last = (0..ARC_STEPS).take_while(|&step| reach(step + 1) > reach(step)).count() as u32;
        let largest_m = reach(last);
        if y_m.abs() >= largest_m {
            return Err(WheelWeightError::OffsetTooLarge { offset_m: y_m, largest_m });
        }
        // 80 bisections reduce the bracket to rounding errors.
        let (mut low, mut high) = (0.0, f64::from(last) * ARC_STEP_RAD);
        for _ in 0..80 {
            let middle = (low + high) / 2.0;
            match self.offset_m(side * middle).abs() < y_m.abs() {
                true => low = middle,
                false => high = middle,
            }
        }
        Ok(side * (low + high) / 2.0)
    }
}

/// Steps of the search for the largest offset: 400 of 1/100 rad go beyond the largest of every arc.
const ARC_STEP_RAD: f64 = 0.01;
const ARC_STEPS: u32 = 400;
