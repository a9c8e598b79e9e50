//! The state of the filter in [`crate::estimation::ekf`], and its covariance: predict, add process noise, update.
//!
//! ```text
//! x = (x, y, theta, e_x, e_y, e_theta, psi, tau)
//! ```

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::recording::odometry_noise::OdometryNoise;

/// Numbers of the state.
pub(crate) const STATES: usize = 8;
/// Of them, psi: the sensor's heading less that of the robot \[rad\].
pub(crate) const PSI: usize = 6;
/// Of them, tau: how late the sensor's clock is in this run \[s\].
const TAU: usize = 7;

/// Which number of a pose was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    X,
    Y,
    Heading,
}

/// The state and its covariance.
#[derive(Clone, Debug)]
pub(crate) struct State {
    pub pose: Pose,
    /// e.
    wobble: [f64; 3],
    /// psi and tau.
    run: [f64; 2],
    covariance: [[f64; STATES]; STATES],
}

/// One number measured, as a linear function of the state: H of equation (2).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading {
    axis: usize,
    lever: f64,
    by_psi: f64,
    by_tau: f64,
}

impl Reading {
    /// H times a column of numbers, one for each state.
    pub fn along(&self, column: &[f64; STATES]) -> f64 {
        column[self.axis]
            + column[self.axis + 3]
            + self.lever * column[2]
            + self.by_psi * column[PSI]
            + self.by_tau * column[TAU]
    }
}

/// An innovation with everything that the update needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Update {
    pub reading: Reading,
    /// nu.
    pub nu: f64,
    /// s.
    pub variance: f64,
    /// K.
    pub gain: [f64; STATES],
    /// P H'.
    ph: [f64; STATES],
}

/// One measured number, and how it depends on the state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScalarMeasurement {
    pub quantity: Quantity,
    pub measured: f64,
    /// The measured point relative to the pose, in the fixed frame, and its derivative by the heading \[m\].
    pub offset: [f64; 2],
    pub by_heading: [f64; 2],
    /// In the fixed frame \[m/s, m/s, rad/s\].
    pub velocity: [f64; 3],
}

impl State {
    pub fn new(pose: Pose) -> Self {
        Self { pose, wobble: [0.0; 3], run: [0.0; 2], covariance: [[0.0; STATES]; STATES] }
    }

    /// Equation (1) of the state: moved to a pose that depends by (gx, gy) on the heading, e faded.
    pub fn predict(&mut self, there: Pose, [gx, gy]: [f64; 2], fade: f64) {
        self.wobble = self.wobble.map(|error| error * fade);
        let p = &mut self.covariance;
        // P F' then F P F', with x and y moved by (gx, gy) theta, and e faded.
        for row in p.iter_mut() {
            row[0] += gx * row[2];
            row[1] += gy * row[2];
            row[3] *= fade;
            row[4] *= fade;
            row[5] *= fade;
        }
        let turned = p[2];
        for (j, from_heading) in turned.into_iter().enumerate() {
            p[0][j] += gx * from_heading;
            p[1][j] += gy * from_heading;
        }
        p[3..PSI].iter_mut().flatten().for_each(|entry| *entry *= fade);
        self.pose = there;
    }

    /// Q of equation (1): the random walk along the rolling, and what renews e after fading.
    pub fn add_process_noise(&mut self, noise: &OdometryNoise, rolled_m: f64, fade: f64) {
        let p = &mut self.covariance;
        let renewed = 1.0 - fade * fade;
        p[3][3] += renewed * noise.position_wobble_m.powi(2);
        p[4][4] += renewed * noise.position_wobble_m.powi(2);
        p[5][5] += renewed * noise.heading_wobble_rad.powi(2);
        p[0][0] += noise.travel_variance_m2(rolled_m);
        p[1][1] += noise.travel_variance_m2(rolled_m);
        p[2][2] += noise.heading_variance_rad2(rolled_m);
    }

    /// The share of the heading's random walk in the position, for a motion of so many even steps: (gx, gy) is the
    /// derivative of its end by the heading at its beginning.
    pub fn couple_heading_noise(
        &mut self,
        noise: &OdometryNoise,
        rolled_m: f64,
        g: [f64; 2],
        steps: f64,
    ) {
        let variance = noise.heading_variance_rad2(rolled_m);
        let before = (steps - 1.0).max(0.0) / steps.max(1.0);
        let place = before * (2.0 - 1.0 / steps.max(1.0)) / 6.0 * variance;
        let shared = before / 2.0 * variance;
        let p = &mut self.covariance;
        for i in 0..2 {
            for j in 0..2 {
                p[i][j] += g[i] * g[j] * place;
            }
            p[i][2] += g[i] * shared;
            p[2][i] += g[i] * shared;
        }
    }

