//! Which variables may an expression of motors use, and what are they in a moment?
//!
//! `load` is the voltage less the back-EMF that the model gives its motor then: what it works against.

use core::f64::consts::TAU;

use crate::drivetrain::effect::definition::Moment;
use crate::drivetrain::model::WheelMotor;
use crate::expression::{Names, Variable};

const SPEED: [f64; 4] = [1.0, -1.0, 0.0, 0.0];
const VOLT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
const ONE: [f64; 4] = [0.0; 4];

/// The value of a variable in a moment.
type Value = fn(&Moment, &WheelMotor) -> f64;

/// Each variable with its value in a moment.
const TABLE: [(Variable, Value); 9] = [
    (Variable::new("v", SPEED), |moment, _| moment.speed_mps.0),
    (Variable::new("v_other", SPEED), |moment, _| moment.speed_mps.1),
    (Variable::new("volts", VOLT), |moment, _| moment.volts.0),
    (Variable::new("volts_other", VOLT), |moment, _| moment.volts.1),
    (Variable::new("load", VOLT), |moment, motor| {
        moment.volts.0 - motor.kv_v_s_per_m * moment.speed_mps.0
    }),
    (Variable::new("phi", ONE), |moment, _| TAU * moment.turns),
    (Variable::new("theta", ONE), |moment, _| moment.heading_rad),
    (Variable::new("t", [0.0, 1.0, 0.0, 0.0]), |moment, _| moment.t_s),
    (Variable::new("side", ONE), |moment, _| moment.side),
];

/// The variables.
pub(super) static VARIABLES: [Variable; TABLE.len()] = Variable::of_table(&TABLE);

/// The names of an expression of motors. Those of the path's expressions, and the model's constants, are no parameters here.
pub(super) static NAMES: Names = Names {
    variables: &VARIABLES,
    reserved: &[
        "omega",
        "v_left",
        "v_right",
        "a_left",
        "a_right",
        "phi_left",
        "phi_right",
        "t_run",
        "payload",
        "kS",
        "kV",
        "kA",
        "kC",
        "kD",
        "kW",
    ],
};

/// The value of the variable of this index.
pub(super) fn value(index: usize, moment: &Moment, motor: &WheelMotor) -> f64 {
    TABLE[index].1(moment, motor)
}
