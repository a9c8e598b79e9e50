//! Where is the robot after its wheels turned so far? Dead reckoning along exact arcs.

use super::geometry::Geometry;
use super::wheel_pair::WheelPair;
use crate::numeric::angle::{Direction, sinc};

/// Where the robot is: the middle between its wheels, and its heading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Forward \[m\].
    pub x_m: f64,
    /// To the left \[m\].
    pub y_m: f64,
    /// Counter-clockwise positive, not wrapped \[rad\].
    pub heading_rad: f64,
}

impl Pose {
    /// At the origin, heading along x.
    pub const ORIGIN: Self = Self { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 };

    /// A pose from its three numbers.
    pub const fn new(x_m: f64, y_m: f64, heading_rad: f64) -> Self {
        Self { x_m, y_m, heading_rad }
    }

    /// Its three numbers.
    pub(crate) const fn to_array(self) -> [f64; 3] {
        [self.x_m, self.y_m, self.heading_rad]
    }

    /// The pose at the end of an exact arc.
    ///
    /// With the travels S_L, S_R: `turn = (S_R - S_L) / b`, `s = (S_L + S_R) / 2`, and the chord
    /// `s sin(turn/2) / (turn/2)` lies at the heading `theta + turn/2`.
    pub fn advance(self, travel_left_m: f64, travel_right_m: f64, track_width_m: f64) -> Self {
        let turn = (travel_right_m - travel_left_m) / track_width_m;
        let chord_m = (travel_left_m + travel_right_m) / 2.0 * sinc(turn / 2.0);
        let (sin, cos) = (self.heading_rad + turn / 2.0).sin_cos();
        Self {
            x_m: self.x_m + chord_m * cos,
            y_m: self.y_m + chord_m * sin,
            heading_rad: self.heading_rad + turn,
        }
    }

    /// A pose given in this pose's frame, in the outer frame.
    pub fn compose(self, local: Self) -> Self {
        let (sin, cos) = self.heading_rad.sin_cos();
        Self {
            x_m: self.x_m + cos * local.x_m - sin * local.y_m,
            y_m: self.y_m + sin * local.x_m + cos * local.y_m,
            heading_rad: self.heading_rad + local.heading_rad,
        }
    }

    /// This pose as seen from `frame`: the inverse of [`Pose::compose`].
    pub fn seen_from(self, frame: Self) -> Self {
        let (sin, cos) = frame.heading_rad.sin_cos();
        let (dx_m, dy_m) = (self.x_m - frame.x_m, self.y_m - frame.y_m);
        Self {
            x_m: cos * dx_m + sin * dy_m,
            y_m: -sin * dx_m + cos * dy_m,
            heading_rad: self.heading_rad - frame.heading_rad,
        }
    }
}

/// The poses at each of the cumulative wheel angles `turns`; the first is `start`.
///
/// Between two of them the wheels are taken to turn in proportion, so each piece is an exact arc.
pub fn dead_reckon(
    start: Pose,
    geometry: &Geometry,
    wheel_weight: f64,
    turns: impl IntoIterator<Item = WheelPair<f64>>,
) -> Vec<Pose> {
    let radius_m = geometry.wheel_radius_m;
    let radii_m = WheelPair::new(radius_m, radius_m * wheel_weight);
    dead_reckon_with(start, radii_m, geometry.track_width_m, turns)
}

/// After so many steps the direction is computed from the heading anew, so that its rounding does not add up.
const ANEW: usize = 32;

