//! The W_T that follows from several runs, and whether its uncertainty is small enough.
//!
//! What a single run says is computed in `robot-model`.

use robot_model::calibration::track_fit::Estimate;
use robot_model::calibration::{Source, WheelWeight};
use robot_model::kinematics::Geometry;

/// The mean of several runs, each weighted by its own variance.
///
/// Averaging does not reduce the uncertainty that the runs share, the tolerances of the nominal
/// robot. If n runs scatter more than their own sigmas explain, these are enlarged (Birge's ratio):
///
/// ```text
/// sigma^2 = B / sum(1 / own_i^2) + common^2,   B = max(1, sum((W_i - W)^2 / own_i^2) / (n - 1))
/// ```
pub(super) fn mean(measured: &[WheelWeight]) -> Estimate {
    if let [one] = measured {
        return Estimate { value: one.value, sigma: one.sigma };
    }
    let is_common = |source| matches!(source, Source::TrackWidth | Source::WheelRadius);
    let mut common = 0.0_f64;
    let mut parts = Vec::new();
    for weight in measured {
        let square = |common: bool| -> f64 {
            let parts = weight.contributions.iter().filter(|part| is_common(part.source) == common);
            parts.map(|part| part.sigma * part.sigma).sum()
        };
        parts.push((weight.value, square(false).max(f64::MIN_POSITIVE)));
        common = common.max(square(true));
    }
    let Estimate { value, sigma } = birge(&parts);
    Estimate { value, sigma: sigma.hypot(common.sqrt()) }
}

/// The weighted mean of values with their own variances, and its sigma without the shared
/// uncertainty.
fn birge(parts: &[(f64, f64)]) -> Estimate {
    let total: f64 = parts.iter().map(|(_, variance)| 1.0 / variance).sum();
    let value = parts.iter().map(|(value, variance)| value / variance).sum::<f64>() / total;
    let squares: f64 = parts.iter().map(|(part, variance)| (part - value).powi(2) / variance).sum();
    let scatter = squares / (parts.len() as f64 - 1.0);
    Estimate { value, sigma: (scatter.max(1.0) / total).sqrt() }
}

/// Whether a robot whose W_T is wrong by this much still drives straight: a centimetre in two
/// metres.
///
/// After s metres the deviation angle is alpha = s dW / b, and the offset from the line
/// y = s alpha / 2.
pub(super) fn is_straight_within(wheel_weight_error: f64, geometry: &Geometry) -> bool {
    const DISTANCE_M: f64 = 2.0;
    const OFFSET_M: f64 = 0.01;
    DISTANCE_M * DISTANCE_M * wheel_weight_error / (2.0 * geometry.track_width_m) <= OFFSET_M
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_that_agree_reduce_the_sigma_and_runs_that_contradict_do_not() {
        let agree = birge(&[(0.991, 1e-6), (0.992, 1e-6)]);
        assert!((agree.value - 0.9915).abs() < 1e-12);
        assert!((agree.sigma - 1e-3 / 2.0_f64.sqrt()).abs() < 1e-12);
        // 16 sigma apart: the sigma of the mean is half their distance.
        let contradict = birge(&[(0.992, 1e-6), (1.008, 1e-6)]);
        assert!((contradict.value - 1.0).abs() < 1e-12 && (contradict.sigma - 8e-3).abs() < 1e-12);
    }
}
