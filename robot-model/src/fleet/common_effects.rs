//! The effects that every campaign of a kind is fitted with.

use crate::effect::definition::{Effect, FirmwareTerm};
use crate::explain::answer::{Answer, StepFound};
use crate::selection::candidates::is_geometry;

/// An effect that a campaign shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Its id.
    pub effect: String,
    /// All effects that the campaign cannot tell from it, itself included.
    pub class: Vec<String>,
    /// It moves the robot by more than the tolerance.
    pub matters: bool,
}

impl Found {
    /// What an answer names, known or missing.
    pub fn of(answer: &Answer) -> Vec<Self> {
        let found = |step: &StepFound| Self {
            effect: step.effect.clone(),
            class: step.class.clone(),
            matters: step.matters,
        };
        answer.known.iter().chain(&answer.steps).map(found).collect()
    }
}

/// Of these candidates, radii and track width, then what was found and matters in any of these campaigns, the most frequent first.
/// Of effects that some campaign cannot tell apart only the most frequent is in.
pub fn common_effects<'a>(found: &[Found], candidates: &[&'a dyn Effect]) -> Vec<&'a dyn Effect> {
    let find = |id: &str| candidates.iter().copied().find(|effect| effect.facts().id == id);
    let mut common: Vec<&'a dyn Effect> =
        candidates.iter().copied().filter(|effect| is_geometry(*effect)).collect();
    let times = |id: &str| found.iter().filter(|one| one.matters && one.effect == id).count();
    let mut named: Vec<(usize, &'a dyn Effect)> = found
        .iter()
        .filter_map(|one| find(&one.effect))
        .map(|effect| (times(effect.facts().id), effect))
        .filter(|(count, _)| *count > 0)
        .collect();
    named.sort_by(|(a, one), (b, other)| b.cmp(a).then(one.facts().id.cmp(other.facts().id)));
    for (_, effect) in named {
        let id = effect.facts().id;
        let has = |one: &Found, id: &str| one.class.iter().any(|other| other == id);
        let not_apart = |other: &&'a dyn Effect| {
            let other = other.facts().id;
            other == id || found.iter().any(|one| has(one, id) && has(one, other))
        };
        if !common.iter().any(not_apart) {
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
    use crate::effect::catalogue::{CATALOGUE, find};

    #[test]
    fn what_some_campaign_cannot_tell_apart_is_in_once() {
        let found = |class: &[&str]| Found {
            effect: class[0].into(),
            class: class.iter().map(|id| (*id).to_owned()).collect(),
            matters: true,
        };
        let three = [
            found(&["scrub", "side_slip"]),
            found(&["scrub"]),
            found(&["slope"]),
            found(&["side_slip"]),
        ];
        let common = common_effects(&three, &CATALOGUE);
        let ids: Vec<&str> = common.iter().map(|effect| effect.facts().id).collect();
        assert_eq!(ids[3..], ["scrub", "slope"], "{ids:?}");
        assert!(common[..3].iter().all(|effect| is_geometry(*effect)));
        let slight = Found { matters: false, ..found(&["slope"]) };
        assert_eq!(common_effects(&[slight], &CATALOGUE).len(), 3);
        // An effect that is no candidate is not in.
        assert_eq!(common_effects(&three, &CATALOGUE[..0]).len(), 0);
    }

    #[test]
    fn wheels_wear_if_their_mean_radius_shrinks() {
        let is = |id, per_day| is_wear(find(id).unwrap(), per_day);
        assert!(is("wheel_radius_scale", -1e-5));
        assert!(!is("wheel_radius_scale", 1e-5) && !is("track_width", -1e-5));
    }
}