    /// The covariance at the first measured pose. `by_heading` is that of a [`ScalarMeasurement`].
    pub fn start(
        &mut self,
        noise: &OdometryNoise,
        heading_sigma_rad: f64,
        by_heading: [f64; 2],
        velocity: [f64; 3],
    ) {
        let heading_var = heading_sigma_rad * heading_sigma_rad;
        let position_var = noise.position_sigma_m * noise.position_sigma_m;
        let wobble_var =
            [noise.position_wobble_m, noise.heading_wobble_rad].map(|sigma| sigma * sigma);
        // pose = z - offset(theta) - e - psi - noise + tau velocity: the uncertainty of each of these is part of
        // that of the pose.
        let psi_var = noise.heading_offset_rad.powi(2);
        let tau_var = noise.clock_offset_s.powi(2);
        let independent = [position_var + wobble_var[0], heading_var + wobble_var[1] + psi_var];
        let lever = [-by_heading[0], -by_heading[1], 1.0];
        // A later clock means a pose further on; the velocity of the pose is that of the point less the share of
        // its lever.
        let later: [f64; 3] = core::array::from_fn(|i| {
            if i < 2 { velocity[i] + lever[i] * velocity[2] } else { velocity[2] }
        });
        for i in 0..3 {
            for j in 0..3 {
                self.covariance[i][j] =
                    lever[i] * lever[j] * independent[1] + later[i] * later[j] * tau_var;
            }
            let shared = [
                (5, -lever[i] * wobble_var[1]),
                (PSI, -lever[i] * psi_var),
                (TAU, later[i] * tau_var),
            ];
            for (state, covariance) in shared {
                self.covariance[i][state] = covariance;
                self.covariance[state][i] = covariance;
            }
        }
        for i in 0..2 {
            self.covariance[i][i] += independent[0];
            self.covariance[3 + i][3 + i] = wobble_var[0];
            self.covariance[i][3 + i] = -wobble_var[0];
            self.covariance[3 + i][i] = -wobble_var[0];
        }
        self.covariance[5][5] = wobble_var[1];
        self.covariance[PSI][PSI] = psi_var;
        self.covariance[TAU][TAU] = tau_var;
    }

    /// Equation (2) of the state.
    pub fn innovation(&self, noise: &OdometryNoise, scalar: &ScalarMeasurement) -> Update {
        let ScalarMeasurement { quantity, measured, offset, by_heading, velocity } = *scalar;
        let [ex, ey, turned] = self.wobble;
        let [psi, tau] = self.run;
        let position_var = noise.position_sigma_m * noise.position_sigma_m;
        let heading_var = noise.heading_sigma_rad * noise.heading_sigma_rad;
        // dh/dx has a one at the quantity and one at its e; a position has its lever, a heading psi.
        let (axis, lever, by_psi, noise_var, nu) = match quantity {
            Quantity::X => {
                (0, by_heading[0], 0.0, position_var, measured - self.pose.x_m - offset[0] - ex)
            }
            Quantity::Y => {
                (1, by_heading[1], 0.0, position_var, measured - self.pose.y_m - offset[1] - ey)
            }
            Quantity::Heading => {
                let nu = wrap(measured - self.pose.heading_rad - turned - psi);
                (2, 0.0, 1.0, heading_var, nu)
            }
        };
        let by_tau = -velocity[axis];
        let nu = nu - by_tau * tau;
        let reading = Reading { axis, lever, by_psi, by_tau };
        let ph: [f64; STATES] = core::array::from_fn(|i| reading.along(&self.covariance[i]));
        let variance = reading.along(&ph) + noise_var;
        let gain = ph.map(|covariance| covariance / variance);
        Update { reading, nu, variance, gain, ph }
    }

    /// Equation (3) of the state.
    pub fn update(&mut self, update: &Update) {
        let Update { nu, gain, ph, .. } = update;
        self.pose.x_m += gain[0] * nu;
        self.pose.y_m += gain[1] * nu;
        self.pose.heading_rad += gain[2] * nu;
        for i in 0..3 {
            self.wobble[i] += gain[3 + i] * nu;
        }
        self.run[0] += gain[PSI] * nu;
        self.run[1] += gain[TAU] * nu;
        for (line, k) in self.covariance.iter_mut().zip(gain) {
            line.iter_mut().zip(ph).for_each(|(p, ph)| *p -= k * ph);
        }
    }
}
