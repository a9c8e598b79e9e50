//! How much floor a run needs.
//!
//! Only the nominal path counts: the margin covers what the robot does beyond it.

use robot_model::recording::Piece;

/// A rectangle of floor, in the robot's frame at its start \[m\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Floor {
    /// Ahead of the mark.
    pub ahead_m: f64,
    /// Behind it.
    pub behind_m: f64,
    /// To its left.
    pub left_m: f64,
    /// To its right.
    pub right_m: f64,
}

impl Floor {
    /// What the nominal path of these pieces covers, and the reach of the robot on each side.
    ///
    /// The robot is assumed to reach one track width from its middle in every direction.
    pub fn of(pieces: &[Piece], track_width_m: f64) -> Self {
        let mut floor = Self::default();
        for [x_m, y_m] in nominal_path(pieces) {
            floor.ahead_m = floor.ahead_m.max(x_m);
            floor.behind_m = floor.behind_m.max(-x_m);
            floor.left_m = floor.left_m.max(y_m);
            floor.right_m = floor.right_m.max(-y_m);
        }
        Self {
            ahead_m: floor.ahead_m + track_width_m,
            behind_m: floor.behind_m + track_width_m,
            left_m: floor.left_m + track_width_m,
            right_m: floor.right_m + track_width_m,
        }
    }

    /// Length along the robot's first heading and width across it \[m\].
    pub fn size_m(&self) -> [f64; 2] {
        [self.ahead_m + self.behind_m, self.left_m + self.right_m]
    }

    /// The floor that covers both.
    pub fn with(self, other: Self) -> Self {
        Self {
            ahead_m: self.ahead_m.max(other.ahead_m),
            behind_m: self.behind_m.max(other.behind_m),
            left_m: self.left_m.max(other.left_m),
            right_m: self.right_m.max(other.right_m),
        }
    }
}

/// Where the nominal robot goes that drives these pieces from the origin, along x: x and y of the middle between its wheels \[m\].
pub fn nominal_path(pieces: &[Piece]) -> Vec<[f64; 2]> {
    const CHORDS: u32 = 90;
    let (mut x_m, mut y_m, mut heading_rad) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut path = vec![[x_m, y_m]];
    for piece in pieces {
        match *piece {
            Piece::Straight { travel_m, .. } => {
                x_m += travel_m * heading_rad.cos();
                y_m += travel_m * heading_rad.sin();
                path.push([x_m, y_m]);
            }
            Piece::Spin { turn_rad, .. } => heading_rad += turn_rad,
            Piece::Arc { radius_m, turn_rad, .. } => {
                // The centre is on the side to which the robot turns.
                let side_m = radius_m * turn_rad.signum();
                let center = [x_m - side_m * heading_rad.sin(), y_m + side_m * heading_rad.cos()];
                for i in 1..=CHORDS {
                    let now = heading_rad + turn_rad * f64::from(i) / f64::from(CHORDS);
                    x_m = center[0] + side_m * now.sin();
                    y_m = center[1] - side_m * now.cos();
                    path.push([x_m, y_m]);
                }
                heading_rad += turn_rad;
            }
            Piece::Rest { .. } => {}
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, TAU};

    /// Ninety chords of a circle miss its edge by less than a thousandth of its radius.
    const CHORD: f64 = 1e-3;

    #[test]
    fn a_left_circle_needs_its_diameter_to_the_left() {
        let arc = Piece::Arc { radius_m: 0.5, turn_rad: TAU, speed_mps: 0.1 };
        let floor = Floor::of(&[arc], 0.3);
        for (is, want) in
            [(floor.ahead_m, 0.8), (floor.behind_m, 0.8), (floor.left_m, 1.3), (floor.right_m, 0.3)]
        {
            assert!((is - want).abs() < CHORD, "{floor:?}");
        }
    }

    #[test]
    fn a_square_to_the_right_needs_its_side_ahead_and_to_the_right() {
        let side = [
            Piece::Straight { travel_m: 1.0, speed_mps: 0.1 },
            Piece::Spin { turn_rad: -FRAC_PI_2, speed_mps: 0.1 },
        ];
        let floor = Floor::of(&side.repeat(4), 0.0);
        for (is, want) in
            [(floor.ahead_m, 1.0), (floor.behind_m, 0.0), (floor.left_m, 0.0), (floor.right_m, 1.0)]
        {
            assert!((is - want).abs() < 1e-9, "{floor:?}");
        }
    }
}
