//! Dead reckoning: where the robot is by its own counts.
//!
//! Outside the control tick, every ten ticks and with every telemetry frame; between two steps the path is taken for an
//! arc.
//!
//! ```text
//! dS      = (dS_L + dS_R) / 2                                  way of the middle between the wheels
//! theta   = ((S_R - S_R0) - (S_L - S_L0)) / b + c sum |dS|     heading; S absolute, so it does not drift   (1)
//! d theta = theta - theta before
//! chord   = dS sin(u) / u,  u = d theta / 2                                                                (2)
//! x      += chord cos(theta before + u),  y += chord sin(theta before + u)                                 (3)
//! ```
//!
//! b is the track width \[m\], c the heading pull \[rad/m\], S a wheel's travel \[m\] (the right one's with W_T), S_0
//! that at the last change of the configuration.

use fixed::types::I32F32;
use shared_proto::{Config, Pose, WheelPair};

use crate::soft_float::{nearest, to_f64};
use crate::units::Travel;

/// Fractional bits of a [`Travel`].
const TRAVEL_STEP_M: f64 = 1.0 / 4_294_967_296.0;

/// What of the configuration it needs.
#[derive(Clone, Copy, Debug)]
pub struct Geometry {
    track_width_m: f64,
    heading_pull_rad_per_m: f64,
}

impl Geometry {
    /// Of a valid configuration.
    pub fn new(config: &Config) -> Self {
        let geometry = &config.geometry;
        Self {
            track_width_m: geometry.track_width_m,
            heading_pull_rad_per_m: geometry.heading_pull_rad_per_m,
        }
    }
}

/// Follows the wheels' travel.
#[derive(Clone, Debug)]
pub struct DeadReckoning {
    /// None: it does not follow, as the scale of the travel is about to change.
    geometry: Option<Geometry>,
    /// S_0, and the heading there \[rad\].
    anchor: WheelPair<Travel>,
    anchor_rad: f64,
    last: WheelPair<Travel>,
    /// sum |dS| since the anchor \[m\].
    path_m: f64,
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
}

impl Default for DeadReckoning {
    fn default() -> Self {
        Self::new()
    }
}

impl DeadReckoning {
    /// At the origin; follows nothing yet.
    pub const fn new() -> Self {
        const ZERO: WheelPair<Travel> = WheelPair::both(Travel(I32F32::ZERO));
        Self {
            geometry: None,
            anchor: ZERO,
            anchor_rad: 0.0,
            last: ZERO,
            path_m: 0.0,
            x_m: 0.0,
            y_m: 0.0,
            heading_rad: 0.0,
        }
    }

    /// Stays where it is, whatever the travel does, until it adopts a configuration.
    pub fn pause(&mut self) {
        self.geometry = None;
    }

    /// Goes on from the same place with another configuration, in which the wheels' travel is this.
    pub fn adopt(&mut self, geometry: Geometry, travel: WheelPair<Travel>) {
        self.geometry = Some(geometry);
        self.anchor = travel;
        self.anchor_rad = self.heading_rad;
        self.last = travel;
        self.path_m = 0.0;
    }

    /// The wheels' travel is now this.
    pub fn step(&mut self, travel: WheelPair<Travel>) {
        let Some(Geometry { track_width_m, heading_pull_rad_per_m }) = self.geometry else {
            return;
        };
        if travel == self.last {
            return;
        }
        let way = travel.zip(self.last).map(|(now, before)| between_m(now, before));
        self.last = travel;
        let ds = 0.5 * (way.left + way.right);
        self.path_m += ds.abs();
        // (1)
        let turned = travel.zip(self.anchor).map(|(now, anchor)| between_m(now, anchor));
        let heading_rad = self.anchor_rad
            + (turned.right - turned.left) / track_width_m
            + heading_pull_rad_per_m * self.path_m;
        let u = 0.5 * (heading_rad - self.heading_rad);
        // (2): the next term, u^6 / 5040, is 2e-9 of the chord for a turn of 0.3 rad in a step.
        let chord = ds * series(u * u, &[20, 6]);
        let (sin, cos) = sin_cos(self.heading_rad + u);
        self.x_m += chord * cos;
        self.y_m += chord * sin;
        self.heading_rad = heading_rad;
    }

    /// Where the robot is.
    pub fn pose(&self) -> Pose {
        let micro = |value: f64| nearest(value * 1e6, 0);
        Pose { x_um: micro(self.x_m), y_um: micro(self.y_m), heading_urad: micro(self.heading_rad) }
    }
}

/// The way from `before` to `now` \[m\].
fn between_m(now: Travel, before: Travel) -> f64 {
    to_f64(now.0.to_bits().wrapping_sub(before.0.to_bits())) * TRAVEL_STEP_M
}

