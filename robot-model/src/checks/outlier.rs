//! Which last poses are outliers among the runs of a campaign, once a geometry is fitted to most of them?
//!
//! A robot could reach a pose that was misread by ten degrees, and a fit takes it for noise or for an effect.
//! Among twenty runs that agree to one degree it stands out. Poses that are off without any comparison are in
//! `end_pose.rs`.

use nalgebra::{Matrix3, Vector3};

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::recording::run::{Recording, Robot};

use super::dead_reckoning::{Reckoned, at, reckon_with};
use super::end_pose::{End, OffEndPose, far_off};

/// From the first number of runs on there may be one outlier, from the second on two.
const RUNS_MIN: [usize; 2] = [5, 9];
/// An outlier is this many times as far off as the farthest of the others.
const TIMES_OTHERS: f64 = 5.0;
/// The least error of an outlier: of the position, as a share of the path and [`NEAR_M`], and of the heading.
const POSITION_MIN: f64 = 0.025;
const HEADING_MIN_RAD: f64 = 0.06;
/// The error of a position is taken in proportion to the path plus this \[m\].
const NEAR_M: f64 = 0.3;
/// Relative changes of the right radius, both radii and the track width: the step of the numerical derivative,
/// and the usual size.
const STEP: f64 = 0.01;
const USUAL: f64 = 0.1;
/// The sum of absolute values is minimised by weighted least squares: rounds, and the least residual that a
/// weight counts with.
const ROUNDS: usize = 30;
const NEAREST: f64 = 1e-3;

/// One error of a run, and its derivatives by right radius, both radii and track width.
struct Row {
    error: f64,
    slope: Vector3<f64>,
}

/// The residual of a run's last pose, once a geometry is fitted to most runs.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Residual {
    t_s: f64,
    path_m: f64,
    /// As a share of the path and [`NEAR_M`].
    position: Option<f64>,
    heading_rad: Option<f64>,
}

/// Where a run ended, and where the wheels lead with each of three changed geometries.
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

    /// The errors along and across the first heading, as a share of the path, and of the heading.
    fn rows(&self) -> [Option<Row>; 3] {
        let end = &self.end;
        let row = |error: f64, of: &dyn Fn(&Pose) -> f64| Row {
            error,
            slope: Vector3::from_fn(|k, _| (of(&self.others[k]) - of(&end.to)) / STEP),
        };
        let scale = 1.0 / (NEAR_M + end.path_m);
        let places = end.first.position_m.zip(end.last.position_m).zip(end.first.heading_rad);
        let measured = places.map(|(([x0_m, y0_m], [x_m, y_m]), heading_rad)| {
            Pose::new(x_m, y_m, heading_rad).seen_from(Pose::new(x0_m, y0_m, heading_rad))
        });
        [
            measured.map(|pose| row(scale * (pose.x_m - end.to.x_m), &|to| scale * to.x_m)),
            measured.map(|pose| row(scale * (pose.y_m - end.to.y_m), &|to| scale * to.y_m)),
            end.heading_off_rad().map(|error_rad| row(error_rad, &|to| to.heading_rad)),
        ]
    }
}

/// What is changed in a geometry.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Changed {
    Right,
    Both,
    Track,
}

/// The residual of each run, once a geometry is fitted to most of them.
fn residuals(robot: &Robot, runs: &[Recording]) -> Vec<Option<Residual>> {
    let ends: Vec<Option<Ends>> = runs.iter().map(|run| Ends::of(robot, run)).collect();
    let rows: Vec<[Option<Row>; 3]> =
        ends.iter().map(|ends| ends.as_ref().map_or([None, None, None], Ends::rows)).collect();
    let mut geometry = Vector3::zeros();
    for _ in 0..ROUNDS {
        let mut normal = Matrix3::identity() * (NEAREST / USUAL.powi(2));
        let mut right = Vector3::zeros();
        for row in rows.iter().flatten().flatten() {
            let weight = 1.0 / (row.error - row.slope.dot(&geometry)).abs().max(NEAREST);
            normal += row.slope * row.slope.transpose() * weight;
            right += row.slope * (row.error * weight);
        }
        let Some(solved) = normal.cholesky().map(|factor| factor.solve(&right)) else { break };
        geometry = solved;
    }
    let residual = |(ends, rows): (&Option<Ends>, &[Option<Row>; 3])| {
        let ends = ends.as_ref()?;
        let left = |k: usize| rows[k].as_ref().map(|row| row.error - row.slope.dot(&geometry));
        Some(Residual {
            t_s: ends.end.last.t_s,
            path_m: ends.end.path_m,
            position: left(0).zip(left(1)).map(|(x, y)| x.hypot(y)),
            heading_rad: left(2).map(wrap),
        })
    };
    ends.iter().zip(&rows).map(residual).collect()
}

/// How far each run is off, once a geometry is fitted to most of them: the share of its path plus radians.
pub fn end_pose_misfits(robot: &Robot, runs: &[Recording]) -> Vec<f64> {
    let misfit = |residual: Residual| {
        let position = residual.position.map_or(0.0, |share| share.min(1.0));
        position + residual.heading_rad.map_or(0.0, f64::abs)
    };
    let all = residuals(robot, runs).into_iter();
    all.map(|residual| residual.map_or(0.0, misfit)).collect()
}

/// The last pose of each run, if it is far off. The campaign as a whole must not be a [`super::Mismatch`].
pub fn end_poses_off(robot: &Robot, runs: &[Recording]) -> Vec<Option<OffEndPose>> {
    let both = far_off(robot, runs).into_iter().zip(outliers(robot, runs));
    both.map(|(far, outlier)| far.or(outlier)).collect()
}

/// The last poses that are far off among all others. A run with a load may well differ from all others, and is
/// left out.
fn outliers(robot: &Robot, runs: &[Recording]) -> Vec<Option<OffEndPose>> {
    let residuals = residuals(robot, runs);
    let bound = |of: fn(&Residual) -> Option<f64>, least: f64| {
        let mut all: Vec<f64> = residuals.iter().flatten().filter_map(of).map(f64::abs).collect();
        all.sort_by(|a, b| b.total_cmp(a));
        let outliers = RUNS_MIN.iter().filter(|runs| all.len() >= **runs).count();
        let others = all.get(outliers).filter(|_| outliers > 0);
        others.map_or(f64::INFINITY, |farthest| (TIMES_OTHERS * farthest).max(least))
    };
    let position = bound(|residual| residual.position, POSITION_MIN);
    let heading_rad = bound(|residual| residual.heading_rad, HEADING_MIN_RAD);
    let off = |(run, residual): (&Recording, &Option<Residual>)| {
        let residual = residual.filter(|_| run.payload_kg == 0.0)?;
        let far = residual.position.filter(|share| *share > position);
        let off = OffEndPose {
            t_s: residual.t_s,
            position_m: far.map(|share| share * (NEAR_M + residual.path_m)),
            heading_rad: residual.heading_rad.filter(|error_rad| error_rad.abs() > heading_rad),
        };
        (off.position_m.is_some() || off.heading_rad.is_some()).then_some(off)
    };
    runs.iter().zip(&residuals).map(off).collect()
}
