//! The normalised innovations of a run: what each measured pose shows that the poses before it did not tell, over its
//! standard deviation. Where a model lacks nothing they are independent, each N(0, 1).

use crate::effect::composition::{Increment, Terms};
use crate::estimation::ekf::{FilterObserver, Innovation, numbers, whiten};
use crate::estimation::fit::Fitted;
use crate::estimation::state::Quantity;
use crate::kinematics::pose::Pose;
use crate::numeric::parallel;
use crate::recording::campaign::Prepared;
use crate::recording::motion::Step;
use crate::recording::run::PoseMeasurement;

/// One innovation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Normalised {
    /// How far the wheels had rolled \[m\].
    pub rolled_m: f64,
    /// The innovation over its standard deviation.
    pub z: f64,
}

/// The innovations of a run.
#[derive(Default)]
pub(super) struct Innovations {
    /// Of one pose, whose numbers come before it.
    pending: Vec<f64>,
    rolled_m: f64,
    /// Of the heading.
    pub heading: Vec<Normalised>,
    /// Of the position along the way: above zero where the robot was further than predicted.
    pub along: Vec<Normalised>,
    /// Of the position to the left of the robot.
    pub left: Vec<Normalised>,
}

impl FilterObserver for Innovations {
    fn row(&mut self, innovation: Innovation, _: &[f64]) {
        self.pending.push(innovation.value / innovation.variance.sqrt());
    }

    fn motion(&mut self, step: &Step, _: &Increment, share: f64) {
        self.rolled_m += share * step.rolled_m();
    }

    fn pose(&mut self, measurement: &PoseMeasurement, step: &Step, pose: Pose) {
        let (sin, cos) = pose.heading_rad.sin_cos();
        let (mut ahead, mut left, mut positions) = (0.0, 0.0, 0);
        let rolled_m = self.rolled_m;
        for ((quantity, ..), z) in numbers(measurement).zip(self.pending.drain(..)) {
            let (x, y) = match quantity {
                Quantity::X => (z, 0.0),
                Quantity::Y => (0.0, z),
                Quantity::Heading => {
                    self.heading.push(Normalised { rolled_m, z });
                    continue;
                }
            };
            (ahead, left) = (ahead + cos * x + sin * y, left + cos * y - sin * x);
            positions += 1;
        }
        if positions == 2 {
            self.along.push(Normalised { rolled_m, z: ahead * step.travel_m().signum() });
            self.left.push(Normalised { rolled_m, z: left });
        }
    }
}

/// The innovations of each run, by a fitted model.
pub(super) fn innovations(prepared: &Prepared, fitted: &Fitted<'_>) -> Vec<Innovations> {
    let fixed = Terms::Fixed(&fitted.terms);
    parallel::map(&prepared.runs, |run| {
        let mut found = Innovations::default();
        whiten(&run.motion, &run.recording.measured_poses, fixed, &fitted.noise, &mut found);
        found
    })
}
