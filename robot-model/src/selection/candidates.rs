//! A look at a campaign from one fitted model: the evidence about its own parameters and about every
//! candidate, gathered in one pass. What follows are questions to it.

use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::definition::{Effect, Group};
use crate::estimation::errors::{TrackErrors, cross_validated_tracks};
use crate::estimation::fit::Fitted;
use crate::estimation::normal_equations::CampaignEquations;
use crate::estimation::odometry_noise::OdometryNoise;
use crate::recording::campaign::Prepared;
use crate::selection::effect_test::{EffectTest, Hypothesis, run_scatter, scatter, test_effect};

/// Two explanations that differ by less in -2 log likelihood cannot be told apart: three sigma.
pub(crate) const RIVAL_MARGIN: f64 = 9.0;

/// One effect as a candidate, at the best start of its shapes.
#[derive(Clone, Debug)]
pub(crate) struct Candidate<'a> {
    pub term: PlacedTerm<'a>,
    pub test: EffectTest,
}

impl Candidate<'_> {
    pub fn id(&self) -> &str {
        self.term.effect.facts().id
    }
}

/// The evidence about a model and all candidates.
pub(crate) struct Screening<'a> {
    terms: Vec<PlacedTerm<'a>>,
    in_model: usize,
    equations: CampaignEquations,
    noise: OdometryNoise,
    /// How much runs disagree about what they are asked.
    scatter: f64,
}

/// A growth of squared errors by less than this share is rounding: effects of the yaw rate sensor do not
/// touch tracks at all.
const ROUNDING: f64 = 1e-6;

/// An effect of a model has to go if tracks of runs held out get better by more than this share without it.
const WORSE_TRACKS: f64 = 0.02;

/// Squared errors of tracks that fall by this share fall beyond doubt.
const GOOD_DEAL: f64 = 0.2;

/// A fit that came to rest is nearer to what it wants than this.
const UNSETTLED_SIGMAS: f64 = 1.0;

/// What an effect's parameters, shapes included, cost in -2 log likelihood: Akaike's two each.
pub(crate) fn penalty(term: &Term<'_>) -> f64 {
    2.0 * term.values.len() as f64
}

/// Whether an effect is of the radii and the track width.
pub(crate) fn is_geometry(effect: &dyn Effect) -> bool {
    effect.facts().group == Group::Geometry
}

