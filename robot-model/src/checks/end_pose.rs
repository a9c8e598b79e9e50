//! Which poses lie far from where the wheels led, as they were misread, have other axes, or the robot was moved?
//!
//! Poses that stand out only among those of other runs are in `outlier.rs`.

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::recording::run::{PoseMeasurement, Recording, Robot};

use super::dead_reckoning::{FAR_M, Reckoned, at, median};

/// The last pose of a run that lies far from where the wheels led from the first one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffEndPose {
    /// When it was measured \[s\].
    pub t_s: f64,
    /// The error of its position, if that is off \[m\].
    pub position_m: Option<f64>,
    /// The error of its heading, if that is off, counter-clockwise positive \[rad\].
    pub heading_rad: Option<f64>,
}

/// Fewer poses do not show where a run went.
const POSES_MIN: usize = 5;
/// A run with a smaller turn does not show by what share of it the wheels are off \[rad\].
const TURNED_SHARE_MIN_RAD: f64 = 1.0;
/// How far a last pose may lie from where the wheels led: this, plus this share of the path or of the turn.
#[derive(Clone, Copy)]
struct Allowed {
    position_m: (f64, f64),
    heading_rad: (f64, f64),
}

const ALLOWED: Allowed = Allowed { position_m: (0.15, 0.15), heading_rad: (0.5, 0.15) };
/// The same if at least [`OTHERS_MIN`] other runs show by what share of a turn the wheels are off, as they are
/// with an inaccurate track width.
const WITH_OTHERS: Allowed = Allowed { heading_rad: (0.5, 0.06), ..ALLOWED };
const OTHERS_MIN: usize = 3;
/// The same for a reading that a person can repeat at once: one question too many does no harm.
const FOR_A_QUESTION: Allowed = Allowed { position_m: (0.1, 0.05), heading_rad: (0.3, 0.08) };

/// The last pose of each run, if it is farther off than the geometry of all runs explains.
pub(super) fn far_off(robot: &Robot, runs: &[Recording]) -> Vec<Option<OffEndPose>> {
    let ends: Vec<Option<End>> =
        runs.iter().map(|run| End::of(&Reckoned::of(robot, run), run)).collect();
    let shares: Vec<Option<f64>> =
        ends.iter().map(|end| end.as_ref().and_then(End::share_of_turn)).collect();
    let off = |(index, end): (usize, &Option<End>)| {
        let others = shares.iter().enumerate().filter(|(other, _)| *other != index);
        let others: Vec<f64> = others.filter_map(|(_, share)| *share).collect();
        let of_others = (others.len() >= OTHERS_MIN).then(|| median(others)).flatten();
        let allowed = if of_others.is_some() { WITH_OTHERS } else { ALLOWED };
        end.as_ref()?.off(of_others.unwrap_or(0.0), allowed)
    };
    ends.iter().enumerate().map(off).collect()
}

/// Whether a pose that a person has just read, `last`, lies far from where the wheels led from `first`, and
/// should be read again. `wheels` are the poses by the wheels, in any frame.
pub fn implausible_end_pose(
    first: &PoseMeasurement,
    last: &PoseMeasurement,
    wheels: &[Pose],
) -> Option<OffEndPose> {
    let (from, to) = (wheels.first()?, wheels.last()?);
    let steps = || wheels.windows(2).map(|pair| pair[1].seen_from(pair[0]));
    let end = End {
        first,
        last,
        to: to.seen_from(*from),
        path_m: steps().map(|step| step.x_m.hypot(step.y_m)).sum(),
        turn_rad: steps().map(|step| step.heading_rad.abs()).sum(),
    };
    end.off(0.0, FOR_A_QUESTION)
}