/// The same for wheels of these radii. Each step is that of [`Pose::advance`].
pub(crate) fn dead_reckon_with(
    start: Pose,
    radii_m: WheelPair<f64>,
    track_width_m: f64,
    turns: impl IntoIterator<Item = WheelPair<f64>>,
) -> Vec<Pose> {
    let mut turns = turns.into_iter();
    let Some(mut before) = turns.next() else {
        return Vec::new();
    };
    let mut poses = Vec::with_capacity(turns.size_hint().0 + 1);
    poses.push(start);
    let mut pose = start;
    let mut direction = Direction::of(pose.heading_rad);
    for (index, now) in turns.enumerate() {
        let step = now.since(before);
        let (left_m, right_m) = (radii_m.left * step.left, radii_m.right * step.right);
        let turn = (right_m - left_m) / track_width_m;
        let half = turn / 2.0;
        let shorter = sinc(half);
        let by = Direction::of_small(half, shorter);
        if index % ANEW == 0 {
            direction = Direction::of(pose.heading_rad);
        }
        let ahead = direction.turned(by);
        let chord_m = (left_m + right_m) / 2.0 * shorter;
        pose = Pose::new(
            pose.x_m + chord_m * ahead.cos,
            pose.y_m + chord_m * ahead.sin,
            pose.heading_rad + turn,
        );
        direction = ahead.turned(by);
        poses.push(pose);
        before = now;
    }
    poses
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn equal_wheels_drive_straight_and_opposite_ones_spin_on_the_spot() {
        let straight = Pose::ORIGIN.advance(1.5, 1.5, 0.3);
        assert_eq!(straight, Pose::new(1.5, 0.0, 0.0));
        let spin = Pose::ORIGIN.advance(-0.3, 0.3, 0.3);
        assert_eq!(spin, Pose::new(0.0, 0.0, 2.0));
    }

    #[test]
    fn a_quarter_circle_to_the_left_ends_one_radius_ahead_and_one_to_the_left() {
        let quarter = core::f64::consts::FRAC_PI_2;
        let pose = Pose::ORIGIN.advance(quarter * 0.8, quarter * 1.2, 0.4);
        // Three roundings of numbers near one.
        assert!((pose.x_m - 1.0).abs() < 1e-15 && (pose.y_m - 1.0).abs() < 1e-15, "{pose:?}");
        assert!((pose.heading_rad - quarter).abs() < 1e-15);
    }

    #[test]
    fn no_turns_give_no_poses() {
        assert!(dead_reckon(Pose::ORIGIN, &Geometry::PAPER, 1.0, []).is_empty());
    }

    #[test]
    fn dead_reckoning_is_one_arc_after_another() {
        let radii_m = WheelPair::new(0.036, 0.0361);
        // Slow and fast turns, and more of them than until the direction is computed anew.
        let turns = (0..200).map(|k| {
            let t = f64::from(k);
            WheelPair::new(0.2 * t + (0.3 * t).sin(), 0.25 * t + 8.0 * (0.05 * t).cos())
        });
        let start = Pose::new(0.4, -2.0, 1.3);
        let poses = dead_reckon_with(start, radii_m, 0.2, turns.clone());
        let turns: Vec<WheelPair<f64>> = turns.collect();
        let mut pose = start;
        for (pair, there) in turns.windows(2).zip(&poses[1..]) {
            let step = pair[1].since(pair[0]);
            pose = pose.advance(radii_m.left * step.left, radii_m.right * step.right, 0.2);
            assert!((pose.x_m - there.x_m).hypot(pose.y_m - there.y_m) < 1e-13, "{pose:?}");
            assert_eq!(pose.heading_rad, there.heading_rad);
        }
        assert_eq!(poses.len(), turns.len());
    }

    proptest! {
        #[test]
        fn an_arc_in_pieces_is_the_arc_as_a_whole(
            left in -3.0_f64..3.0, right in -3.0_f64..3.0, pieces in 1_u32..50,
        ) {
            let turns = WheelPair { left: left / 0.036, right: right / 0.036 };
            let steps = (0..=pieces).map(|i| WheelPair::default().toward(turns, f64::from(i) / f64::from(pieces)));
            let pieced = *dead_reckon(Pose::ORIGIN, &Geometry::PAPER, 1.0, steps).last().unwrap();
            let whole = Pose::ORIGIN.advance(left, right, 0.372);
            // 50 steps, each with roundings of a few 1e-16 of up to 3 m and 16 rad.
            prop_assert!((pieced.x_m - whole.x_m).hypot(pieced.y_m - whole.y_m) < 1e-12);
            prop_assert!((pieced.heading_rad - whole.heading_rad).abs() < 1e-12);
        }

        #[test]
        fn seen_from_is_the_inverse_of_compose(
            x in -9.0_f64..9.0, y in -9.0_f64..9.0, heading in -7.0_f64..7.0, ahead in -2.0_f64..2.0,
        ) {
            let frame = Pose::new(x, y, heading);
            let local = Pose::new(ahead, -0.3, 0.2);
            let back = frame.compose(local).seen_from(frame);
            prop_assert!((back.x_m - local.x_m).hypot(back.y_m - local.y_m) < 1e-13);
            prop_assert!((back.heading_rad - local.heading_rad).abs() < 1e-14);
        }
    }
}
