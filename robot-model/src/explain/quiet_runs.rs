//! What could any model reach, where some runs are off by far more than the others?
//!
//! What is missing makes these runs err, and no smooth function of what was recorded says how: a wet patch, counts that get
//! lost at top speed. Learnt from all runs, the noise is then that of the runs that are off. But noise is the same in all
//! runs, and the others show it. So these are explained by themselves, and what a model of them reaches is reachable.
//!
//! But of runs that all have the same noise, too, some are quieter than others. And a flexible model may explain what
//! throws runs off. So what it reaches on all runs stands, unless the quiet ones show less beyond chance: by more than the
//! `quiet` quietest of `all` runs of equal noise. With D the mean squared displacement, n the numbers measured in a run:
//!
//! ```text
//! F = c D^2(all) / D^2(quiet),   c = P(chi^2_(n+2) < q) / s,   P(chi^2_n < q) = s = quiet / all   (1)
//! ```
//!
//! c is the mean square of the quietest share s, over that of all.
//!
//! In whole tracks, hundreds of innovations tell of each run that it is off, and no chance made it so: a wheel that slips on its
//! shaft in the only loaded run. There the quiet runs count if they show clearly less.

use crate::effect::definition::Effect;
use crate::estimation::errors::{Errors, displacement_m, lower};
use crate::estimation::fit::{Fitted, fit_roughly};
use crate::explain::model_errors::errors;
use crate::numeric::distributions::{chi_squared, fisher};
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::residuals::flexible_model::flexible;
use crate::residuals::group_search::numbers_measured;
use crate::residuals::heavy_tails::heavy_tails;
use crate::residuals::regressor::Regressor;
use crate::residuals::uneven_runs::{Divided, set_apart};
use crate::selection::select::{backward_elimination, select};

/// How often runs that are off are set aside: beside runs that are off by far, others look quiet.
const ROUNDS_MAX: usize = 4;
/// Significance level of (1): the runs were divided at the same one.
const P_MAX: f64 = 1e-3;

/// Where each run that is off is so beyond chance, the quiet ones reach less if it is less than this share.
const LESS_ON_TRACKS: f64 = 0.9;

/// What the runs that are not off by far show.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct QuietRuns {
    /// What is reachable on them.
    pub reachable: Errors,
    /// The names of the runs that are off, the one that is furthest off first.
    pub off: Vec<String>,
    /// What those have and the quiet ones have not; else the run itself.
    pub differ_by: Regressor,
}

/// What is reachable on the runs that are not off by far more than others. `None` if all runs are alike, or if a model
/// that reaches `on_all` of all runs leaves no more than that.
pub(super) fn reachable_on_quiet_runs<'a>(
    prepared: &Prepared,
    fitted: &Fitted<'a>,
    catalogue: &[&'a dyn Effect],
    on_all: &Errors,
) -> Option<QuietRuns> {
    let first = set_apart(prepared, fitted)?;
    let mut off = furthest_first(prepared, &first);
    let mut quiet = among(prepared, &first.quiet);
    let mut about = explained(&quiet, catalogue, (fitted, &first));
    for _ in 1..ROUNDS_MAX {
        let Some(more) = set_apart(&quiet, &about) else { break };
        off.extend(furthest_first(&quiet, &more));
        quiet = among(&quiet, &more.quiet);
        about = explained(&quiet, catalogue, (&about, &first));
    }
    let about = match first.each_beyond_chance {
        true => backward_elimination(&quiet, catalogue, about.terms).fitted,
        false => about,
    };
    // Frames that come late or twice come in all runs, in some more often than in others by chance.
    if first.each_beyond_chance && heavy_tails(&quiet, &about).is_some() {
        return None;
    }
    // Effects of few runs may predict each of them worse than none do.
    let nominal = errors(&quiet, &about.noise, &[]).cross_validated;
    let reachable = flexible(&quiet, &about, catalogue).reachable;
    let track_width_m = prepared.robot.track_width_m;
    let on_quiet = lower(&nominal, &reachable, track_width_m);
    let of = |errors: &Errors| displacement_m(errors, track_width_m);
    let both = [(prepared, of(on_all)), (&quiet, of(&on_quiet))]
        .map(|(of, displacement_m)| Displaced::new(of, displacement_m));
    let is_less = match first.each_beyond_chance {
        true => of(&on_quiet) < LESS_ON_TRACKS * of(on_all),
        false => is_less_beyond_chance(both),
    };
    is_less.then(|| QuietRuns { reachable: on_quiet, off, differ_by: first.regressor(prepared) })
}

