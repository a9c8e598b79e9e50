//! Do radii and track width alone, or least squares of whole tracks, predict runs better than the choice of effects?
//!
//! The filter weighs a run by the noise that it assumes: an error of dead reckoning that grows along the path. Where
//! that is not what the error is like, plain least squares of whole tracks weighs better. So every choice is held
//! against the three numbers R_L, R_R and b, and against other shares of growing noise, down to none:
//!
//! ```text
//! share 1: as estimated;   share 0: whole tracks by least squares                        (1)
//! ```
//!
//! What predicts runs best that it was not fitted to is taken; the choice itself where the others are hardly better.

use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::definition::Effect;
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::errors::{Errors, cross_validated, displacement_m};
use crate::estimation::fit::{Fitted, fit_parameters};
use crate::recording::campaign::Prepared;
use crate::recording::odometry_noise::OdometryNoise;
use crate::selection::candidates::is_geometry;

/// Shares of (1) that are tried besides the noise as estimated.
const SHARES: [f64; 2] = [0.2, 1e-3];
/// Another model or weighting has to predict better by this share.
const BETTER: f64 = 0.02;
/// A choice whose error is this near to the noise of a pose needs no alternative.
const NEAR_NOISE: f64 = 1.15;

/// A fit that predicts runs better than the choice.
#[derive(Clone, Debug)]
pub(crate) struct AlternativeFit<'a> {
    /// The better model, with the noise that weighs the runs.
    pub fitted: Fitted<'a>,
    /// Whether it has radii and track width only, unlike the choice.
    pub geometry_only: bool,
    /// Its cross-validated errors.
    pub errors: Errors,
}

/// A model or a weighting that predicts runs better than the choice.
pub(crate) fn alternative_fit<'a>(
    prepared: &Prepared,
    chosen: &Fitted<'a>,
    catalogue: &[&'a dyn Effect],
) -> Option<AlternativeFit<'a>> {
    if prepared.runs.len() < 3 {
        return None;
    }
    let geometry = || -> Vec<Term<'a>> {
        let effects = catalogue.iter().filter(|effect| is_geometry(**effect));
        effects.map(|effect| Term::new(*effect, vec![0.0])).collect()
    };
    let track_width_m = prepared.robot.track_width_m;
    let here_m = displacement_m(&predicted(prepared, chosen), track_width_m);
    let noise = &chosen.noise.of_one_pose(prepared.poses_in_one);
    let pose_m = [
        noise.position_sigma_m,
        noise.position_wobble_m,
        noise.heading_sigma_rad * track_width_m / 2.0,
        noise.heading_wobble_rad * track_width_m / 2.0,
    ];
    // Two numbers make up a position.
    let least_m = (pose_m.map(|sigma_m| sigma_m * sigma_m).iter().sum::<f64>() * 2.0).sqrt();
    if here_m < NEAR_NOISE * least_m {
        return None;
    }
    let others = || chosen.terms.iter().any(|term| !is_geometry(term.effect));
    let mut models: Vec<(Vec<Term<'a>>, bool)> = vec![(chosen.terms.clone(), false)];
    if others() {
        models.push((geometry(), true));
    }
    let mut best: Option<(f64, AlternativeFit<'a>)> = None;
    for (terms, geometry_only) in models {
        for share in core::iter::once(1.0).chain(SHARES) {
            if share == 1.0 && !geometry_only {
                continue;
            }
            let noise = weighed(&chosen.noise, share);
            let fitted = fit_parameters(prepared, terms.clone(), noise);
            let errors = predicted(prepared, &fitted);
            let there_m = displacement_m(&errors, track_width_m);
            if best.as_ref().is_none_or(|(least_m, _)| there_m < *least_m) {
                best = Some((there_m, AlternativeFit { fitted, geometry_only, errors }));
            }
        }
    }
    let (there_m, mut alternative) = best?;
    // Its noise has the size of what is left.
    let fitted = &mut alternative.fitted;
    let size = (fitted.chi_squared / fitted.rows.max(1.0)).sqrt();
    fitted.noise = fitted.noise.times(size);
    fitted.covariance *= size * size;
    alternative.errors.chi /= size;
    (there_m < (1.0 - BETTER) * here_m).then_some(alternative)
}

/// The noise with a share of what grows along the path; what does not grow takes its place.
fn weighed(noise: &OdometryNoise, share: f64) -> OdometryNoise {
    OdometryNoise {
        travel_walk: noise.travel_walk * share,
        heading_walk: noise.heading_walk * share,
        ..*noise
    }
}

/// Errors of runs predicted by a fit to all others.
fn predicted(prepared: &Prepared, fitted: &Fitted<'_>) -> Errors {
    let placed = PlacedTerm::place(&fitted.terms);
    let equations = CampaignEquations::gather(prepared, &placed, &fitted.noise);
    let columns: Vec<usize> = placed.iter().flat_map(PlacedTerm::columns).collect();
    cross_validated(prepared, (&equations, &placed), &columns, &fitted.noise)
}
