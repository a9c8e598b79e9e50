//! How sure dead reckoning is: the covariance of the pose, from what the wheels scatter by and the geometry is known to.
//!
//! It follows the pose outside the control tick, once a wheel has gone a centimetre: a count that flickers while the
//! robot stands is no way, and adds nothing. Between two steps the path is taken for an arc.
//!
//! ```text
//! random:      q_i = n^2 |dS_i|                                       variance of wheel i's way dS_i            (1)
//!              P   = F P F' + q_L g_L g_L' + q_R g_R g_R'             P of (x, y, heading)                      (2)
//! systematic:  w   = F w + g_R dS_R sd_W / W_T                        what one sd of W_T does to the pose       (3)
//!              v   = F v - h (dS_R - dS_L) / b  sd_b / b              what one sd of b does to it               (4)
//! covariance:  P + w w' + v v'                                                                                  (5)
//!
//! F = (1 0 -dy; 0 1 dx; 0 0 1)        the heading turns all that follows it, so by the way (dx, dy) of the step
//! h = (-dy / 2, dx / 2, 1)            what a turn of the step does                                              (6)
//! g_i = (cos phi / 2, sin phi / 2, 0) -+ h / b                                                                  (7)
//! ```
//!
//! phi is the heading halfway, b the track width. (6) and (7) are the derivatives of the step in
//! [`dead_reckoning`](crate::dead_reckoning), without what is too small to matter: a share of d theta / 3 of (6), which is
//! half a step, of d theta^2 / 24 of (7), and in (7) the pull c, a share of b c / 2. w and v are sums along the path, so what a
//! wrong geometry displaces on the way out comes back on the way back; what is random adds up. As in Kelly, Some useful results
//! for closed-form propagation of error in vehicle odometry, CMU-RI-TR-00-20, 2000.
//!
//! Not in it: the radius of the left wheel, a slip that the noise does not stand for, a push.
//!
//! In `f32`, which the chip computes in hardware: a step rounds by 6e-8 of what there is, so after 10 km the deviations are good
//! to 2 %. Ways are differences of whole numbers, and exact before they are rounded.

use fixed::types::I32F32;
use shared_proto::{Config, Pose, PoseDeviation, WheelPair};

use crate::dead_reckoning::sin_cos;
use crate::soft_float::{nearest, to_f64};
use crate::units::Travel;

/// A step follows once a wheel has gone this far \[m\]: farther than a count flickers, and a small turn for any robot.
const STEP_M: f32 = 0.01;

/// What the configuration says of its own numbers, and what (2) to (7) need of these.
#[derive(Clone, Copy, Debug)]
pub struct Uncertainty {
    /// 1 / b \[1/m\].
    per_track: f32,
    /// n^2 \[m\].
    noise: f32,
    /// sd_W / W_T.
    weight_share: f32,
    /// sd_b / b.
    track_share: f32,
}

impl Uncertainty {
    /// Of a robot whose travel says nothing: what does not move the pose adds nothing.
    const NONE: Self = Self { per_track: 0.0, noise: 0.0, weight_share: 0.0, track_share: 0.0 };

    /// Of a valid configuration.
    pub fn new(config: &Config) -> Self {
        let (geometry, odometry) = (&config.geometry, &config.odometry);
        let noise = single(odometry.noise_m_per_sqrt_m);
        let per_track = 1.0 / single(geometry.track_width_m);
        Self {
            per_track,
            noise: noise * noise,
            weight_share: single(odometry.wheel_weight_sd) / single(geometry.wheel_weight),
            track_share: single(odometry.track_width_sd_m) * per_track,
        }
    }
}

/// Follows the pose.
#[derive(Clone, Debug)]
pub struct PoseCovariance {
    known: Uncertainty,
    /// P (2).
    random: Matrix,
    /// w (3) and v (4).
    systematic: [[f32; 3]; 2],
    /// Up to where it has followed.
    travel: WheelPair<Travel>,
    pose: Pose,
}

impl Default for PoseCovariance {
    fn default() -> Self {
        Self::new()
    }
}

impl PoseCovariance {
    /// Sure; follows nothing yet.
    pub const fn new() -> Self {
        Self {
            known: Uncertainty::NONE,
            random: Matrix([0.0; 6]),
            systematic: [[0.0; 3]; 2],
            travel: WheelPair::both(Travel(I32F32::ZERO)),
            pose: Pose { x_um: 0, y_um: 0, heading_urad: 0 },
        }
    }

    /// Stays as it is, whatever the travel does, until it adopts a configuration.
    pub fn pause(&mut self) {
        self.known = Uncertainty::NONE;
    }

    /// Goes on with another configuration, in which the wheels' travel is this. What was systematic until now is
    /// independent of what will be, and so becomes part of P.
    pub fn adopt(&mut self, known: Uncertainty, travel: WheelPair<Travel>, pose: Pose) {
        for column in &mut self.systematic {
            self.random.add(column, 1.0);
            *column = [0.0; 3];
        }
        self.known = known;
        (self.travel, self.pose) = (travel, pose);
    }

