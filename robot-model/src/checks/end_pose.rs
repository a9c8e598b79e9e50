//! Poses that lie far from where the wheels led: misread, of other axes, or of a robot that was moved.

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::recording::run::{PoseMeasurement, Recording, Robot};

use super::reckoning::{FAR_M, Reckoned, at, median};

/// The last pose of a run, far from where the wheels led from the first one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffEndPose {
    /// When it was measured \[s\].
    pub t_s: f64,
    /// How far off it is, if the position is \[m\].
    pub position_m: Option<f64>,
    /// How far off it is, if the heading is, counter-clockwise positive \[rad\].
    pub heading_rad: Option<f64>,
}

/// Fewer poses on the way are no picture of it.
const SEEN_MIN: usize = 5;
/// Turned by less in all, a run does not say by what share of it the wheels are off \[rad\].
const TURNED_SHARE_MIN_RAD: f64 = 1.0;
/// How far a last pose may be off before it is called off: by this, and by this share of the way and of the turn.
#[derive(Clone, Copy)]
struct Allowed {
    position_m: (f64, f64),
    heading_rad: (f64, f64),
}

const ALLOWED: Allowed = Allowed { position_m: (0.15, 0.15), heading_rad: (0.5, 0.15) };
/// Where at least so many other runs say by what share of a turn the wheels are off, as with a track width that is
/// merely wrong.
const BESIDE_OTHERS: Allowed = Allowed { heading_rad: (0.5, 0.06), ..ALLOWED };
const OTHERS_MIN: usize = 3;
/// Who asks a person at once, and has no other runs, may ask once too often.
const ASKED: Allowed = Allowed { position_m: (0.1, 0.05), heading_rad: (0.3, 0.08) };

/// The last pose of each run, if it is farther off than the geometry of all runs explains.
pub(super) fn far_off(robot: &Robot, runs: &[Recording]) -> Vec<Option<OffEndPose>> {
    let ends: Vec<Option<End>> =
        runs.iter().map(|run| End::of(&Reckoned::of(robot, run), run)).collect();
    let shares: Vec<Option<f64>> =
        ends.iter().map(|it| it.as_ref().and_then(End::share_of_turn)).collect();
    let off = |(index, end): (usize, &Option<End>)| {
        let others: Vec<f64> =
            shares.iter().enumerate().filter(|it| it.0 != index).filter_map(|it| *it.1).collect();
        let beside = (others.len() >= OTHERS_MIN).then(|| median(others)).flatten();
        let allowed = if beside.is_some() { BESIDE_OTHERS } else { ALLOWED };
        end.as_ref()?.off(beside.unwrap_or(0.0), allowed)
    };
    ends.iter().enumerate().map(off).collect()
}

/// Whether what was just read of where a robot stands, `last`, is far from where its wheels led from `first`,
/// as poses of theirs from anywhere: what may be asked again.
pub fn doubtful(
    first: &PoseMeasurement,
    last: &PoseMeasurement,
    wheels: &[Pose],
) -> Option<OffEndPose> {
    let (from, to) = (wheels.first()?, wheels.last()?);
    let steps = || wheels.windows(2).map(|it| it[1].seen_from(it[0]));
    let end = End {
        first,
        last,
        to: to.seen_from(*from),
        way_m: steps().map(|it| it.x_m.hypot(it.y_m)).sum(),
        turn_rad: steps().map(|it| it.heading_rad.abs()).sum(),
    };
    end.off(0.0, ASKED)
}

