use super::*;
use crate::effect::catalogue::{CATALOGUE, find};
use crate::effect::composition::PlacedTerm;
use crate::effect::{Custom, Parameter};
use crate::selection::candidates::Screening;
use crate::tests::synthetic::{ALONE, NOISE, campaign, full_plan, term};

#[test]
fn a_fit_converges_and_one_that_ended_at_zero_is_recognised() {
    for (id, values) in [("wheel_radius_ratio", &[0.01][..]), ("backlash", &[0.06, 0.07, 10.0])] {
        let prepared = campaign(&full_plan(), &[term(id, values)], 8).prepare().unwrap();
        let effect = find(id).unwrap();
        let start = Term::new(effect, effect.starts(&prepared.excitation).swap_remove(0));
        let fitted = fit_afresh(&prepared, vec![start]);
        assert_eq!(Screening::new(&prepared, &fitted, &CATALOGUE).is_unsettled(), [false], "{id}");
        let mut elsewhere = fitted.clone();
        elsewhere.terms[0].values.fill(0.0);
        assert_eq!(
            Screening::new(&prepared, &elsewhere, &CATALOGUE).is_unsettled(),
            [true],
            "{id}"
        );
    }
}

#[test]
fn no_fit_ends_worse_than_it_began() {
    let cost = |prepared: &Prepared, terms: &[Term<'_>]| {
        let equations = CampaignEquations::gather(prepared, &PlacedTerm::place(terms), &NOISE);
        equations.total.squares + equations.prior_cost()
    };
    // A wave whose length is far off: full steps lead from one wrong wave to the next.
    let mut wave = Custom::from_equation("dtheta/ds = c * sin(w * s)").unwrap();
    wave.ranges.insert("w".into(), [0.5, 60.0]);
    let wave = wave.build().unwrap();
    let (mut better, mut all) = (0, 0);
    for (id, values) in ALONE.into_iter().filter(|(id, _)| !id.starts_with("gyro_")) {
        let prepared = campaign(&full_plan(), &[term(id, values)], 9).prepare().unwrap();
        for [c, w] in [[0.02, 3.0], [0.1, 11.0], [-0.05, 29.0]] {
            let of = |parameter: &Parameter| if parameter.name == "c" { c } else { w };
            let values = wave.facts().parameters.iter().map(of).collect();
            let terms = vec![Term::new(&wave, values)];
            let before = cost(&prepared, &terms);
            let after = cost(&prepared, &fit_parameters(&prepared, terms, NOISE).terms);
            assert!(after <= before + RISE, "{id}, {c}, {w}: {before} to {after}");
            all += 1;
            better += usize::from(after < before - RISE);
        }
    }
    assert!(2 * better > all, "{better} of {all} got better");
}

#[test]
fn an_amplitude_of_one_sign_stays_at_zero_where_noise_would_have_it_negative() {
    // Play in the left gear alone: by noise, every other fit would have that of the right one negative.
    let mut at_zero = 0;
    for seed in 1..=6 {
        let truth = [term("backlash", &[0.05, 0.0, 10.0])];
        let prepared = campaign(&full_plan(), &truth, seed).prepare().unwrap();
        let fitted = fit_parameters(
            &prepared,
            vec![Term::new(find("backlash").unwrap(), vec![0.0, 0.0, 10.0])],
            NOISE,
        );
        let [left, right, _] = fitted.terms[0].values[..] else { unreachable!() };
        assert!((left - 0.05).abs() < 4.0 * fitted.covariance[(0, 0)].sqrt(), "{left}");
        assert!((0.0..4.0 * fitted.covariance[(1, 1)].sqrt()).contains(&right), "{right}");
        at_zero += usize::from(right == 0.0);
    }
    assert!((1..6).contains(&at_zero), "{at_zero}");
}
