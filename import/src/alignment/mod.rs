//! Brings the clocks of wheels and poses together, however far apart they are: by how fast the robot moved and turned.
//!
//! Neither depends on the tracker's axes, nor on where a marker sits. With w the wheels' numbers and z the poses', both on
//! one grid, a the best factors (nobody need know a radius), and the sum over the overlap:
//!
//! ```text
//! misfit(lag) = sum (z - a w(t - lag))^2 / sum z^2                (1)
//! ```
//!
//! A lag at which less of the poses' motion has wheels beside it has to fit better for that: of drives that repeat themselves, the
//! lag is right that brings all of them together. A jump of a tracker and a counter that restarts are faster than the robot ever
//! was for longer, and do not count. Where the wheels only go, or only turn, the rest of the poses' motion is noise, and does not
//! count either. If one wheel counts backwards, going looks like turning to the wheels: that is tried as well.
//!
//! The lag is found on a grid that is coarse enough for the whole of both logs, and then on finer ones. If no lag fits well, one
//! that grows along the log is sought: two clocks that differ by 100 ppm are 0.7 s further apart after two hours. What is left,
//! half a step of the grid, is found by `robot_model::clocks` run by run.

mod products;
mod search;
mod speeds;

use products::{Fit, energies, shown};
use search::{Lag, lags};
pub use speeds::{Speeds, speeds};

/// A lag has to leave at most this misfit: a robot that is carried from run to run moves without its wheels.
const MISFIT_MAX: f64 = 0.5;
/// The same with what the motion costs that has no wheels beside it: parts of two drives may look alike.
const COST_MAX: f64 = 0.4;
/// Others, further away, have to leave more by this factor; by the second one if the lag leaves so much itself: the motions of
/// another drive may resemble these.
const RIVAL_FACTOR: f64 = 1.2;
const RIVAL_FACTOR_OF_POOR: f64 = 1.3;
const POOR_MISFIT: f64 = 0.25;
/// Lags nearer than this are no others \[s\].
const NEIGHBOUR_S: f64 = 2.0;
/// Wheels of which one is reversed have to fit better by this factor.
const REVERSED_FACTOR: f64 = 0.5;
/// A drift is sought where lags alone cost more, and taken if it costs less by this factor.
const STEADY_COST: f64 = 0.03;
const DRIFT_FACTOR: f64 = 0.6;

/// How both clocks go together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// Time of the poses less that of the wheels, in the middle of the poses \[s\].
    pub late_s: f64,
    /// By which share the poses' clock runs faster than that of the wheels, if it shows.
    pub drift: f64,
    /// The middle of the poses, by their own clock \[s\].
    pub middle_s: f64,
    /// What is left of the motion; equation (1).
    pub misfit: f64,
    /// Metres that the robot goes for a radian of both wheels, where wheels are in radians: the radius. `None` if it only turned.
    pub travel_per_unit: Option<f64>,
    /// Radians that it turns for a radian of difference. `None` if it only went straight.
    pub turn_per_unit: Option<f64>,
    /// One of the wheels counts backwards.
    pub one_reversed: bool,
}

/// Why no lag was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlignError {
    /// One of them hardly moved.
    NoMotion {
        /// The wheels, else the poses.
        of_wheels: bool,
    },
    /// At no lag do both move alike.
    NothingInCommon {
        /// The least that is left.
        misfit: f64,
    },
    /// Several lags fit about as well.
    Ambiguous {
        /// Two of them \[s\].
        lags_s: [f64; 2],
    },
}

impl Alignment {
    /// A time of the poses by the clock of the wheels \[s\].
    pub fn by_wheels_s(&self, t_s: f64) -> f64 {
        t_s - self.late_s - self.drift * (t_s - self.middle_s)
    }
}

/// Wheels as they are, or with one of them reversed, and the best lags.
struct Found {
    one_reversed: bool,
    best: Vec<(Lag, Fit)>,
}

impl Found {
    fn of(wheels: &Speeds, reversed: &Speeds, poses: &Speeds, may_drift: bool) -> Self {
        let [as_is, other] = [wheels, reversed].map(|wheels| lags(wheels, poses, may_drift));
        let one_reversed = cost(&other) < REVERSED_FACTOR * cost(&as_is);
        Self { one_reversed, best: if one_reversed { other } else { as_is } }
    }

    /// Another lag than the best that is about as good.
    fn rival(&self, step_s: f64) -> Option<Lag> {
        let (lag, Fit { misfit, cost }) = *self.best.first()?;
        let factor = if misfit > POOR_MISFIT { RIVAL_FACTOR_OF_POOR } else { RIVAL_FACTOR };
        let is_rival = |(other, fit): &&(Lag, Fit)| {
            (other.shift - lag.shift).abs() as f64 * step_s > NEIGHBOUR_S
                && fit.misfit < factor * misfit
                && fit.cost < factor * cost
        };
        self.best.iter().find(is_rival).map(|(other, _)| *other)
    }
}

fn cost(best: &[(Lag, Fit)]) -> f64 {
    best.first().map_or(f64::INFINITY, |(_, fit)| fit.cost)
}

/// Finds how late the poses are.
pub fn align([wheels, poses]: &[Speeds; 2]) -> Result<Alignment, AlignError> {
    let moves = |speeds: &Speeds| energies(speeds).iter().any(|energy| *energy > 0.0);
    if !moves(wheels) || !moves(poses) {
        return Err(AlignError::NoMotion { of_wheels: !moves(wheels) });
    }
    let reversed = wheels.one_reversed();
    let mut found = Found::of(wheels, &reversed, poses, false);
    if cost(&found.best) > STEADY_COST || found.rival(wheels.step_s).is_some() {
        let drifting = Found::of(wheels, &reversed, poses, true);
        if cost(&drifting.best) < DRIFT_FACTOR * cost(&found.best) {
            found = drifting;
        }
    }
    let wheels = if found.one_reversed { &reversed } else { wheels };
    let Some(&(lag, Fit { misfit, cost })) = found.best.first() else {
        return Err(AlignError::NothingInCommon { misfit: 1.0 });
    };
    if misfit > MISFIT_MAX || cost > COST_MAX {
        return Err(AlignError::NothingInCommon { misfit });
    }
    let late_s = |lag: Lag| poses.start_s - wheels.start_s + lag.shift as f64 * wheels.step_s;
    if let Some(rival) = found.rival(wheels.step_s) {
        return Err(AlignError::Ambiguous { lags_s: [late_s(lag), late_s(rival)] });
    }
    let products = lag.products(wheels, poses);
    let shown = shown(wheels, poses);
    let factor = |axis: usize| {
        let is_known = shown[axis] && products.wheels[axis] > 0.0;
        is_known.then(|| products.both[axis] / products.wheels[axis])
    };
    Ok(Alignment {
        late_s: late_s(lag),
        drift: lag.drift,
        middle_s: poses.start_s + poses.values.len() as f64 / 2.0 * poses.step_s,
        misfit,
        travel_per_unit: factor(0),
        turn_per_unit: factor(1).filter(|_| products.poses[1] > 0.0),
        one_reversed: found.one_reversed,
    })
}
