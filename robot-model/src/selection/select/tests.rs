use super::*;
use crate::effect::catalogue::{CATALOGUE, find};
use crate::tests::synthetic::{campaign, part_of_plan, term};

fn named(selection: &Selection<'_>) -> Vec<String> {
    ids(&selection.fitted.terms)
}

#[test]
fn a_wrong_track_width_comes_before_what_looks_like_one() {
    let zero = |id: &str| {
        let effect = find(id).unwrap();
        vec![Term::new(effect, vec![0.0; effect.facts().parameters.len()])]
    };
    // In spins and straights, scrub is the same. With arcs it is not.
    let chosen = |plan: &[&str], seed: u64| {
        let recorded = campaign(&part_of_plan(plan), &[term("scrub", &[0.02])], seed);
        let prepared = recorded.prepare().unwrap();
        let selection = backward_elimination(&prepared, &CATALOGUE, zero("scrub"));
        assert_eq!(named(&selection), ["scrub"]);
        assert!(geometry_first(&prepared, &CATALOGUE, &selection, &["scrub"]).is_none());
        geometry_first(&prepared, &CATALOGUE, &selection, &[]).map(|other| named(&other))
    };
    let geometry = ["track_width", "wheel_radius_ratio", "wheel_radius_scale"].map(String::from);
    for seed in 0..3 {
        assert_eq!(chosen(&["spin", "repeat"], seed), Some(geometry.to_vec()), "seed {seed}");
        assert_eq!(chosen(&["spin", "repeat", "arc"], seed), None, "seed {seed}");
    }
}
