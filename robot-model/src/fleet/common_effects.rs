//! The effects that every campaign of a kind is fitted with.

use crate::effect::catalogue::{CATALOGUE, find};
use crate::effect::definition::{Effect, FirmwareTerm};
use crate::explain::answer::{Answer, StepFound};
use crate::selection::candidates::is_geometry;

/// Radii and track width, then what was found and matters in any of these answers, the most frequent first. Of effects that
/// some campaign cannot tell apart only the most frequent is in.
pub fn common_effects(answers: &[&Answer]) -> Vec<&'static dyn Effect> {
    let mut common: Vec<&'static dyn Effect> =
        CATALOGUE.iter().copied().filter(|effect| is_geometry(*effect)).collect();
    let steps = || answers.iter().flat_map(|answer| answer.known.iter().chain(&answer.steps));
    let times = |id: &str| steps().filter(|step| step.matters && step.effect == id).count();
    let mut found: Vec<(usize, &'static dyn Effect)> = steps()
        .filter_map(|step| find(&step.effect))
        .map(|effect| (times(effect.facts().id), effect))
        .filter(|(count, _)| *count > 0)
        .collect();
    found.sort_by(|(a, one), (b, other)| b.cmp(a).then(one.facts().id.cmp(other.facts().id)));
    for (_, effect) in found {
        let id = effect.facts().id;
        let has = |step: &StepFound, id: &str| step.class.iter().any(|other| other == id);
        let not_apart = |other: &&dyn Effect| {
            let other = other.facts().id;
            other == id || steps().any(|step| has(step, id) && has(step, other))
        };
        if !common.iter().any(|other| not_apart(other)) {
            common.push(effect);
        }
    }
    common
}

/// Whether a value of this effect that changes so means that wheels wear: their mean radius shrinks.
pub fn is_wear(effect: &dyn Effect, per_day: f64) -> bool {
    effect.facts().compensated_by == Some(FirmwareTerm::MeanRadius) && per_day < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explain::explain;
    use crate::tests::synthetic::{campaign, full_plan};

    #[test]
    fn what_some_campaign_cannot_tell_apart_is_in_once() {
        let nothing = explain(&campaign(&full_plan(), &[], 5)).unwrap();
        let step = |class: &[&str]| StepFound {
            effect: class[0].into(),
            class: class.iter().map(|id| (*id).to_owned()).collect(),
            parameters: Vec::new(),
            fitted: Default::default(),
            cross_validated: Default::default(),
            p_value: 1e-9,
            evidence: Default::default(),
            effect_size_m: 1e-2,
            moves_no_track: false,
            matters: true,
        };
        let with = |steps: Vec<StepFound>| Answer { steps, ..nothing.clone() };
        let answers = [
            with(vec![step(&["scrub", "side_slip"])]),
            with(vec![step(&["scrub"]), step(&["slope"])]),
            with(vec![step(&["side_slip"])]),
        ];
        let common = common_effects(&answers.each_ref());
        let ids: Vec<&str> = common.iter().map(|effect| effect.facts().id).collect();
        assert_eq!(ids[3..], ["scrub", "slope"], "{ids:?}");
        assert!(common[..3].iter().all(|effect| is_geometry(*effect)));
        let slight = StepFound { matters: false, ..step(&["slope"]) };
        assert_eq!(common_effects(&[&with(vec![slight])]).len(), 3);
    }

    #[test]
    fn wheels_wear_if_their_mean_radius_shrinks() {
        let is = |id, per_day| is_wear(find(id).unwrap(), per_day);
        assert!(is("wheel_radius_scale", -1e-5));
        assert!(!is("wheel_radius_scale", 1e-5) && !is("track_width", -1e-5));
    }
}
