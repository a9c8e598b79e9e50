//! Ends of runs beside what the wheels say once their geometry fits most runs: the ones that stand alone.
//!
//! Misread by ten degrees, a pose is nothing that no robot could do, and a fit takes it for noise or for an effect.
//! Beside twenty runs that agree to one degree it can be told all the same.

use nalgebra::{Matrix3, Vector3};

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::recording::run::{Recording, Robot};

use super::end_pose::{End, OffEndPose, far_off};
use super::reckoning::{Reckoned, at, reckon_with};

/// From so many runs on one of them may stand alone, and from so many on two.
const RUNS_MIN: [usize; 2] = [5, 9];
/// Alone is what is so many times as far off as the farthest of the others.
const ALONE: f64 = 5.0;
/// No less is called misread: of the way and what is added to it \[m\], and of the heading \[rad\].
const POSITION_MIN: f64 = 0.025;
const HEADING_MIN_RAD: f64 = 0.06;
/// How far off a position is goes with the way, and this \[m\].
const NEAR_M: f64 = 0.3;
/// Of the right radius, both radii and the track width: a step of the difference, and what is usual.
const STEP: f64 = 0.01;
const USUAL: f64 = 0.1;
/// Sums of absolute values, by weights: so many rounds, and no number weighs as one nearer than this.
const ROUNDS: usize = 30;
const NEAREST: f64 = 1e-3;

/// One number of a run that is off, and how it goes with right radius, both radii and track width.
struct Row {
    off: f64,
    slope: Vector3<f64>,
}

/// What a run leaves once the geometry fits most of them.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rest {
    t_s: f64,
    way_m: f64,
    /// As a share of the way.
    position: Option<f64>,
    heading_rad: Option<f64>,
}

/// Where a run ended, and where wheels of three other geometries led.
struct Ends<'a> {
    end: End<'a>,
    others: [Pose; 3],
}

impl<'a> Ends<'a> {
    fn of(robot: &Robot, run: &'a Recording) -> Option<Self> {
        let end = End::of(&Reckoned::of(robot, run), run)?;
        let others = [Changed::Right, Changed::Both, Changed::Track].map(|changed| {
            let times = |which: Changed| if which == changed { 1.0 + STEP } else { 1.0 };
            let robot = Robot {
                wheel_radius_m: robot.wheel_radius_m * times(Changed::Both),
                track_width_m: robot.track_width_m * times(Changed::Track),
                ..*robot
            };
            let poses = reckon_with(&robot, run, times(Changed::Right));
            at(run, &poses, end.last.t_s).seen_from(at(run, &poses, end.first.t_s))
        });
        Some(Self { end, others })
    }

    /// Along and across where it first looked, as a share of the way, and the heading.
    fn rows(&self) -> [Option<Row>; 3] {
        let end = &self.end;
        let row = |off: f64, of: &dyn Fn(&Pose) -> f64| Row {
            off,
            slope: Vector3::from_fn(|k, _| (of(&self.others[k]) - of(&end.to)) / STEP),
        };
        let scale = 1.0 / (NEAR_M + end.way_m);
        let places = end.first.position_m.zip(end.last.position_m).zip(end.first.heading_rad);
        let seen = places.map(|(([x0_m, y0_m], [x_m, y_m]), heading_rad)| {
            Pose::new(x_m, y_m, heading_rad).seen_from(Pose::new(x0_m, y0_m, heading_rad))
        });
        [
            seen.map(|it| row(scale * (it.x_m - end.to.x_m), &|to| scale * to.x_m)),
            seen.map(|it| row(scale * (it.y_m - end.to.y_m), &|to| scale * to.y_m)),
            end.heading_off_rad().map(|off_rad| row(off_rad, &|to| to.heading_rad)),
        ]
    }
}

/// What of a geometry is another.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Changed {
    Right,
    Both,
    Track,
}

/// What each run leaves once the geometry fits most of them.
fn rests(robot: &Robot, runs: &[Recording]) -> Vec<Option<Rest>> {
    let ends: Vec<Option<Ends>> = runs.iter().map(|run| Ends::of(robot, run)).collect();
    let rows: Vec<[Option<Row>; 3]> =
        ends.iter().map(|it| it.as_ref().map_or([None, None, None], Ends::rows)).collect();
    let mut geometry = Vector3::zeros();
    for _ in 0..ROUNDS {
        let mut normal = Matrix3::identity() * (NEAREST / USUAL.powi(2));
        let mut right = Vector3::zeros();
        for row in rows.iter().flatten().flatten() {
            let weight = 1.0 / (row.off - row.slope.dot(&geometry)).abs().max(NEAREST);
            normal += row.slope * row.slope.transpose() * weight;
            right += row.slope * (row.off * weight);
        }
        let Some(solved) = normal.cholesky().map(|it| it.solve(&right)) else { break };
        geometry = solved;
    }
    let rest = |(ends, rows): (&Option<Ends>, &[Option<Row>; 3])| {
        let ends = ends.as_ref()?;
        let left = |k: usize| rows[k].as_ref().map(|it| it.off - it.slope.dot(&geometry));
        Some(Rest {
            t_s: ends.end.last.t_s,
            way_m: ends.end.way_m,
            position: left(0).zip(left(1)).map(|(x, y)| x.hypot(y)),
            heading_rad: left(2).map(wrap),
        })
    };
    ends.iter().zip(&rows).map(rest).collect()
}

/// How far each run is off once the geometry fits most of them: the share of its way and radians.
pub fn misfits(robot: &Robot, runs: &[Recording]) -> Vec<f64> {
    let of = |it: Option<Rest>| {
        it.map_or(0.0, |it| {
            it.position.map_or(0.0, |it| it.min(1.0)) + it.heading_rad.map_or(0.0, f64::abs)
        })
    };
    rests(robot, runs).into_iter().map(of).collect()
}

/// The last pose of each run, if it is far off; the campaign as a whole is no [`super::Mismatch`].
pub fn end_poses_off(robot: &Robot, runs: &[Recording]) -> Vec<Option<OffEndPose>> {
    let both = far_off(robot, runs).into_iter().zip(outliers(robot, runs));
    both.map(|(far, outlier)| far.or(outlier)).collect()
}

/// The last poses that are far off beside all others; one that carries a load may well differ from all others.
fn outliers(robot: &Robot, runs: &[Recording]) -> Vec<Option<OffEndPose>> {
    let rests = rests(robot, runs);
    let bound = |of: fn(&Rest) -> Option<f64>, least: f64| {
        let mut all: Vec<f64> = rests.iter().flatten().filter_map(of).map(f64::abs).collect();
        all.sort_by(|a, b| b.total_cmp(a));
        let alone = RUNS_MIN.iter().filter(|it| all.len() >= **it).count();
        let others = all.get(alone).filter(|_| alone > 0);
        others.map_or(f64::INFINITY, |it| (ALONE * it).max(least))
    };
    let position = bound(|it| it.position, POSITION_MIN);
    let heading_rad = bound(|it| it.heading_rad, HEADING_MIN_RAD);
    let off = |(run, rest): (&Recording, &Option<Rest>)| {
        let rest = rest.filter(|_| run.payload_kg == 0.0)?;
        let far = rest.position.filter(|it| *it > position);
        let off = OffEndPose {
            t_s: rest.t_s,
            position_m: far.map(|it| it * (NEAR_M + rest.way_m)),
            heading_rad: rest.heading_rad.filter(|it| it.abs() > heading_rad),
        };
        (off.position_m.is_some() || off.heading_rad.is_some()).then_some(off)
    };
    runs.iter().zip(&rests).map(off).collect()
}
