//! Which variables may an expression of the path use, and what are they in a step?

use crate::expression::{Names, Variable};
use crate::recording::motion::Step;

const SPEED: [f64; 4] = [1.0, -1.0, 0.0, 0.0];
const ACCELERATION: [f64; 4] = [1.0, -2.0, 0.0, 0.0];
const ANGLE: [f64; 4] = [0.0; 4];
const SECOND: [f64; 4] = [0.0, 1.0, 0.0, 0.0];

/// The value of a variable in a step.
type Value = fn(&Step) -> f64;

/// Each variable with its value in a step.
const TABLE: [(Variable, Value); 14] = [
    (Variable::new("v", SPEED), |step| step.speed_mps()),
    (Variable::new("omega", [0.0, -1.0, 0.0, 0.0]), |step| step.turn_rate_rad_s()),
    (Variable::new("v_left", SPEED), |step| step.wheel_speed_mps.left),
    (Variable::new("v_right", SPEED), |step| step.wheel_speed_mps.right),
    (Variable::new("a", ACCELERATION), |step| step.wheel_accel_mps2.mean()),
    (Variable::new("a_left", ACCELERATION), |step| step.wheel_accel_mps2.left),
    (Variable::new("a_right", ACCELERATION), |step| step.wheel_accel_mps2.right),
    (Variable::new("theta", ANGLE), |step| step.heading_rad),
    (Variable::new("phi_left", ANGLE), |step| middle(step.phi_rad.left, step.dphi_rad.left)),
    (Variable::new("phi_right", ANGLE), |step| middle(step.phi_rad.right, step.dphi_rad.right)),
    (Variable::new("s", [1.0, 0.0, 0.0, 0.0]), |step| step.path_m + step.travel_m().abs() / 2.0),
    (Variable::new("t", SECOND), |step| step.clock_s),
    (Variable::new("t_run", SECOND), |step| step.t_s),
    (Variable::new("payload", [0.0, 0.0, 1.0, 0.0]), |step| step.payload_kg),
];

/// The variables.
pub(super) static VARIABLES: [Variable; TABLE.len()] = Variable::of_table(&TABLE);

/// The names of an expression of the path.
pub(super) static NAMES: Names = Names { variables: &VARIABLES, reserved: &[] };

/// The value of the variable of this index.
pub(super) fn value(index: usize, step: &Step) -> f64 {
    TABLE[index].1(step)
}

fn middle(phi: f64, dphi: f64) -> f64 {
    phi + dphi / 2.0
}
