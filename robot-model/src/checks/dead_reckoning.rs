//! Where do the wheels alone lead a nominal robot? The dead reckoning that single rows are compared with.

use crate::kinematics::pose::{Pose, dead_reckon_with};
use crate::kinematics::wheel_pair::WheelPair;
use crate::recording::run::{Recording, Robot};

/// The poses of the nominal robot by its wheels alone, from the origin, at each sample of the wheels.
pub(super) fn reckon(robot: &Robot, run: &Recording) -> Vec<Pose> {
    let radii_m = WheelPair::both(robot.wheel_radius_m);
    let turns = run.wheels.iter().map(|sample| sample.phi_rad);
    dead_reckon_with(Pose::ORIGIN, radii_m, robot.track_width_m, turns)
}

/// The pose by the wheels at a time: that of the last sample up to then.
pub(super) fn at(run: &Recording, reckoned: &[Pose], t_s: f64) -> Pose {
    let after = run.wheels.partition_point(|sample| sample.t_s <= t_s);
    reckoned[after.saturating_sub(1)]
}

/// A run with its dead reckoning.
pub(super) struct Reckoned<'a> {
    pub(super) run: &'a Recording,
    /// By the wheels alone, from the origin.
    pub(super) poses: Vec<Pose>,
    /// Path \[m\] and turn \[rad\] up to each sample, both without a sign.
    rolled: Vec<(f64, f64)>,
}

impl<'a> Reckoned<'a> {
    pub(super) fn of(robot: &Robot, run: &'a Recording) -> Self {
        let mut rolled = vec![(0.0, 0.0)];
        for pair in run.wheels.windows(2) {
            let step =
                pair[1].phi_rad.zip(pair[0].phi_rad).map(|(a, b)| (a - b) * robot.wheel_radius_m);
            let (path_m, turn_rad) = rolled[rolled.len() - 1];
            let turn = (step.difference() / robot.track_width_m).abs();
            rolled.push((path_m + step.mean().abs(), turn_rad + turn));
        }
        Self { run, poses: reckon(robot, run), rolled }
    }

    /// Path \[m\] and turn \[rad\] between two times, both without a sign.
    pub(super) fn rolled(&self, from_s: f64, to_s: f64) -> (f64, f64) {
        let by = |t_s: f64| {
            let after = self.run.wheels.partition_point(|sample| sample.t_s <= t_s);
            self.rolled[after.saturating_sub(1)]
        };
        let ((a_m, a_rad), (b_m, b_rad)) = (by(from_s), by(to_s));
        (b_m - a_m, b_rad - a_rad)
    }
}
