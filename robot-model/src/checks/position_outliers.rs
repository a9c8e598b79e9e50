//! Which single positions are elsewhere for one frame? A fit can live with them.

use crate::numeric::median::median;
use crate::recording::run::{Recording, Robot};

use super::dead_reckoning::Reckoned;

/// A position far from those before and after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spike {
    /// When \[s\].
    pub t_s: f64,
    /// How far off it is \[m\].
    pub off_m: f64,
}

/// A spike is off by at least this \[m\], and by this many times the median error between frames.
const SPIKE_M: f64 = 0.1;
const SPIKE_TIMES: f64 = 10.0;
/// Frames farther apart than this do not show that the one between them is wrong \[s\].
const SPIKE_S: f64 = 1.0;
/// Fewer rows do not show what is usual.
const STEPS_MIN: usize = 20;

/// The first position of a run that is elsewhere for one frame: an outlier, which a fit may well ignore.
pub fn spike(robot: &Robot, run: &Recording) -> Option<Spike> {
    let reckoned = Reckoned::of(robot, run);
    let poses = run.measured_poses.iter();
    let positions: Vec<(f64, [f64; 2])> =
        poses.filter_map(|pose| Some((pose.t_s, pose.position_m?))).collect();
    if positions.len() <= STEPS_MIN {
        return None;
    }
    let apart_m = |a: &(f64, [f64; 2]), b: &(f64, [f64; 2])| {
        let gap_m = (b.1[0] - a.1[0]).hypot(b.1[1] - a.1[1]);
        gap_m - reckoned.rolled(a.0, b.0).0
    };
    let usual_m =
        median(positions.windows(2).map(|pair| apart_m(&pair[0], &pair[1]).abs()).collect())?;
    let limit_m = SPIKE_M.max(SPIKE_TIMES * usual_m);
    let off = |three: &[(f64, [f64; 2])]| {
        let [before, row, after] = three else { return None };
        let off_m = apart_m(before, row).min(apart_m(row, after));
        let near = after.0 - before.0 < SPIKE_S && apart_m(before, after) < 0.5 * off_m;
        (off_m > limit_m && near).then_some(Spike { t_s: row.0, off_m })
    };
    positions.windows(3).find_map(off)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::synthetic::{ROBOT, each_alone, sound};

    #[test]
    fn a_robot_that_is_merely_inaccurate_has_no_spikes() {
        for (id, campaign) in each_alone() {
            assert_eq!(campaign.runs.iter().find_map(|run| spike(&ROBOT, run)), None, "{id}");
        }
    }

    #[test]
    fn one_position_that_is_elsewhere_is_found() {
        for run in sound().runs.iter().filter(|run| run.measured_poses.len() > 2 * STEPS_MIN) {
            let mut wrong = run.clone();
            let middle = wrong.measured_poses.len() / 2;
            wrong.measured_poses[middle].position_m =
                run.measured_poses[middle].position_m.map(|[x, y]| [x, y + 0.5]);
            let found = spike(&ROBOT, &wrong);
            let at_s = run.measured_poses[middle].t_s;
            assert!(
                found.is_some_and(|spike| spike.t_s == at_s && spike.off_m > 0.4),
                "{}: {found:?}",
                run.name
            );
        }
    }
}
