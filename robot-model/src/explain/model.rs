//! A model that somebody chose: these effects and no others, fitted to a campaign.

use crate::effect::catalogue::{CATALOGUE, find};
use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::definition::{Effect, Need};
use crate::estimation::errors::{ErrorPair, Errors, train};
use crate::estimation::fit::{self, Fitted, fit_afresh};
use crate::estimation::normal_equations::CampaignEquations;
use crate::estimation::odometry_noise::OdometryNoise;
use crate::explain::answer::{HeldOut, ParameterFound};
use crate::explain::explanation::{errors, lacking, parameters};
use crate::explain::held_out;
use crate::recording::campaign::{Campaign, Prepared};
use crate::recording::run::RecordingError;
use crate::recording::run_kind::RunKind;
use crate::selection::candidates::Screening;

/// A gain that chance gives more often than this is no gain.
pub const CHANCE: f64 = 0.01;

/// A fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Its effects, in the order asked for.
    pub effects: Vec<ModelEffect>,
    /// Errors of the nominal robot.
    pub nominal: ErrorPair,
    /// Errors on the runs fitted to, and on runs held out.
    pub errors: ErrorPair,
    /// Errors on the runs kept aside, if there are any.
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
    /// What speaks for it, given all others.
    pub verdict: Verdict,
}

/// What speaks for an effect, given all others of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// By chance at least as much gain.
    pub p_value: f64,
    /// By how much -2 log likelihood falls on runs that were predicted by a fit to the others.
    pub cross_validated_gain: f64,
    /// By what factor runs disagree about it more than their noise explains, in variance.
    pub dispersion: f64,
    /// No robot has such values.
    pub implausible: bool,
    /// A kind of run that it predicts worse when fitted to the others.
    pub worse_kind: Option<RunKind>,
    /// Tracks of runs held out are predicted worse with it than without.
    pub spoils_tracks: bool,
    /// One run alone shows it: what it gains was held out of nothing.
    pub one_run_alone: bool,
    /// What the runs would have to have in order to show it, and lack.
    pub lacking: Option<Need>,
}

impl Verdict {
    /// Better than chance, on runs that it was not fitted to, and nothing speaks against it.
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
    let prepared = campaign.prepare()?;
    let fitted = fit_from_best_starts(&prepared, effects);
    let screening = Screening::new(&prepared, &fitted, &CATALOGUE);
    let (kept, spoils) = (screening.kept(), screening.spoils_tracks(&prepared));
    let effects = effects
        .iter()
        .map(|effect| {
            let id = effect.facts().id;
            let at = fitted.terms.iter().position(|it| it.effect.facts().id == id);
            let index = at.expect("every effect asked for is in the model");
            let it = &kept[index];
            ModelEffect {
                effect: id.to_owned(),
                parameters: parameters(&prepared, &fitted, index, it.dispersion),
                verdict: Verdict {
                    p_value: it.p_value,
                    cross_validated_gain: it.cross_validated_gain,
                    dispersion: it.dispersion,
                    implausible: it.implausible,
                    worse_kind: it.worse_kind.map(|(kind, _)| kind),
                    spoils_tracks: spoils[index],
                    one_run_alone: it.one_run_alone,
                    lacking: lacking(&prepared, &effect.facts()),
                },
            }
        })
        .collect();
    let nominal = errors(&prepared, &fitted, &[]);
    let errors = errors(&prepared, &fitted, &fitted.terms);
    let held_out = held_out::errors(&prepared, &[], &fitted.terms, &fitted.noise);
    Ok(Model { effects, nominal, errors, held_out, noise: fitted.noise })
}

/// Effects without shapes first; those with shapes join one after the other, each at the start that
/// gains most by then.
pub(crate) fn fit_from_best_starts<'a>(
    prepared: &Prepared,
    effects: &[&'a dyn Effect],
) -> Fitted<'a> {
    let starts = |effect: &dyn Effect| effect.starts(&prepared.survey);
    let (shaped, plain): (Vec<_>, Vec<_>) =
        effects.iter().copied().partition(|effect| starts(*effect).len() > 1);
    let terms =
        plain.into_iter().map(|effect| Term::new(effect, starts(effect).swap_remove(0))).collect();
    let mut fitted = fit_afresh(prepared, terms);
    for effect in shaped {
        let screening = Screening::new(prepared, &fitted, &[effect]);
        let mut terms = fitted.terms.clone();
        // One of which no start can be judged, as with numbers that are none, begins at its first.
        let found = screening.candidates(&[]).into_iter().map(|it| it.term.fixed()).next();
        terms.push(found.unwrap_or_else(|| Term::new(effect, starts(effect).swap_remove(0))));
        fitted = fit::fit(prepared, terms, fitted.noise);
    }
    fitted
}

impl Model {
    /// Whether all that it says are numbers: an expression of one's own may overflow.
    pub fn is_finite(&self) -> bool {
        let held_out = self.held_out.iter().flat_map(|it| [it.baseline, it.model]);
        let errors =
            [self.nominal, self.errors].into_iter().flat_map(|it| [it.train, it.cross_validated]);
        let errors =
            errors.chain(held_out).flat_map(|it| [it.position_rms_m, it.heading_rms_rad, it.chi]);
        let parameters = self.effects.iter().flat_map(|it| &it.parameters);
        let parameters = parameters.flat_map(|it| [it.value, it.sigma, it.low95, it.high95]);
        errors.chain(parameters).chain(self.noise.to_array()).all(f64::is_finite)
    }

    /// Errors of this model, as it is, on other runs than those that it was fitted to; of the catalogue's
    /// effects, as one of the user's own is not found by its id alone. Runs that are held out count too.
    pub fn errors_on(&self, campaign: &Campaign) -> Result<Errors, RecordingError> {
        let mut all = campaign.clone();
        all.runs.iter_mut().for_each(|run| run.held_out = false);
        let prepared = all.prepare()?;
        let terms: Vec<Term<'_>> = self
            .effects
            .iter()
            .filter_map(|it| {
                let values = it.parameters.iter().map(|it| it.value).collect();
                Some(Term::new(find(&it.effect)?, values))
            })
            .collect();
        let terms = PlacedTerm::place(&terms);
        let equations = CampaignEquations::gather(&prepared, &terms, &self.noise);
        Ok(train(&prepared, (&equations, &terms), &[], &self.noise))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::synthetic::{campaign, full_plan};

    #[test]
    fn what_runs_cannot_show_is_said_of_an_effect_that_was_asked_for() {
        let mut campaign = campaign(&full_plan(), &[], 5);
        campaign.runs.iter_mut().for_each(|run| run.payload_kg = 0.0);
        let model = fit(&campaign, &[find("payload").unwrap(), find("scrub").unwrap()]).unwrap();
        let [payload, scrub] = &model.effects[..] else { panic!("{:?}", model.effects) };
        assert!(!payload.verdict.better(), "{:?}", payload.verdict);
        assert_eq!(payload.verdict.lacking, Some(Need::Load));
        assert_eq!(scrub.verdict.lacking, None);
    }

    #[test]
    fn an_expression_that_overflows_is_no_panic_and_can_be_told() {
        let campaign = campaign(&full_plan(), &[], 5);
        let own = |id: &str, equation: &str| {
            let own = crate::effect::custom::Custom::from_equation(equation).unwrap();
            crate::effect::custom::Custom { id: id.to_owned(), ..own }.build().unwrap()
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
}
