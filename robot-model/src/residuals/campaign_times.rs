//! A pull, or a share of the travel, that changes in the course of a campaign: functions of the time since it began.
//!
//! ```text
//! dtheta = sum_k p_k h_k(t) |ds|,  or  ds_i -> ds_i (1 + sum_k p_k h_k(t)),   k = 1 ... 4             (1)
//! ```
//!
//! h_k is 1 at one moment, and falls in straight lines to 0 at the ones before and after it. Two sets of four share the campaign:
//! a run left out has runs beside it that tell what was then.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::campaign::Prepared;
use crate::recording::motion::Step;

/// Moments of a campaign, the first one at its beginning.
const MOMENTS: usize = 9;
/// Fewer runs do not tell one moment from another.
const RUNS_MIN: usize = 9;

/// (1), of four moments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CampaignTimes {
    /// Time between two moments \[s\].
    apart_s: f64,
    /// The first of the four, counted from zero.
    first: usize,
    /// Whether it turns the robot, else it changes travel.
    turns: bool,
}

/// All functions in a campaign, if the times of its runs are known.
pub(super) fn campaign_times(prepared: &Prepared) -> Vec<CampaignTimes> {
    let known = prepared.runs.iter().all(|run| run.recording.started_s.is_some());
    if !known || prepared.runs.len() < RUNS_MIN {
        return Vec::new();
    }
    let apart_s = prepared.excitation.span_s / (MOMENTS - 1) as f64;
    let of = |first: usize| [true, false].map(|turns| CampaignTimes { apart_s, first, turns });
    [1, 5].into_iter().flat_map(of).collect()
}

impl CampaignTimes {
    /// h_1 to h_4.
    fn at(&self, clock_s: f64) -> [f64; 4] {
        core::array::from_fn(|k| {
            let moment = (self.first + k) as f64;
            (1.0 - (clock_s / self.apart_s - moment).abs()).max(0.0)
        })
    }
}

static FACTS: Facts<'static> = Facts {
    id: "campaign_times",
    name: "what changes in the course of a campaign",
    equation: "dtheta = sum_k p_k h_k(t) |ds|",
    parameters: &[
        Parameter::amplitude("a", "1", 0.1),
        Parameter::amplitude("b", "1", 0.1),
        Parameter::amplitude("c", "1", 0.1),
        Parameter::amplitude("d", "1", 0.1),
    ],
    ..Facts::DEFAULT
};

impl Effect for CampaignTimes {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let [a, b, c, d] = self.at(step.clock_s);
        let now = p[0] * a + p[1] * b + p[2] * c + p[3] * d;
        match self.turns {
            true => Change { turn_rad: now * step.travel_m().abs(), ..Change::NONE },
            false => Change { travel: WheelPair::both(now), ..Change::NONE },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_two_moments_both_act_by_their_shares() {
        let times = CampaignTimes { apart_s: 100.0, first: 1, turns: true };
        for (clock_s, expected) in [
            (0.0, [0.0; 4]),
            (100.0, [1.0, 0.0, 0.0, 0.0]),
            (275.0, [0.0, 0.25, 0.75, 0.0]),
            (450.0, [0.0, 0.0, 0.0, 0.5]),
            (800.0, [0.0; 4]),
        ] {
            assert_eq!(times.at(clock_s), expected, "{clock_s} s");
        }
    }
}
