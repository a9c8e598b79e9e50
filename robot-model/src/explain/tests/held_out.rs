//! Runs kept aside: nothing is learnt from them, and they show what a model predicts.

use crate::compare::{Assumed, Comparer, Comparison};
use crate::effect::catalogue::{CATALOGUE, find};
use crate::explain::explanation::{explain, explain_beyond};
use crate::explain::model::fit;
use crate::recording::{Campaign, RecordingProblem, RunKind};
use crate::tests::synthetic::{campaign, full_plan, term};

/// A robot with unequal wheels, its two squares marked.
fn marked() -> Campaign {
    let mut campaign = campaign(&full_plan(), &[term("wheel_radius_ratio", &[0.005])], 77);
    let squares = campaign.runs.iter_mut().filter(|run| run.name.starts_with("square"));
    squares.for_each(|run| run.held_out = true);
    campaign
}

/// The same without these runs at all.
fn without(campaign: &Campaign) -> Campaign {
    let runs = campaign.fitted_runs().cloned().collect();
    Campaign { robot: campaign.robot, runs }
}

#[test]
fn an_explanation_is_what_it_would_be_without_the_runs_kept_aside() {
    let marked = marked();
    assert_eq!(marked.runs.len(), without(&marked).runs.len() + 2);
    let mut answer = explain(&marked).unwrap();
    let held_out = answer.held_out.take().unwrap();
    let bare = explain(&without(&marked)).unwrap();
    assert_eq!(answer, bare);
    assert_eq!((held_out.runs, held_out.kinds.as_slice()), (2, &[RunKind::Square][..]));
    // 0.5 % of 4 m over 0.37 m is 54 mrad; what is left is noise, of which a good fit has as much as here.
    assert!(held_out.baseline.position_rms_m > 3.0 * held_out.model.position_rms_m, "{held_out:?}");
    assert!((0.7..1.4).contains(&held_out.model.chi), "{held_out:?}");
}

#[test]
fn what_is_known_already_is_where_the_error_on_runs_kept_aside_begins() {
    let answer = explain_beyond(&marked(), &CATALOGUE, &["wheel_radius_ratio"]).unwrap();
    assert!(answer.steps.is_empty() && answer.known.len() == 1, "{answer:?}");
    let held_out = answer.held_out.unwrap();
    assert_eq!(held_out.baseline, held_out.model);
}

#[test]
fn whatever_the_runs_kept_aside_hold_no_model_is_fitted_to_it() {
    let marked = marked();
    let mut damaged = marked.clone();
    for run in damaged.runs.iter_mut().filter(|run| run.held_out) {
        // As if it had turned the other way, at another time, with another load.
        run.measured_poses.iter_mut().for_each(|it| it.heading_rad = it.heading_rad.map(|it| -it));
        (run.started_s, run.payload_kg) = (Some(-1e6), 70.0);
    }
    let ratio = [find("wheel_radius_ratio").unwrap()];
    let (good, bad) = (fit(&marked, &ratio).unwrap(), fit(&damaged, &ratio).unwrap());
    assert_eq!((&good.effects, &good.errors), (&bad.effects, &bad.errors));
    let chi = |model: &crate::explain::model::Model| model.held_out.as_ref().unwrap().model.chi;
    assert!(chi(&bad) > 3.0 * chi(&good), "{} {}", chi(&bad), chi(&good));
}

#[test]
fn a_comparison_shows_them_apart_and_counts_them_nowhere_else() {
    let marked = marked();
    let model = [Assumed { effect: find("wheel_radius_ratio").unwrap(), values: vec![0.005] }];
    let all = Comparer::new(&marked, &[]).unwrap().compare(&model);
    let bare = Comparer::new(&without(&marked), &[]).unwrap().compare(&model);
    assert_eq!((all.position_m, &all.regimes), (bare.position_m, &bare.regimes));
    assert_eq!(bare.held_out, None);
    // Of two runs; each drifts off by as much as dead reckoning does, so they scatter by a third.
    let times = |it: &Comparison| it.held_out.unwrap().map(|it| it.rms / it.noise);
    assert!(times(&all).iter().all(|it| (0.5..1.5).contains(it)), "{:?}", all.held_out);
    let nominal = Comparer::new(&marked, &[]).unwrap().compare(&[]);
    assert!(times(&nominal).iter().all(|it| *it > 3.0), "{:?}", nominal.held_out);
    let apart: Vec<_> =
        all.runs.iter().map(|it| (it.held_out, it.kind == RunKind::Square)).collect();
    assert!(apart.iter().all(|(held_out, square)| held_out == square), "{apart:?}");
    assert_eq!(apart[apart.len() - 2..], [(true, true); 2]);
}

#[test]
fn where_all_runs_are_kept_aside_there_is_nothing_to_fit_to() {
    let mut all = marked();
    all.runs.iter_mut().for_each(|run| run.held_out = true);
    let error = explain(&all).unwrap_err();
    assert_eq!(error.problem, RecordingProblem::AllHeldOut);
    // To judge a model on them is another matter: nothing is fitted then.
    let model = fit(&marked(), &[find("wheel_radius_ratio").unwrap()]).unwrap();
    assert!(model.errors_on(&all).unwrap().chi < 1.4);
}
