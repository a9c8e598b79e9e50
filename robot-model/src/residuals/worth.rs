//! How far does it move the robot, what the residuals depend on? What is beyond chance may be too small to matter.

use crate::effect::composition::{PlacedTerm, Term};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::errors::{moved, moves_m};
use crate::estimation::tolerance::least_size_m;
use crate::recording::campaign::Prepared;

/// Of these columns of auxiliary effects, which are in a model with others: how far they move the runs at least, with the
/// probability by chance of as much and allowance for so many that were asked for \[m\].
pub(super) fn least_move_m(
    prepared: &Prepared,
    (equations, terms): (&CampaignEquations, &[PlacedTerm<'_>]),
    model: &[usize],
    (own, p_value): (&[usize], f64),
    asked: usize,
) -> f64 {
    let delta = equations.best(&equations.total, model);
    let all = moved(prepared, terms, model, &delta);
    let acts = |term: &Term<'_>| term.values.iter().any(|value| *value != 0.0);
    let is_own =
        |placed: &PlacedTerm<'_>| own.iter().any(|column| placed.columns().contains(column));
    let with: Vec<Term<'_>> = all.iter().filter(|term| acts(term)).cloned().collect();
    let others = all.iter().zip(terms).filter(|(term, placed)| acts(term) && !is_own(placed));
    let without: Vec<Term<'_>> = others.map(|(term, _)| term.clone()).collect();
    least_size_m(moves_m(prepared, &with, &without), p_value, asked)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::definition::Effect;
    use crate::estimation::tolerance::tolerance_m;
    use crate::recording::odometry_noise::OdometryNoise;
    use crate::residuals::auxiliary_effects::AUXILIARY_EFFECTS;
    use crate::residuals::regressor::Regressor;
    use crate::tests::synthetic::{campaign, full_plan, sound, term};

    #[test]
    fn how_far_terms_take_the_runs_is_in_proportion_to_their_values() {
        let prepared = sound().prepare().unwrap();
        let moves = |pull: f64| moves_m(&prepared, &[term("heading_pull", &[pull])], &[]);
        let (once_m, twice_m) = (moves(2e-3), moves(4e-3));
        assert!((twice_m / once_m - 2.0).abs() < 0.01, "{once_m}, {twice_m}");
        // Two milliradians per metre, over runs of two to five metres.
        assert!((1e-3..6e-3).contains(&once_m), "{once_m}");
        assert_eq!(moves(0.0), 0.0);
    }

    #[test]
    fn what_moves_the_runs_beyond_doubt_is_above_the_tolerance_and_chance_is_not() {
        // Turns in proportion to v^2 dt, which no wrong geometry makes.
        let mut auxiliary =
            AUXILIARY_EFFECTS.iter().filter(|one| one.regressor == Regressor::Speed);
        let effect: &dyn Effect = auxiliary.nth(1).unwrap();
        let of = |pull: f64, p_value: f64| {
            let truth = [Term::new(effect, vec![0.0, pull, 0.0, 0.0])];
            let prepared = campaign(&full_plan(), &truth, 3).prepare().unwrap();
            let terms = PlacedTerm::place(&[Term::new(effect, vec![0.0; 4])]);
            let noise = OdometryNoise::TYPICAL;
            let equations = CampaignEquations::gather(&prepared, &terms, &noise);
            let columns: Vec<usize> = terms[0].columns().collect();
            let least_m =
                least_move_m(&prepared, (&equations, &terms), &columns, (&columns, p_value), 30);
            (least_m, tolerance_m(&prepared, &noise))
        };
        let (least_m, tolerance_m) = of(0.03, 1e-30);
        assert!(least_m > 10.0 * tolerance_m, "{least_m}");
        let (least_m, tolerance_m) = of(0.0, 1e-5);
        assert!(least_m < tolerance_m, "{least_m}");
        assert_eq!(of(0.03, 0.01).0, 0.0, "of thirty that were asked for, one is as unlikely");
    }
}
