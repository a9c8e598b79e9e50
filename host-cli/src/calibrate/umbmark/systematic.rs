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
//! The mean of both radii stays: a closed path says nothing about it. Four coordinates, two unknowns: what
//! radii and track cannot make is left over,
//!
//! ```text
//! stray:  left e (1, 1) / 2,  right e (1, -1) / 2                                       (6)
//! ```
//!
//! What a part that is corrected may still be off by is its noise and, as what strays with the correction, what else moves the
//! ends; one that is not corrected may be off by all of itself too. By the derivatives of (3) and (4), with s_a and s_beta such
//! parts over 2 L,
//!
//! ```text
//! sd_b = b s_a / (pi/2),   sd_W = W_T b s_beta / L                                     (7)
//! ```
//!
//! A floor that carries the robot by d on the whole way adds d to both ends, half of it along (1) and (2),
//! half along (6): the stray part is as large as the error that it makes in a and beta. Source: Borenstein and Feng,
//! UMBmark: a benchmark test for measuring odometry errors in mobile robots, 1995; (1) and (2) are
//! derived anew for turns to the left positive, and use both coordinates.

use std::f64::consts::{FRAC_PI_2, SQRT_2};

use shared_proto::{GeometryConfig, OdometryConfig};

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
    /// The part of the ends that unequal radii make, 2 L beta \[m\].
    pub wheel_part_m: f64,
    /// The part of the ends that a wrong track width makes, 2 L a \[m\].
    pub track_part_m: f64,
    /// The part that neither makes (6), root mean square of both ways \[m\].
    pub stray_m: f64,
    /// Standard error of each part, from the scatter of the squares; zero if there is one each way \[m\].
    pub noise_m: f64,
}

/// Parts that stand out by fewer standard errors are noise.
const SIGMAS: f64 = 3.0;
/// Squares whose stray part is more than this share of what they correct contradict the correction.
const STRAY_SHARE: f64 = 0.25;
/// Ends that stray by less than this are closed for any purpose \[m\].
const NEGLIGIBLE_M: f64 = 0.002;

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
        let [sum_m, difference_m] = [(left[0] - left[1]) / 2.0, (right[0] + right[1]) / 2.0];
        let track_part_m = (sum_m + difference_m) / 2.0;
        let wheel_part_m = (sum_m - difference_m) / 2.0;
        let (a, beta) = (track_part_m / (2.0 * side_m), wheel_part_m / (2.0 * side_m));
        let stray_m = ((left[0] + left[1]) / 2.0).hypot((right[0] - right[1]) / 2.0) / SQRT_2;
        let half = side_m / 2.0;
        // (4), with the fraction cleared of the infinite radius of a straight leg.
        let bend = track_m / 2.0 * (beta / 2.0).sin();
        Self {
            error_m: left[0].hypot(left[1]).max(right[0].hypot(right[1])),
            wheel_ratio: (half + bend) / (half - bend),
            track_ratio: FRAC_PI_2 / (FRAC_PI_2 + a),
            wheel_part_m,
            track_part_m,
            stray_m,
            noise_m: noise_m(&[(&left_m, left), (&right_m, right)]),
            left_m,
            right_m,
        }
    }

    /// Whether more of the ends is stray than a correction can be trusted with: beyond noise, and more than a quarter
    /// of what radii and track make. The second order, which (1) and (2) leave out, is a tenth of that.
    pub fn is_contradicted(&self) -> bool {
        let least_m = SIGMAS * self.noise_m;
        let made_m = self.wheel_part_m.abs().max(self.track_part_m.abs());
        self.stray_m > least_m.max(NEGLIGIBLE_M) && self.stray_m > STRAY_SHARE * made_m
    }

    /// Whether a part stands out from noise and from what is stray.
    fn stands_out(&self, part_m: f64) -> bool {
        part_m.abs() > (SIGMAS * self.noise_m).max(self.stray_m)
    }

    /// Whether neither radii nor track stand out: there is nothing to correct.
    pub fn is_square(&self) -> bool {
        !self.stands_out(self.wheel_part_m) && !self.stands_out(self.track_part_m)
    }

    /// The geometry corrected by (3) and (4) where that stands out, with the mean radius as before.
    pub fn corrected(&self, in_use: &GeometryConfig) -> GeometryConfig {
        let told = |part_m: f64, ratio: f64| if self.stands_out(part_m) { ratio } else { 1.0 };
        let wheel_weight = in_use.wheel_weight * told(self.wheel_part_m, self.wheel_ratio);
        GeometryConfig {
            wheel_radius_m: in_use.wheel_radius_m * (1.0 + in_use.wheel_weight)
                / (1.0 + wheel_weight),
            wheel_weight,
            track_width_m: in_use.track_width_m * told(self.track_part_m, self.track_ratio),
            ..*in_use
        }
    }

    /// How sure a corrected geometry is (7), from the squares with it.
    pub fn deviations(
        &self,
        after: &Self,
        in_use: &OdometryConfig,
        corrected: &GeometryConfig,
        side_m: f64,
    ) -> OdometryConfig {
        let sd = |part_m: f64, after_m: f64| {
            let left_m = if self.stands_out(part_m) { 0.0 } else { after_m };
            self.noise_m.hypot(after.stray_m).hypot(left_m) / (2.0 * side_m)
        };
        let (track_m, weight) = (corrected.track_width_m, corrected.wheel_weight);
        let wheel_sd = sd(self.wheel_part_m, after.wheel_part_m);
        let track_sd = sd(self.track_part_m, after.track_part_m);
        OdometryConfig {
            wheel_weight_sd: weight * track_m * wheel_sd / side_m,
            track_width_sd_m: track_m * track_sd / FRAC_PI_2,
            ..*in_use
        }
    }
}

