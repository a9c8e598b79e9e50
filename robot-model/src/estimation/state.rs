//! The state of the filter in [`crate::estimation::ekf`], and its covariance: predict, add process noise, update.
//!
//! ```text
//! x = (x, y, theta, e_x, e_y, e_theta, psi, tau, delta)
//! ```
//!
//! It is one state, or several beside each other that differ in their noise: the same arithmetic in every lane.

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::numeric::lanes::Number;
use crate::recording::odometry_noise::{NUMBERS, OdometryNoise};

/// Numbers of the state.
pub(crate) const STATES: usize = 9;
/// Of them, theta.
pub(crate) const THETA: usize = 2;
/// Of them, the first of e.
const E: usize = 3;
/// Of them, psi: the sensor's heading less that of the robot \[rad\].
pub(crate) const PSI: usize = 6;
/// Of them, tau: how late the sensor's clock is in the middle of this run \[s\].
const TAU: usize = 7;
/// Of them, delta: by how much later it is at the end \[s\].
const DELTA: usize = 8;

/// Which number of a pose was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    X,
    Y,
    Heading,
}

/// The noise as variances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Variances<T> {
    position: T,
    heading: T,
    /// Of the random walks, per metre of rolling.
    travel_per_m: T,
    heading_per_m: T,
    position_wobble: T,
    heading_wobble: T,
    /// A time, no variance.
    wobble_s: T,
    /// Of the yaw rate sensor's random walk, per second.
    gyro_per_s: T,
    heading_offset: T,
    clock_offset: T,
}

impl Variances<f64> {
    pub fn of(noise: &OdometryNoise) -> Self {
        Self::from_sigmas(noise.to_array())
    }
}

impl<T: Number> Variances<T> {
    /// In the order of [`OdometryNoise::to_array`].
    pub fn from_sigmas(sigmas: [T; NUMBERS]) -> Self {
        let wobble_s = sigmas[6];
        let [
            position,
            heading,
            travel_per_m,
            heading_per_m,
            position_wobble,
            heading_wobble,
            _,
            gyro_per_s,
            heading_offset,
            clock_offset,
        ] = sigmas.map(|sigma| sigma * sigma);
        Self {
            position,
            heading,
            travel_per_m,
            heading_per_m,
            position_wobble,
            heading_wobble,
            wobble_s,
            gyro_per_s,
            heading_offset,
            clock_offset,
        }
    }

    /// Of one measured heading \[rad^2\].
    pub fn heading(&self) -> T {
        self.heading
    }

    /// Of one measured heading with what fades \[rad^2\].
    pub fn whole_heading(&self) -> T {
        self.heading + self.heading_wobble
    }

    /// Of the yaw rate sensor's random walk, per second \[rad^2/s\].
    pub fn gyro_per_s(&self) -> T {
        self.gyro_per_s
    }

    /// Correlation of e over a time.
    pub fn wobble_fade(&self, t_s: f64) -> T {
        (T::of(-t_s) / self.wobble_s).each(f64::exp)
    }
}

/// A symmetric matrix: its lower triangle.
#[derive(Clone, Debug)]
struct Symmetric<T>([[T; STATES]; STATES]);

impl<T: Number> Symmetric<T> {
    fn at(&self, i: usize, j: usize) -> T {
        self.0[i.max(j)][i.min(j)]
    }

    fn of(&mut self, i: usize, j: usize) -> &mut T {
        &mut self.0[i.max(j)][i.min(j)]
    }
}

/// The state and its covariance.
#[derive(Clone, Debug)]
pub(crate) struct State<T> {
    mean: [T; STATES],
    covariance: Symmetric<T>,
}

/// One number measured, as a linear function of the state: H of equation (2).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading<T> {
    axis: usize,
    lever: T,
    by_psi: T,
    by_tau: T,
    by_delta: T,
}

impl<T: Number> Reading<T> {
    /// H times a column of numbers, one for each state.
    #[inline(always)]
    pub fn along(&self, of_state: impl Fn(usize) -> T) -> T {
        of_state(self.axis)
            + of_state(self.axis + E)
            + self.lever * of_state(THETA)
            + self.by_psi * of_state(PSI)
            + self.by_tau * of_state(TAU)
            + self.by_delta * of_state(DELTA)
    }
}

