//! The constants of a drivetrain as one vector, which a search moves through.

use nalgebra::DVector;

use super::model::{Couple, Drivetrain, WheelMotor};
use crate::kinematics::WheelPair;

/// How many constants there are.
pub(super) const LEN: usize = 11;
/// Which of them is the delay.
pub(super) const DELAY: usize = 9;

/// All of a model.
pub(super) fn to_vector(model: &Drivetrain) -> DVector<f64> {
    let WheelPair { left, right } = model.wheels;
    let of = |motor: WheelMotor| {
        [motor.ks_forward_v, motor.ks_backward_v, motor.kv_v_s_per_m, motor.ka_v_s2_per_m]
    };
    let both = of(left).into_iter().chain(of(right));
    DVector::from_iterator(
        LEN,
        both.chain([model.kc_v_s2_per_m, model.delay_s, model.kw_v_s2_per_m2]),
    )
}

/// The model with these constants.
pub(super) fn from_vector(at: &DVector<f64>) -> Drivetrain {
    let Couple { wheels, kc, kw } = couple(|constant| at[constant]);
    Drivetrain { wheels, kc_v_s2_per_m: kc, delay_s: at[DELAY], kw_v_s2_per_m2: kw }
}

/// The constants but the delay, each by its number.
pub(super) fn couple<T>(at: impl Fn(usize) -> T) -> Couple<T> {
    let wheel = |first: usize| WheelMotor {
        ks_forward_v: at(first),
        ks_backward_v: at(first + 1),
        kv_v_s_per_m: at(first + 2),
        ka_v_s2_per_m: at(first + 3),
    };
    Couple { wheels: WheelPair::new(wheel(0), wheel(4)), kc: at(8), kw: at(10) }
}
