//! What several runs say together, and whether that is enough.

use robot_model::track_fit::Estimate;
use robot_model::{Geometry, Source, WheelWeight};

/// The mean of several runs, each weighted by what it alone adds.
///
/// What the runs have in common, the tolerances of the nominal robot, no mean makes smaller:
/// sigma^2 = 1 / sum(1 / own_i^2) + common^2.
pub(super) fn mean(said: &[WheelWeight]) -> Estimate {
    if let [one] = said {
        return Estimate { value: one.value, sigma: one.sigma };
    }
    let is_common = |source| matches!(source, Source::TrackWidth | Source::WheelRadius);
    let (mut common, mut total, mut sum) = (0.0_f64, 0.0, 0.0);
    for weight in said {
        let square = |common: bool| -> f64 {
            let parts = weight.contributions.iter().filter(|part| is_common(part.source) == common);
            parts.map(|part| part.sigma * part.sigma).sum()
        };
        let share = 1.0 / square(false).max(f64::MIN_POSITIVE);
        common = common.max(square(true));
        total += share;
        sum += share * weight.value;
    }
    Estimate { value: sum / total, sigma: (1.0 / total + common).sqrt() }
}

/// Whether a W_T that is wrong by this much still counts as straight: a centimetre in two metres.
///
/// The deviation angle after s metres is alpha = s dW / b, the offset from the line y = s alpha / 2.
pub(super) fn is_straight_within(wheel_weight_error: f64, geometry: &Geometry) -> bool {
    const DISTANCE_M: f64 = 2.0;
    const OFFSET_M: f64 = 0.01;
    DISTANCE_M * DISTANCE_M * wheel_weight_error / (2.0 * geometry.track_width_m) <= OFFSET_M
}