/// Sine and cosine of an angle \[rad\], to 1e-10 within a million radians.
///
/// A small one of our own: the library's takes 4 KiB.
#[inline(never)]
pub(crate) fn sin_cos(angle: f64) -> (f64, f64) {
    use core::f64::consts::FRAC_2_PI;
    // pi / 2 in two parts, of which the first has 33 bits: its multiples are exact.
    const HALF_PI_HIGH: f64 = 1.570_796_326_734_125_6;
    const HALF_PI_LOW: f64 = 6.077_100_506_506_192e-11;
    let quarter = nearest(angle * FRAC_2_PI, 0);
    let n = to_f64(quarter);
    let r = (angle - n * HALF_PI_HIGH) - n * HALF_PI_LOW;
    let q = r * r;
    // Taylor's series; within pi / 4 the first terms that are left out are 1e-11 and 4e-13.
    let sin = r * series(q, &[110, 72, 42, 20, 6]);
    let cos = series(q, &[132, 90, 56, 30, 12, 2]);
    match quarter & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// 1 - q/d (1 - q/d' (1 - ...)), of which the last divisor is d.
#[inline(never)]
fn series(q: f64, divisors: &[u8]) -> f64 {
    divisors.iter().fold(1.0, |rest, &divisor| 1.0 - q / to_f64(divisor.into()) * rest)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const STRAIGHT: Geometry = Geometry { track_width_m: 0.372, heading_pull_rad_per_m: 0.0 };

    fn travel(left_m: f64, right_m: f64) -> WheelPair<Travel> {
        WheelPair::new(left_m, right_m).map(|m| Travel(I32F32::from_num(m)))
    }

    /// The pose after the wheels have gone these ways in steps of ten ticks, at up to 0.4 m/s.
    fn after(geometry: Geometry, legs: &[(f64, f64)]) -> (f64, f64, f64) {
        let mut reckoning = DeadReckoning::new();
        reckoning.adopt(geometry, travel(5.0, -3.0));
        let (mut left, mut right) = (5.0, -3.0);
        for &(left_m, right_m) in legs {
            let steps = (left_m.abs().max(right_m.abs()) / 0.004).ceil().max(1.0);
            for step in 1..=steps as u32 {
                let share = f64::from(step) / steps;
                reckoning.step(travel(left + share * left_m, right + share * right_m));
            }
            (left, right) = (left + left_m, right + right_m);
        }
        let Pose { x_um, y_um, heading_urad } = reckoning.pose();
        (x_um as f64 * 1e-6, y_um as f64 * 1e-6, heading_urad as f64 * 1e-6)
    }

    proptest! {
        #[test]
        fn sine_and_cosine_are_those_of_the_library(angle in -1e6..1e6_f64) {
            let (sin, cos) = sin_cos(angle);
            prop_assert!((sin - angle.sin()).abs() < 1e-10, "{sin} {}", angle.sin());
            prop_assert!((cos - angle.cos()).abs() < 1e-10, "{cos} {}", angle.cos());
        }

        #[test]
        fn an_arc_ends_where_it_ends_on_paper(left_m in -3.0..3.0_f64, right_m in -3.0..3.0_f64) {
            let (x_m, y_m, heading_rad) = after(STRAIGHT, &[(left_m, right_m)]);
            let theta = (right_m - left_m) / 0.372;
            let s = 0.5 * (left_m + right_m);
            let (x, y) = if theta.abs() < 1e-9 {
                (s, 0.0)
            } else {
                (s / theta * theta.sin(), s / theta * (1.0 - theta.cos()))
            };
            prop_assert!((heading_rad - theta).abs() < 2e-6);
            prop_assert!((x_m - x).abs() < 5e-6 && (y_m - y).abs() < 5e-6, "{x_m} {x} {y_m} {y}");
        }
    }

    #[test]
    fn a_square_of_a_kilometre_comes_back_to_a_tenth_of_a_millimetre() {
        let quarter = 0.5 * 0.372 * core::f64::consts::FRAC_PI_2;
        let legs: Vec<_> = (0..4).flat_map(|_| [(250.0, 250.0), (-quarter, quarter)]).collect();
        let (x_m, y_m, heading_rad) = after(STRAIGHT, &legs);
        assert!(x_m.hypot(y_m) < 1e-4, "{x_m} {y_m}");
        assert!((heading_rad - core::f64::consts::TAU).abs() < 2e-6, "{heading_rad}");
    }

    #[test]
    fn a_pull_turns_the_heading_by_way_in_both_directions() {
        let pulled = Geometry { heading_pull_rad_per_m: 0.01, ..STRAIGHT };
        let (.., heading_rad) = after(pulled, &[(2.0, 2.0), (-2.0, -2.0)]);
        assert!((heading_rad - 0.04).abs() < 1e-5, "{heading_rad}");
    }

    #[test]
    fn another_configuration_moves_nothing() {
        let mut reckoning = DeadReckoning::new();
        reckoning.step(travel(1.0, 2.0));
        reckoning.adopt(STRAIGHT, travel(0.0, 0.0));
        assert_eq!(reckoning.pose(), Pose::default());
        reckoning.step(travel(0.1, 0.1));
        reckoning.step(travel(0.1, 0.2));
        let before = reckoning.pose();
        // W_T has changed, and with it the whole travel of the right wheel.
        reckoning.pause();
        reckoning.step(travel(0.1, 0.19));
        reckoning.adopt(Geometry { track_width_m: 0.4, ..STRAIGHT }, travel(0.1, 0.19));
        reckoning.step(travel(0.1, 0.19));
        assert_eq!(reckoning.pose(), before);
        reckoning.step(travel(0.2, 0.29));
        let Pose { heading_urad, .. } = reckoning.pose();
        assert_eq!(heading_urad, before.heading_urad, "straight on");
    }
}
