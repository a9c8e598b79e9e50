//! Held-out runs: nothing is learnt from them, and they show how well a model predicts.

use crate::compare::{Comparer, Comparison, EffectWithValues};
use crate::effect::catalogue::{CATALOGUE, find};
use crate::explain::explanation::{explain, explain_given};
use crate::explain::model::fit;
use crate::recording::{Campaign, RecordingProblem, RunKind};
use crate::tests::synthetic::{campaign, full_plan, term};

/// A robot with unequal wheels, its two squares held out.
fn marked() -> Campaign {
    let mut campaign = campaign(&full_plan(), &[term("wheel_radius_ratio", &[0.005])], 77);
    let squares = campaign.runs.iter_mut().filter(|run| run.name.starts_with("square"));
    squares.for_each(|run| run.held_out = true);
    campaign
}

/// The same campaign without these runs.
fn without(campaign: &Campaign) -> Campaign {
    let runs = campaign.fitted_runs().cloned().collect();
    Campaign { robot: campaign.robot, runs }
}

#[test]
fn held_out_runs_do_not_change_an_explanation() {
    let marked = marked();
    assert_eq!(marked.runs.len(), without(&marked).runs.len() + 2);
    let mut answer = explain(&marked).unwrap();
    let held_out = answer.held_out.take().unwrap();
    let bare = explain(&without(&marked)).unwrap();
    assert_eq!(answer, bare);
    assert_eq!((held_out.runs, held_out.kinds.as_slice()), (2, &[RunKind::Square][..]));
    // 0.5 % of 4 m over 0.37 m is 54 mrad; the rest is noise, of which a good fit has as much.
    assert!(held_out.baseline.position_rms_m > 3.0 * held_out.model.position_rms_m, "{held_out:?}");
    assert!((0.7..1.4).contains(&held_out.model.chi), "{held_out:?}");
}

#[test]
fn the_baseline_on_held_out_runs_has_the_known_effects() {
    let answer = explain_given(&marked(), &CATALOGUE, &["wheel_radius_ratio"]).unwrap();
    assert!(answer.steps.is_empty() && answer.known.len() == 1, "{answer:?}");
    let held_out = answer.held_out.unwrap();
    assert_eq!(held_out.baseline, held_out.model);
}

#[test]
fn no_model_is_fitted_to_held_out_runs_whatever_they_contain() {
    let marked = marked();
    let mut damaged = marked.clone();
    for run in damaged.runs.iter_mut().filter(|run| run.held_out) {
        // As if it had turned the other way, at another time, with another load.
        for pose in &mut run.measured_poses {
            pose.heading_rad = pose.heading_rad.map(|heading_rad| -heading_rad);
        }
        (run.started_s, run.payload_kg) = (Some(-1e6), 70.0);
    }
    let ratio = [find("wheel_radius_ratio").unwrap()];
    let (good, bad) = (fit(&marked, &ratio).unwrap(), fit(&damaged, &ratio).unwrap());
    assert_eq!((&good.effects, &good.errors), (&bad.effects, &bad.errors));
    let chi = |model: &crate::explain::model::Model| model.held_out.as_ref().unwrap().model.chi;
    assert!(chi(&bad) > 3.0 * chi(&good), "{} {}", chi(&bad), chi(&good));
}

#[test]
fn a_comparison_shows_held_out_runs_separately_and_counts_them_nowhere_else() {
    let marked = marked();
    let model = [EffectWithValues {
        effect: find("wheel_radius_ratio").unwrap(),
        values: vec![0.005],
        up_to_mps: None,
    }];
    let all = Comparer::new(&marked, &[]).unwrap().compare(&model);
    let bare = Comparer::new(&without(&marked), &[]).unwrap().compare(&model);
    assert_eq!((all.position_m, &all.regimes), (bare.position_m, &bare.regimes));
    assert_eq!(bare.held_out, None);
    // Two runs, each off by as much as dead reckoning drifts, scatter by a third.
    let times =
        |comparison: &Comparison| comparison.held_out.unwrap().map(|error| error.rms / error.noise);
    assert!(times(&all).iter().all(|ratio| (0.5..1.5).contains(ratio)), "{:?}", all.held_out);
    let nominal = Comparer::new(&marked, &[]).unwrap().compare(&[]);
    assert!(times(&nominal).iter().all(|ratio| *ratio > 3.0), "{:?}", nominal.held_out);
    let apart: Vec<_> =
        all.runs.iter().map(|run| (run.held_out, run.kind == RunKind::Square)).collect();
    assert!(apart.iter().all(|(held_out, square)| held_out == square), "{apart:?}");
    assert_eq!(apart[apart.len() - 2..], [(true, true); 2]);
}

#[test]
fn a_campaign_whose_runs_are_all_held_out_cannot_be_fitted() {
    let mut all = marked();
    all.runs.iter_mut().for_each(|run| run.held_out = true);
    let error = explain(&all).unwrap_err();
    assert_eq!(error.problem, RecordingProblem::AllHeldOut);
    // A model can still be tested on them: that fits nothing.
    let model = fit(&marked(), &[find("wheel_radius_ratio").unwrap()]).unwrap();
    assert!(model.errors_on(&all).unwrap().chi < 1.4);
}
