//! What could any model reach, where some runs are off by far more than the others?
//!
//! What is missing makes these runs err, and no smooth function of what was recorded says how: a wet patch, counts that get
//! lost at top speed. Learnt from all runs, the noise is then that of the runs that are off. But noise is the same in all
//! runs, and the others show it. So these are explained by themselves, and what a model of them reaches is reachable.

use crate::effect::definition::Effect;
use crate::estimation::errors::Errors;
use crate::estimation::fit::Fitted;
use crate::explain::model_errors::errors;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::residuals::flexible_model::{flexible, lower};
use crate::residuals::uneven_runs::{RUNS_MIN, divided};
use crate::selection::select::select;

/// How often runs that are off are set aside: beside runs that are off by far, others look quiet.
const ROUNDS_MAX: usize = 4;

/// What is reachable on the runs that are not off by far more than others; `None` if all runs are alike.
pub(super) fn reachable_on_quiet_runs(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    catalogue: &[&dyn Effect],
) -> Option<Errors> {
    let mut quiet = among(prepared, &divided(prepared, fitted, RUNS_MIN)?.quiet);
    let mut selection = select(&quiet, catalogue);
    for _ in 1..ROUNDS_MAX {
        let Some(more) = divided(&quiet, &selection.fitted, RUNS_MIN) else { break };
        quiet = among(&quiet, &more.quiet);
        selection = select(&quiet, catalogue);
    }
    // Effects of few runs may predict each of them worse than none do.
    let nominal = errors(&quiet, &selection.fitted.noise, &[]).cross_validated;
    let reachable = flexible(&quiet, &selection.fitted, catalogue).reachable;
    Some(lower(&nominal, &reachable, prepared.robot.track_width_m))
}

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
    use crate::explain::explain;
    use crate::recording::campaign::Campaign;
    use crate::tests::synthetic::{ends, push_some_aside};

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
}