/// An innovation with everything that the update needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Update<T> {
    pub reading: Reading<T>,
    /// nu.
    pub nu: T,
    /// s.
    pub variance: T,
    /// K.
    pub gain: [T; STATES],
    /// P H'.
    ph: [T; STATES],
}

/// One measured number, and how it depends on the state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScalarMeasurement<T> {
    pub quantity: Quantity,
    pub measured: f64,
    /// The measured point relative to the pose, in the fixed frame, and its derivative by the heading \[m\].
    pub offset: [T; 2],
    pub by_heading: [T; 2],
    /// In the fixed frame \[m/s, m/s, rad/s\].
    pub velocity: [T; 3],
    /// When in the run: -1 at its first pose, 1 at its last.
    pub when: f64,
}

impl State<f64> {
    pub fn pose(&self) -> Pose {
        let [x_m, y_m, heading_rad, ..] = self.mean;
        Pose::new(x_m, y_m, heading_rad)
    }
}

impl<T: Number> State<T> {
    pub fn new(pose: [T; 3]) -> Self {
        let covariance = Symmetric([[T::of(0.0); STATES]; STATES]);
        let mut state = Self { mean: [T::of(0.0); STATES], covariance };
        state.set_pose(pose);
        state
    }

    pub fn set_pose(&mut self, pose: [T; 3]) {
        self.mean[..E].copy_from_slice(&pose);
    }

    pub fn position_m(&self) -> [T; 2] {
        [self.mean[0], self.mean[1]]
    }

    pub fn heading_rad(&self) -> T {
        self.mean[THETA]
    }

    /// Equation (1) of the state: moved to a pose that depends by (gx, gy) on the heading, e faded.
    pub fn predict(&mut self, there: [T; 3], g: [T; 2], fade: T) {
        self.set_pose(there);
        for error in &mut self.mean[E..PSI] {
            *error *= fade;
        }
        // F P F', with x and y moved by (gx, gy) theta.
        let p = &mut self.covariance;
        let turned: [T; STATES] = core::array::from_fn(|j| p.at(THETA, j));
        for (i, g_i) in g.into_iter().enumerate() {
            for j in 0..=i {
                *p.of(i, j) += g_i * turned[j] + g[j] * (turned[i] + g_i * turned[THETA]);
            }
            for (j, from_heading) in turned.into_iter().enumerate().skip(THETA) {
                *p.of(i, j) += g_i * from_heading;
            }
        }
        // And e faded.
        for i in E..STATES {
            for j in 0..=i.min(PSI - 1) {
                let both = (E..PSI).contains(&i) && j >= E;
                if both {
                    *p.of(i, j) *= fade * fade;
                } else if (E..PSI).contains(&i) || j >= E {
                    *p.of(i, j) *= fade;
                }
            }
        }
    }

    /// Q of equation (1): the random walk along the rolling, and what renews e after fading.
    pub fn add_process_noise(&mut self, noise: &Variances<T>, rolled_m: f64, fade: T) {
        let renewed = T::of(1.0) - fade * fade;
        let rolled_m = T::of(rolled_m);
        let position = renewed * noise.position_wobble;
        let added = [
            noise.travel_per_m * rolled_m,
            noise.travel_per_m * rolled_m,
            noise.heading_per_m * rolled_m,
            position,
            position,
            renewed * noise.heading_wobble,
        ];
        for (i, variance) in added.into_iter().enumerate() {
            *self.covariance.of(i, i) += variance;
        }
    }

    /// The share of the heading's random walk in the position, for a motion of so many even steps: (gx, gy) is the
    /// derivative of its end by the heading at its beginning.
    pub fn couple_heading_noise(
        &mut self,
        noise: &Variances<T>,
        rolled_m: f64,
        g: [T; 2],
        steps: f64,
    ) {
        let before = (steps - 1.0).max(0.0) / steps.max(1.0);
        let variance = noise.heading_per_m * T::of(rolled_m);
        let place = T::of(before * (2.0 - 1.0 / steps.max(1.0)) / 6.0) * variance;
        let shared = T::of(before / 2.0) * variance;
        let p = &mut self.covariance;
        for i in 0..2 {
            for j in 0..=i {
                *p.of(i, j) += g[i] * g[j] * place;
            }
            *p.of(THETA, i) += g[i] * shared;
        }
    }

