//! The winding warms, and the same voltage gives less torque.
//!
//! ```text
//! V -> kS (1 + h T) sgn v + kV v + kA (1 + h T) a        T: time since the campaign began
//! ```
//!
//! h \[1/s\] > 0: more resistance later. Back-EMF does not change. Wear and a gear that runs in or dries look the same.

use super::definition::{Acting, Moment, MotorEffect, MotorFacts, MotorParameter};

/// Resistance grows with time.
#[derive(Debug)]
pub struct Heating;

impl MotorEffect for Heating {
    fn facts(&self) -> &'static MotorFacts {
        &FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        let share = 1.0 + p[0] * moment.t_s;
        acting.scale_friction(share.max(0.1));
        acting.motor.ka_v_s2_per_m *= share.max(0.1);
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "heating",
    name: "the motors change with time, as warming windings do",
    equation: "kS (1 + h T) sgn v + kV v + kA (1 + h T) a",
    parameters: &[MotorParameter::amplitude("h", "1/s", 1e-3, 2e-2)],
    sign: "more resistance later",
    shown_by: "the first experiment once more at the end",
    remedy: "tune the warm robot",
};