/// The effects of these runs, from those of more runs.
///
/// Whole tracks show a flexible model what no effect says, so the same effects, fitted anew, say well enough which runs are
/// off. The ends of runs tell it little: there the effects are searched for.
fn explained<'a>(
    quiet: &Prepared,
    catalogue: &[&'a dyn Effect],
    (before, divided): (&Fitted<'a>, &Divided),
) -> Fitted<'a> {
    match divided.each_beyond_chance {
        true => fit_roughly(quiet, before.terms.clone()),
        false => select(quiet, catalogue).fitted,
    }
}

/// The names of the runs that are off, the one that is furthest off first.
fn furthest_first(prepared: &Prepared, divided: &Divided) -> Vec<String> {
    let names = divided.loud.iter().rev().map(|run| prepared.runs[*run].recording.name.clone());
    names.collect()
}

/// How far tracks of some runs are off.
#[derive(Clone, Copy)]
struct Displaced {
    displacement_m: f64,
    runs: usize,
    /// How many were measured.
    numbers: f64,
}

impl Displaced {
    fn new(of: &Prepared, displacement_m: f64) -> Self {
        Self { displacement_m, runs: of.runs.len(), numbers: numbers_measured(of) }
    }
}

/// Whether the quiet ones of all runs are off by less than chance explains: (1).
fn is_less_beyond_chance([all, quiet]: [Displaced; 2]) -> bool {
    let each = (all.numbers / all.runs as f64).round().max(1.0);
    let of_quietest = square_of_quietest(quiet.runs as f64 / all.runs as f64, each as usize);
    let times = (all.displacement_m / quiet.displacement_m).powi(2);
    let freedom = all.numbers;
    fisher(freedom as usize, quiet.numbers, freedom * of_quietest * times) < P_MAX
}

/// c of (1): the mean square of the quietest share of runs, over that of all, where all have the same noise.
fn square_of_quietest(share: f64, numbers: usize) -> f64 {
    let below = |freedom: usize, square: f64| 1.0 - chi_squared(freedom, square);
    let (mut low, mut high) = (0.0, 10.0 * (numbers + 1) as f64);
    for _ in 0..BISECTIONS {
        let middle = (low + high) / 2.0;
        if below(numbers, middle) < share { low = middle } else { high = middle }
    }
    below(numbers + 2, low) / share
}

/// Enough for ten digits.
const BISECTIONS: usize = 40;

