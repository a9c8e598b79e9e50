//! Travel of one wheel that changes above a rate: what its encoder or its tyre does only when it turns fast.
//!
//! ```text
//! dphi_i -> dphi_i (1 + sum_k p_k max(0, |dphi_i/dt| / w_k - 1))                          (1)
//! ```
//!
//! The rates w_k are shares of the fastest wheel's. The limit of p_k is tight: without it, one that lies near the rate of an
//! effect of the model would cancel that, and a run left out, which reaches beyond the others' rates, would go anywhere.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::excitation::Excitation;
use crate::recording::motion::Step;

/// w_k of (1), of the highest rate of a campaign: two sets, so that steps between them are seen too.
const SHARES: [[f64; 4]; 2] = [[0.3, 0.5, 0.65, 0.8], [0.4, 0.58, 0.72, 0.9]];

/// (1) of one wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WheelRates {
    /// w_k \[rad/s\].
    above_rad_s: [f64; 4],
    /// 1 for the wheel that it acts on, 0 for the other one.
    acts: WheelPair<f64>,
}

/// Both sets of either wheel, in a campaign.
pub(super) fn wheel_rates(excitation: &Excitation) -> Vec<WheelRates> {
    let each = SHARES.iter().flat_map(|shares| {
        let above_rad_s = shares.map(|share| share * excitation.wheel_rate_max_rad_s);
        [WheelPair::new(1.0, 0.0), WheelPair::new(0.0, 1.0)]
            .map(|acts| WheelRates { above_rad_s, acts })
    });
    each.collect()
}

static FACTS: Facts<'static> = Facts {
    id: "wheel_rates",
    name: "travel of one wheel above a rate",
    equation: "dphi_i (1 + sum_k p_k max(0, |dphi_i/dt| / w_k - 1))",
    parameters: &[
        Parameter::amplitude("a", "1", 0.05),
        Parameter::amplitude("b", "1", 0.05),
        Parameter::amplitude("c", "1", 0.05),
        Parameter::amplitude("d", "1", 0.05),
    ],
    ..Facts::DEFAULT
};

impl Effect for WheelRates {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let travel = step.wheel_speed_mps.zip(self.acts).map(|(speed_mps, acts)| {
            let rate = speed_mps.abs() / step.wheel_radius_m;
            let by = self.above_rad_s.map(|above| acts * (rate / above - 1.0).max(0.0));
            p[0] * by[0] + p[1] * by[1] + p[2] * by[2] + p[3] * by[3]
        });
        Change { travel, ..Change::NONE }
    }
}
