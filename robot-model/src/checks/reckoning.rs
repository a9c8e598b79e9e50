//! Where the wheels alone lead a nominal robot.

use crate::kinematics::pose::Pose;
use crate::kinematics::wheel_pair::WheelPair;
use crate::recording::run::{Recording, Robot};

/// Wheels that took the robot less far than this say nothing of the unit \[m\].
pub(super) const FAR_M: f64 = 0.2;
/// Wheels that turned the robot less than this say nothing of it \[rad\]: a heading that jumps from pi
/// to -pi is 22 times that.
pub(super) const TURNED_RAD: f64 = 0.3;

/// Where the wheels alone take the nominal robot, from anywhere, at each sample of the wheels.
pub(super) fn reckon(robot: &Robot, run: &Recording) -> Vec<Pose> {
    reckon_with(robot, run, 1.0)
}

/// The same with a right radius that is so many times the left one.
pub(super) fn reckon_with(robot: &Robot, run: &Recording, right: f64) -> Vec<Pose> {
    let mut pose = Pose::ORIGIN;
    let radius_m = WheelPair::new(robot.wheel_radius_m, robot.wheel_radius_m * right);
    let steps = run.wheels.windows(2).map(|pair| {
        let turned_rad = pair[1].phi_rad.zip(pair[0].phi_rad).map(|(a, b)| a - b);
        let travel_m = turned_rad.zip(radius_m).map(|(turned, radius)| turned * radius);
        (travel_m.mean(), travel_m.difference() / robot.track_width_m)
    });
    let mut poses = vec![pose];
    for (travel_m, turn_rad) in steps {
        let (sin, cos) = (pose.heading_rad + turn_rad / 2.0).sin_cos();
        pose = Pose::new(
            pose.x_m + travel_m * cos,
            pose.y_m + travel_m * sin,
            pose.heading_rad + turn_rad,
        );
        poses.push(pose);
    }
    poses
}

/// The pose that the wheels say at a time: that of the last sample by then.
pub(super) fn at(run: &Recording, reckoned: &[Pose], t_s: f64) -> Pose {
    let after = run.wheels.partition_point(|it| it.t_s <= t_s);
    reckoned[after.saturating_sub(1)]
}

/// A run, and where its wheels led.
pub(super) struct Reckoned<'a> {
    pub(super) run: &'a Recording,
    /// By the wheels alone, from anywhere.
    pub(super) poses: Vec<Pose>,
    /// How far the middle of the robot went and how much it turned by each sample, ahead or back.
    rolled: Vec<(f64, f64)>,
}

impl<'a> Reckoned<'a> {
    pub(super) fn of(robot: &Robot, run: &'a Recording) -> Self {
        let mut rolled = vec![(0.0, 0.0)];
        for pair in run.wheels.windows(2) {
            let step =
                pair[1].phi_rad.zip(pair[0].phi_rad).map(|(a, b)| (a - b) * robot.wheel_radius_m);
            let (way_m, turn_rad) = rolled[rolled.len() - 1];
            let turn = (step.difference() / robot.track_width_m).abs();
            rolled.push((way_m + step.mean().abs(), turn_rad + turn));
        }
        Self { run, poses: reckon(robot, run), rolled }
    }

    pub(super) fn rolled(&self, from_s: f64, to_s: f64) -> (f64, f64) {
        let by = |t_s: f64| {
            let after = self.run.wheels.partition_point(|it| it.t_s <= t_s);
            self.rolled[after.saturating_sub(1)]
        };
        let ((a_m, a_rad), (b_m, b_rad)) = (by(from_s), by(to_s));
        (b_m - a_m, b_rad - a_rad)
    }
}

/// Of one of both sides.
pub(super) fn of_side(sides: WheelPair<f64>, right: bool) -> f64 {
    if right { sides.right } else { sides.left }
}

/// The middle value; the greater of both middle ones of an even number.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
