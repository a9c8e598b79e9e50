//! Travel of one wheel, or of both, that changes above a rate: what an encoder or a tyre does only when it turns fast.
//!
//! ```text
//! dphi_i -> dphi_i (1 + sum_k p_k f_k(|dphi_i/dt|)),   k = 1 ... 4                                    (1)
//! f_k(w) = h_k(w), or max(0, w / w_k - 1)
//! ```
//!
//! h_k is 1 at the rate w_k, and falls in straight lines to 0 at the rates before and after it; above the last rate it stays
//! at 1. So p_k is the share that is lost or gained at w_k, as of thin lines of a disc, which are lost one after the other.
//! Nothing changes below w_0. A run left out may reach beyond the rates of all others: there the share is that of the last.
//!
//! The other functions are of what grows on and on above a rate. The limit of their p_k is tight: without it, one that lies near
//! the rate of an effect of the model would cancel that, and a run left out would go anywhere.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::excitation::Excitation;
use crate::recording::motion::Step;

/// w_0 to w_4 of h_k, of the highest rate of a campaign: what is lost in steps lies between the rates of one set.
const SHARES: [[f64; 5]; 3] =
    [[0.15, 0.3, 0.5, 0.7, 0.9], [0.25, 0.4, 0.6, 0.8, 1.0], [0.35, 0.5, 0.65, 0.8, 0.95]];
/// w_1 to w_4 of what grows.
const GROWS_ABOVE: [[f64; 4]; 2] = [[0.3, 0.5, 0.65, 0.8], [0.4, 0.58, 0.72, 0.9]];

/// Each wheel, and both with the same p_k: discs of one make may lose the same.
const ACTS: [WheelPair<f64>; 3] =
    [WheelPair::new(1.0, 0.0), WheelPair::new(0.0, 1.0), WheelPair::new(1.0, 1.0)];

/// (1) of the wheels that it acts on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WheelRates {
    functions: Functions,
    /// 1 for a wheel that it acts on, else 0.
    acts: WheelPair<f64>,
}

/// f_1 to f_4, with their rates \[rad/s\].
#[derive(Clone, Copy, Debug, PartialEq)]
enum Functions {
    Shares([f64; 5]),
    Growth([f64; 4]),
}

/// All functions for all wheels, in a campaign.
pub(super) fn wheel_rates(excitation: &Excitation) -> Vec<WheelRates> {
    let most_rad_s = excitation.wheel_rate_max_rad_s;
    let shares = SHARES.iter().flat_map(|set| {
        let functions = Functions::Shares(set.map(|share| share * most_rad_s));
        ACTS.map(|acts| WheelRates { functions, acts })
    });
    let growth = GROWS_ABOVE.iter().flat_map(|set| {
        let functions = Functions::Growth(set.map(|share| share * most_rad_s));
        [ACTS[0], ACTS[1]].map(|acts| WheelRates { functions, acts })
    });
    shares.chain(growth).collect()
}

impl Functions {
    /// f_1 to f_4 at this rate.
    fn at(&self, rate_rad_s: f64) -> [f64; 4] {
        match self {
            Self::Growth(above) => above.map(|above| (rate_rad_s / above - 1.0).max(0.0)),
            Self::Shares(rates) => {
                // How far it is between two of the rates: from 0 at the first to 1 at the second.
                let [first, second, third, fourth] = core::array::from_fn(|k| {
                    let (from, to) = (rates[k], rates[k + 1]);
                    ((rate_rad_s - from) / (to - from)).clamp(0.0, 1.0)
                });
                [first - second, second - third, third - fourth, fourth]
            }
        }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "wheel_rates",
    name: "travel of wheels above a rate",
    equation: "dphi_i (1 + sum_k p_k f_k(|dphi_i/dt|))",
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
            let [a, b, c, d] = self.functions.at(speed_mps.abs() / step.wheel_radius_m);
            (p[0] * a + p[1] * b + p[2] * c + p[3] * d) * acts
        });
        Change { travel, ..Change::NONE }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_that_of_each_rate_and_above_the_last_it_stays() {
        let shares = Functions::Shares([1.0, 2.0, 4.0, 6.0, 8.0]);
        for (rate, expected) in [
            (0.0, [0.0; 4]),
            (1.0, [0.0; 4]),
            (1.5, [0.5, 0.0, 0.0, 0.0]),
            (2.0, [1.0, 0.0, 0.0, 0.0]),
            (5.0, [0.0, 0.5, 0.5, 0.0]),
            (8.0, [0.0, 0.0, 0.0, 1.0]),
            (100.0, [0.0, 0.0, 0.0, 1.0]),
        ] {
            assert_eq!(shares.at(rate), expected, "{rate} rad/s");
        }
        assert_eq!(Functions::Growth([1.0, 2.0, 4.0, 8.0]).at(4.0), [3.0, 1.0, 0.0, 0.0]);
    }
}
