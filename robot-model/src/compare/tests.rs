//! Comparisons of simulated robots of known truth with known models.

use super::comparison::{CHOOSING_RUNS_MAX, share};
use super::*;
use crate::effect::composition::Term;
use crate::effect::{CATALOGUE, Custom, Effect, NetChange, Ways};
use crate::explain::explain_with;
use crate::recording::RunKind;
use crate::tests::synthetic::{campaign, full_plan, part_of_plan, term};

fn compared(truth: &[Term<'static>], model: &[EffectWithValues<'_>], seed: u64) -> Comparison {
    let runs = campaign(&full_plan(), truth, seed);
    Comparer::new(&runs, &[]).unwrap().compare(model)
}

fn effect_with_values(id: &str, values: &[f64]) -> EffectWithValues<'static> {
    EffectWithValues {
        effect: crate::effect::find(id).unwrap(),
        values: values.into(),
        up_to_mps: None,
    }
}

fn group(comparison: &Comparison, regime: Regime, label: Label) -> &RegimeError {
    let grouping = comparison.regimes.iter().find(|grouping| grouping.regime == regime).unwrap();
    grouping.groups.iter().find(|group| group.label == label).unwrap()
}

#[test]
fn a_perfect_robot_is_noise_everywhere() {
    for seed in 300..303 {
        let comparison = compared(&[], &[], seed);
        assert!(
            !comparison.position_m.beyond_noise() && !comparison.heading_rad.beyond_noise(),
            "{:?}",
            comparison.finding
        );
        // What noise gives is found to what the 15 runs of a campaign scatter by.
        assert!(
            (0.7..1.3).contains(&(comparison.position_m.rms / comparison.position_m.noise)),
            "{comparison:?}"
        );
        for grouping in &comparison.regimes {
            for group in &grouping.groups {
                assert!(!group.beyond_noise, "{:?}: {group:?}", grouping.regime);
                // Three numbers a stretch, and some hundred groups in all: four sigma.
                let four_sigma = 4.0 / (6.0 * group.stretches as f64).sqrt();
                assert!(
                    (group.chi - 1.0).abs() < 0.1 + four_sigma,
                    "{:?}: {group:?}",
                    grouping.regime
                );
            }
        }
        assert_eq!(
            (comparison.finding.error_level, comparison.finding.worst),
            (ErrorLevel::WithinNoise, None)
        );
    }
}

#[test]
fn a_radius_ratio_flips_with_the_direction_of_travel_and_a_pull_does_not() {
    let ratio = compared(&[term("wheel_radius_ratio", &[0.01])], &[], 1);
    let turn = |comparison: &Comparison, label: Label| {
        let drift =
            group(comparison, Regime::TravelDirection, label).drifts[Component::Turn as usize];
        assert!(drift.sigmas() > 4.0, "{label:?}: {drift:?}");
        drift.per_m
    };
    // R (1 +- rho/2): rho / b for each metre, here 0.01 / 0.372 m; the arcs drive forwards alone.
    let (ahead, back) = (turn(&ratio, Label::Forward), turn(&ratio, Label::Backward));
    assert!((ahead - 0.0269).abs() < 0.003 && (back + 0.0269).abs() < 0.003, "{ahead} {back}");
    assert!(ratio.position_m.beyond_noise() && ratio.heading_rad.beyond_noise());
    assert!(matches!(ratio.finding.error_level, ErrorLevel::TimesNoise(_)), "{:?}", ratio.finding);
    let pull = compared(&[term("heading_pull", &[0.03])], &[], 1);
    assert!(turn(&pull, Label::Forward) > 0.0 && turn(&pull, Label::Backward) > 0.0);
}

#[test]
fn what_the_model_knows_is_no_longer_an_error() {
    let truth = [term("side_slip", &[0.05])];
    let before = compared(&truth, &[], 2);
    let after = compared(&truth, &[effect_with_values("side_slip", &[0.05])], 2);
    let arc = |comparison: &Comparison| {
        group(comparison, Regime::RunKind, Label::Kind(RunKind::Arc)).clone()
    };
    assert!(arc(&before).beyond_noise && !arc(&after).beyond_noise);
    assert!(!after.position_m.beyond_noise(), "{:?}", after.finding);
    // To the outside: in turns to the left, to the right; as arcs differ in speed, so do they in slip.
    let left = group(&before, Regime::TurnDirection, Label::Left).drifts[Component::Left as usize];
    assert!(left.per_m < 0.0 && left.sigmas() > 2.0, "{left:?}");
}

