//! Every candidate beside a fitted model: what would it gain, and would tracks be predicted better?
//!
//! The normal equations of the model's own parameters and of every candidate are gathered in one pass; all questions
//! after that are answered from them. The test of one effect is in [`crate::selection::effect_test`]; which candidate
//! enters the model is decided in [`crate::selection::select`].

use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::definition::{Effect, Group};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::errors::{TrackErrors, cross_validated_tracks, tracks};
use crate::estimation::fit::Fitted;
use crate::estimation::normal_equations::Sums;
use crate::numeric::parallel;
use crate::recording::campaign::Prepared;
use crate::recording::odometry_noise::OdometryNoise;
use crate::selection::answers::{Answers, known};
use crate::selection::dispersion::{run_scatter, scatter};
use crate::selection::effect_test::{EffectTest, test_effect};
use crate::selection::gain::Hypothesis;
use crate::selection::track_gain::TrackGain;

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

/// The normal equations of a model and of all candidates.
pub(crate) struct Screening<'a> {
    terms: Vec<PlacedTerm<'a>>,
    in_model: usize,
    equations: CampaignEquations,
    noise: OdometryNoise,
    /// By how much more runs disagree, in the median, than their noise explains.
    scatter: f64,
    answers: Answers,
}

/// A growth of squared errors by less than this share is rounding: effects of the yaw rate sensor do not
/// change tracks at all.
const ROUNDING: f64 = 1e-6;

/// An effect is removed if cross-validated tracks get better by more than this share without it.
const WORSE_TRACKS: f64 = 0.02;

/// A fall of the squared errors of tracks by this share is beyond doubt.
const CLEAR_GAIN: f64 = 0.2;

/// A fit that has converged is nearer to its optimum than this.
const UNSETTLED_SIGMAS: f64 = 1.0;

/// What an effect's parameters, shapes included, cost in -2 log likelihood: Akaike's two each.
pub(crate) fn penalty(term: &Term<'_>) -> f64 {
    2.0 * term.values.len() as f64
}

/// Whether an effect is one of radii and track width.
pub(crate) fn is_geometry(effect: &dyn Effect) -> bool {
    effect.facts().group == Group::Geometry
}

