use super::*;
use crate::effect::catalogue::{CATALOGUE, find};
use crate::recording::nominal_run::Piece;
use crate::tests::synthetic::{campaign, full_plan, part_of_plan, term};

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

#[test]
fn an_effect_that_runs_hardly_tell_from_radii_and_track_width_is_refused() {
    // Forwards in one heading, a drift along it is a radius, until turns on the spot are carried too; these and straight runs
    // tell no scrub from a track width.
    let ahead = |k: usize| {
        let speed_mps = [0.07, 0.12][k % 2];
        (format!("straight_{k}"), 0.0, vec![Piece::Straight { travel_m: 1.5, speed_mps }])
    };
    let straights: Vec<_> = (0..6).map(ahead).collect();
    let with_spins: Vec<_> = (0..6).map(ahead).chain(part_of_plan(&["spin"])).collect();
    let blur = |plan: &[(String, f64, Vec<Piece>)], id: &str| {
        let prepared = campaign(plan, &[], 1).prepare().unwrap();
        let fitted = fit_roughly(&prepared, geometry(&CATALOGUE));
        let screening = Screening::new(&prepared, &fitted, &CATALOGUE);
        let found = screening.candidates().into_iter().find(|one| one.id() == id).unwrap();
        let test = EffectTest { cross_validated_gain: 100.0, own_share: 0.5, ..found.test };
        (test.blurs_geometry, EffectTest { implausible: false, ..test }.is_sound())
    };
    for (id, runs) in [("scrub", &with_spins), ("carpet_drift", &straights)] {
        let (times, sound) = blur(runs, id);
        assert!(times > 10.0 && !sound, "{id}: {times}");
        let (times, sound) = blur(&full_plan(), id);
        assert!(times < 3.0 && sound, "{id}: {times}");
    }
}
