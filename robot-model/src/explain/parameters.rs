//! The values of an effect of a fitted model, with intervals that hold when the noise is not quite as assumed.

use crate::effect::composition::PlacedTerm;
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::fit::Fitted;
use crate::estimation::profile_likelihood::interval;
use crate::explain::answer::ParameterFound;
use crate::numeric::distributions::SIGMAS_95;
use crate::recording::campaign::Prepared;
use crate::selection::effect_test::EffectTest;

/// The parameters of each effect of a model, with what speaks for it. The dispersion of that, the variance among runs over
/// what their noise explains, widens the intervals.
pub(crate) fn parameters(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    kept: &[EffectTest],
) -> Vec<Vec<ParameterFound>> {
    let jackknifed = jackknife(prepared, fitted);
    let of = |(index, test): (usize, &EffectTest)| {
        of_one(prepared, fitted, index, (test.dispersion, &jackknifed))
    };
    kept.iter().enumerate().map(of).collect()
}

/// The parameters of one effect.
fn of_one(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    index: usize,
    (dispersion, jackknifed): (f64, &[f64]),
) -> Vec<ParameterFound> {
    let term = &fitted.terms[index];
    let first: usize = fitted.terms[..index].iter().map(|term| term.values.len()).sum();
    let parameters = term.effect.facts().parameters.iter().zip(&term.values).enumerate();
    parameters
        .map(|(j, (parameter, value))| {
            let own = fitted.covariance[(first + j, first + j)].sqrt();
            let ratio = if own > 0.0 { jackknifed[first + j] / (own * own) } else { 0.0 };
            let dispersion = dispersion.max(ratio);
            let sigma = dispersion.sqrt() * own;
            let (low95, high95) = if term.effect.is_linear() {
                (value - SIGMAS_95 * sigma, value + SIGMAS_95 * sigma)
            } else {
                interval(prepared, fitted, (index, j), (own, dispersion))
            };
            ParameterFound {
                name: parameter.name.to_string(),
                unit: parameter.unit.to_string(),
                value: *value,
                sigma,
                low95,
                high95,
            }
        })
        .collect()
}

/// The variance of each parameter by how it changes when a run is left out: whatever the noise is like, runs vary by
/// themselves.
fn jackknife(prepared: &Prepared, fitted: &Fitted<'_>) -> Vec<f64> {
    let terms = PlacedTerm::place(&fitted.terms);
    let equations = CampaignEquations::gather(prepared, &terms, &fitted.noise);
    let columns: Vec<usize> = (0..equations.priors.len()).collect();
    let runs: Vec<usize> = (0..prepared.runs.len()).collect();
    let n = runs.len() as f64;
    if n < RUNS_FOR_JACKKNIFE {
        return vec![0.0; columns.len()];
    }
    let left_out = |run: &usize| {
        let sums = equations.without(equations.folds_of(*run));
        equations.best(&sums, &columns)
    };
    let each: Vec<_> = runs.iter().map(left_out).collect();
    let variance = |column: &usize| {
        let mean = each.iter().map(|delta| delta[*column]).sum::<f64>() / n;
        each.iter().map(|delta| (delta[*column] - mean).powi(2)).sum::<f64>() * (n - 1.0) / n
    };
    columns.iter().map(variance).collect()
}

/// With fewer runs than this, how they vary is not known.
const RUNS_FOR_JACKKNIFE: f64 = 6.0;
