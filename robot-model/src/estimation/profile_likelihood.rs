//! How sure is a parameter where the fit is not quadratic, as for a threshold or a fading length?
//!
//! A parameter is held at a value, all others are fitted anew, and the value moved until
//!
//! ```text
//! chi^2(value) - chi^2(best) = 3.84 phi                                               (1)
//! ```
//!
//! 3.84 is the 95 % quantile of a chi^2 of one degree; phi is the dispersion, how much more runs scatter than their
//! noise explains ([`crate::selection::effect_test`]). If the fit is quadratic, this is 1.96 standard errors. Where the fit has
//! steps, as at a threshold, (1) may hold right beside the estimate: nearer than one standard error no interval ends, but at
//! the end of the parameter's range.

use crate::effect::composition::{PlacedTerm, Term};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::fit::{Fitted, moved_within_range, raise_to_zero, within_signs};
use crate::estimation::normal_equations::Sums;
use crate::numeric::distributions::SIGMAS_95;
use crate::recording::campaign::Prepared;

/// Equation (1).
const RISE_95: f64 = 3.84;
/// Tolerance of the rise, as a share: the ends are then right to 3 %.
const RISE_TOLERANCE: f64 = 0.06;
/// Most values tried on either side.
const TRIALS_MAX: usize = 8;
/// Iterations of fitting the others, each starting where the last trial ended.
const ROUNDS: usize = 2;

/// The 95 % interval of parameter `parameter` of effect `index`, by (1); `sigma` is a first guess.
pub(crate) fn interval(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    (index, parameter): (usize, usize),
    (sigma, dispersion): (f64, f64),
) -> (f64, f64) {
    let column =
        fitted.terms[..index].iter().map(|term| term.values.len()).sum::<usize>() + parameter;
    let best = fitted.terms[index].values[parameter];
    let (low, high) = fitted.terms[index].effect.range(parameter, &prepared.excitation);
    let least = cost_at(prepared, fitted, &mut fitted.terms.clone(), column);
    let one_sigma = sigma * dispersion.sqrt();
    let end = |side: f64, limit: f64| {
        let mut terms = fitted.terms.clone();
        let rise = |distance: f64| {
            terms[index].values[parameter] = best + side * distance;
            (cost_at(prepared, fitted, &mut terms, column) - least) / dispersion
        };
        best + side * where_it_rises(one_sigma, (limit - best).abs(), rise)
    };
    (end(-1.0, low), end(1.0, high))
}

/// The distance from the estimate, at most `reach`, at which the rise is that of (1).
fn where_it_rises(one_sigma: f64, reach: f64, mut rise: impl FnMut(f64) -> f64) -> f64 {
    let mut distance = SIGMAS_95 * one_sigma;
    // The nearest distance known to be too far.
    let mut beyond = f64::INFINITY;
    for _ in 0..TRIALS_MAX {
        let at_limit = distance >= reach;
        distance = distance.min(reach);
        let rise = rise(distance);
        if (rise / RISE_95 - 1.0).abs() < RISE_TOLERANCE || (at_limit && rise < RISE_95) {
            break;
        }
        if rise > RISE_95 {
            beyond = beyond.min(distance);
        }
        // Where the fit is quadratic, the square root of the rise is linear in the distance.
        let factor = (RISE_95 / rise.max(0.05)).sqrt().clamp(0.3, 3.0);
        let next = distance * factor;
        distance = if next >= beyond { (distance + beyond) / 2.0 } else { next };
    }
    distance.max(one_sigma).min(reach)
}

/// chi^2 with one column fixed and the others fitted; moves `terms` there.
fn cost_at(prepared: &Prepared, fitted: &Fitted<'_>, terms: &mut [Term<'_>], held: usize) -> f64 {
    let mut cost = 0.0;
    for _ in 0..ROUNDS {
        let equations =
            CampaignEquations::gather(prepared, &PlacedTerm::place(terms), &fitted.noise);
        let columns: Vec<usize> =
            (0..equations.priors.len()).filter(|column| *column != held).collect();
        let delta = within_signs(&equations, terms, &columns);
        cost = equations.total.chi_squared(&columns, &delta);
        let mut step = vec![0.0; equations.priors.len()];
        columns.iter().zip(&delta).for_each(|(column, delta)| step[*column] = *delta);
        moved_within_range(prepared, terms, &step);
        raise_to_zero(terms);
    }
    cost
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_ends_where_chi_squared_has_risen_but_not_beside_the_estimate() {
        let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 0.04;
        let quadratic = |sigma: f64| move |distance: f64| (distance / sigma).powi(2);
        assert!(near(where_it_rises(1.0, f64::INFINITY, quadratic(1.0)), SIGMAS_95));
        // The first guess is too large, too small, and beyond what the parameter can be.
        assert!(near(where_it_rises(3.0, f64::INFINITY, quadratic(2.5)), 2.5 * SIGMAS_95));
        assert!(near(where_it_rises(0.2, f64::INFINITY, quadratic(2.5)), 2.5 * SIGMAS_95));
        assert!(near(where_it_rises(1.0, 1.5, quadratic(1.0)), 1.5));
        // A step right beside the estimate, as of a threshold that a sample more or less passes.
        let step = |_: f64| 10.0;
        assert!(near(where_it_rises(1.0, f64::INFINITY, step), 1.0));
        assert_eq!(where_it_rises(1.0, 0.0, step), 0.0, "at the end of its range");
    }
}
