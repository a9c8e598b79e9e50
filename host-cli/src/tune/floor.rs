//! Where on its floor the robot is, by its own counts, and how far it may go.

use shared_proto::{Config, Telemetry};

use crate::wheel_angles::travel_m;

/// The floor ahead of where the robot stood at first.
#[derive(Clone, Copy, Debug)]
pub struct Floor {
    ahead_m: f64,
    /// Where the robot is, ahead of where it stood \[m\].
    at_m: f64,
    /// How far ahead and behind it has been \[m\].
    range_m: (f64, f64),
}

/// Longest floor that is used \[m\]: no experiment lasts long enough for more, and the robot refuses a bound of travel above 20 m.
const USEFUL_M: f64 = 20.0;

/// Share of the way to an edge that a motion may use: the rest is for rolling out.
const USABLE: f64 = 0.75;

impl Floor {
    /// This much is ahead; no experiment needs more than [`USEFUL_M`] of it.
    pub fn new(ahead_m: f64) -> Self {
        let ahead_m = ahead_m.min(USEFUL_M);
        Self { ahead_m, at_m: 0.0, range_m: (0.0, 0.0) }
    }

    /// How far a motion may go forwards, or backwards \[m\].
    pub fn room_m(&self, forward: bool) -> f64 {
        let to_edge_m = if forward { self.ahead_m - self.at_m } else { self.at_m };
        USABLE * to_edge_m.max(0.0)
    }

    /// Where the robot is, ahead of where it stood \[m\].
    pub fn at_m(&self) -> f64 {
        self.at_m
    }

    /// From the farthest behind to the farthest ahead \[m\].
    pub fn used_m(&self) -> f64 {
        self.range_m.1 - self.range_m.0
    }

    /// Follows what a recording shows.
    pub fn follow(&mut self, config: &Config, telemetry: &[Telemetry]) {
        let Some(first) = telemetry.first() else { return };
        let start_m = self.at_m;
        for frame in telemetry {
            let travel = travel_m(config, first, frame);
            self.at_m = start_m + 0.5 * (travel.left + travel.right);
            self.range_m = (self.range_m.0.min(self.at_m), self.range_m.1.max(self.at_m));
        }
    }
}
