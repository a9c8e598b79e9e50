//! May an effect that passes its test be there by chance?
//!
//! Every effect that might be there is tested, so the level is divided by their number (Bonferroni).
//!
//! A test goes by the noise that is left beside the effect. Of few numbers, such as the ends of twenty runs, an effect takes
//! up part of what is noise; by the rest the same effect seems to gain more than it does. There, what counts is no more than
//! the fall of the likelihood, each model with a noise of its own (Wilks):
//!
//! ```text
//! gain = -2 log L(model without it, noise learnt without it) + 2 log L(model, its noise)          (1)
//! ```

use crate::effect::composition::Term;
use crate::estimation::fit::{Fitted, fit_afresh, minus_two_log_likelihood};
use crate::numeric::parallel;
use crate::recording::campaign::Prepared;
use crate::selection::candidates::{Screening, is_geometry};
use crate::selection::effect_test::EffectTest;

/// How often the likelihood alone asks for an effect in a perfect robot. Cross-validation refuses most of these,
/// so that fewer than 5 % of perfect robots get one.
const FALSE_ALARM: f64 = 0.12;
/// Stricter beside another effect: where an equation misses part of its own effect, the rest resembles one more.
const FALSE_ALARM_BESIDE: f64 = 0.06;
/// Of few numbers, cross-validation refuses hardly any effect that the likelihood asks for.
const FALSE_ALARM_OF_FEW: f64 = 0.05;
/// Strictest for an effect with a shape, of which cross-validation refuses fewer, and for one of a sensor, which no
/// track can refuse.
const FALSE_ALARM_STRICTEST: f64 = 0.04;

/// Whether the result of a test may be chance, in a model of `effects` effects (this one counted) and with `asked`
/// effects tested.
pub(crate) fn is_chance(test: &EffectTest, asked: usize, effects: usize) -> bool {
    let level = match (effects > 1, test.has_shape || test.moves_no_track) {
        (false, false) => FALSE_ALARM,
        (true, false) => FALSE_ALARM_BESIDE,
        (_, true) => FALSE_ALARM_STRICTEST,
    };
    let level = if test.few_numbers { level.min(FALSE_ALARM_OF_FEW) } else { level };
    test.p_value * asked as f64 > level
}

/// The model without the effect that is most likely chance by (1), if any is; only of few numbers.
///
/// Where one effect of radii and track width is no chance, the others stay with it.
pub(crate) fn without_chance_by_own_noise<'a>(
    prepared: &Prepared,
    screening: &Screening<'a>,
    fitted: &Fitted<'a>,
) -> Option<Vec<Term<'a>>> {
    let kept = screening.kept();
    if prepared.noise.is_some() || !kept.iter().any(|test| test.few_numbers) {
        return None;
    }
    let without = |index: usize| {
        let mut terms = fitted.terms.clone();
        terms.remove(index);
        terms
    };
    let runs: Vec<_> = prepared.runs.iter().collect();
    let cost = |of: &Fitted<'_>| minus_two_log_likelihood(&runs, &of.terms, &of.noise);
    let with = cost(fitted);
    let effects: Vec<usize> = (0..kept.len()).collect();
    let tests: Vec<EffectTest> = parallel::map(&effects, |index| {
        let fall = cost(&fit_afresh(prepared, without(*index))) - with;
        kept[*index].with_gain_at_most(fall)
    });
    let passes = |index: &usize| !is_chance(&tests[*index], screening.asked(), tests.len());
    let of_geometry = |index: &usize| is_geometry(fitted.terms[*index].effect);
    let found = |index: &usize| passes(index) && kept[*index].predicts_better();
    let geometry_found = effects.iter().filter(|index| of_geometry(index)).any(found);
    let chance = |index: &&usize| !(passes(index) || geometry_found && of_geometry(index));
    let likeliest = effects
        .iter()
        .filter(chance)
        .max_by(|a, b| tests[**a].p_value.total_cmp(&tests[**b].p_value))?;
    Some(without(*likeliest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explain::explain;
    use crate::tests::synthetic::ends;

    #[test]
    fn what_no_track_can_refuse_has_to_be_rarer_by_chance() {
        let test =
            |moves_no_track| EffectTest { p_value: 4e-3, moves_no_track, ..EffectTest::default() };
        assert!(!is_chance(&test(false), 23, 1), "cross-validated tracks refuse most of these");
        assert!(is_chance(&test(true), 23, 1));
    }

    #[test]
    fn no_effect_is_found_by_noise_that_it_took_up_itself() {
        // Of eighty sound robots of which only the ends of runs were measured, these were given an effect.
        for seed in [16, 29, 40, 41, 62, 69] {
            let steps = explain(&ends(seed)).unwrap().steps;
            assert!(steps.is_empty(), "seed {seed}: {steps:?}");
        }
    }

    #[test]
    fn a_gain_counts_for_no_more_than_the_likelihood_falls() {
        let test = EffectTest { own: 1, dispersion: 1.0, gain: 12.0, ..EffectTest::default() };
        let (more, less) = (test.with_gain_at_most(15.0), test.with_gain_at_most(4.0));
        assert_eq!((more.gain, less.gain), (12.0, 4.0));
        // Two sigma.
        assert!((less.p_value - 0.0455).abs() < 1e-3, "{}", less.p_value);
    }

    #[test]
    fn of_few_numbers_an_effect_has_to_be_as_rare_as_false_alarms_may_be() {
        let test =
            |few_numbers, p_value| EffectTest { p_value, few_numbers, ..EffectTest::default() };
        assert!(is_chance(&test(true, 3e-3), 23, 1) && !is_chance(&test(false, 3e-3), 23, 1));
        assert!(!is_chance(&test(true, 2e-3), 23, 1));
    }
}