#[test]
fn a_curve_shows_the_shape_of_the_residual() {
    let truth = [term("wheel_eccentricity", &[0.03, 0.0, 0.0, 0.0])];
    let comparer = Comparer::new(&campaign(&full_plan(), &truth, 9), &[]).unwrap();
    let worst =
        |curves: Vec<Curve>| curves.into_iter().max_by(|a, b| a.chi.total_cmp(&b.chi)).unwrap();
    let before = worst(comparer.curves(&[]));
    assert_eq!(before.axis, Axis::LeftWheelAngle, "{before:?}");
    let after =
        worst(comparer.curves(&[effect_with_values("wheel_eccentricity", &[0.03, 0.0, 0.0, 0.0])]));
    assert!(after.chi < before.chi / 2.0, "{} {}", after.chi, before.chi);
}

#[test]
fn what_a_class_has_in_common_is_one_plain_number() {
    let comparer = Comparer::new(&campaign(&full_plan(), &[], 1), &[]).unwrap();
    let turn = |rad_per_m, on| NetChange::TurnPerMetre { rad_per_m, on };
    for (id, values, expected) in [
        ("heading_pull", &[0.008][..], turn(0.008, Ways::Both)),
        ("wheel_radius_ratio", &[-0.00372], turn(-0.01, Ways::Opposite)),
        ("track_width", &[0.02], NetChange::TurnShare(-0.0196)),
        ("wheel_radius_scale", &[0.005], NetChange::TravelShare(0.005)),
    ] {
        use NetChange as N;
        let found = comparer.net_change(&effect_with_values(id, values)).unwrap();
        let (a, b) = match (found, expected) {
            (N::TurnPerMetre { rad_per_m: a, on: here }, N::TurnPerMetre { rad_per_m: b, on })
                if here == on =>
            {
                (a, b)
            }
            (N::TurnShare(a), N::TurnShare(b)) | (N::TravelShare(a), N::TravelShare(b)) => (a, b),
            _ => panic!("{id}: {found:?}"),
        };
        // To the digits that are told.
        assert!((a - b).abs() < 5e-5, "{id}: {found:?}");
    }
    assert_eq!(comparer.net_change(&effect_with_values("heading_pull", &[0.0])), None);
}

#[test]
fn runs_without_headings_or_places_are_compared_as_far_as_they_go() {
    let mut runs = campaign(&part_of_plan(&["square"]), &[], 3);
    runs.runs[0].measured_poses.iter_mut().for_each(|pose| pose.heading_rad = None);
    runs.runs[1].measured_poses.clear();
    let comparison = Comparer::new(&runs, &[]).unwrap().compare(&[]);
    assert!(comparison.runs[0].position_m.is_some() && comparison.runs[0].heading_rad.is_none());
    assert!(comparison.runs[1].position_m.is_none() && comparison.runs[1].end_m.is_none());
}

#[test]
fn an_explanation_has_the_noise_that_a_comparison_would_estimate() {
    let own = Custom::from_equation("dtheta/ds = k * sin(4*theta)").unwrap();
    let own = own.build().unwrap();
    // Unknown to the search, so that it is made again with less noise; and known to it.
    let runs = campaign(&full_plan(), &[Term::new(&own, vec![0.05])], 4);
    for more in [vec![], vec![&own as &dyn Effect]] {
        let catalogue = [CATALOGUE.to_vec(), more.clone()].concat();
        let answer = explain_with(&runs, &catalogue).unwrap();
        assert_eq!(answer.compared_by, *Comparer::new(&runs, &more).unwrap().noise());
    }
}

#[test]
fn of_many_runs_a_share_chooses_the_effects_and_all_tell_the_noise() {
    // Of two kinds by turns: neither of them alone tells a pull from a radius.
    let plan = part_of_plan(&["out_and_back_1", "spin_0.2_13"]);
    let truth = [term("heading_pull", &[0.02])];
    let mut many = campaign(&plan, &truth, 0);
    for seed in 1..=(CHOOSING_RUNS_MAX as u64 / plan.len() as u64 + 50) {
        many.runs.extend(campaign(&plan, &truth, seed).runs);
    }
    let chosen_by = share(&many).expect("there are many").runs.len();
    assert!(chosen_by < many.runs.len() && chosen_by <= CHOOSING_RUNS_MAX + 5, "{chosen_by}");
    let comparison =
        Comparer::new(&many, &[]).unwrap().compare(&[effect_with_values("heading_pull", &[0.02])]);
    for Rms { rms, noise, .. } in [comparison.position_m, comparison.heading_rad] {
        assert!((noise / rms).ln().abs() < 0.05, "{noise} of {rms}");
    }
    many.runs.truncate(CHOOSING_RUNS_MAX);
    assert!(share(&many).is_none(), "few runs choose by themselves");
}