/// The campaign of these runs alone.
fn among(prepared: &Prepared, runs: &[usize]) -> Prepared {
    let mut runs = runs.to_vec();
    runs.sort_unstable();
    let of = |all: &[PreparedRun]| runs.iter().map(|run| all[*run].clone()).collect();
    Prepared {
        runs: of(&prepared.runs),
        dense: prepared.dense.as_deref().map(of),
        noise: None,
        ..prepared.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::catalogue::CATALOGUE;
    use crate::explain::explain;
    use crate::explain::model_choice::choose;
    use crate::recording::campaign::Campaign;
    use crate::tests::synthetic::{
        ALONE, campaign, end_poses_only, ends, full_plan, push_some_aside, sound, term,
    };

    #[test]
    fn what_some_runs_are_off_by_is_not_the_error_floor_of_all() {
        for seed in 0..4 {
            let floor_m = |campaign: &Campaign| explain(campaign).unwrap().reachable.position_rms_m;
            let sound_m = floor_m(&ends(seed));
            let mut pushed = ends(seed);
            push_some_aside(&mut pushed);
            let times = floor_m(&pushed) / sound_m;
            assert!((times - 1.0).abs() < 0.3, "seed {seed}: {times} of the sound robot's");
        }
    }

    #[test]
    fn a_wheel_that_slips_on_its_shaft_in_one_run_is_not_the_noise_of_all() {
        let mut slipped = sound().clone();
        let wheels = &mut slipped.runs[4].wheels;
        let (begins, lasts) = (wheels.len() / 3, 20);
        for (index, sample) in wheels.iter_mut().enumerate() {
            let share = index.saturating_sub(begins).min(lasts) as f64 / lasts as f64;
            sample.phi_rad.left += 1.5 * share;
        }
        let [sound, found] = [sound(), &slipped].map(|campaign| explain(campaign).unwrap());
        let times = found.reachable.position_rms_m / sound.reachable.position_rms_m;
        assert!((times - 1.0).abs() < 0.1, "{times} of the sound robot's");
        // The wheel rolled less by this slip than was counted: the spin is some degrees off.
        assert!(found.unexplained.size_m > 2.0 * sound.reachable.position_rms_m);
        assert!(found.unexplained.depends_on.contains(&Regressor::Run), "{:?}", found.unexplained);
        assert_eq!(found.unexplained.runs_off, [slipped.runs[4].name.clone()]);
        assert!(!sound.unexplained.structure && sound.unexplained.runs_off.is_empty());
    }

    #[test]
    fn the_quietest_runs_of_equal_noise_are_quieter_by_chance() {
        // Of chi^2 of two degrees, which is exponential, the lower half lies below 2 ln 2.
        let half = square_of_quietest(0.5, 2);
        assert!((half - (1.0 - core::f64::consts::LN_2)).abs() < 1e-6, "{half}");
        assert!((square_of_quietest(1.0, 3) - 1.0).abs() < 1e-6);
        let of = |displacement_m, runs: usize| Displaced {
            displacement_m,
            runs,
            numbers: 3.0 * runs as f64,
        };
        let is_less = |quiet, all| is_less_beyond_chance([of(all, 20), of(quiet, 10)]);
        // Twice as quiet is what chance gives the quietest half; three times is not.
        assert!(!is_less(1e-3, 2e-3) && is_less(1e-3, 3e-3));
    }

    #[test]
    fn what_a_flexible_model_reaches_on_all_runs_stands_where_quiet_ones_are_less_by_chance() {
        // What the catalogue lacks here throws some runs off. A flexible model finds scrub, but not unequal radii.
        for (id, seed, less) in [("scrub", 1, false), ("wheel_radius_ratio", 0, true)] {
            let (_, values) = ALONE.into_iter().find(|effect| effect.0 == id).unwrap();
            let catalogue: Vec<&dyn Effect> =
                CATALOGUE.into_iter().filter(|effect| effect.facts().id != id).collect();
            let recorded = end_poses_only(campaign(&full_plan(), &[term(id, values)], seed));
            let choice = choose(recorded.prepare().unwrap(), &catalogue, &[]);
            let quiet = |on_all: &Errors| {
                reachable_on_quiet_runs(&choice.prepared, &choice.selected, &catalogue, on_all)
            };
            let all = choice.flexible.reachable;
            let none = Errors { position_rms_m: 1.0, ..all };
            let lower = quiet(&none).expect("some runs are off").reachable;
            assert!(lower.position_rms_m < all.position_rms_m, "{lower:?}, {all:?}");
            assert_eq!(quiet(&all).is_some(), less, "{id}: {lower:?}, {all:?}");
        }
    }
}