impl<'a> Screening<'a> {
    pub fn new(prepared: &Prepared, fitted: &Fitted<'a>, catalogue: &[&'a dyn Effect]) -> Self {
        let mut terms = fitted.terms.clone();
        let in_model = terms.len();
        for effect in catalogue {
            let id = effect.facts().id;
            if terms[..in_model].iter().all(|it| it.effect.facts().id != id) {
                for values in effect.starts(&prepared.survey) {
                    terms.push(Term::new(*effect, values));
                }
            }
        }
        let terms = PlacedTerm::place(&terms);
        let equations = CampaignEquations::gather(prepared, &terms, &fitted.noise);
        let mut screening = Self { terms, in_model, equations, noise: fitted.noise, scatter: 1.0 };
        let model = screening.model_columns(&[]);
        let asked: Vec<Vec<usize>> =
            (0..screening.terms.len()).map(|it| screening.amplitudes(it)).collect();
        let others = |index: usize| {
            let own = if index < in_model { &asked[index][..] } else { &[] };
            let others = model.iter().filter(|it| !own.contains(it));
            others.copied().collect::<Vec<usize>>()
        };
        let given: Vec<Vec<usize>> = (0..asked.len()).map(others).collect();
        let hypotheses = given.iter().zip(&asked).map(|(given, asked)| (&given[..], &asked[..]));
        // What a run may have for itself are its own radii and track width.
        let of_geometry = |index: &usize| is_geometry(screening.terms[*index].effect);
        let own: Vec<usize> =
            (0..asked.len()).filter(of_geometry).flat_map(|it| asked[it].clone()).collect();
        screening.scatter = scatter(&screening.equations, hypotheses).max(run_scatter(
            &screening.equations,
            &model,
            &own,
        ));
        screening
    }

    /// How many effects are asked about: those of the model and the candidates.
    pub fn asked(&self) -> usize {
        let mut ids: Vec<&str> = self.terms.iter().map(|it| it.effect.facts().id).collect();
        ids.dedup();
        ids.len()
    }

    /// The evidence and its terms, the model's first.
    pub fn equations(&self) -> (&CampaignEquations, &[PlacedTerm<'a>]) {
        (&self.equations, &self.terms)
    }

    /// An effect of the model.
    pub fn term(&self, index: usize) -> &Term<'a> {
        &self.terms[index]
    }

    /// The columns of the model's effects, but those of the effects left out.
    pub fn model_columns(&self, left_out: &[usize]) -> Vec<usize> {
        let kept = self.terms[..self.in_model].iter().enumerate();
        kept.filter(|(index, _)| !left_out.contains(index))
            .flat_map(|(_, term)| term.columns())
            .collect()
    }

    fn amplitudes(&self, index: usize) -> Vec<usize> {
        self.terms[index].amplitudes()
    }

    /// The evidence as it is with these effects of the model gone.
    fn equations_without(&self, left_out: &[usize]) -> CampaignEquations {
        let mut equations = self.equations.clone();
        for index in left_out {
            let term = &self.terms[*index];
            for column in term.amplitudes() {
                equations.shift(column, -term.value(column));
            }
        }
        equations
    }

    /// What speaks for each effect of the model, given all its others.
    pub fn kept(&self) -> Vec<EffectTest> {
        (0..self.in_model)
            .map(|index| {
                let model = self.model_columns(&[index]);
                let asked = self.amplitudes(index);
                let (effect, scatter) = (self.terms[index].effect, self.scatter);
                let hypothesis = Hypothesis { model: &model, asked: &asked, effect, scatter };
                test_effect(&self.equations_without(&[index]), &hypothesis)
            })
            .collect()
    }

    /// What speaks for each candidate, given the model without these effects of it.
    pub fn candidates(&self, left_out: &[usize]) -> Vec<Candidate<'a>> {
        self.candidates_that_gain(left_out, f64::NEG_INFINITY)
    }

    /// The same of those alone whose gain, less the penalty of their parameters, is at least so much.
    pub fn candidates_that_gain(&self, left_out: &[usize], least: f64) -> Vec<Candidate<'a>> {
        let equations = self.equations_without(left_out);
        let model = self.model_columns(left_out);
        let chi_squared = |columns: &[usize]| {
            let delta = equations.solve(&equations.total, columns).delta;
            equations.total.chi_squared(columns, &delta)
        };
        let without = chi_squared(&model);
        // Of each effect, the start of its shapes that gains most.
        let mut best: Vec<(usize, f64)> = Vec::new();
        for index in self.in_model..self.terms.len() {
            let both: Vec<usize> = model.iter().copied().chain(self.amplitudes(index)).collect();
            let gain = without - chi_squared(&both);
            let same = |other: usize| {
                self.terms[other].effect.facts().id == self.terms[index].effect.facts().id
            };
            match best.last_mut() {
                Some(last) if same(last.0) => {
                    if gain > last.1 {
                        *last = (index, gain);
                    }
                }
                _ => best.push((index, gain)),
            }
        }
        best.into_iter()
            .filter(|(index, gain)| gain - penalty(&self.terms[*index]) >= least)
            .map(|(index, _)| {
                let asked = self.amplitudes(index);
                let term = self.terms[index].clone();
                let (effect, scatter) = (term.effect, self.scatter);
                let hypothesis = Hypothesis { model: &model, asked: &asked, effect, scatter };
                Candidate { test: test_effect(&equations, &hypothesis), term }
            })
            .collect()
    }

    /// Whether tracks of runs held out are predicted worse with a candidate in place of some effects of
    /// the model than with the model as it is.
    pub fn tracks_get_worse(
        &self,
        prepared: &Prepared,
        left_out: &[usize],
        candidate: &PlacedTerm<'a>,
    ) -> bool {
        let with = self.cross_validated_tracks(prepared, left_out, Some(candidate));
        let as_it_is = self.cross_validated_tracks(prepared, &[], None);
        with.zip(as_it_is).is_some_and(|(with, as_it_is)| with.worse_than(as_it_is, ROUNDING))
    }

    /// For each effect of the model, whether tracks of runs held out are predicted worse with it than without.
    pub fn spoils_tracks(&self, prepared: &Prepared) -> Vec<bool> {
        let whole = self.cross_validated_tracks(prepared, &[], None);
        let spoils = |index: usize| {
            let without = self.cross_validated_tracks(prepared, &[index], None);
            whole.zip(without).is_some_and(|(whole, it)| whole.worse_than(it, WORSE_TRACKS))
        };
        (0..self.in_model).map(spoils).collect()
    }

    /// For each effect of the model, whether it stands at nothing though the runs say there that it should not, so
    /// that its fit never came to rest: what is said of it then is about no value. (At a kink, as of a threshold, a
    /// fit may rest where they would have it further on.)
    pub fn is_unsettled(&self) -> Vec<bool> {
        let columns = self.model_columns(&[]);
        let solution = self.equations.solve(&self.equations.total, &columns);
        let effect = |index: usize| {
            let (own, term) = (self.amplitudes(index), &self.terms[index]);
            let standing = (0..columns.len()).filter(|i| own.contains(&columns[*i])).map(|i| {
                let sigma = UNSETTLED_SIGMAS * solution.covariance[(i, i)].sqrt();
                (term.value(columns[i]).abs() < sigma, solution.delta[i].abs() > sigma)
            });
            let (nothing, far) = standing.fold((true, false), |(a, b), it| (a && it.0, b || it.1));
            nothing && far
        };
        (0..self.in_model).map(effect).collect()
    }

    /// The effects of the model, but for its geometry, by which tracks of runs held out get better by less than
    /// a good deal.
    pub fn hardly_better_tracks(&self, prepared: &Prepared) -> Vec<usize> {
        let whole = self.cross_validated_tracks(prepared, &[], None);
        let asked = |index: &usize| {
            let without = self.cross_validated_tracks(prepared, &[*index], None);
            !is_geometry(self.terms[*index].effect)
                && whole.zip(without).is_some_and(|(whole, it)| whole.worse_than(it, -GOOD_DEAL))
        };
        (0..self.in_model).filter(asked).collect()
    }

    /// Whether tracks of runs held out are predicted worse than by a model that was fitted for itself.
    pub fn tracks_are_worse_than(&self, prepared: &Prepared, other: &Fitted<'a>) -> bool {
        let terms = PlacedTerm::place(&other.terms);
        let equations = CampaignEquations::gather(prepared, &terms, &other.noise);
        let columns: Vec<usize> = (0..equations.priors.len()).collect();
        let there = cross_validated_tracks(prepared, (&equations, &terms), &columns, &self.noise);
        let here = self.cross_validated_tracks(prepared, &[], None);
        here.zip(there).is_some_and(|(here, there)| here.worse_than(there, WORSE_TRACKS))
    }

    fn cross_validated_tracks(
        &self,
        prepared: &Prepared,
        left_out: &[usize],
        candidate: Option<&PlacedTerm<'a>>,
    ) -> Option<TrackErrors> {
        let equations = self.equations_without(left_out);
        let mut columns = self.model_columns(left_out);
        let kept = self.terms[..self.in_model].iter().enumerate();
        let mut terms: Vec<PlacedTerm<'a>> =
            kept.filter(|(i, _)| !left_out.contains(i)).map(|(_, it)| it.clone()).collect();
        if let Some(term) = candidate {
            columns.extend(term.amplitudes());
            terms.push(term.clone());
        }
        cross_validated_tracks(prepared, (&equations, &terms), &columns, &self.noise)
    }

    /// The share of what an effect of the model does that a candidate could do in its place.
    pub fn resemblance(&self, index: usize, candidate: &PlacedTerm<'a>) -> f64 {
        let term = &self.terms[index];
        let columns = self.amplitudes(index);
        let values: Vec<f64> = columns.iter().map(|column| term.value(*column)).collect();
        let model = self.model_columns(&[index]);
        let mut with = model.clone();
        with.extend(candidate.amplitudes());
        let left = |others: &[usize]| {
            self.equations.separation(&self.equations.total, &columns, &values, others)
        };
        1.0 - left(&with) / left(&model).max(f64::MIN_POSITIVE)
    }

    /// -2 log likelihood and penalty of the model without these effects of it, the rest fitted anew.
    pub fn cost_without(&self, left_out: &[usize]) -> f64 {
        self.cost(left_out, None)
    }

    /// The same with a candidate in it.
    pub fn cost(&self, left_out: &[usize], candidate: Option<&PlacedTerm<'a>>) -> f64 {
        let equations = self.equations_without(left_out);
        let mut columns = self.model_columns(left_out);
        let kept = self.terms[..self.in_model].iter().enumerate();
        let kept = kept.filter(|(index, _)| !left_out.contains(index)).map(|(_, term)| term);
        let price: f64 = kept.chain(candidate).map(|term| penalty(term)).sum();
        if let Some(term) = candidate {
            columns.extend(term.amplitudes());
        }
        let delta = equations.solve(&equations.total, &columns).delta;
        equations.total.chi_squared(&columns, &delta) + price
    }
}
