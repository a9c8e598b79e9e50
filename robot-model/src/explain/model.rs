//! A model whose effects the user chose: how well does it predict, and what speaks for each effect?
//!
//! Nothing is added or removed here; `selection` searches for effects.

use crate::clocks;
use crate::effect::catalogue::CATALOGUE;
use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::definition::{Effect, Need};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::errors::{ErrorPair, Errors, errors_on_runs};
use crate::estimation::fit::{self, Fitted, Nearness, fit_afresh};
use crate::explain::answer::{Answer, Averaged, HeldOut, ParameterFound};
use crate::explain::explanation::lacking;
use crate::explain::held_out;
use crate::explain::model_errors::{errors, errors_as_fitted};
use crate::explain::parameters::parameters;
use crate::recording::campaign::{Campaign, Prepared};
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run::RecordingError;
use crate::recording::run_kind::RunKind;
use crate::selection::candidates::Screening;

/// A gain that chance gives more often than this is no gain.
pub const CHANCE: f64 = 0.01;

/// A fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Its effects, in the order given.
    pub effects: Vec<ModelEffect>,
    /// Errors of the nominal robot.
    pub nominal: ErrorPair,
    /// Errors of the model: on the runs fitted to, and cross-validated.
    pub errors: ErrorPair,
    /// Errors on the held-out runs, if there are any.
    pub held_out: Option<HeldOut>,
    /// The noise that goes with it.
    pub noise: OdometryNoise,
}

/// One effect of a fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelEffect {
    /// Its id.
    pub effect: String,
    /// Its parameters.
    pub parameters: Vec<ParameterFound>,
    /// The evidence for it, given all others.
    pub verdict: EffectVerdict,
}

/// The evidence for an effect, given all others of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectVerdict {
    /// Probability of at least as much gain by chance.
    pub p_value: f64,
    /// Cross-validated: by how much -2 log likelihood falls.
    pub cross_validated_gain: f64,
    /// Variance of its values among runs over what their noise explains.
    pub dispersion: f64,
    /// Its values lie outside the plausible range.
    pub implausible: bool,
    /// A kind of run that it predicts worse when fitted to the other kinds.
    pub worse_kind: Option<RunKind>,
    /// The cross-validated tracks are worse with it than without.
    pub spoils_tracks: bool,
    /// Only one run shows it, so its gain is not cross-validated.
    pub one_run_alone: bool,
    /// What the runs lack to show it.
    pub lacking: Option<Need>,
}

impl EffectVerdict {
    /// Whether its cross-validated gain is more than chance gives, and nothing speaks against it.
    pub fn better(&self) -> bool {
        self.p_value < CHANCE
            && self.cross_validated_gain > 0.0
            && self.lacking.is_none()
            && !self.implausible
            && !self.spoils_tracks
            && self.worse_kind.is_none()
    }
}

/// Fits these effects to a campaign.
pub fn fit(campaign: &Campaign, effects: &[&dyn Effect]) -> Result<Model, RecordingError> {
    Ok(ModelFitter::new(campaign)?.fit(effects))
}

/// A campaign that many models are fitted to: its clocks are brought together once.
#[derive(Debug)]
pub struct ModelFitter {
    prepared: Prepared,
}

impl ModelFitter {
    /// Of the runs that are not held out.
    pub fn new(campaign: &Campaign) -> Result<Self, RecordingError> {
        Ok(Self { prepared: clocks::prepare(campaign)?.0 })
    }

    /// The values of these effects, fitted with a noise that is known already; an effect's shapes begin at the first of their
    /// starts. A glance: what speaks for an effect, and how well others are predicted, is left to [`fit`](Self::fit).
    pub fn values(&self, effects: &[&dyn Effect], noise: OdometryNoise) -> Vec<Vec<f64>> {
        let start = |effect: &&dyn Effect| effect.starts(&self.prepared.excitation).swap_remove(0);
        let terms = effects.iter().map(|effect| Term::new(*effect, start(effect))).collect();
        let fitted = fit::fit_parameters(&self.prepared, terms, noise);
        fitted.terms.into_iter().map(|term| term.values).collect()
    }

