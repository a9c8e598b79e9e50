//! Which effects can these experiments not tell from one that was found? Each other effect takes its place, and everything is
//! fitted anew: where that predicts other experiments as well, the answer is the class.

use super::chance::{gains, p_value};
use super::least_squares::{Fitted, Problem};
use super::modes::Modes;
use super::selection::{Judged, Selected};
use crate::drivetrain::effect::KnownMotorEffect;

/// A rival has to explain this share of what the effect does.
const RESEMBLANCE_MIN: f64 = 0.6;
/// A rival that loses less than this share of what the effect explains is as good: something is always missing in a model.
const LOSS: f64 = 0.03;
/// Chance makes one better than the other so often.
const P_MIN: f64 = 0.02;
/// So many rivals are fitted in full.
const FITTED: usize = 5;

/// An effect that explains as much in the place of another.
pub(super) struct Rival {
    pub effect: KnownMotorEffect,
    pub fitted: Fitted,
}

/// The rivals of one effect of a model, best first. `without` is the model without it.
pub(super) fn rivals(
    problem: &Problem<'_>,
    selected: &Selected,
    (last, without): (&Judged, &Judged),
    index: usize,
) -> Vec<Rival> {
    let own = last.fitted.model.effects[index].facts().id;
    let sum = |costs: &[Modes]| problem.weighted(costs);
    let gained = sum(&without.costs) - sum(&last.costs);
    let floors = problem.floors();
    let as_good = |rival: &Judged| {
        let lost = sum(&rival.costs) - sum(&last.costs);
        let told = p_value(&gains(&rival.costs, &last.costs, &floors)) < P_MIN;
        lost < (1.0 - RESEMBLANCE_MIN) * gained && (!told || lost < LOSS * gained)
    };
    let mut found: Vec<(f64, Rival)> = selected
        .screen
        .candidates(problem, &without.fitted)
        .iter()
        .filter(|candidate| candidate.effect.facts().id != own)
        // The screening is of first order: it may miss half of what the rival explains.
        .filter(|candidate| {
            sum(&without.costs) - sum(&candidate.costs) > 0.5 * RESEMBLANCE_MIN * gained
        })
        .take(FITTED)
        .map(|candidate| (candidate.effect.clone(), without.with(problem, candidate)))
        .filter(|(_, rival)| as_good(rival))
        .map(|(effect, rival)| (sum(&rival.costs), Rival { effect, fitted: rival.fitted }))
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, rival)| rival).collect()
}
