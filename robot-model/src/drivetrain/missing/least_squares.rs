//! Which constants explain the travel best, and how well do the others predict each experiment?
//!
//! Output error: the model is driven by the voltage alone. What is left within an experiment is correlated, so every
//! judgement counts whole experiments: each is predicted by the constants that the others give, to first order about the fit of
//! all (they move by (H - H_g)^-1 g_g), and simulated with those.

use nalgebra::{DMatrix, DVector};

use super::alike::alike_together;
use super::experiment::{Experiment, KnownRobot};
use super::modes::Modes;
use super::simulate::{BASELINE, Simulation};
use crate::drivetrain::effect::{KnownMotorEffect, MotorParameter, MotorRole};
use crate::drivetrain::intervals::{Intervals, Share};
use crate::kinematics::WheelPair;
use crate::numeric::parallel;

/// Rounds of the search.
const ROUNDS_MAX: usize = 12;
/// So many samples are as good as one that is independent of the others.
const ALIKE: f64 = 50.0;
/// Parameters keep within so many of their usual sizes where the data say nothing.
const WIDE: f64 = 10.0;

/// The experiments that a model is fitted to.
#[derive(Clone)]
pub(super) struct Problem<'a> {
    pub robot: &'a KnownRobot,
    pub experiments: Vec<&'a Experiment>,
    /// How much each mode counts.
    pub weights: Modes,
    /// When the longest pause between two experiments ended, on the campaign's clock \[s\]; infinite without one.
    pub pause_end_s: f64,
    /// The highest voltage of either motor \[V\].
    pub full_v: f64,
}

/// A model with its parameters.
#[derive(Clone)]
pub(super) struct Model {
    pub effects: Vec<KnownMotorEffect>,
    pub at: Vec<f64>,
}

/// A model at its best, linearised there.
#[derive(Clone)]
pub(super) struct Fitted {
    pub model: Model,
    /// Sum of the squares of what is left, by experiment and mode, without weights \[m^2\].
    pub costs: Vec<Modes>,
    /// What is left of each experiment, and how the travel changes with each parameter: in modes, weighted.
    pub residuals: Vec<DVector<f64>>,
    pub columns: Vec<DMatrix<f64>>,
}

impl Model {
    /// Where the parameters of an effect begin.
    pub fn first_of(&self, index: usize) -> usize {
        let before = self.effects[..index].iter();
        BASELINE + before.map(|effect| effect.facts().parameters.len()).sum::<usize>()
    }

    /// The same with one more effect, at these parameters.
    pub fn with(&self, effect: KnownMotorEffect, p: &[f64]) -> Self {
        let mut more = self.clone();
        more.effects.push(effect);
        more.at.extend_from_slice(p);
        more
    }

    /// The same without one of its effects.
    pub fn without(&self, index: usize) -> Self {
        let first = self.first_of(index);
        let len = self.effects[index].facts().parameters.len();
        let mut less = self.clone();
        less.effects.remove(index);
        less.at.drain(first..first + len);
        less
    }

    fn parameters(&self) -> impl Iterator<Item = &MotorParameter> {
        self.effects.iter().flat_map(|effect| effect.facts().parameters)
    }

    /// Keeps the parameters where a motor can have them.
    fn admit(&self, at: &mut [f64]) {
        at[0] = at[0].max(0.0);
        at[1] = at[1].max(1e-6);
        at[2] = at[2].max(1e-3 * at[1]);
        at[4] = at[4].clamp(-0.5 * at[2], 0.5 * at[2]);
        let least = at[2] - at[4].abs();
        at[3] = at[3].clamp(-0.95 * least, 0.95 * least);
        for (value, parameter) in at[BASELINE..].iter_mut().zip(self.parameters()) {
            *value = value.clamp(parameter.low, parameter.high);
        }
    }