    /// The covariance at the first measured pose. `by_heading` is that of a [`ScalarMeasurement`]; where no heading was
    /// measured, its variance is that of the start's estimated one.
    pub fn start(
        &mut self,
        noise: &Variances<T>,
        heading_var: T,
        by_heading: [T; 2],
        velocity: [T; 3],
    ) {
        // pose = z - offset(theta) - e - psi - noise + (tau - delta) velocity: the uncertainty of each of these is part
        // of that of the pose.
        let independent = [
            noise.position + noise.position_wobble,
            heading_var + noise.heading_wobble + noise.heading_offset,
        ];
        let lever = [-by_heading[0], -by_heading[1], T::of(1.0)];
        // A later clock means a pose further on; the velocity of the pose is that of the point less the share of
        // its lever.
        let later: [T; 3] = core::array::from_fn(|i| {
            if i < 2 { velocity[i] + lever[i] * velocity[2] } else { velocity[2] }
        });
        let p = &mut self.covariance;
        for i in 0..3 {
            for j in 0..=i {
                *p.of(i, j) = lever[i] * lever[j] * independent[1]
                    + later[i] * later[j] * (noise.clock_offset + noise.clock_offset);
            }
            *p.of(5, i) = -lever[i] * noise.heading_wobble;
            *p.of(PSI, i) = -lever[i] * noise.heading_offset;
            *p.of(TAU, i) = later[i] * noise.clock_offset;
            *p.of(DELTA, i) = -later[i] * noise.clock_offset;
        }
        for i in 0..2 {
            *p.of(i, i) += independent[0];
            *p.of(E + i, E + i) = noise.position_wobble;
            *p.of(E + i, i) = -noise.position_wobble;
        }
        *p.of(5, 5) = noise.heading_wobble;
        *p.of(PSI, PSI) = noise.heading_offset;
        *p.of(TAU, TAU) = noise.clock_offset;
        *p.of(DELTA, DELTA) = noise.clock_offset;
    }

    /// Equation (2) of the state.
    pub fn innovation(&self, noise: &Variances<T>, scalar: &ScalarMeasurement<T>) -> Update<T> {
        match scalar.quantity {
            Quantity::X => self.innovation_along::<0>(noise, scalar),
            Quantity::Y => self.innovation_along::<1>(noise, scalar),
            Quantity::Heading => self.innovation_along::<THETA>(noise, scalar),
        }
    }

    /// The same for the quantity of this axis.
    fn innovation_along<const AXIS: usize>(
        &self,
        noise: &Variances<T>,
        scalar: &ScalarMeasurement<T>,
    ) -> Update<T> {
        let ScalarMeasurement { measured, offset, by_heading, velocity, when, .. } = *scalar;
        let by_tau = -velocity[AXIS];
        let by_delta = by_tau * T::of(when);
        let left = T::of(measured) - self.mean[AXIS] - self.mean[E + AXIS];
        // dh/dx has a one at the quantity and one at its e; a position has its lever, a heading psi.
        let (lever, by_psi, noise_var, nu) = if AXIS == THETA {
            let nu = (left - self.mean[PSI]).each(wrap);
            (T::of(0.0), T::of(1.0), noise.heading, nu)
        } else {
            (by_heading[AXIS], T::of(0.0), noise.position, left - offset[AXIS])
        };
        let nu = nu - by_tau * self.mean[TAU] - by_delta * self.mean[DELTA];
        let reading = Reading { axis: AXIS, lever, by_psi, by_tau, by_delta };
        let p = &self.covariance;
        let ph: [T; STATES] = core::array::from_fn(|i| {
            let own = p.at(i, AXIS) + p.at(i, E + AXIS);
            let own = own + by_tau * p.at(i, TAU) + by_delta * p.at(i, DELTA);
            own + if AXIS == THETA { p.at(i, PSI) } else { lever * p.at(i, THETA) }
        });
        let variance = reading.along(|state| ph[state]) + noise_var;
        let weight = T::of(1.0) / variance;
        let gain = ph.map(|covariance| covariance * weight);
        Update { reading, nu, variance, gain, ph }
    }

    /// Equation (3) of the state.
    pub fn update(&mut self, update: &Update<T>) {
        let Update { nu, gain, ph, .. } = update;
        for (mean, k) in self.mean.iter_mut().zip(gain) {
            *mean += *k * *nu;
        }
        for (i, k) in gain.iter().enumerate() {
            for (p, ph) in self.covariance.0[i][..=i].iter_mut().zip(ph) {
                *p -= *k * *ph;
            }
        }
    }
}
