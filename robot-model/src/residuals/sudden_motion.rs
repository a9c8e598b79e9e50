//! In which runs did the robot at once move as its wheels did not: a wheel that slipped, counts that were lost, a push?
//!
//! ```text
//! within a window of at most a second or so: a turn, and a way ahead, more than the wheels say            (1)
//! chi^2 falls by 60 with (1), by 40 more than without the pose that stands out most, and nothing is left           (2)
//! ```
//!
//! A pose that was misread shows once: without it the run is like the others. A robot that moved stays where it is, and every
//! later pose shows it. What many runs have is no accident, and is left to the other tests.

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use crate::effect::composition::{PlacedTerm, Term, Terms};
use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::estimation::ekf::{FilterObserver, Innovation, whiten};
use crate::estimation::fit::Fitted;
use crate::kinematics::pose::Pose;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::numeric::parallel;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::motion::Step;
use crate::recording::run::PoseMeasurement;

/// A robot that at once moved as its wheels did not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SuddenMotion {
    /// The run's name.
    pub run: String,
    /// From when to when, as the run's file counts time \[s\].
    pub from_s: f64,
    /// The end of that.
    pub to_s: f64,
    /// How much further it turned than its wheels say, counter-clockwise positive \[rad\].
    pub turn_rad: f64,
    /// Its standard error \[rad\].
    pub turn_sigma_rad: f64,
    /// How much further the left wheel and the right one went than they say \[m\].
    pub wheels_m: [f64; 2],
}

/// At most so many runs are searched, and at most this share of them may have it.
const RUNS_MAX: usize = 4;
const SHARE_MAX: f64 = 0.25;
/// A pose stands out if the squares of its whitened innovations add up to this.
const STANDS_OUT: f64 = 25.0;
/// (2).
const GAIN_MIN: f64 = 60.0;
const MORE_THAN_ONE_POSE: f64 = 40.0;
/// Nothing is left if the mean square of the run is then at most this many times the median of all runs.
const LIKE_OTHERS: f64 = 1.5;
/// Windows, as numbers of intervals between poses.
const WIDTHS: [usize; 6] = [1, 2, 4, 8, 16, 32];
/// Each width is tried at so many places about the pose that stands out.
const PLACES: usize = 4;

/// Moves that the wheels do not tell, spread evenly over the time of a window.
#[derive(Debug)]
struct Moment {
    from_s: f64,
    to_s: f64,
}

impl Effect for Moment {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let (begin_s, end_s) = (step.t_s - step.dt_s / 2.0, step.t_s + step.dt_s / 2.0);
        let within_s = (end_s.min(self.to_s) - begin_s.max(self.from_s)).max(0.0);
        let share = within_s / (self.to_s - self.from_s);
        let (sin, cos) = step.heading_rad.sin_cos();
        Change {
            turn_rad: p[0] * share,
            drift_m: [p[1] * (share * cos), p[1] * (share * sin)],
            ..Change::NONE
        }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "sudden_motion",
    name: "sudden motion",
    parameters: &[
        Parameter::amplitude("turn", "rad", 3.0),
        Parameter::amplitude("ahead", "m", 1.0),
    ],
    ..Facts::DEFAULT
};

/// The whitened innovations of a run.
#[derive(Default)]
struct Rows {
    /// Of each pose after the first: its time, and the sum of the squares of its numbers.
    poses: Vec<(f64, f64)>,
    open: f64,
    numbers: f64,
    /// Products with the last two columns, if there are any.
    gram: Matrix2<f64>,
    right: Vector2<f64>,
}

impl FilterObserver for Rows {
    fn row(&mut self, innovation: Innovation, whitened: &[f64]) {
        let value = innovation.value / innovation.variance.sqrt();
        self.open += value * value;
        self.numbers += 1.0;
        if let [.., turn, ahead] = *whitened {
            let row = Vector2::new(turn, ahead);
            self.gram += row * row.transpose();
            self.right += row * value;
        }
    }

    fn pose(&mut self, measurement: &PoseMeasurement, _: &Step, _: Pose) {
        self.poses.push((measurement.t_s, core::mem::take(&mut self.open)));
    }
}

