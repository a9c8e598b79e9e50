//! In which parameters is an expression linear, so that it vanishes without them?

use super::evaluate::evaluate;
use super::tree::Tree;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};

/// Ordinary values of parameters, no two alike.
pub(crate) const PLACES: [f64; PARAMETERS_MAX] = [0.83, 1.31, 0.57, 1.71];

/// The largest set of parameters in which the expression is linear and without which it vanishes. Each sample gives the values
/// of all variables.
pub(crate) fn amplitudes(tree: &Tree, count: usize, samples: &[Vec<f64>]) -> Option<Vec<usize>> {
    let subsets = (1_u32..1 << count)
        .map(|bits| -> Vec<usize> { (0..count).filter(|j| bits & (1 << j) != 0).collect() });
    let mut subsets: Vec<_> = subsets.collect();
    subsets.sort_by_key(|set| core::cmp::Reverse(set.len()));
    let (a, b) = ([0.41, -0.77, 1.23, 0.29], [-1.1, 0.63, 0.37, -0.91]);
    subsets.into_iter().find(|set| {
        let value = |sample: &[f64], of: &dyn Fn(usize) -> f64| {
            let at: Vec<f64> =
                (0..count).map(|j| if set.contains(&j) { of(j) } else { PLACES[j] }).collect();
            evaluate(tree, &Jet::parameters(&at), &|index| sample[index]).value
        };
        let mut finite = 0;
        let linear = samples.iter().all(|sample| {
            let (of_a, of_b) = (value(sample, &|j| a[j]), value(sample, &|j| b[j]));
            let both = value(sample, &|j| 2.0 * a[j] + b[j]);
            if !(of_a.is_finite() && of_b.is_finite() && both.is_finite()) {
                return true;
            }
            let at_zero = value(sample, &|_| 0.0);
            if at_zero.is_finite() && at_zero != 0.0 {
                return false;
            }
            finite += 1;
            // The rounding errors of sums of such numbers, and of numbers so small that they lose their digits.
            let rounding = 1e-9 * (of_a.abs() + of_b.abs() + both.abs()) + 1e-290;
            (both - 2.0 * of_a - of_b).abs() <= rounding
        });
        linear && finite > 0
    })
}
