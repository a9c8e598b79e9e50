//! Above a rate the counter misses edges.
//!
//! ```text
//! dphi_i -> dphi_i (1 + k max(0, |dphi_i/dt| - w0) / w0)
//! ```
//!
//! k > 0: the wheel turned further than was counted; w0 \[rad/s\] is the rate above which it happens.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter, Role};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::excitation::Excitation;
use crate::recording::motion::Step;

/// Fast edges are missed by the counter.
#[derive(Debug)]
pub struct LostCounts;

impl Effect for LostCounts {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let travel = step.wheel_speed_mps.map(|speed_mps| {
            let rate = speed_mps.abs() / step.wheel_radius_m;
            if rate > p[1].value { p[0] * ((-p[1] + rate) / p[1]) } else { Jet::ZERO }
        });
        Change { travel, ..Change::NONE }
    }

    fn starts(&self, excitation: &Excitation) -> Vec<Vec<f64>> {
        [0.4, 0.6, 0.8].map(|share| vec![0.0, share * excitation.wheel_rate_max_rad_s]).into()
    }

    /// A rate that these runs exceed by a fifth and also stay below for a while: otherwise the effect is the same as
    /// a wheel radius, or as nothing.
    fn range(&self, parameter: usize, excitation: &Excitation) -> (f64, f64) {
        let facts = &FACTS.parameters[parameter];
        match facts.role {
            Role::Amplitude => (facts.low, facts.high),
            Role::Shape => {
                let most = excitation.wheel_rate_max_rad_s;
                ((0.3 * most).max(facts.low), (0.83 * most).clamp(facts.low, facts.high))
            }
        }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "lost_counts",
    name: "lost encoder counts",
    equation: "dphi_i (1 + k max(0, |dphi_i/dt| - w0) / w0)",
    parameters: &[Parameter::positive("k", "1", 0.5), Parameter::shape("w0", "rad/s", 0.5, 200.0)],
    signature: "an error that begins above a certain wheel speed",
    shown_by: "straight runs at several speeds",
    compensation: "filter the encoder's signals, or drive slower",
    ..Facts::DEFAULT
};