impl Rows {
    fn squares(&self) -> f64 {
        self.poses.iter().map(|(_, squares)| squares).sum()
    }

    /// The place of the pose that stands out most, and its squares.
    fn loudest(&self) -> (usize, f64) {
        let squares = self.poses.iter().map(|(_, squares)| *squares).enumerate();
        squares.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
    }
}

/// One run with the model.
struct Search<'r, 'a> {
    run: &'r PreparedRun,
    fitted: &'r Fitted<'a>,
}

impl Search<'_, '_> {
    fn as_fitted(&self, poses: &[PoseMeasurement]) -> Rows {
        let (terms, mut rows) = (Terms::Fixed(&self.fitted.terms), Rows::default());
        whiten(&self.run.motion, poses, terms, &self.fitted.noise, &mut rows);
        rows
    }

    /// With moves in a window.
    fn with(&self, moment: &Moment, values: [f64; 2]) -> Rows {
        let mut terms: Vec<Term<'_>> = self.fitted.terms.clone();
        terms.push(Term::new(moment, values.into()));
        let (placed, mut rows) = (PlacedTerm::place(&terms), Rows::default());
        let (poses, noise) = (&self.run.recording.measured_poses, &self.fitted.noise);
        whiten(&self.run.motion, poses, Terms::Free(&placed), noise, &mut rows);
        rows
    }

    /// The window whose moves explain most, near the pose in this place.
    fn best_window(&self, rows: &Rows, loudest: usize) -> Option<Moment> {
        let last = rows.poses.len() - 1;
        let start_s = self.run.motion.start_s;
        let windows = WIDTHS.iter().flat_map(|width| {
            let places = 0..PLACES.min(*width);
            places.map(move |place| {
                let from = loudest.saturating_sub(1 + place * width / PLACES.min(*width));
                let [from_s, to_s] = [from, (from + width).min(last)].map(|at| rows.poses[at].0);
                Moment { from_s: from_s - start_s, to_s: to_s - start_s }
            })
        });
        let gain = |moment: &Moment| {
            let rows = self.with(moment, [0.0; 2]);
            rows.gram.try_inverse().map_or(0.0, |inverse| rows.right.dot(&(inverse * rows.right)))
        };
        let windows = windows.filter(|moment| moment.to_s > moment.from_s);
        let gains = windows.map(|moment| (gain(&moment), moment));
        gains.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, moment)| moment)
    }

    /// What happened at once in this run, if (2) holds; `usual` is the mean square of other runs.
    fn find(&self, rows: &Rows, usual: f64, track_width_m: f64) -> Option<SuddenMotion> {
        let (loudest, _) = rows.loudest();
        let moment = self.best_window(rows, loudest)?;
        let (mut values, mut variances) = (Vector2::zeros(), Matrix2::zeros());
        // Once about zero and twice about where that leads: large turns are not linear.
        for _ in 0..3 {
            let there = self.with(&moment, values.into());
            variances = there.gram.try_inverse()?;
            values += variances * there.right;
        }
        let after = self.with(&moment, values.into());
        let mut poses = self.run.recording.measured_poses.clone();
        poses.retain(|pose| pose.t_s != rows.poses[loudest].0);
        let gain = rows.squares() - after.squares();
        let by_one_pose = rows.squares() - self.as_fitted(&poses).squares();
        let is_all = after.squares() < LIKE_OTHERS * usual * after.numbers;
        let is_motion = gain > GAIN_MIN && gain > by_one_pose + MORE_THAN_ONE_POSE;
        let [turn_rad, ahead_m] = values.into();
        let half_m = turn_rad * track_width_m / 2.0;
        (is_motion && is_all).then(|| SuddenMotion {
            run: self.run.recording.name.clone(),
            from_s: moment.from_s + self.run.motion.start_s,
            to_s: moment.to_s + self.run.motion.start_s,
            turn_rad,
            turn_sigma_rad: variances[(0, 0)].sqrt(),
            wheels_m: [ahead_m - half_m, ahead_m + half_m],
        })
    }
}