    /// Usual sizes: of the baseline as it is, of the effects by their facts.
    fn usual(&self) -> Vec<f64> {
        let [ks, kv, ka] = [self.at[0], self.at[1], self.at[2]];
        let of_effects = self.parameters().zip(&self.at[BASELINE..]).map(|(parameter, value)| {
            match parameter.role {
                MotorRole::Amplitude => parameter.usual,
                MotorRole::Shape => 0.1 * value.abs().max(parameter.usual),
            }
        });
        // kW is M d / b^2 and kA about M / 2 and more: kW per kA is 1/m, where d is a tenth of b and b is 0.2 m.
        let baseline = [ks.max(0.05), 0.1 * kv, 0.3 * ka, 0.3 * ka, 0.1 * ka, ka];
        baseline.into_iter().chain(of_effects).collect()
    }

    /// Measured less modelled travel of one experiment, both modes with their weights, sample by sample \[m\].
    pub fn residuals(
        &self,
        problem: &Problem<'_>,
        at: &[f64],
        experiment: &Experiment,
    ) -> DVector<f64> {
        let weights = problem.weights;
        let left = self.left_of_travel(problem, at, experiment);
        let left = left.map(|left| weights.weighted(left.left, left.right));
        DVector::from_iterator(2 * experiment.recording.samples().len(), left.flatten())
    }

    /// Measured less modelled travel of one experiment, sample by sample \[m\].
    pub fn left_of_travel(
        &self,
        problem: &Problem<'_>,
        at: &[f64],
        experiment: &Experiment,
    ) -> impl Iterator<Item = WheelPair<f64>> {
        let simulation = problem.simulation(&self.effects, at);
        let travel_m = simulation.travel_m(experiment);
        let samples = experiment.recording.samples();
        let start = samples[0].travel_m;
        let both = samples.iter().zip(travel_m);
        both.map(move |(sample, modelled)| sample.travel_m.since(start).since(modelled))
    }
}