/// How far the poses of a run lie from where its wheels led \[m\], if most of them lie far from there: their middle.
pub fn beside(robot: &Robot, run: &Recording) -> Option<f64> {
    let led = Reckoned::of(robot, run);
    let first = run.measured_poses.iter().find(|it| it.position_m.is_some())?;
    let until = |last: &'_ PoseMeasurement| {
        let end = End::between(&led, first, last);
        let way_m = end.way_m;
        Some((end.position_off_m()?, way_m)).filter(|it| it.1 > FAR_M)
    };
    let off: Vec<(f64, f64)> = run.measured_poses.iter().filter_map(until).collect();
    let (least_m, share) = ALLOWED.position_m;
    let far = |it: &&(f64, f64)| it.0 > least_m + share * it.1;
    let most = 2 * off.iter().filter(far).count() > off.len();
    median(off.iter().map(|it| it.0).collect()).filter(|_| most && off.len() >= SEEN_MIN)
}

/// Where a run ended: as it was seen, and by its wheels.
pub(super) struct End<'a> {
    pub(super) first: &'a PoseMeasurement,
    pub(super) last: &'a PoseMeasurement,
    /// By the wheels, seen from where it was first seen; its heading counts whole turns.
    pub(super) to: Pose,
    /// How far they took it and turned it, ahead or back \[m, rad\].
    pub(super) way_m: f64,
    turn_rad: f64,
}

impl<'a> End<'a> {
    pub(super) fn of(led: &Reckoned, run: &'a Recording) -> Option<Self> {
        let first = run.measured_poses.iter().find(|it| it.position_m.is_some())?;
        let last = run.measured_poses.last().filter(|it| it.t_s > first.t_s)?;
        Some(Self::between(led, first, last))
    }

    fn between(led: &Reckoned, first: &'a PoseMeasurement, last: &'a PoseMeasurement) -> Self {
        let (way_m, turn_rad) = led.rolled(first.t_s, last.t_s);
        let by_wheels = |t_s: f64| at(led.run, &led.poses, t_s);
        let (from, to) = (by_wheels(first.t_s), by_wheels(last.t_s));
        Self { first, last, to: to.seen_from(from), way_m, turn_rad }
    }

    /// How far its heading is from where the wheels led \[rad\].
    pub(super) fn heading_off_rad(&self) -> Option<f64> {
        let both = self.first.heading_rad.zip(self.last.heading_rad);
        both.map(|(from, seen)| wrap(seen - from - self.to.heading_rad))
    }

    /// That, as a share of how much they turned it.
    fn share_of_turn(&self) -> Option<f64> {
        let turned = self.to.heading_rad.abs() > TURNED_SHARE_MIN_RAD;
        self.heading_off_rad().filter(|_| turned).map(|it| it / self.to.heading_rad)
    }

    /// How far its position is from where the wheels led \[m\].
    fn position_off_m(&self) -> Option<f64> {
        let both_m = self.first.position_m.zip(self.last.position_m);
        both_m.map(|([from_x_m, from_y_m], [x_m, y_m])| {
            match self.first.heading_rad {
                Some(heading_rad) => {
                    let there = Pose::new(from_x_m, from_y_m, heading_rad).compose(self.to);
                    (x_m - there.x_m).hypot(y_m - there.y_m)
                }
                // It looked anywhere: how far it got must do.
                None => {
                    let got_m = (x_m - from_x_m).hypot(y_m - from_y_m);
                    (got_m - self.to.x_m.hypot(self.to.y_m)).abs()
                }
            }
        })
    }

    /// If it is off: `share` of its turn is that of all runs, and `allowed` more of it is no wonder.
    fn off(&self, share: f64, allowed: Allowed) -> Option<OffEndPose> {
        let bound = |(least, share): (f64, f64), of: f64| least + share * of;
        let position_m = self.position_off_m();
        let heading_rad = self.heading_off_rad().map(|it| wrap(it - share * self.to.heading_rad));
        let off = OffEndPose {
            t_s: self.last.t_s,
            position_m: position_m.filter(|it| *it > bound(allowed.position_m, self.way_m)),
            heading_rad: heading_rad
                .filter(|it| it.abs() > bound(allowed.heading_rad, self.turn_rad)),
        };
        (off.position_m.is_some() || off.heading_rad.is_some()).then_some(off)
    }
}
