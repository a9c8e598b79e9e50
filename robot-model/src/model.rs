//! A model that somebody chose: these effects and no others, fitted to a campaign.

use crate::answer::{ErrorPair, Errors, ParameterFound};
use crate::campaign::Campaign;
use crate::effect::{Effect, find};
use crate::errors::train;
use crate::evidence::Evidence;
use crate::explain::{errors, parameters};
use crate::fit::fit_afresh;
use crate::increment::Term;
use crate::look::Look;
use crate::odometry_noise::OdometryNoise;
use crate::recording::RecordingError;

/// A fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Its effects, in the order asked for.
    pub effects: Vec<ModelEffect>,
    /// Errors on the runs fitted to, and on runs held out.
    pub errors: ErrorPair,
    /// The noise that goes with it.
    pub noise: OdometryNoise,
}

/// One effect of a fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelEffect {
    /// Its id.
    pub effect: &'static str,
    /// Its parameters.
    pub parameters: Vec<ParameterFound>,
}

/// Fits these effects to a campaign. An effect with shapes starts at the middle one of its starts.
pub fn fit(campaign: &Campaign, effects: &[&'static dyn Effect]) -> Result<Model, RecordingError> {
    let prepared = campaign.prepare()?;
    let terms = effects
        .iter()
        .map(|effect| {
            let mut starts = effect.starts(&prepared.survey);
            let middle = starts.len() / 2;
            Term { effect: *effect, values: starts.swap_remove(middle), column: None }
        })
        .collect();
    let fitted = fit_afresh(&prepared, terms);
    let kept = Look::new(&prepared, &fitted, &[]).kept();
    let effects = (0..fitted.terms.len())
        .map(|index| ModelEffect {
            effect: effects[index].facts().id,
            parameters: parameters(&prepared, &fitted, index, kept[index].dispersion),
        })
        .collect();
    let errors = errors(&prepared, &fitted, &fitted.terms);
    Ok(Model { effects, errors, noise: fitted.noise })
}

impl Model {
    /// Errors of this model, as it is, on other runs than those that it was fitted to.
    pub fn errors_on(&self, campaign: &Campaign) -> Result<Errors, RecordingError> {
        let prepared = campaign.prepare()?;
        let mut terms: Vec<Term<'static>> = self
            .effects
            .iter()
            .filter_map(|it| {
                let values = it.parameters.iter().map(|it| it.value).collect();
                Some(Term { effect: find(it.effect)?, values, column: None })
            })
            .collect();
        let evidence = Evidence::gather(&prepared, &mut terms, &self.noise);
        Ok(train(&prepared, (&evidence, &terms), &[], &self.noise))
    }
}