    /// Fits these effects.
    pub fn fit(&self, effects: &[&dyn Effect]) -> Model {
        let prepared = &self.prepared;
        let fitted = fit_from_best_starts(prepared, effects);
        let screening = Screening::new(prepared, &fitted, &CATALOGUE);
        let (kept, spoils) = (screening.kept(), screening.spoils_tracks(prepared));
        let mut parameters = parameters(prepared, &fitted, kept);
        let effects = effects
            .iter()
            .map(|effect| {
                let id = effect.facts().id;
                let at = fitted.terms.iter().position(|term| term.effect.facts().id == id);
                let index = at.expect("every effect given is in the model");
                let test = &kept[index];
                ModelEffect {
                    effect: id.to_owned(),
                    parameters: core::mem::take(&mut parameters[index]),
                    verdict: EffectVerdict {
                        p_value: test.p_value,
                        cross_validated_gain: test.cross_validated_gain,
                        dispersion: test.dispersion,
                        implausible: test.implausible,
                        worse_kind: test.worse_kind.map(|(kind, _)| kind),
                        spoils_tracks: spoils[index],
                        one_run_alone: test.one_run_alone,
                        lacking: lacking(prepared, &effect.facts()),
                    },
                }
            })
            .collect();
        let nominal = errors(prepared, &fitted.noise, &[]);
        let errors = errors_as_fitted(prepared, &fitted.noise, &fitted.terms);
        let held_out = held_out::errors(prepared, &[], &fitted.terms, &fitted.noise);
        Model { effects, nominal, errors, held_out, noise: fitted.noise }
    }
}

/// Fits effects without shapes first. Those with shapes join one by one, each at the start that gains
/// most at that point.
pub(crate) fn fit_from_best_starts<'a>(
    prepared: &Prepared,
    effects: &[&'a dyn Effect],
) -> Fitted<'a> {
    let starts = |effect: &dyn Effect| effect.starts(&prepared.excitation);
    let (shaped, plain): (Vec<_>, Vec<_>) =
        effects.iter().copied().partition(|effect| starts(*effect).len() > 1);
    let terms =
        plain.into_iter().map(|effect| Term::new(effect, starts(effect).swap_remove(0))).collect();
    let mut fitted = fit_afresh(prepared, terms);
    for effect in shaped {
        let screening = Screening::new(prepared, &fitted, &[effect]);
        let mut terms = fitted.terms.clone();
        // An effect of which no start can be tested, as its numbers are not finite, begins at its first.
        let found = screening.candidates().first().map(|candidate| candidate.term.fixed());
        terms.push(found.unwrap_or_else(|| Term::new(effect, starts(effect).swap_remove(0))));
        fitted = fit::fit(prepared, terms, fitted.noise, Nearness::Converged);
    }
    fitted
}

impl Model {
    /// Whether every number of the model is one: an expression of the user's own may overflow. Where the
    /// information of its column overflows, the parameter comes out as 0 +- 0, so a standard error of exactly
    /// zero does not count as finite either.
    pub fn is_finite(&self) -> bool {
        let held_out = self.held_out.iter().flat_map(|errors| [errors.baseline, errors.model]);
        let pairs = [self.nominal, self.errors].into_iter();
        let mut numbers = pairs
            .flat_map(|pair| [pair.fitted, pair.cross_validated])
            .chain(held_out)
            .flat_map(|errors| [errors.position_rms_m, errors.heading_rms_rad, errors.chi])
            .chain(self.noise.to_array());
        let mut parameters = self.effects.iter().flat_map(|effect| &effect.parameters);
        numbers.all(f64::is_finite) && parameters.all(ParameterFound::is_finite)
    }

    /// Errors of this model, as it is, on other runs than those that it was fitted to, held-out ones
    /// included. Only effects of the catalogue count: the id alone does not give one of the user's own.
    pub fn errors_on(&self, campaign: &Campaign) -> Result<Errors, RecordingError> {
        let of = |one: &ModelEffect| (one.effect.clone(), one.parameters.clone(), None);
        let effects = self.effects.iter().map(of);
        errors_on(campaign, effects, (&self.noise, &CATALOGUE))
    }
}

