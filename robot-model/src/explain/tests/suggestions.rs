//! The closed loop: a campaign that cannot tell, the run that is suggested, made, and the answer then.

use crate::effect::CATALOGUE;
use crate::explain::next_run::plans;
use crate::explain::{Answer, explain, explain_beyond};
use crate::recording::Campaign;
use crate::recording::nominal_plan::Piece;
use crate::tests::synthetic::{campaign, end_poses_only, part_of_plan, term};

type Plan = Vec<(String, f64, Vec<Piece>)>;

/// Explains runs of a robot with one effect; loads are left out of it.
fn asked(plan: &Plan, truth: (&str, &[f64]), ends_only: usize) -> (Campaign, Answer) {
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
    let step = answer.steps.iter().find(|it| it.class.iter().any(|it| it == id));
    let mut class = step.unwrap_or_else(|| panic!("{id}: {answer:?}")).class.clone();
    class.sort();
    class
}

/// Follows the suggestions until nothing else is in the truth's class; returns how many it took.
///
/// What a suggestion says that it separates has to be separated by it; not where only ends of runs were
/// measured, as the noise is then a guess until the suggested run shows it.
fn suggestions_followed(start: &[&str], truth: (&str, &[f64]), ends_only: bool) -> usize {
    let mut plan: Plan = part_of_plan(start);
    if start == ["out_and_back_0"] {
        plan[0].2.truncate(1);
    }
    let ends_only = if ends_only { plan.len() } else { 0 };
    for made in 0..4 {
        let (campaign, answer) = asked(&plan, truth, ends_only);
        let class = class_of(&answer, truth.0);
        if class.len() == 1 {
            return made;
        }
        let next = answer.next_run.unwrap_or_else(|| panic!("{truth:?}: no run for {class:?}"));
        let survey = campaign.prepare().unwrap().survey;
        let speed_mps = survey.wheel_rate_max_rad_s * campaign.robot.wheel_radius_m;
        let suggested = plans(speed_mps).into_iter().find(|it| it.kind == next.kind).unwrap();
        for (k, (heading_rad, _, pieces)) in suggested.runs.into_iter().enumerate() {
            plan.push((format!("next_{made}_{k}"), heading_rad, pieces));
        }
        let after = class_of(&asked(&plan, truth, ends_only).1, truth.0);
        let promised = next.separates.iter().filter(|it| *it != truth.0 && class.contains(*it));
        let kept: Vec<_> = promised.filter(|it| after.contains(*it)).collect();
        assert!(ends_only > 0 || kept.is_empty(), "{truth:?}: {:?} leaves {kept:?}", next.kind);
    }
    panic!("{truth:?}: four suggestions did not do");
}

#[test]
fn one_straight_run_and_what_is_suggested_then_resolve_a_pull_and_a_radius() {
    for truth in [("heading_pull", [0.02]), ("wheel_radius_ratio", [0.01])] {
        let made = suggestions_followed(&["out_and_back_0"], (truth.0, &truth.1), false);
        assert_eq!(made, 1, "{truth:?}");
    }
}

#[test]
fn spins_and_what_is_suggested_then_resolve_a_scale_and_a_track_width() {
    for truth in [("wheel_radius_scale", [0.02]), ("track_width", [0.02])] {
        let made = suggestions_followed(&["spin"], (truth.0, &truth.1), false);
        assert_eq!(made, 1, "{truth:?}");
    }
}

#[test]
fn squares_of_which_the_ends_are_measured_and_what_is_suggested_then_resolve_uneven_turns() {
    for truth in [("turn_asymmetry", [0.01]), ("wheel_radius_ratio", [0.01])] {
        let squares = ["square", "square", "square"];
        let made = suggestions_followed(&squares, (truth.0, &truth.1), true);
        assert_eq!(made, 1, "{truth:?}");
    }
}

#[test]
fn what_the_model_has_already_is_what_a_class_is_called_by() {
    // One straight run: a radius and a pull do the same.
    let plan: Plan = part_of_plan(&["out_and_back_0"])
        .into_iter()
        .map(|(name, heading_rad, pieces)| (name, heading_rad, pieces[..1].to_vec()))
        .collect();
    let (campaign, answer) = asked(&plan, ("heading_pull", &[0.02]), 0);
    let class = class_of(&answer, "heading_pull");
    assert!(class.contains(&"wheel_radius_ratio".to_owned()), "{class:?}");
    for id in ["heading_pull", "wheel_radius_ratio"] {
        let answer = explain_beyond(&campaign, &CATALOGUE, &[id]).unwrap();
        assert!(answer.steps.is_empty(), "{:?}", answer.steps);
        assert_eq!(answer.known[0].effect, id);
        assert!(answer.known[0].class.len() > 1);
    }
}

#[test]
fn who_measured_ends_alone_is_told_that_the_next_run_needs_poses_along_the_way() {
    let mut straight: Plan = part_of_plan(&["out_and_back_0"]);
    straight[0].2.truncate(1);
    for (plan, ends_only) in [(part_of_plan(&["square"]), true), (straight, false)] {
        let measured_so = if ends_only { plan.len() } else { 0 };
        let answer = asked(&plan, ("wheel_radius_ratio", &[0.01]), measured_so).1;
        let next = answer.next_run.expect("a class to be told apart");
        assert_eq!(next.promise.needs_poses_along_the_way, ends_only, "{:?}", next.promise);
    }
}
