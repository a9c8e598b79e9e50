//! A run, thinned: what its wheels did in a few hundred steps, and some forty of its poses; how a hypothesis changes
//! it.

use core::f64::consts::PI;

use crate::kinematics::pose::{Pose, dead_reckon_with};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::angle::wrap;
use crate::recording::run::{PoseMeasurement, Robot, WheelSample};

use super::data_fault::{Axes, DataFault, Wheel};
use super::relative_geometry::RelativeGeometry;

/// As many poses of a run are looked at.
const POSES: usize = 40;
/// A step ends where the nominal robot has turned by this \[rad\], and there are at least so many in a run.
const TURN_RAD: f64 = 0.12;
const STEPS: usize = 120;
/// Radius over track width, as real robots have it; a data sheet may be wrong by any factor.
const RADIUS_OVER_TRACK_MIN: f64 = 0.05;
const RADIUS_OVER_TRACK_MAX: f64 = 0.5;
/// Poses tell a direction if they are so far apart \[m\] and the robot turned by less between them \[rad\].
const APART_M: f64 = 0.03;
const APART_TURN_RAD: f64 = 1.0;

/// A run with only so many poses and steps as its geometry and its clock need.
#[derive(Clone, Debug)]
pub(super) struct ThinnedRun {
    /// The wheels, since the first sample.
    pub(super) wheels: Vec<WheelSample>,
    pub(super) poses: Vec<PoseMeasurement>,
}

impl ThinnedRun {
    pub(super) fn of(robot: &Robot, wheels: &[WheelSample], poses: &[PoseMeasurement]) -> Self {
        Self { wheels: steps(robot, wheels), poses: every_few(poses, POSES) }
    }

    /// The same run with these poses.
    pub(super) fn with(&self, poses: &[PoseMeasurement]) -> Self {
        Self { wheels: self.wheels.clone(), poses: poses.to_vec() }
    }

    /// With this mended; what concerns the data sheet is no matter of a track.
    pub(super) fn mended(&self, what: &DataFault) -> Self {
        let wheels = |change: &dyn Fn(WheelPair<f64>) -> WheelPair<f64>| {
            let each =
                |sample: &WheelSample| WheelSample { phi_rad: change(sample.phi_rad), ..*sample };
            Self { wheels: self.wheels.iter().map(each).collect(), poses: self.poses.clone() }
        };
        let poses = |first: usize, change: &dyn Fn(&PoseMeasurement) -> PoseMeasurement| Self {
            wheels: self.wheels.clone(),
            poses: (self.poses.iter().enumerate())
                .map(|(k, pose)| if k < first { *pose } else { change(pose) })
                .collect(),
        };
        match *what {
            DataFault::WheelsExchanged => wheels(&|phi| WheelPair::new(phi.right, phi.left)),
            DataFault::CountsReversed { wheel } => wheels(&|phi| one_side(phi, wheel, -1.0)),
            DataFault::Counts { wheel, times } => wheels(&|phi| one_side(phi, wheel, times)),
            DataFault::Positions { per_m } => poses(0, &|pose| PoseMeasurement {
                position_m: pose.position_m.map(|position| position.map(|value| value / per_m)),
                ..*pose
            }),
            DataFault::Axes { axes, after_first } => {
                poses(usize::from(after_first), &|pose| axes.ours(pose))
            }
            _ => self.clone(),
        }
    }

    /// The run in so many parts, in each of which its wheels turned as far.
    pub(super) fn parts(&self, count: usize) -> Vec<Self> {
        let mut parts = Vec::new();
        let (mut from, mut rolled_rad) = (0, 0.0);
        let each_rad = self.rolled_rad() / count as f64;
        for k in 1..self.wheels.len() {
            let step = self.wheels[k].phi_rad.since(self.wheels[k - 1].phi_rad);
            rolled_rad += step.map(f64::abs).mean();
            let last = k + 1 == self.wheels.len();
            if last || rolled_rad >= each_rad * (parts.len() + 1) as f64 {
                let times_s = self.wheels[from].t_s..=self.wheels[k].t_s;
                let poses = self.poses.iter().filter(|pose| times_s.contains(&pose.t_s)).copied();
                parts.push(Self { wheels: self.wheels[from..=k].to_vec(), poses: poses.collect() });
                from = k;
            }
        }
        parts
    }

    /// Where the wheels lead from the origin, at each sample of theirs.
    pub(super) fn reckon(&self, robot: &Robot, geometry: &RelativeGeometry) -> Vec<Pose> {
        let turns = self.wheels.iter().map(|sample| sample.phi_rad);
        dead_reckon_with(Pose::ORIGIN, geometry.radius_m(robot), geometry.width_m(robot), turns)
    }

    /// The pose by the wheels at a time, between two samples in proportion.
    pub(super) fn at(&self, reckoned: &[Pose], t_s: f64) -> Pose {
        let after = self.wheels.partition_point(|sample| sample.t_s <= t_s);
        if after == 0 || after == self.wheels.len() {
            return reckoned[after.min(self.wheels.len() - 1)];
        }
        let (from, to) = (&self.wheels[after - 1], &self.wheels[after]);
        let share = (t_s - from.t_s) / (to.t_s - from.t_s);
        let between = |a: f64, b: f64| a + share * (b - a);
        let (a, b) = (reckoned[after - 1], reckoned[after]);
        Pose::new(
            between(a.x_m, b.x_m),
            between(a.y_m, b.y_m),
            between(a.heading_rad, b.heading_rad),
        )
    }

