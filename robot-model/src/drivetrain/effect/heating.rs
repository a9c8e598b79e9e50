//! The winding warms, and the same voltage gives less torque.
//!
//! ```text
//! V -> kS (1 + r) sgn v + kV v + kA (1 + r) a
//! r = h tau (1 - exp(-T / tau)) + w exp(-P / tau)      T: time since the campaign began; P: since its longest pause, if any
//! ```
//!
//! h \[1/s\] > 0: more resistance later, at first by so much a second; w \[1\] > 0: so much more after the longest pause between
//! two experiments, as after driving that was not recorded; tau \[s\]: in which the motors settle. A tau much longer than the
//! campaign is a straight line. Back-EMF does not change. Wear and a gear that runs in or dries look the same.

use super::definition::{Acting, Excitation, Moment, MotorEffect, MotorFacts, MotorParameter};

/// Resistance changes with time.
#[derive(Debug)]
pub struct Heating;

impl MotorEffect for Heating {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        let tau_s = p[2];
        let risen = p[0] * tau_s * (1.0 - (-moment.t_s / tau_s).exp());
        let more = risen + p[1] * (-moment.since_pause_s / tau_s).exp();
        let share = (1.0 + more).max(0.1);
        acting.scale_friction(share);
        acting.motor.ka_v_s2_per_m *= share;
    }

    fn starts(&self, _excitation: &Excitation) -> Vec<Vec<f64>> {
        [12.0, 40.0, 300.0].map(|tau_s| vec![0.0, 0.0, tau_s]).into()
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "heating",
    name: "the motors change with time, as warming windings do",
    equation: "kS (1 + r) sgn v + kV v + kA (1 + r) a, r = h tau (1 - exp(-T / tau)) + w exp(-P / tau)",
    parameters: &[
        MotorParameter::amplitude("h", "1/s", 1e-3, 2e-2),
        MotorParameter::amplitude("w", "1", 0.05, 2.0),
        MotorParameter::shape("tau", "s", 4.0, 1e3),
    ],
    sign: "more resistance later",
    shown_by: "the first experiment once more at the end",
    remedy: "tune the warm robot",
};
