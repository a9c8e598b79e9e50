//! A few runs that are off by far more than the others must not hide what the others show.
//!
//! A wheel slips in one run of twenty, or someone pushes the robot. The fit goes by all runs, so the one bends every value, its
//! error becomes noise of all, and beside that noise no effect is significant. So where a few runs are off by far more than the
//! others ([`super::quiet_runs`]), the others are explained by themselves. That stands if it predicts them clearly better than what
//! all runs together say:
//!
//! ```text
//! D(others by a model of the others) < 0.9 D(others by a model of all)                    (1)
//! ```
//!
//! with D the displacement of the wheels. Otherwise the few do no harm, and what they show counts. Where the ends alone
//! are measured of any run, none is left out: few numbers do not tell a slip from what a model lacks, and the one run with a whole track
//! beside them may be the one that tells effects apart.

use crate::effect::definition::Effect;
use crate::estimation::errors::displacement_m;
use crate::explain::answer::Answer;
use crate::recording::campaign::Campaign;
use crate::recording::run::RecordingError;
use crate::residuals::uneven_runs::RUNS_MIN;
use crate::residuals::unexplained::Unexplained;

/// At most this share of the runs is a few.
const FEW: f64 = 0.25;
/// With fewer poses than this, the track of a run is not known.
const TRACK_POSES: usize = 20;
/// Equation (1).
const LESS: f64 = 0.9;

/// This answer about all runs; or that about the others, if a few are off and (1) holds.
pub(super) fn without_few(
    (campaign, catalogue): (&Campaign, &[&dyn Effect]),
    of_all: Answer,
    explain: impl FnOnce(&Campaign) -> Result<Answer, RecordingError>,
) -> Result<Answer, RecordingError> {
    let off = &of_all.unexplained.runs_off;
    let count = campaign.fitted_runs().count();
    let are_tracks = campaign.fitted_runs().all(|run| run.measured_poses.len() >= TRACK_POSES);
    if !are_tracks
        || off.is_empty()
        || off.len() as f64 > FEW * count as f64
        || count - off.len() < RUNS_MIN
    {
        return Ok(of_all);
    }
    let is_off = |name: &String| off.contains(name);
    let mut few = campaign.clone();
    few.runs.retain(|run| is_off(&run.name));
    let mut others = campaign.clone();
    others.runs.retain(|run| !is_off(&run.name));
    let of_others = explain(&others)?;
    others.runs.retain(|run| !run.held_out);
    let displacement_m = |errors| displacement_m(&errors, campaign.robot.track_width_m);
    let by_others_m = displacement_m(of_others.predicts_by.cross_validated);
    if by_others_m > LESS * displacement_m(of_all.errors_on_with(&others, catalogue)?) {
        return Ok(of_all);
    }
    let set_aside = Some(of_others.errors_on_with(&few, catalogue)?);
    let Unexplained { runs_off, sudden, .. } = of_all.unexplained;
    let unexplained = Unexplained { runs_off, sudden, ..of_others.unexplained };
    Ok(Answer { set_aside, unexplained, clocks: of_all.clocks, ..of_others })
}

#[cfg(test)]
mod tests {
    use crate::explain::{Answer, explain};
    use crate::recording::campaign::Campaign;
    use crate::tests::synthetic::{campaign, full_plan, term};

    /// A robot whose wheels grow with speed, and whose left wheel slips in one run for half a second by so many turns.
    fn slips(turns: f64) -> Campaign {
        let mut campaign = campaign(&full_plan(), &[term("speed_growth", &[0.05])], 3);
        let run = campaign.runs.iter_mut().find(|run| run.name.contains("square")).unwrap();
        let begins_s = run.duration_s() / 3.0;
        for sample in &mut run.wheels {
            let share = ((sample.t_s - run.measured_poses[0].t_s - begins_s) / 0.5).clamp(0.0, 1.0);
            sample.phi_rad.left += share * turns * core::f64::consts::TAU;
        }
        campaign
    }

    fn found(answer: &Answer) -> Vec<&str> {
        answer.steps.iter().filter(|step| step.matters).map(|step| &*step.effect).collect()
    }

    #[test]
    fn a_slip_in_one_run_does_not_hide_what_the_others_show() {
        let sound = explain(&slips(0.0)).unwrap();
        assert_eq!((found(&sound), &sound.set_aside), (vec!["speed_growth"], &None));
        let campaign = slips(0.33);
        let square = campaign.runs.iter().find(|run| run.name.contains("square")).unwrap();
        let answer = explain(&campaign).unwrap();
        assert_eq!(found(&answer), ["speed_growth"]);
        assert_eq!(answer.unexplained.runs_off, core::slice::from_ref(&square.name));
        assert!(!answer.unexplained.structure, "the others are clean: {:?}", answer.unexplained);
        let errors = [&sound, &answer].map(|of| of.predicts_by.cross_validated.position_rms_m);
        assert!((errors[1] / errors[0] - 1.0).abs() < 0.1, "{errors:?}");
        // A third of a turn turned the rest of the run by tens of degrees of the robot.
        assert!(answer.set_aside.unwrap().position_rms_m > 0.02);
    }
}