    /// How large the measured track is: the greatest distance from its middle \[m\].
    pub(super) fn extent_m(&self) -> f64 {
        let positions = || self.poses.iter().filter_map(|pose| pose.position_m);
        let count = positions().count().max(1) as f64;
        let sum = positions().fold([0.0; 2], |[x, y], [dx, dy]| [x + dx, y + dy]);
        let middle = sum.map(|value| value / count);
        positions().map(|[x, y]| (x - middle[0]).hypot(y - middle[1])).fold(0.0, f64::max)
    }

    /// How far the wheels turned the robot, without a sign, if it is built as most are \[rad\].
    pub(super) fn turned_rad(&self, robot: &Robot) -> f64 {
        let radius_over_track = radius_over_track(robot);
        let turn = |pair: &[WheelSample]| {
            radius_over_track * pair[1].phi_rad.since(pair[0].phi_rad).difference().abs()
        };
        self.wheels.windows(2).map(turn).sum()
    }

    /// How far the wheels turned, without a sign: the mean of both \[rad\].
    pub(super) fn rolled_rad(&self) -> f64 {
        let step =
            |pair: &[WheelSample]| pair[1].phi_rad.since(pair[0].phi_rad).map(f64::abs).mean();
        self.wheels.windows(2).map(step).sum()
    }

    /// Which share of the way between poses that are apart goes across the measured headings, as a square: 0 where the robot
    /// goes where it points, or back from there. `None` if no two poses with headings are apart.
    pub(super) fn across(&self) -> Option<f64> {
        let (mut across_m2, mut all_m2) = (0.0, 0.0);
        for pair in self.poses.windows(2) {
            let (Some([x0, y0]), Some([x1, y1])) = (pair[0].position_m, pair[1].position_m) else {
                continue;
            };
            let (Some(from), Some(to)) = (pair[0].heading_rad, pair[1].heading_rad) else {
                continue;
            };
            let ([dx, dy], turn) = ([x1 - x0, y1 - y0], wrap(to - from));
            if dx.hypot(dy) < APART_M || turn.abs() > APART_TURN_RAD {
                continue;
            }
            let (sin, cos) = (from + turn / 2.0).sin_cos();
            across_m2 += (dy * cos - dx * sin).powi(2);
            all_m2 += dx * dx + dy * dy;
        }
        (all_m2 > 0.0).then(|| across_m2 / all_m2)
    }

    pub(super) fn has_headings(&self) -> bool {
        self.poses.iter().any(|pose| pose.heading_rad.is_some())
    }
}

impl Axes {
    /// A pose in our axes.
    pub(super) fn ours(self, pose: &PoseMeasurement) -> PoseMeasurement {
        let position = |change: fn([f64; 2]) -> [f64; 2]| PoseMeasurement {
            position_m: pose.position_m.map(change),
            ..*pose
        };
        match self {
            Self::XMirrored => position(|[x, y]| [-x, y]),
            Self::YMirrored => position(|[x, y]| [x, -y]),
            Self::Exchanged => position(|[x, y]| [y, x]),
            Self::Heading { degrees, negated, turned_rad } => {
                let unit = if degrees { PI / 180.0 } else { 1.0 };
                let unit = if negated { -unit } else { unit };
                let heading_rad = pose.heading_rad.map(|heading| unit * heading - turned_rad);
                PoseMeasurement { heading_rad, ..*pose }
            }
            Self::Frame { turned_rad } => {
                let (sin, cos) = turned_rad.sin_cos();
                PoseMeasurement {
                    position_m: pose
                        .position_m
                        .map(|[x, y]| [cos * x + sin * y, cos * y - sin * x]),
                    heading_rad: pose.heading_rad.map(|heading| heading - turned_rad),
                    ..*pose
                }
            }
        }
    }
}

fn one_side(phi: WheelPair<f64>, wheel: Wheel, times: f64) -> WheelPair<f64> {
    let of = |side: Wheel| if wheel == side || wheel == Wheel::Both { times } else { 1.0 };
    WheelPair::new(of(Wheel::Left) * phi.left, of(Wheel::Right) * phi.right)
}

fn radius_over_track(robot: &Robot) -> f64 {
    (robot.wheel_radius_m / robot.track_width_m).clamp(RADIUS_OVER_TRACK_MIN, RADIUS_OVER_TRACK_MAX)
}

/// The samples at which a step ends, since the first.
fn steps(robot: &Robot, wheels: &[WheelSample]) -> Vec<WheelSample> {
    let radius_over_track = radius_over_track(robot);
    let first = wheels[0];
    let often = (wheels.len() / STEPS).max(1);
    let mut kept: Vec<WheelSample> = Vec::new();
    let mut since = 0;
    let last = wheels.len() - 1;
    for (k, sample) in wheels.iter().enumerate() {
        let phi_rad = sample.phi_rad.since(first.phi_rad);
        // As soon as the next one would be too far.
        let far = kept.last().is_some_and(|before| {
            let next = wheels[(k + 1).min(last)].phi_rad.since(first.phi_rad);
            radius_over_track * next.since(before.phi_rad).difference().abs() > TURN_RAD
        });
        if k == 0 || k == last || k >= since + often || far {
            kept.push(WheelSample { t_s: sample.t_s, phi_rad });
            since = k;
        }
    }
    kept
}

/// Some of many, evenly, the first and the last among them.
pub(super) fn every_few<T: Copy>(all: &[T], wanted: usize) -> Vec<T> {
    if all.len() <= wanted {
        return all.to_vec();
    }
    (0..wanted).map(|k| all[k * (all.len() - 1) / (wanted - 1)]).collect()
}