impl Problem<'_> {
    /// Of this robot and campaign.
    pub fn simulation<'b>(
        &'b self,
        effects: &'b [KnownMotorEffect],
        at: &'b [f64],
    ) -> Simulation<'b> {
        let Self { robot, pause_end_s, full_v, .. } = *self;
        Simulation { robot, pause_end_s, full_v, effects, at }
    }

    /// How many residuals an experiment has.
    pub fn len(&self, index: usize) -> usize {
        2 * self.experiments[index].recording.samples().len()
    }

    /// How many there are.
    fn samples(&self) -> usize {
        (0..self.experiments.len()).map(|index| self.len(index)).sum()
    }

    /// What the counts hide of each experiment, in either mode \[m^2\].
    pub fn floors(&self) -> Vec<f64> {
        let floor = self.robot.resolution_m().powi(2);
        (0..self.experiments.len()).map(|index| 0.5 * floor * self.len(index) as f64).collect()
    }

    /// Mean squares of costs over all samples, by mode \[m^2\].
    pub fn mean_squares(&self, costs: &[Modes]) -> Modes {
        let sum = costs.iter().fold(Modes::default(), |sum, cost| sum.zip(*cost, |a, b| a + b));
        sum.zip(Modes::both(0.5 * self.samples() as f64), |sum, samples| sum / samples)
    }

    /// Root mean square of costs over all samples and wheels \[m\].
    pub fn rms_m(&self, costs: &[Modes]) -> f64 {
        (0.5 * self.mean_squares(costs).sum()).sqrt()
    }

    /// The sum of costs by their weights \[m^2\].
    pub fn weighted(&self, costs: &[Modes]) -> f64 {
        costs.iter().map(|cost| cost.zip(self.weights, |cost, weight| cost * weight).sum()).sum()
    }

    /// The same problem with each mode's weight by what a model leaves in it.
    pub fn reweighted(&self, costs: &[Modes]) -> Self {
        let weights = self.mean_squares(costs).inverse(self.robot.resolution_m().powi(2));
        Self { weights, ..self.clone() }
    }

    /// What a weighted vector of residuals costs without weights \[m^2\].
    pub fn cost(&self, residuals: &DVector<f64>) -> Modes {
        let cost = Modes::squares(residuals).zip(self.weights, |square, weight| square / weight);
        if cost.sum().is_finite() { cost } else { Modes::both(f64::INFINITY) }
    }

    /// What is left of one experiment by a model.
    pub fn residuals(&self, model: &Model, at: &[f64], experiment: &Experiment) -> DVector<f64> {
        model.residuals(self, at, experiment)
    }

    fn costs(&self, model: &Model, at: &[f64]) -> Vec<Modes> {
        parallel::map(&self.experiments, |experiment| {
            self.cost(&self.residuals(model, at, experiment))
        })
    }

    fn linearise(&self, model: Model) -> Fitted {
        let usual = model.usual();
        let parts = parallel::map(&self.experiments, |experiment| {
            let base = self.residuals(&model, &model.at, experiment);
            let mut columns = DMatrix::zeros(base.len(), model.at.len());
            for (i, usual) in usual.iter().enumerate() {
                let mut at = model.at.clone();
                let step = 0.01 * usual;
                at[i] += step;
                let moved = self.residuals(&model, &at, experiment);
                // A residual falls as its travel rises.
                columns.set_column(i, &((&base - moved) / step));
            }
            (base, columns)
        });
        let (residuals, columns): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
        let costs = residuals.iter().map(|residuals| self.cost(residuals)).collect();
        Fitted { model, costs, residuals, columns }
    }

    /// With one more effect, from these parameters. To first order they may be far out, and lead astray: where the fit ends worse
    /// than without the effect, it begins again with smaller amplitudes, from which the model is no worse.
    pub fn fit_with(&self, without: &Fitted, effect: &KnownMotorEffect, p: &[f64]) -> Fitted {
        const SMALLER: [f64; 5] = [0.5, 0.2, 0.05, 0.01, 0.0];
        let roles = effect.facts().parameters.iter().map(|parameter| parameter.role);
        let is_amplitude: Vec<bool> = roles.map(|role| role == MotorRole::Amplitude).collect();
        let model = |share: f64| {
            let p: Vec<f64> = p
                .iter()
                .zip(&is_amplitude)
                .map(|(value, is_amplitude)| if *is_amplitude { share * value } else { *value })
                .collect();
            let mut model = without.model.with(effect.clone(), &p);
            let mut at = model.at.clone();
            model.admit(&mut at);
            model.at = at;
            model
        };
        let cost = self.weighted(&without.costs);
        let fitted = self.fit(model(1.0));
        if self.weighted(&fitted.costs) <= cost {
            return fitted;
        }
        let is_no_worse = |model: &Model| self.weighted(&self.costs(model, &model.at)) <= cost;
        let start = SMALLER.into_iter().map(model).find(is_no_worse);
        self.fit(start.unwrap_or_else(|| model(0.0)))
    }

    /// Without one of its effects. The others may have gone far to make room for it: so from the baseline as well, and the better end
    /// counts.
    pub fn fit_without(&self, model: &Model, index: usize, baseline: &Model) -> Fitted {
        let kept = model.without(index);
        let mut fresh = kept.clone();
        fresh.at[..BASELINE].copy_from_slice(&baseline.at[..BASELINE]);
        let roles: Vec<MotorRole> = kept.parameters().map(|parameter| parameter.role).collect();
        for (value, role) in fresh.at[BASELINE..].iter_mut().zip(roles) {
            if role == MotorRole::Amplitude {
                *value = 0.0;
            }
        }
        let (kept, fresh) = (self.fit(kept), self.fit(fresh));
        let cost = |fitted: &Fitted| self.weighted(&fitted.costs);
        if cost(&fresh) < cost(&kept) { fresh } else { kept }
    }

    /// Levenberg's search from the model's parameters.
    pub fn fit(&self, model: Model) -> Fitted {
        let mut model = model;
        let mut at = model.at.clone();
        model.admit(&mut at);
        model.at = at;
        let mut best = self.linearise(model);
        let mut damping = 1e-3;
        for _ in 0..ROUNDS_MAX {
            let cost = self.weighted(&best.costs);
            let (gram, gradient) = best.sums(self);
            let mut gained = 0.0;
            while damping < 1e7 {
                let mut damped = gram.clone();
                for i in 0..damped.nrows() {
                    damped[(i, i)] += damping * gram[(i, i)];
                }
                let step = damped.cholesky().map(|factor| factor.solve(&gradient));
                if let Some(step) = step {
                    let mut at = best.model.at.clone();
                    at.iter_mut().zip(step.iter()).for_each(|(value, step)| *value += step);
                    best.model.admit(&mut at);
                    let next = self.weighted(&self.costs(&best.model, &at));
                    if next < cost {
                        gained = 1.0 - next / cost;
                        best = self.linearise(Model { at, ..best.model });
                        damping = (0.1 * damping).max(1e-9);
                        break;
                    }
                }
                damping *= 10.0;
            }
            if gained < 1e-4 {
                break;
            }
        }
        best
    }

    /// What is left of each experiment when the others predict it \[m^2\].
    pub fn cross_validated(&self, fitted: &Fitted) -> Vec<Modes> {
        let shares = fitted.shares();
        let (gram, gradient) = fitted.sums(self);
        let indices: Vec<usize> = (0..self.experiments.len()).collect();
        parallel::map(&indices, |&index| {
            let share = &shares[index];
            let others = (&gram - &share.gram).cholesky();
            let Some(others) = others else { return Modes::both(f64::INFINITY) };
            let moved = others.solve(&(&gradient - &share.gradient));
            let mut at = fitted.model.at.clone();
            at.iter_mut().zip(moved.iter()).for_each(|(value, moved)| *value += moved);
            fitted.model.admit(&mut at);
            self.cost(&self.residuals(&fitted.model, &at, self.experiments[index]))
        })
    }

    /// Half the widths of the parameters' 95 % intervals: with each experiment as one observation, or with those that are alike
    /// as one, whichever is wider.
    pub fn half_widths_95(&self, fitted: &Fitted) -> Vec<f64> {
        let (gram, _) = fitted.sums(self);
        let len = gram.nrows();
        let each = Intervals::new(&gram, &fitted.shares());
        let (Some(each), Some(alike)) =
            (each, Intervals::new(&gram, &alike_together(&self.experiments, fitted.shares())))
        else {
            return vec![f64::INFINITY; len];
        };
        let of = |i: usize| {
            let mut weights = DVector::zeros(len);
            weights[i] = 1.0;
            each.half_width_95(&weights).max(alike.half_width_95(&weights))
        };
        (0..len).map(of).collect()
    }
}

impl Fitted {
    /// Each experiment's share of the normal equations.
    pub fn shares(&self) -> Vec<Share> {
        let both = self.columns.iter().zip(&self.residuals);
        both.map(|(columns, residuals)| Share {
            gram: columns.tr_mul(columns),
            gradient: columns.tr_mul(residuals),
        })
        .collect()
    }

    /// The normal equations, with what keeps parameters of which the data say nothing at usual sizes.
    pub fn sums(&self, problem: &Problem<'_>) -> (DMatrix<f64>, DVector<f64>) {
        let len = self.model.at.len();
        let mut gram = DMatrix::zeros(len, len);
        let mut gradient = DVector::zeros(len);
        for share in self.shares() {
            gram += share.gram;
            gradient += share.gradient;
        }
        let noise = problem.weighted(&self.costs) / problem.samples() as f64;
        let noise = noise.max(problem.robot.resolution_m().powi(2)).max(1e-14);
        for (i, usual) in self.model.usual().into_iter().enumerate() {
            gram[(i, i)] += ALIKE * noise / (WIDE * usual).powi(2);
        }
        (gram, gradient)
    }
}
