//! What does an effect add up to over the runs of a campaign, in one number? Effects that the campaign cannot tell
//! apart agree about it.
//!
//! What the effect adds to turn and travel of each step is fitted by each of
//!
//! ```text
//! turn = c |ds|,  turn = c ds,  turn = c dtheta,  travel = c ds,  left = c |ds|         (1)
//! ```
//!
//! The result is the one that explains most, if it explains most of the whole.

use crate::effect::composition::{Composer, Term, Terms};
use crate::recording::campaign::Prepared;

/// What an effect adds up to, in one number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NetChange {
    /// It turns the robot along the path \[rad/m\], to the left positive.
    TurnPerMetre {
        /// How much, driving forwards; backwards where the runs went only that way.
        rad_per_m: f64,
        /// In which direction of travel.
        on: Ways,
    },
    /// It adds a share of the turn by the wheels.
    TurnShare(f64),
    /// It adds a share of the travel by the wheels.
    TravelShare(f64),
    /// It moves the robot sideways along the path \[m/m\], to the left positive.
    SidewaysPerMetre(f64),
}

/// In which direction of travel a robot is turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ways {
    /// Forwards; the runs hardly went backwards.
    Forwards,
    /// Backwards; the runs hardly went forwards.
    Backwards,
    /// The same way round forwards and backwards.
    Both,
    /// The opposite way round backwards.
    Opposite,
}

/// The part of what an effect does that one number has to explain.
const EXPLAINED_MIN: f64 = 0.6;

/// A smaller share of the path in one direction shows nothing about that direction.
const ONE_WAY: f64 = 0.1;

/// One fit of (1): sums of x^2 and x y.
#[derive(Clone, Copy, Default)]
struct Line {
    xx: f64,
    xy: f64,
}

impl Line {
    fn add(&mut self, x: f64, y: f64) {
        self.xx += x * x;
        self.xy += x * y;
    }

    fn slope(self) -> f64 {
        if self.xx > 0.0 { self.xy / self.xx } else { 0.0 }
    }

    /// How much of the sum of y^2 it explains.
    fn explained(self) -> f64 {
        self.slope() * self.xy
    }
}

/// What a term adds up to in these runs, if one number explains most of it.
pub(crate) fn net_change(prepared: &Prepared, term: &Term<'_>) -> Option<NetChange> {
    let mut lines = [Line::default(); 5];
    let mut all = 0.0;
    let (mut forwards_m, mut backwards_m) = (0.0, 0.0);
    let track_m = prepared.robot.track_width_m;
    for run in &prepared.runs {
        let mut composer = Composer::new(Terms::Fixed(std::slice::from_ref(term)));
        for step in &run.motion.steps {
            let increment = composer.step(step);
            let (ds_m, dtheta) = (step.travel_m(), step.turn_rad());
            forwards_m += ds_m.max(0.0);
            backwards_m += (-ds_m).max(0.0);
            // All in metres at the wheels: a turn counts by half the track width.
            let turn_m = (increment.turn_rad - dtheta) * track_m / 2.0;
            let travel_m = increment.travel_m - ds_m;
            let left_m = increment.sideways_m;
            all += turn_m * turn_m + travel_m * travel_m + left_m * left_m;
            lines[0].add(ds_m.abs(), turn_m);
            lines[1].add(ds_m, turn_m);
            lines[2].add(dtheta * track_m / 2.0, turn_m);
            lines[3].add(ds_m, travel_m);
            lines[4].add(ds_m.abs(), left_m);
        }
    }
    let best =
        (0..lines.len()).max_by(|a, b| lines[*a].explained().total_cmp(&lines[*b].explained()))?;
    if all <= 0.0 || lines[best].explained() < EXPLAINED_MIN * all {
        return None;
    }
    let slope = lines[best].slope();
    let rad_per_m = slope * 2.0 / track_m;
    let one_way = forwards_m.min(backwards_m) < ONE_WAY * forwards_m.max(backwards_m);
    let forwards = forwards_m > backwards_m;
    Some(match best {
        0 | 1 if one_way => {
            let on = if forwards { Ways::Forwards } else { Ways::Backwards };
            // In proportion to ds, driving backwards turns it the other way round.
            let rad_per_m = if best == 0 || forwards { rad_per_m } else { -rad_per_m };
            NetChange::TurnPerMetre { rad_per_m, on }
        }
        0 => NetChange::TurnPerMetre { rad_per_m, on: Ways::Both },
        1 => NetChange::TurnPerMetre { rad_per_m, on: Ways::Opposite },
        2 => NetChange::TurnShare(slope),
        3 => NetChange::TravelShare(slope),
        _ => NetChange::SidewaysPerMetre(slope),
    })
}
