//! Which effects does the model lack? Forwards, one effect after the other, and then whether each is still needed.

use super::chance::{gains, p_value};
use super::experiment::excitation;
use super::least_squares::{Fitted, Problem};
use super::modes::Modes;
use super::screening::{Candidate, Screen, pair_costs};
use super::strength;
use crate::drivetrain::effect::KnownMotorEffect;

/// The most effects that are looked for.
const EFFECTS_MAX: usize = 5;
/// So many of the best candidates are fitted in full.
const FITTED: usize = 4;
/// And of the best pairs.
const PAIRS_FITTED: usize = 3;
/// A gain that chance gives less often than this is none of chance. A dozen effects are tried at each step.
pub(super) const P_MAX: f64 = 0.004;
/// An effect moves the robot by this share of what a count hides, root mean square, or it is not worth a word.
pub(super) const SIZE_SHARE: f64 = 0.35;
/// And by this much \[m\].
pub(super) const SIZE_M: f64 = 2e-5;

/// What an effect has to show: chance gives as much less often than `p_max`, and the cross-validated error falls by this share.
#[derive(Clone, Copy, Debug)]
struct Bar {
    p_max: f64,
    less: f64,
}
/// By which experiments gain and which lose.
const BY_SIGNS: Bar = Bar { p_max: P_MAX, less: 0.03 };
/// By its strength, of an effect with several amplitudes or either sign: a slope, or sides that differ, bend to what a caster
/// leaves, and lower the error of sound robots by up to 0.15.
const BY_STRENGTH: Bar = Bar { p_max: P_MAX, less: 0.15 };
/// By its strength, of one amplitude whose sign is known. In sound robots none of these lowers the error by as much.
const BY_ONE_SIGN: Bar = Bar { p_max: 0.05, less: 0.02 };

/// A model with its cross-validated costs.
#[derive(Clone)]
pub(super) struct Judged {
    pub fitted: Fitted,
    /// What is left of each experiment, predicted by the others, by mode \[m^2\].
    pub costs: Vec<Modes>,
}

/// What an effect gains.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gain {
    pub p_value: f64,
    /// Root mean square of what it explains \[m\].
    pub size_m: f64,
    /// By which share it lowers the error of one mode.
    pub less: f64,
    /// The error of both modes together falls.
    falls: bool,
    bar: Bar,
    /// What a caster alone would explain \[m\].
    imitated_m: f64,
}

impl Gain {
    pub fn matters(&self, problem: &Problem<'_>) -> bool {
        self.p_value < self.bar.p_max && self.is_large(problem, self.bar)
    }

    fn is_large(&self, problem: &Problem<'_>, bar: Bar) -> bool {
        let size_m = SIZE_M.max(self.imitated_m).max(SIZE_SHARE * problem.robot.resolution_m());
        self.falls && self.size_m > size_m && self.less > bar.less
    }
}

/// From one model to another.
pub(super) fn gain(problem: &Problem<'_>, before: &[Modes], after: &[Modes]) -> Gain {
    let (b, a) = (problem.mean_squares(before), problem.mean_squares(after));
    let explained = b.zip(a, |before, after| (before - after).max(0.0));
    let less = b.zip(a, |before, after| 1.0 - (after / before).sqrt());
    Gain {
        p_value: p_value(&gains(before, after, &problem.floors())),
        size_m: (0.5 * explained.sum()).sqrt(),
        less: less.common.max(less.differential),
        falls: a.sum() < b.sum(),
        bar: BY_SIGNS,
        imitated_m: 0.0,
    }
}

/// From a model to one that has this effect besides. What is weak or shows in few experiments may matter by its strength instead:
/// two ways to matter, so chance has two.
pub(super) fn gain_by(
    problem: &Problem<'_>,
    before: &Judged,
    after: &Judged,
    index: usize,
) -> Gain {
    let effect = &*after.fitted.model.effects[index];
    let by_signs = gain(problem, &before.costs, &after.costs);
    let by_signs = Gain { imitated_m: effect.imitated_m(), ..by_signs };
    let bar = if strength::is_of_one_sign(effect) { BY_ONE_SIGN } else { BY_STRENGTH };
    if by_signs.matters(problem) || !by_signs.is_large(problem, bar) {
        return by_signs;
    }
    let p_value = 2.0 * strength::chance(problem, &before.fitted, &after.fitted, index);
    let by_strength = Gain { p_value, bar, ..by_signs };
    if by_strength.matters(problem) { by_strength } else { by_signs }
}

impl Judged {
    pub fn new(problem: &Problem<'_>, fitted: Fitted) -> Self {
        let costs = problem.cross_validated(&fitted);
        Self { fitted, costs }
    }

    /// With the modes weighted by what the model itself leaves.
    pub fn reweighted<'a>(problem: &Problem<'a>, fitted: Fitted) -> (Problem<'a>, Self) {
        let problem = problem.reweighted(&fitted.costs);
        let judged = Self::new(&problem, problem.fit(fitted.model));
        (problem, judged)
    }

    /// With a candidate, fitted in full.
    pub fn with(&self, problem: &Problem<'_>, candidate: &Candidate) -> Self {
        Self::new(problem, problem.fit_with(&self.fitted, &candidate.effect, &candidate.p))
    }
}