/// What happened at once, in the runs that stand out most.
pub(crate) fn sudden_motions(prepared: &Prepared, fitted: &Fitted<'_>) -> Vec<SuddenMotion> {
    let all: Vec<Rows> = parallel::map(&prepared.runs, |run| {
        Search { run, fitted }.as_fitted(&run.recording.measured_poses)
    });
    let mut means: Vec<f64> =
        all.iter().map(|rows| rows.squares() / rows.numbers.max(1.0)).collect();
    means.sort_by(f64::total_cmp);
    let usual = means[means.len() / 2];
    let each = prepared.runs.iter().zip(&all);
    let mut loud: Vec<(&PreparedRun, &Rows)> = each
        .filter(|(_, rows)| rows.poses.len() > 1 && rows.loudest().1 > STANDS_OUT * usual)
        .collect();
    loud.sort_by(|a, b| b.1.loudest().1.total_cmp(&a.1.loudest().1));
    loud.truncate(RUNS_MAX);
    let track_width_m = prepared.robot.track_width_m;
    let found =
        parallel::map(&loud, |(run, rows)| Search { run, fitted }.find(rows, usual, track_width_m));
    let found: Vec<SuddenMotion> = found.into_iter().flatten().collect();
    let few = found.len() as f64 <= SHARE_MAX * prepared.runs.len() as f64;
    if few { found } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use crate::explain::explain;
    use crate::recording::campaign::Campaign;
    use crate::tests::synthetic::{ROBOT, campaign, full_plan};

    /// A sound robot of whose left wheel so many metres are not told by its counts, in one run, from half of it on.
    fn slips(slipped_m: f64, seconds: f64) -> (Campaign, f64) {
        let mut campaign = campaign(&full_plan(), &[], 3);
        let run = campaign.runs.iter_mut().find(|run| run.name.contains("square")).unwrap();
        let begins_s = run.wheels[0].t_s + run.duration_s() / 2.0;
        for sample in &mut run.wheels {
            let share = ((sample.t_s - begins_s) / seconds).clamp(0.0, 1.0);
            sample.phi_rad.left += share * slipped_m / ROBOT.wheel_radius_m;
        }
        (campaign, begins_s)
    }

    #[test]
    fn a_wheel_that_slips_for_a_moment_is_told_with_run_time_and_size() {
        for (slipped_m, seconds) in [(0.02, 0.2), (0.012, 0.1), (0.05, 0.6)] {
            let (campaign, begins_s) = slips(slipped_m, seconds);
            let found = explain(&campaign).unwrap().unexplained.sudden;
            let [only] = &found[..] else { panic!("{slipped_m}: {found:?}") };
            assert!(only.run.contains("square"), "{only:?}");
            assert!(only.from_s < begins_s + seconds && begins_s < only.to_s, "{only:?}");
            assert!(only.to_s - only.from_s < 2.0 * seconds + 0.2, "{only:?}");
            // The left wheel went less far than it says, the right one as far.
            let [left_m, right_m] = only.wheels_m;
            assert!((left_m + slipped_m).abs() < 0.2 * slipped_m, "{only:?}");
            assert!(right_m.abs() < 0.3 * slipped_m, "{only:?}");
        }
    }

    #[test]
    fn a_pose_that_was_misread_is_no_motion_and_a_sound_robot_has_none() {
        let mut campaign = campaign(&full_plan(), &[], 3);
        assert_eq!(explain(&campaign).unwrap().unexplained.sudden, []);
        let run = campaign.runs.iter_mut().find(|run| run.name.contains("square")).unwrap();
        let middle = run.measured_poses.len() / 2;
        let pose = &mut run.measured_poses[middle];
        pose.position_m = pose.position_m.map(|[x_m, y_m]| [x_m + 0.05, y_m - 0.03]);
        pose.heading_rad = pose.heading_rad.map(|heading_rad| heading_rad + 0.1);
        assert_eq!(explain(&campaign).unwrap().unexplained.sudden, []);
    }
}