impl<'a> Screening<'a> {
    pub fn new(prepared: &Prepared, fitted: &Fitted<'a>, catalogue: &[&'a dyn Effect]) -> Self {
        let mut terms = fitted.terms.clone();
        let in_model = terms.len();
        for effect in catalogue {
            let id = effect.facts().id;
            if terms[..in_model].iter().all(|term| term.effect.facts().id != id) {
                for values in effect.starts(&prepared.excitation) {
                    terms.push(Term::new(*effect, values));
                }
            }
        }
        let terms = PlacedTerm::place(&terms);
        let equations = CampaignEquations::gather(prepared, &terms, &fitted.noise);
        let answers = Answers::none(in_model);
        let noise = fitted.noise;
        let mut screening = Self { terms, in_model, equations, noise, scatter: 1.0, answers };
        let model = screening.model_columns(&[]);
        let asked: Vec<Vec<usize>> =
            (0..screening.terms.len()).map(|index| screening.amplitudes(index)).collect();
        let others = |index: usize| {
            let own = if index < in_model { &asked[index][..] } else { &[] };
            let others = model.iter().filter(|column| !own.contains(column));
            others.copied().collect::<Vec<usize>>()
        };
        let given: Vec<Vec<usize>> = (0..asked.len()).map(others).collect();
        let hypotheses = given.iter().zip(&asked).map(|(given, asked)| (&given[..], &asked[..]));
        // Runs may differ in radii and track width of their own.
        let of_geometry = |index: &usize| is_geometry(screening.terms[*index].effect);
        let own: Vec<usize> =
            (0..asked.len()).filter(of_geometry).flat_map(|index| asked[index].clone()).collect();
        screening.scatter = scatter(&screening.equations, hypotheses).max(run_scatter(
            &screening.equations,
            &model,
            &own,
        ));
        screening
    }

    /// How many effects are tested: those of the model and the candidates.
    pub fn asked(&self) -> usize {
        let mut ids: Vec<&str> = self.terms.iter().map(|term| term.effect.facts().id).collect();
        ids.dedup();
        ids.len()
    }

    /// The normal equations and their terms, the model's first.
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

    /// The columns of radii and track width in the model.
    fn geometry_columns(&self) -> Vec<usize> {
        let terms = self.terms[..self.in_model].iter();
        terms.filter(|term| is_geometry(term.effect)).flat_map(|term| term.columns()).collect()
    }

    fn amplitudes(&self, index: usize) -> Vec<usize> {
        self.terms[index].amplitudes()
    }

    /// The normal equations about the point at which these effects of the model are zero.
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

    /// The test of each effect of the model, given all its others.
    pub fn kept(&self) -> &[EffectTest] {
        known::<Vec<_>>(&self.answers.kept, || self.tests_of_kept())
    }

    fn tests_of_kept(&self) -> Vec<EffectTest> {
        let effects: Vec<usize> = (0..self.in_model).collect();
        parallel::map(&effects, |index| {
            let model = self.model_columns(&[*index]);
            let asked = self.amplitudes(*index);
            let (effect, scatter) = (self.terms[*index].effect, self.scatter);
            let geometry = self.geometry_columns();
            let hypothesis =
                Hypothesis { model: &model, asked: &asked, effect, geometry: &geometry, scatter };
            test_effect(&self.equations_without(&[*index]), &hypothesis)
        })
    }

    /// The test of each candidate, given the model.
    pub fn candidates(&self) -> Vec<Candidate<'a>> {
        let find = || self.tests_that_gain(&[], f64::NEG_INFINITY);
        self.named(known::<Vec<_>>(&self.answers.candidates, find))
    }

    fn named(&self, tests: &[(usize, EffectTest)]) -> Vec<Candidate<'a>> {
        let named = |(index, test): &(usize, EffectTest)| Candidate {
            term: self.terms[*index].clone(),
            test: test.clone(),
        };
        tests.iter().map(named).collect()
    }

    /// The same, only for candidates whose gain less the penalty of their parameters is at least `least`.
    pub fn candidates_that_gain(&self, left_out: &[usize], least: f64) -> Vec<Candidate<'a>> {
        self.named(&self.tests_that_gain(left_out, least))
    }

    fn tests_that_gain(&self, left_out: &[usize], least: f64) -> Vec<(usize, EffectTest)> {
        let equations = self.equations_without(left_out);
        let model = self.model_columns(left_out);
        let chi_squared = |columns: &[usize]| {
            let delta = equations.best(&equations.total, columns);
            equations.total.chi_squared(columns, &delta)
        };
        let without = chi_squared(&model);
        // For each effect, the start of its shapes that gains most.
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
        best.retain(|(index, gain)| gain - penalty(&self.terms[*index]) >= least);
        parallel::map(&best, |(index, _)| {
            let asked = self.amplitudes(*index);
            let (effect, scatter) = (self.terms[*index].effect, self.scatter);
            let geometry = self.geometry_columns();
            let hypothesis =
                Hypothesis { model: &model, asked: &asked, effect, geometry: &geometry, scatter };
            (*index, test_effect(&equations, &hypothesis))
        })
    }

    /// Whether cross-validated tracks get worse with a candidate in place of some effects of the model.
    pub fn tracks_get_worse(
        &self,
        prepared: &Prepared,
        left_out: &[usize],
        candidate: &PlacedTerm<'a>,
    ) -> bool {
        let with = self.cross_validated_tracks(prepared, left_out, Some(candidate));
        let as_it_is = self.tracks_without(prepared, None);
        with.zip(as_it_is).is_some_and(|(with, as_it_is)| with.worse_than(as_it_is, ROUNDING))
    }

    /// For each effect of the model, whether cross-validated tracks are worse with it than without.
    pub fn spoils_tracks(&self, prepared: &Prepared) -> Vec<bool> {
        (0..self.in_model).map(|index| self.worse_with(prepared, index, WORSE_TRACKS)).collect()
    }

    /// For each effect of the model, whether its fit has not converged: its value is zero although the gradient there
    /// is not, so that its test is about no value. (At a kink, as at a threshold, a fit may converge with a gradient
    /// that is not zero.)
    pub fn is_unsettled(&self) -> Vec<bool> {
        let columns = self.model_columns(&[]);
        let solution = self.equations.solve(&self.equations.total, &columns);
        let effect = |index: usize| {
            let (own, term) = (self.amplitudes(index), &self.terms[index]);
            let standing = (0..columns.len()).filter(|i| own.contains(&columns[*i])).map(|i| {
                let sigma = UNSETTLED_SIGMAS * solution.covariance[(i, i)].sqrt();
                (term.value(columns[i]).abs() < sigma, solution.delta[i].abs() > sigma)
            });
            let (nothing, far) =
                standing.fold((true, false), |(a, b), column| (a && column.0, b || column.1));
            nothing && far
        };
        (0..self.in_model).map(effect).collect()
    }

    /// For each effect of the model, whether the runs show it: they leave at most half of what is usual.
    pub fn is_shown(&self) -> Vec<bool> {
        let columns = self.model_columns(&[]);
        let solution = self.equations.solve(&self.equations.total, &columns);
        let sigma = |column: usize| {
            let i = columns.iter().position(|other| *other == column).expect("in the model");
            solution.covariance[(i, i)].sqrt()
        };
        let shown = |column: &usize| sigma(*column) < 0.5 * self.equations.priors[*column].spread;
        (0..self.in_model).map(|index| self.amplitudes(index).iter().all(shown)).collect()
    }

    /// The effects of the model, except its geometry, that do not improve cross-validated tracks beyond doubt.
    pub fn hardly_improves_tracks(&self, prepared: &Prepared) -> Vec<usize> {
        let hardly_improves = |index: &usize| {
            !is_geometry(self.terms[*index].effect)
                && self.worse_with(prepared, *index, -CLEAR_GAIN)
        };
        (0..self.in_model).filter(hardly_improves).collect()
    }

    /// Whether cross-validated tracks are worse than those of another model, which was fitted with its own noise.
    pub fn tracks_are_worse_than(&self, prepared: &Prepared, other: &Fitted<'a>) -> bool {
        let terms = PlacedTerm::place(&other.terms);
        let equations = CampaignEquations::gather(prepared, &terms, &other.noise);
        let columns: Vec<usize> = (0..equations.priors.len()).collect();
        let there = cross_validated_tracks(prepared, (&equations, &terms), &columns, &self.noise);
        let here = self.tracks_without(prepared, None);
        here.zip(there).is_some_and(|(here, there)| here.worse_than(&there, WORSE_TRACKS))
    }

    /// For each effect of the model, what cross-validated tracks gain by it, all others fitted anew.
    pub fn track_gains(&self, prepared: &Prepared) -> Vec<TrackGain> {
        let track_width_m = prepared.robot.track_width_m;
        let whole = self.tracks_left_out(prepared, &[]);
        let gain = |index: usize| {
            let without = self.tracks_left_out(prepared, &[index]);
            TrackGain::new(&without, &whole, track_width_m)
        };
        (0..self.in_model).map(gain).collect()
    }

    /// The mean squared displacement of the wheels in cross-validated tracks, without some effects of the model \[m^2\].
    pub fn displacement_m2(&self, prepared: &Prepared, left_out: &[usize]) -> f64 {
        self.tracks_left_out(prepared, left_out).displacement_m2(prepared.robot.track_width_m)
    }

    fn tracks_left_out(&self, prepared: &Prepared, left_out: &[usize]) -> TrackErrors {
        let (equations, terms, columns) = self.variant(left_out, None);
        tracks(prepared, (&equations, &terms), &columns, &self.noise)
    }

    /// Whether cross-validated tracks are worse with an effect of the model than without, by more than a share.
    fn worse_with(&self, prepared: &Prepared, index: usize, tolerance: f64) -> bool {
        let whole = self.tracks_without(prepared, None);
        let without = self.tracks_without(prepared, Some(index));
        whole.zip(without).is_some_and(|(whole, without)| whole.worse_than(without, tolerance))
    }

    /// The cross-validated tracks of the model, without one of its effects or with all. The runs are always those of
    /// [`Screening::new`].
    fn tracks_without(&self, prepared: &Prepared, left_out: Option<usize>) -> Option<&TrackErrors> {
        let answer = &self.answers.tracks[left_out.unwrap_or(self.in_model)];
        known(answer, || self.cross_validated_tracks(prepared, left_out.as_slice(), None)).as_ref()
    }

    fn cross_validated_tracks(
        &self,
        prepared: &Prepared,
        left_out: &[usize],
        candidate: Option<&PlacedTerm<'a>>,
    ) -> Option<TrackErrors> {
        let (equations, terms, columns) = self.variant(left_out, candidate);
        cross_validated_tracks(prepared, (&equations, &terms), &columns, &self.noise)
    }

    /// The model without some of its effects and with a candidate: normal equations, terms and columns to fit.
    fn variant(
        &self,
        left_out: &[usize],
        candidate: Option<&PlacedTerm<'a>>,
    ) -> (CampaignEquations, Vec<PlacedTerm<'a>>, Vec<usize>) {
        let equations = self.equations_without(left_out);
        let mut columns = self.model_columns(left_out);
        let kept = self.terms[..self.in_model].iter().enumerate();
        let mut terms: Vec<PlacedTerm<'a>> =
            kept.filter(|(i, _)| !left_out.contains(i)).map(|(_, term)| term.clone()).collect();
        if let Some(term) = candidate {
            columns.extend(term.amplitudes());
            terms.push(term.clone());
        }
        (equations, terms, columns)
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
        let delta = equations.best(&equations.total, &columns);
        equations.total.chi_squared(&columns, &delta) + price
    }
}