/// What a selection went through: the model after each step, the baseline first.
pub(super) struct Selected<'a> {
    /// With the modes' weights by the last model.
    pub problem: Problem<'a>,
    pub steps: Vec<Judged>,
    /// Every effect, alone beside the baseline, to first order.
    pub alone: Vec<Candidate>,
    pub screen: Screen,
}

/// Selects effects, from a fitted baseline on. Each model's own errors weight the modes for the next.
pub(super) fn select<'a>(
    problem: &Problem<'a>,
    baseline: Fitted,
    catalogue: &[KnownMotorEffect],
) -> Selected<'a> {
    let excitation = excitation(problem.robot, &problem.experiments);
    let (mut problem, baseline) = Judged::reweighted(problem, baseline);
    let screen = Screen::new(&problem, &baseline.fitted, (excitation, catalogue));
    let mut steps = vec![baseline];
    let mut alone = Vec::new();
    while steps.len() <= EFFECTS_MAX {
        let now = &steps[steps.len() - 1];
        let mut candidates = screen.candidates(&problem, &now.fitted);
        let mut next = Vec::from_iter(best(&problem, now, &candidates));
        if next.is_empty() && steps.len() < EFFECTS_MAX {
            next = best_pair(&problem, now, &candidates);
        }
        if steps.len() == 1 {
            alone.append(&mut candidates);
        }
        let Some(last) = next.pop() else { break };
        steps.append(&mut next);
        let (weighted, last) = Judged::reweighted(&problem, last.fitted);
        problem = weighted;
        steps.push(last);
    }
    let steps = without_needless(&problem, steps);
    Selected { problem, steps, alone, screen }
}

/// The best of the candidates that matter, fitted in full.
fn best(problem: &Problem<'_>, now: &Judged, candidates: &[Candidate]) -> Option<Judged> {
    // A caster alone lets a wave, a slope and sides that differ gain more than a weak delay does.
    let may_be_weak = |candidate: &Candidate| {
        let gain = gain(problem, &now.costs, &candidate.costs);
        strength::is_of_one_sign(&*candidate.effect) && gain.is_large(problem, BY_ONE_SIGN)
    };
    let tried = candidates.iter().enumerate();
    tried
        .filter(|(rank, candidate)| *rank < FITTED || may_be_weak(candidate))
        .map(|(_, candidate)| now.with(problem, candidate))
        .filter(|next| {
            gain_by(problem, now, next, next.fitted.model.effects.len() - 1).matters(problem)
        })
        .min_by(|a, b| problem.weighted(&a.costs).total_cmp(&problem.weighted(&b.costs)))
}

/// Two effects that hide each other: each alone makes half of the experiments worse, as motors that differ by side and by
/// direction do. The model with the first, and with both; both matter beside each other.
fn best_pair(problem: &Problem<'_>, now: &Judged, candidates: &[Candidate]) -> Vec<Judged> {
    let mut pairs: Vec<(f64, &Candidate, &Candidate)> = Vec::new();
    for (index, one) in candidates.iter().enumerate() {
        for other in &candidates[index + 1..] {
            let Some(costs) = pair_costs(problem, &now.fitted, (one, other)) else { continue };
            if gain(problem, &now.costs, &costs).matters(problem) {
                pairs.push((problem.weighted(&costs), one, other));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let tried = pairs.into_iter().take(PAIRS_FITTED).filter_map(|(_, one, other)| {
        let first = now.with(problem, one);
        let both = first.with(problem, other);
        let second = now.with(problem, other);
        let matters = |before: &Judged| gain(problem, &before.costs, &both.costs).matters(problem);
        (matters(now) && matters(&first) && matters(&second)).then(|| vec![first, both])
    });
    let cost = |pair: &Vec<Judged>| problem.weighted(&pair[1].costs);
    tried.min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or_default()
}

/// Takes out what later effects have made needless, and lists the models anew, the effects that gain most first.
fn without_needless(problem: &Problem<'_>, mut steps: Vec<Judged>) -> Vec<Judged> {
    let Some(mut last) = steps.pop() else { return steps };
    if last.fitted.model.effects.len() < 2 {
        steps.push(last);
        return steps;
    }
    let mut removed = false;
    let mut index = 0;
    while index < last.fitted.model.effects.len() {
        let model = &last.fitted.model;
        let without = problem.fit_without(model, index, &steps[0].fitted.model);
        let without = Judged::new(problem, without);
        if gain_by(problem, &without, &last, index).matters(problem) {
            index += 1;
        } else {
            (last, removed) = (without, true);
        }
    }
    if removed {
        steps.truncate(1);
        let effects = last.fitted.model.effects.clone();
        for len in 1..effects.len() {
            let mut model = last.fitted.model.clone();
            for extra in (len..effects.len()).rev() {
                model = model.without(extra);
            }
            steps.push(Judged::new(problem, problem.fit(model)));
        }
        if effects.is_empty() {
            return steps;
        }
    }
    steps.push(last);
    steps
}
