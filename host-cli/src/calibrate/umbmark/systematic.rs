//! What the ends of squares driven both ways say about wheels and track: the equations of UMBmark.
//!
//! # Equations
//!
//! A square of side L begins along x. Its end, measured less dead reckoning, is e, the mean over
//! several squares. If every leg bends by beta to the left and every turn is too wide by a, then to
//! first order
//!
//! ```text
//! left turns:  e = 2 L (a + beta) ( 1, -1)              (1)
//! right turns: e = 2 L (a - beta) ( 1,  1)              (2)
//! ```
//!
//! so a and beta follow by least squares over x and y. Then, with b the track width in use:
//!
//! ```text
//! b'  = b E_b,     E_b = (pi/2) / (pi/2 + a)                                            (3)
//! W_T' = W_T E_d,  E_d = (R + b/2) / (R - b/2),  R = (L/2) / sin(beta/2)                (4)
//! E_max,syst = max |e| of the two ways                                                  (5)
//! ```
//!
//! The mean of both radii stays: a closed path says nothing about it. Source: Borenstein and Feng,
//! UMBmark: a benchmark test for measuring odometry errors in mobile robots, 1995; (1) and (2) are
//! derived anew for turns to the left positive, and use both coordinates.

use std::f64::consts::FRAC_PI_2;

use shared_proto::GeometryConfig;

/// The systematic error of two sets of squares.
#[derive(Clone, Debug, PartialEq)]
pub struct Systematic {
    /// Measured ends less dead reckoning, of each square to the left \[m\].
    pub left_m: Vec<[f64; 2]>,
    /// The same of each square to the right \[m\].
    pub right_m: Vec<[f64; 2]>,
    /// E_max,syst (5) \[m\].
    pub error_m: f64,
    /// E_d (4).
    pub wheel_ratio: f64,
    /// E_b (3).
    pub track_ratio: f64,
}

impl Systematic {
    /// The systematic error that follows from these ends.
    pub fn new(left_m: Vec<[f64; 2]>, right_m: Vec<[f64; 2]>, side_m: f64, track_m: f64) -> Self {
        let mean = |errors: &[[f64; 2]]| {
            let n = errors.len().max(1) as f64;
            let sum = |k: usize| errors.iter().map(|error| error[k]).sum::<f64>() / n;
            [sum(0), sum(1)]
        };
        let (left, right) = (mean(&left_m), mean(&right_m));
        // (1) and (2) along (1, -1) and (1, 1): 2 L (a + beta) and 2 L (a - beta).
        let sum = (left[0] - left[1]) / 2.0 / (2.0 * side_m);
        let difference = (right[0] + right[1]) / 2.0 / (2.0 * side_m);
        let (a, beta) = ((sum + difference) / 2.0, (sum - difference) / 2.0);
        let half = side_m / 2.0;
        // (4), with the fraction cleared of the infinite radius of a straight leg.
        let bend = track_m / 2.0 * (beta / 2.0).sin();
        Self {
            error_m: left[0].hypot(left[1]).max(right[0].hypot(right[1])),
            wheel_ratio: (half + bend) / (half - bend),
            track_ratio: FRAC_PI_2 / (FRAC_PI_2 + a),
            left_m,
            right_m,
        }
    }

    /// The geometry corrected by (3) and (4), with the mean radius as before.
    pub fn corrected(&self, in_use: &GeometryConfig) -> GeometryConfig {
        let wheel_weight = in_use.wheel_weight * self.wheel_ratio;
        GeometryConfig {
            wheel_radius_m: in_use.wheel_radius_m * (1.0 + in_use.wheel_weight)
                / (1.0 + wheel_weight),
            wheel_weight,
            track_width_m: in_use.track_width_m * self.track_ratio,
            ..*in_use
        }
    }
}

#[cfg(test)]
mod tests {
    use shared_proto::Config;

    use super::*;

    /// The end of a robot whose wheels and track differ from those of its odometry, less the end by
    /// its odometry; exact.
    fn error_m(way: f64, side_m: f64, track_m: f64, true_track_m: f64, ratio: f64) -> [f64; 2] {
        let (mut x, mut y, mut h) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut roll = |left_m: f64, right_m: f64| {
            // The mean of the true radii is the nominal one.
            let (left_m, right_m) =
                (left_m * 2.0 / (1.0 + ratio), right_m * 2.0 * ratio / (1.0 + ratio));
            let (s, turn) = ((left_m + right_m) / 2.0, (right_m - left_m) / true_track_m);
            let chord = if turn == 0.0 { s } else { s * (turn / 2.0).sin() / (turn / 2.0) };
            x += chord * (h + turn / 2.0).cos();
            y += chord * (h + turn / 2.0).sin();
            h += turn;
        };
        for _ in 0..4 {
            roll(side_m, side_m);
            let rim_m = way * FRAC_PI_2 * track_m / 2.0;
            roll(-rim_m, rim_m);
        }
        [x, y]
    }

    #[test]
    fn squares_both_ways_tell_the_wheels_from_the_track() {
        let in_use = Config::default().geometry;
        for (true_track_m, ratio) in [(0.380, 1.0), (0.372, 1.005), (0.368, 0.994)] {
            let errors = |way: f64| vec![error_m(way, 1.0, 0.372, true_track_m, ratio); 2];
            let systematic = Systematic::new(errors(1.0), errors(-1.0), 1.0, 0.372);
            let corrected = systematic.corrected(&in_use);
            // First order: the residual is of the order of the error squared, 5 % of a 2 % error.
            let (track, weight) =
                (corrected.track_width_m / true_track_m, corrected.wheel_weight / ratio);
            assert!((track - 1.0).abs() < 1e-3, "{track} {systematic:?}");
            assert!((weight - 1.0).abs() < 3e-4, "{weight} {systematic:?}");
            let mean = corrected.wheel_radius_m * (1.0 + corrected.wheel_weight) / 2.0;
            assert!((mean / 0.036 - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_perfect_robot_has_no_systematic_error_and_is_left_alone() {
        let Systematic { error_m, wheel_ratio, track_ratio, .. } =
            Systematic::new(vec![[0.0; 2]; 5], vec![[0.0; 2]; 5], 4.0, 0.3);
        assert_eq!((error_m, wheel_ratio, track_ratio), (0.0, 1.0, 1.0));
    }
}
