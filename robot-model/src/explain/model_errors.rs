//! The errors of a model: fitted, and cross-validated.

use crate::effect::composition::{PlacedTerm, Term};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::errors::{ErrorPair, cross_validated, errors_on_runs};
use crate::estimation::fit::fit_parameters;
use crate::recording::campaign::Prepared;
use crate::recording::odometry_noise::OdometryNoise;

/// The errors of a model of these terms, fitted with this noise.
pub(crate) fn errors(prepared: &Prepared, noise: &OdometryNoise, terms: &[Term<'_>]) -> ErrorPair {
    errors_as_fitted(prepared, noise, &fit_parameters(prepared, terms.to_vec(), *noise).terms)
}

/// The errors of a model of these terms, which are fitted with this noise already.
pub(crate) fn errors_as_fitted(
    prepared: &Prepared,
    noise: &OdometryNoise,
    terms: &[Term<'_>],
) -> ErrorPair {
    let terms = PlacedTerm::place(terms);
    let equations = CampaignEquations::gather(prepared, &terms, noise);
    let columns: Vec<usize> = (0..equations.priors.len()).collect();
    let model = (&equations, terms.as_slice());
    ErrorPair {
        fitted: errors_on_runs(prepared, model, &[], noise),
        cross_validated: cross_validated(prepared, model, &columns, noise),
    }
}