/// The median distance of a run's poses from where the wheels led \[m\], if most of them lie far from there.
pub fn median_pose_error(robot: &Robot, run: &Recording) -> Option<f64> {
    let reckoned = Reckoned::of(robot, run);
    let first = run.measured_poses.iter().find(|pose| pose.position_m.is_some())?;
    let until = |last: &'_ PoseMeasurement| {
        let end = End::between(&reckoned, first, last);
        let path_m = end.path_m;
        Some((end.position_off_m()?, path_m)).filter(|(_, path_m)| *path_m > FAR_M)
    };
    let off: Vec<(f64, f64)> = run.measured_poses.iter().filter_map(until).collect();
    let (least_m, share) = ALLOWED.position_m;
    let far = |(off_m, path_m): &&(f64, f64)| *off_m > least_m + share * path_m;
    let most = 2 * off.iter().filter(far).count() > off.len();
    median(off.iter().map(|(off_m, _)| *off_m).collect()).filter(|_| most && off.len() >= POSES_MIN)
}

/// Where a run ended: as measured, and by its wheels.
pub(super) struct End<'a> {
    pub(super) first: &'a PoseMeasurement,
    pub(super) last: &'a PoseMeasurement,
    /// By the wheels, in the frame of the first pose; its heading counts whole turns.
    pub(super) to: Pose,
    /// Path by the wheels, without a sign \[m\].
    pub(super) path_m: f64,
    /// Turn by the wheels, without a sign \[rad\].
    turn_rad: f64,
}

impl<'a> End<'a> {
    pub(super) fn of(reckoned: &Reckoned, run: &'a Recording) -> Option<Self> {
        let first = run.measured_poses.iter().find(|pose| pose.position_m.is_some())?;
        let last = run.measured_poses.last().filter(|pose| pose.t_s > first.t_s)?;
        Some(Self::between(reckoned, first, last))
    }

    fn between(reckoned: &Reckoned, first: &'a PoseMeasurement, last: &'a PoseMeasurement) -> Self {
        let (path_m, turn_rad) = reckoned.rolled(first.t_s, last.t_s);
        let by_wheels = |t_s: f64| at(reckoned.run, &reckoned.poses, t_s);
        let (from, to) = (by_wheels(first.t_s), by_wheels(last.t_s));
        Self { first, last, to: to.seen_from(from), path_m, turn_rad }
    }

    /// How far its heading is from where the wheels led \[rad\].
    pub(super) fn heading_off_rad(&self) -> Option<f64> {
        let both = self.first.heading_rad.zip(self.last.heading_rad);
        both.map(|(first, last)| wrap(last - first - self.to.heading_rad))
    }

    /// The same as a share of the turn by the wheels.
    fn share_of_turn(&self) -> Option<f64> {
        let turned = self.to.heading_rad.abs() > TURNED_SHARE_MIN_RAD;
        self.heading_off_rad().filter(|_| turned).map(|off_rad| off_rad / self.to.heading_rad)
    }

    /// How far its position is from where the wheels led \[m\].
    fn position_off_m(&self) -> Option<f64> {
        let both_m = self.first.position_m.zip(self.last.position_m);
        both_m.map(|([from_x_m, from_y_m], [x_m, y_m])| {
            match self.first.heading_rad {
                Some(heading_rad) => {
                    let to = Pose::new(from_x_m, from_y_m, heading_rad).compose(self.to);
                    (x_m - to.x_m).hypot(y_m - to.y_m)
                }
                // Without a first heading, only the distance can be compared.
                None => {
                    let went_m = (x_m - from_x_m).hypot(y_m - from_y_m);
                    (went_m - self.to.x_m.hypot(self.to.y_m)).abs()
                }
            }
        })
    }

    /// The last pose, if it is off by more than allowed, where `share` is by what share of a turn the wheels of
    /// other runs are off.
    fn off(&self, share: f64, allowed: Allowed) -> Option<OffEndPose> {
        let bound = |(least, share): (f64, f64), of: f64| least + share * of;
        let position_m = self.position_off_m();
        let heading_rad = self.heading_off_rad();
        let heading_rad = heading_rad.map(|off_rad| wrap(off_rad - share * self.to.heading_rad));
        let off = OffEndPose {
            t_s: self.last.t_s,
            position_m: position_m.filter(|off_m| *off_m > bound(allowed.position_m, self.path_m)),
            heading_rad: heading_rad
                .filter(|off_rad| off_rad.abs() > bound(allowed.heading_rad, self.turn_rad)),
        };
        (off.position_m.is_some() || off.heading_rad.is_some()).then_some(off)
    }
}