    /// How sure the pose is, as it was a centimetre of a wheel's way ago at most.
    pub fn deviation(&self) -> PoseDeviation {
        // (5)
        let mut total = self.random;
        for column in &self.systematic {
            total.add(column, 1.0);
        }
        total.deviation()
    }

    /// The wheels' travel and the pose are now these.
    #[inline(never)]
    pub fn step(&mut self, travel: WheelPair<Travel>, now: Pose) {
        let known = &self.known;
        // Steps of 2^-28 m, of which 32 bits hold 8 m.
        let way_m = travel.zip(self.travel).map(|(Travel(now), Travel(before))| {
            let steps = now.to_bits().wrapping_sub(before.to_bits()) >> 4;
            steps as i32 as f32 * (1.0 / 268_435_456.0)
        });
        if !way_m.any(|way_m| way_m.abs() >= STEP_M) {
            return;
        }
        let before = self.pose;
        (self.travel, self.pose) = (travel, now);
        let micro = |now: i64, before: i64| now.wrapping_sub(before) as i32 as f32 * 1e-6;
        let arm = [-micro(now.y_um, before.y_um), micro(now.x_um, before.x_um), 0.0];
        let (sin, cos) = sin_cos(to_f64(now.heading_urad + before.heading_urad) * 0.5e-6);

        // (6), (7): what a metre of both wheels does, and what a metre of the right one more and of the left one less.
        let both = [0.5 * single(cos), 0.5 * single(sin), 0.0];
        let mut turn = [0.0, 0.0, known.per_track];
        add(&mut turn, &arm, 0.5 * known.per_track);
        let (mut left, mut right) = (both, both);
        add(&mut left, &turn, -1.0);
        add(&mut right, &turn, 1.0);
        // (2)
        self.random.turn(&arm);
        self.random.add(&left, known.noise * way_m.left.abs());
        self.random.add(&right, known.noise * way_m.right.abs());
        // (3), (4)
        let [weight, track] = &mut self.systematic;
        for sums in [&mut *weight, &mut *track] {
            let heading = sums[2];
            add(sums, &arm, heading);
        }
        add(weight, &right, known.weight_share * way_m.right);
        add(track, &turn, known.track_share * (way_m.left - way_m.right));
    }
}

/// Adds another column times a share.
#[inline(never)]
fn add(column: &mut [f32; 3], other: &[f32; 3], share: f32) {
    for (sum, term) in column.iter_mut().zip(other) {
        *sum += share * term;
    }
}

/// A symmetric matrix over x, y and heading: xx, xy, yy, x heading, y heading, heading heading.
#[derive(Clone, Copy, Debug)]
struct Matrix([f32; 6]);

impl Matrix {
    /// Becomes F P F'.
    fn turn(&mut self, &[to_x, to_y, _]: &[f32; 3]) {
        let [xx, xy, yy, xh, yh, hh] = self.0;
        let (x, y) = (xh + to_x * hh, yh + to_y * hh);
        self.0 = [xx + to_x * (xh + x), xy + to_y * xh + to_x * y, yy + to_y * (yh + y), x, y, hh];
    }

    /// Adds a column times itself times a weight.
    #[inline(never)]
    fn add(&mut self, &[x, y, h]: &[f32; 3], weight: f32) {
        let [wx, wy, wh] = [x * weight, y * weight, h * weight];
        for (sum, term) in self.0.iter_mut().zip([wx * x, wx * y, wy * y, wx * h, wy * h, wh * h]) {
            *sum += term;
        }
    }

    /// As the telemetry has it.
    #[inline(never)]
    fn deviation(&self) -> PoseDeviation {
        /// Correlations as sent are this much of 1/8191 smaller, so that rounding them down never makes a matrix that is no
        /// covariance: it moves an eigenvalue by two steps at most, and this adds four to it.
        const ONE: f32 = 8187.0;
        let [xx, xy, yy, xh, yh, hh] = self.0;
        let [x, y, h] = [xx, yy, hh].map(root);
        let micro = |sd: f32| (sd * 1e6) as u32;
        // 0 / 0 becomes 0.
        let share = |product: f32, a: f32, b: f32| {
            ((product / (a * b) * ONE) as i32).clamp(-ONE as i32, ONE as i32) as i16
        };
        PoseDeviation {
            x_um: micro(x),
            y_um: micro(y),
            heading_urad: micro(h),
            x_y: share(xy, x, y),
            x_heading: share(xh, x, h),
            y_heading: share(yh, y, h),
        }
    }
}

/// A number within 8 as `f32`, to 2^-29 at worst: the compiler's conversion would be one more routine in the image.
#[inline(never)]
fn single(value: f64) -> f32 {
    nearest(value, 28) as i32 as f32 * (1.0 / 268_435_456.0)
}

/// The square root; 0 of what is not above 2^-126. `core` has none.
#[inline(never)]
fn root(value: f32) -> f32 {
    if value < f32::MIN_POSITIVE {
        return 0.0;
    }
    // Halving the exponent gives 6 % accuracy, and each Newton step doubles the digits: 2e-6.
    let mut root = f32::from_bits((value.to_bits() >> 1) + (127 << 22));
    for _ in 0..2 {
        root = 0.5 * (root + value / root);
    }
    root
}

#[cfg(test)]
mod tests;