/// Standard error of a part, which is a quarter of the sum of four means: of both coordinates, both ways.
fn noise_m(ways: &[(&Vec<[f64; 2]>, [f64; 2])]) -> f64 {
    let (mut squares, mut freedom, mut squares_driven) = (0.0, 0, 0);
    for (ends, mean) in ways {
        let off = |end: &[f64; 2]| (end[0] - mean[0]).powi(2) + (end[1] - mean[1]).powi(2);
        squares += ends.iter().map(off).sum::<f64>();
        freedom += 2 * ends.len().saturating_sub(1);
        squares_driven += ends.len();
    }
    if freedom == 0 {
        return 0.0;
    }
    // Of one coordinate of one square; a mean of n of them has an n-th of it.
    let variance = squares / freedom as f64;
    (variance / (2.0 * squares_driven as f64)).sqrt()
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
    fn a_floor_that_carries_the_robot_contradicts_radii_and_track() {
        // A ratio of 0.9917, and 52 mm to the left on the way, whichever way the squares are turned.
        let errors = |way: f64, carried_m: f64| {
            let [x_m, y_m] = error_m(way, 1.0, 0.372, 0.372, 0.9917);
            vec![[x_m, y_m + carried_m]; 5]
        };
        let squares = |carried_m: f64| {
            Systematic::new(errors(1.0, carried_m), errors(-1.0, carried_m), 1.0, 0.372)
        };
        let carried = squares(0.052);
        assert!(carried.is_contradicted(), "{carried:?}");
        // (6): as large as the error of W_T.
        let wrong_m = carried.wheel_part_m - squares(0.0).wheel_part_m;
        assert!((carried.stray_m / wrong_m.abs() - 1.0).abs() < 0.05, "{carried:?} {wrong_m}");
        assert!(!squares(0.0).is_contradicted() && !squares(0.005).is_contradicted());
    }

    #[test]
    fn what_does_not_stand_out_is_not_corrected() {
        let in_use = Config::default().geometry;
        // A track 1 % wide, and half a millimetre of scatter, which W_T would follow.
        let errors = |way: f64| {
            let [x_m, y_m] = error_m(way, 1.0, 0.372, 0.3757, 1.0);
            vec![[x_m + 0.001, y_m], [x_m - 0.001, y_m + 0.0004], [x_m, y_m + 0.0008]]
        };
        let squares = Systematic::new(errors(1.0), errors(-1.0), 1.0, 0.372);
        assert!(!squares.is_square() && !squares.is_contradicted(), "{squares:?}");
        let corrected = squares.corrected(&in_use);
        assert_eq!(corrected.wheel_weight, in_use.wheel_weight);
        assert!((corrected.track_width_m / 0.3757 - 1.0).abs() < 1e-3, "{corrected:?}");
    }

    #[test]
    fn a_corrected_geometry_is_as_sure_as_other_squares_would_repeat_it() {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(95);
        let in_use = Config::default();
        let (sets, mut off, mut said) = (300, [0.0; 2], [0.0; 2]);
        for _ in 0..sets {
            let mut ends = |way: f64, track_m: f64, weight: f64| -> Vec<[f64; 2]> {
                let [x_m, y_m] = error_m(way, 1.0, track_m, 0.3757, 0.9917 / weight);
                let mut scattered = |m: f64| m + rng.random_range(-0.01..0.01);
                (0..5).map(|_| [scattered(x_m), scattered(y_m)]).collect()
            };
            let mut set = |track_m: f64, weight: f64| {
                let [left, right] = [1.0, -1.0].map(|way| ends(way, track_m, weight));
                Systematic::new(left, right, 1.0, track_m)
            };
            let before = set(0.372, 1.0);
            let corrected = before.corrected(&in_use.geometry);
            let after = set(corrected.track_width_m, corrected.wheel_weight);
            let odometry = before.deviations(&after, &in_use.odometry, &corrected, 1.0);
            assert_eq!(odometry.noise_m_per_sqrt_m, in_use.odometry.noise_m_per_sqrt_m);
            let errors = [corrected.wheel_weight - 0.9917, corrected.track_width_m - 0.3757];
            let sds = [odometry.wheel_weight_sd, odometry.track_width_sd_m];
            for i in 0..2 {
                off[i] += errors[i] * errors[i];
                said[i] += sds[i] * sds[i];
            }
        }
        for (off, said) in off.into_iter().zip(said) {
            let ratio = (said / off).sqrt();
            println!("said {:.6}, off {:.6}", (said / 300.0).sqrt(), (off / 300.0).sqrt());
            // The scatter is in the error as noise, and in what is said also as what strays, which has twice the variance:
            // the root of 3, and 300 sets give each side to 4 %.
            assert!((1.5..2.0).contains(&ratio), "{ratio}");
        }
    }

    #[test]
    fn a_perfect_robot_has_no_systematic_error_and_is_left_alone() {
        let perfect = Systematic::new(vec![[0.0; 2]; 5], vec![[0.0; 2]; 5], 4.0, 0.3);
        let Systematic { error_m, wheel_ratio, track_ratio, .. } = perfect;
        assert_eq!((error_m, wheel_ratio, track_ratio), (0.0, 1.0, 1.0));
        assert!(perfect.is_square() && !perfect.is_contradicted());
    }
}