impl Answer {
    /// Errors of what is found, as it predicts other runs, on such runs, held-out ones included. Only effects of the
    /// catalogue count.
    pub fn errors_on(&self, campaign: &Campaign) -> Result<Errors, RecordingError> {
        self.errors_on_with(campaign, &CATALOGUE)
    }

    /// The same with the effects of any catalogue.
    pub(crate) fn errors_on_with(
        &self,
        campaign: &Campaign,
        catalogue: &[&dyn Effect],
    ) -> Result<Errors, RecordingError> {
        let of = |one: &Averaged| (one.effect.clone(), one.parameters.clone(), one.up_to_mps);
        let effects = self.predicts_with.iter().map(of);
        errors_on(campaign, effects, (&self.noise, catalogue))
    }
}

fn errors_on(
    campaign: &Campaign,
    effects: impl Iterator<Item = (String, Vec<ParameterFound>, Option<f64>)>,
    (noise, catalogue): (&OdometryNoise, &[&dyn Effect]),
) -> Result<Errors, RecordingError> {
    let mut all = campaign.clone();
    all.runs.iter_mut().for_each(|run| run.held_out = false);
    let prepared = clocks::prepare(&all)?.0;
    let terms: Vec<Term<'_>> = effects
        .filter_map(|(id, parameters, up_to_mps)| {
            let values = parameters.iter().map(|parameter| parameter.value).collect();
            let effect = catalogue.iter().find(|effect| effect.facts().id == id)?;
            Some(Term { up_to_mps, ..Term::new(*effect, values) })
        })
        .collect();
    let terms = PlacedTerm::place(&terms);
    let equations = CampaignEquations::gather(&prepared, &terms, noise);
    Ok(errors_on_runs(&prepared, (&equations, &terms), &[], noise))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::catalogue::find;
    use crate::effect::custom::Custom;
    use crate::tests::synthetic::{campaign, full_plan};

    #[test]
    fn an_effect_that_the_runs_cannot_show_is_reported_with_what_they_lack() {
        let mut campaign = campaign(&full_plan(), &[], 5);
        campaign.runs.iter_mut().for_each(|run| run.payload_kg = 0.0);
        let model = fit(&campaign, &[find("payload").unwrap(), find("scrub").unwrap()]).unwrap();
        let [payload, scrub] = &model.effects[..] else { panic!("{:?}", model.effects) };
        assert!(!payload.verdict.better(), "{:?}", payload.verdict);
        assert_eq!(payload.verdict.lacking, Some(Need::Load));
        assert_eq!(scrub.verdict.lacking, None);
    }

    #[test]
    fn an_expression_that_overflows_does_not_panic_and_numbers_that_are_not_finite_are_noticed() {
        let campaign = campaign(&full_plan(), &[], 5);
        let own = |id: &str, equation: &str| {
            let own = Custom::from_equation(equation).unwrap();
            Custom { id: id.to_owned(), ..own }.build().unwrap()
        };
        let wild = own("wild", "dtheta = k * exp(1000*v/0.1[m/s])");
        let wave = own("wave", "dtheta/ds = k * sin(phi_left + p)");
        let model = fit(&campaign, &[&wild, &wave]).unwrap();
        assert_eq!(model.effects.len(), 2);
        let sound = fit(&campaign, &[&wave]).unwrap();
        let mut broken = [sound.clone(), sound.clone(), sound.clone()];
        broken[0].errors.cross_validated.chi = f64::INFINITY;
        broken[1].noise.travel_walk = f64::NAN;
        broken[2].effects[0].parameters[0].high95 = f64::INFINITY;
        assert!(sound.is_finite() && !broken.iter().any(Model::is_finite));
    }

    #[test]
    fn a_standard_error_of_exactly_zero_is_not_finite() {
        let campaign = campaign(&full_plan(), &[], 5);
        let own = Custom::from_equation("dtheta = k * exp(v/0.0001[m/s])").unwrap();
        let model = fit(&campaign, &[&own.build().unwrap()]).unwrap();
        // The information of the column is infinite, and everything that comes of it is finite.
        let parameter = &model.effects[0].parameters[0];
        assert_eq!((parameter.value, parameter.sigma), (0.0, 0.0), "{parameter:?}");
        assert!(!model.is_finite());
    }
}
