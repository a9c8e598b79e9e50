//! How noisy are samples? Estimated from their scatter about a smooth curve.

/// Noise of one sample, from second differences.
pub(super) fn scatter(values: &[f64]) -> f64 {
    noise_of(second_differences(values).collect())
}

/// Absolute second differences.
pub(super) fn second_differences(values: &[f64]) -> impl Iterator<Item = f64> {
    values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs())
}

/// The noise that gives such second differences, from their median; 0 if there are none.
pub(super) fn noise_of(mut differences: Vec<f64>) -> f64 {
    differences.sort_by(f64::total_cmp);
    // The median of |N(0, 1)| is 0.6745.
    differences.get(differences.len() / 2).map_or(0.0, |middle| middle / 0.6745 / 6_f64.sqrt())
}
