//! Does a kind of run contradict an effect?
//!
//! An effect that is what it seems, fitted to the other kinds of runs, predicts this kind better as well.

use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::normal_equations::{Columns, EquationsWithout};
use crate::recording::run_kind::RunKind;
use crate::selection::gain::{BLUR_MAX, Gain, Hypothesis, blurs_geometry, gain_on};

/// A kind of run may be predicted worse by this much in -2 log likelihood, by chance: two sigma.
const KIND_LOSS_MAX: f64 = 4.0;
/// A kind contradicts an effect if its gain lies this many sigmas below what the effect predicts.
const KIND_CONTRADICTS_SIGMAS: f64 = 3.5;
/// What a kind loses counts if it is more than this share of what the other kinds gain: where something else is missing as
/// well, no effect suits every kind.
const KIND_LOSS_SHARE: f64 = 0.2;
/// Runs of other kinds excite an effect if they alone determine it to within this share of its value.
const EXCITED_SHARE: f64 = 0.5;

/// An effect does not act on a kind that holds no more than this share of the information about it.
const ACTS_SHARE: f64 = 1e-3;

/// The kind of run that an effect fitted to the other kinds makes worst, if there is one.
///
/// Where the other kinds do not excite the effect, or do not tell it from radii and track width, half of the kind's own folds
/// join them. A kind on which it does not act
/// says nothing about it: there only the geometry fitted with it differs, and kinds disagree about that whenever anything
/// else is missing.
pub(crate) fn worse_kind(
    equations: &CampaignEquations,
    hypothesis: &Hypothesis<'_>,
    values: &[f64],
    dispersion: f64,
) -> Option<(RunKind, f64)> {
    let mut kinds: Vec<RunKind> = equations.folds.iter().map(|fold| fold.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let both: Vec<usize> = hypothesis.model.iter().chain(hypothesis.asked).copied().collect();
    let first = hypothesis.model.len();
    let on_all: f64 =
        hypothesis.asked.iter().map(|column| equations.total.gram[(*column, *column)]).sum();
    let mut gains = Vec::new();
    for kind in kinds {
        let left_out: Vec<usize> = equations
            .folds
            .iter()
            .enumerate()
            .filter(|(_, fold)| fold.kind == kind)
            .map(|(index, _)| index)
            .collect();
        let on_kind: f64 = left_out
            .iter()
            .flat_map(|fold| {
                let gram = &equations.folds[*fold].sums.gram;
                hypothesis.asked.iter().map(|column| gram[(*column, *column)])
            })
            .sum();
        if on_kind <= ACTS_SHARE * on_all {
            continue;
        }
        let score = |left_out: &[usize]| {
            let rest = Columns::of(&equations.without(left_out.iter().copied()), &both);
            let on = EquationsWithout::new(&equations.total, vec![&rest]);
            let covariance = equations.solve(&rest, &both).covariance;
            let excited = values.iter().enumerate().any(|(j, value)| {
                covariance[(first + j, first + j)].sqrt() < EXCITED_SHARE * value.abs()
            }) && blurs_geometry(equations, hypothesis, (&rest, &covariance))
                < BLUR_MAX;
            let gain = gain_on(equations, hypothesis, &rest, &on);
            let share = Gain {
                gain: gain.gain / dispersion,
                promised: gain.promised / dispersion,
                unknown: gain.unknown / dispersion,
            };
            (excited, share)
        };
        let (excited, mut gain) = score(&left_out);
        if !excited {
            let half = |parity: usize| {
                let position = left_out.iter().enumerate();
                let part: Vec<usize> =
                    position.filter(|(i, _)| i % 2 == parity).map(|(_, index)| *index).collect();
                score(&part).1
            };
            gain = half(0).add(half(1));
        }
        gains.push((kind, gain));
    }
    contradicted_by(&gains)
}

/// The kind that loses most, of those that contradict an effect, if any does: by more than chance, and more than a small share
/// of what other kinds gain.
fn contradicted_by(gains: &[(RunKind, Gain)]) -> Option<(RunKind, f64)> {
    let gained: f64 = gains.iter().map(|(_, gain)| gain.gain.max(0.0)).sum();
    let loss_max = KIND_LOSS_MAX.max(KIND_LOSS_SHARE * gained);
    gains
        .iter()
        .filter(|(_, gain)| gain.gain < -loss_max)
        .filter(|(_, gain)| gain.kept_promise_sigmas() < -KIND_CONTRADICTS_SIGMAS)
        .map(|(kind, gain)| (*kind, gain.gain))
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_of_run_contradicts_an_effect_by_more_than_a_small_share_of_what_others_gain() {
        let of = |kind: RunKind, gain: f64| (kind, Gain { gain, promised: 40.0, unknown: 1.0 });
        let (square, spin) = (RunKind::Square, RunKind::Spin);
        // A real robot's scrub: squares 3.2 mm off without it and 1.9 mm with it.
        assert_eq!(contradicted_by(&[of(square, 285.0), of(spin, -20.0)]), None);
        assert_eq!(contradicted_by(&[of(square, 60.0), of(spin, -20.0)]), Some((spin, -20.0)));
        assert_eq!(contradicted_by(&[of(square, -20.0), of(spin, -30.0)]), Some((spin, -30.0)));
        // Less than two sigma is chance.
        assert_eq!(contradicted_by(&[of(square, 1.0), of(spin, -3.9)]), None);
        // What was hardly promised may fail to come.
        let unsure = Gain { gain: -20.0, promised: 1.0, unknown: 100.0 };
        assert_eq!(contradicted_by(&[(spin, unsure)]), None);
    }
}
