//! The closed loop: does the suggested run, once driven, tell effects apart that the campaign could not?

use crate::effect::CATALOGUE;
use crate::explain::next_run::candidate_runs;
use crate::explain::{Answer, explain, explain_given};
use crate::recording::Campaign;
use crate::recording::nominal_run::Piece;
use crate::tests::synthetic::{campaign, end_poses_only, part_of_plan, term};

type PlannedRuns = Vec<(String, f64, Vec<Piece>)>;

/// Explains runs of a robot with one effect, all without a load.
fn explained(plan: &PlannedRuns, truth: (&str, &[f64]), ends_only: usize) -> (Campaign, Answer) {
    let mut campaign = campaign(plan, &[term(truth.0, truth.1)], 7);
    campaign.runs.iter_mut().for_each(|run| run.payload_kg = 0.0);
    if ends_only > 0 {
        let late = campaign.runs.split_off(ends_only);
        campaign = end_poses_only(campaign);
        campaign.runs.extend(late);
    }
    let answer = explain(&campaign).unwrap();
    (campaign, answer)
}

fn class_of(answer: &Answer, id: &str) -> Vec<String> {
    let step = answer.steps.iter().find(|step| step.class.iter().any(|member| member == id));
    let mut class = step.unwrap_or_else(|| panic!("{id}: {answer:?}")).class.clone();
    class.sort();
    class
}

/// Follows the suggestions until the true effect is alone in its class; returns how many it took.
///
/// Each suggestion must separate the effects that it names. Not so where only end poses were measured: the
/// noise is not known then until the suggested run shows it.
fn suggestions_followed(start: &[&str], truth: (&str, &[f64]), ends_only: bool) -> usize {
    let mut plan: PlannedRuns = part_of_plan(start);
    if start == ["out_and_back_0"] {
        plan[0].2.truncate(1);
    }
    let ends_only = if ends_only { plan.len() } else { 0 };
    for made in 0..4 {
        let (campaign, answer) = explained(&plan, truth, ends_only);
        let class = class_of(&answer, truth.0);
        if class.len() == 1 {
            return made;
        }
        let next = answer.next_run.unwrap_or_else(|| panic!("{truth:?}: no run for {class:?}"));
        let excitation = campaign.prepare().unwrap().excitation;
        let speed_mps = excitation.wheel_rate_max_rad_s * campaign.robot.wheel_radius_m;
        let suggested = candidate_runs(speed_mps)
            .into_iter()
            .find(|candidate| candidate.kind == next.kind)
            .unwrap();
        for (k, (heading_rad, _, pieces)) in suggested.runs.into_iter().enumerate() {
            plan.push((format!("next_{made}_{k}"), heading_rad, pieces));
        }
        let after = class_of(&explained(&plan, truth, ends_only).1, truth.0);
        let promised = next.separates.iter().filter(|id| *id != truth.0 && class.contains(*id));
        let kept: Vec<_> = promised.filter(|id| after.contains(*id)).collect();
        assert!(ends_only > 0 || kept.is_empty(), "{truth:?}: {:?} leaves {kept:?}", next.kind);
    }
    panic!("{truth:?}: still not told apart after four suggestions");
}

#[test]
fn one_straight_run_and_the_suggested_run_resolve_a_pull_and_a_radius() {
    for truth in [("heading_pull", [0.02]), ("wheel_radius_ratio", [0.01])] {
        let made = suggestions_followed(&["out_and_back_0"], (truth.0, &truth.1), false);
        assert_eq!(made, 1, "{truth:?}");
    }
}

#[test]
fn spins_and_the_suggested_run_resolve_a_scale_and_a_track_width() {
    for truth in [("wheel_radius_scale", [0.02]), ("track_width", [0.02])] {
        let made = suggestions_followed(&["spin"], (truth.0, &truth.1), false);
        assert_eq!(made, 1, "{truth:?}");
    }
}

#[test]
fn squares_with_end_poses_only_and_the_suggested_run_resolve_uneven_turns() {
    for truth in [("turn_asymmetry", [0.01]), ("wheel_radius_ratio", [0.01])] {
        let squares = ["square", "square", "square"];
        let made = suggestions_followed(&squares, (truth.0, &truth.1), true);
        assert_eq!(made, 1, "{truth:?}");
    }
}

#[test]
fn a_class_is_named_by_the_effect_that_the_model_has_already() {
    // One straight run: a radius and a pull do the same.
    let plan: PlannedRuns = part_of_plan(&["out_and_back_0"])
        .into_iter()
        .map(|(name, heading_rad, pieces)| (name, heading_rad, pieces[..1].to_vec()))
        .collect();
    let (campaign, answer) = explained(&plan, ("heading_pull", &[0.02]), 0);
    let class = class_of(&answer, "heading_pull");
    assert!(class.contains(&"wheel_radius_ratio".to_owned()), "{class:?}");
    for id in ["heading_pull", "wheel_radius_ratio"] {
        let answer = explain_given(&campaign, &CATALOGUE, &[id]).unwrap();
        assert!(answer.steps.is_empty(), "{:?}", answer.steps);
        assert_eq!(answer.known[0].effect, id);
        assert!(answer.known[0].class.len() > 1);
    }
}

#[test]
fn after_end_poses_only_the_next_run_needs_poses_along_the_way() {
    let mut straight: PlannedRuns = part_of_plan(&["out_and_back_0"]);
    straight[0].2.truncate(1);
    for (plan, ends_only) in [(part_of_plan(&["square"]), true), (straight, false)] {
        let runs = if ends_only { plan.len() } else { 0 };
        let answer = explained(&plan, ("wheel_radius_ratio", &[0.01]), runs).1;
        let next = answer.next_run.expect("a class to be told apart");
        assert_eq!(next.predicted.needs_poses_along_the_way, ends_only, "{:?}", next.predicted);
    }
}
