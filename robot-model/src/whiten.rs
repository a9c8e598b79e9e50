//! From a run's measured poses to residuals that are independent of each other, and to their
//! derivatives by every parameter, in one pass.
//!
//! A pose error grows along the way, so the errors of a track are not independent. An extended Kalman
//! filter follows the measured poses; what each measurement adds to what was known, its innovation
//! nu with variance s, is independent of the others. The same gain K runs over the sensitivities:
//!
//! ```text
//! move:     x <- f(x),  P <- F P F' + Q,            S <- F S + df/dp                     (1)
//! measure:  nu = z - h(x),  s = H P H' + r,  K = P H'/s
//!           j = H S + dh/dp                         row: (nu, j) / sqrt(s)               (2)
//!           x <- x + K nu,  P <- (1 - K H) P,       S <- S - K j                         (3)
//! ```
//!
//! The state is x = (x, y, theta, e_x, e_y, e_theta, psi, tau), S = dx/dp, h = pose(t - tau) + e + psi:
//! e is an error of the measured pose that does not add up along the way but fades within a second or
//! so, psi how far the sensor's heading is turned against the way the robot rolls, tau by how much the
//! clocks of sensor and encoders differ. Both are nuisances of a run, as its start is: drawn anew for
//! every run with a spread that [`OdometryNoise`] holds, and never evidence of anything.
//! The rows of (2) are an ordinary least squares problem in the parameters.
//! The first pose measured starts the filter: a start is a nuisance, never evidence.
//! The three numbers of a pose are measured one after the other, which is the same as together.
//!
//! The heading at which effects of the world act ([`Step::heading_rad`]) is the filter's own: how it
//! depends on the parameters is second order and left out.

use crate::effect::View;
use crate::increment::{Composer, Increment, Term};
use crate::motion::{Motion, Step};
use crate::odometry_noise::OdometryNoise;
use crate::path::{Pose, sinc};
use crate::recording::{Sight, wrap};

/// Heading noise of a start of which no heading was ever measured \[rad\].
const UNKNOWN_HEADING_SIGMA_RAD: f64 = 0.3;

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    X,
    Y,
    Heading,
}

/// One innovation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Innovation {
    /// Index of the step at whose end, or within which, it was measured.
    pub step: usize,
    /// nu.
    pub value: f64,
    /// s.
    pub variance: f64,
}

/// Takes the rows as they come.
pub(crate) trait Sink {
    /// One innovation with its whitened derivatives j / sqrt(s).
    fn row(&mut self, innovation: Innovation, whitened: &[f64]);
}

/// Numbers of the filter's state.
const STATES: usize = 8;
/// Of them, psi: the sensor's heading less that of the robot \[rad\].
const PSI: usize = 6;
/// Of them, tau: how late the sensor's clock is in this run \[s\].
const TAU: usize = 7;

/// The filter over one run.
pub(crate) struct Filter<'a> {
    composer: Composer<'a>,
    view: View,
    view_by_column: Vec<View>,
    noise: &'a OdometryNoise,
    pose: Pose,
    /// e.
    wobble: [f64; 3],
    /// psi and tau.
    run: [f64; 2],
    covariance: [[f64; STATES]; STATES],
    sensitivity: Vec<[f64; STATES]>,
    row: Vec<f64>,
}

/// Runs the filter over a run.
pub(crate) fn whiten(
    motion: &Motion,
    sights: &[Sight],
    terms: &[Term<'_>],
    columns: usize,
    noise: &OdometryNoise,
    sink: &mut impl Sink,
) {
    let Some((start, sigma_rad)) = start_pose(motion, sights, terms, noise) else {
        return;
    };
    let composer = Composer::new(terms, columns);
    let (view, view_by_column) = composer.view();
    let mut filter = Filter {
        composer,
        view,
        view_by_column,
        noise,
        pose: start,
        wobble: [0.0; 3],
        run: [0.0; 2],
        covariance: [[0.0; STATES]; STATES],
        sensitivity: vec![[0.0; STATES]; columns],
        row: vec![0.0; columns],
    };
    let delay_s = view.delay_s.value;
    let mut sights = sights.iter().skip_while(|it| it.position_m.is_none()).peekable();
    let mut started = false;
    let mut begin_s = motion.start_s;
    for (k, nominal) in motion.steps.iter().enumerate() {
        let end_s = begin_s + nominal.dt_s;
        let mut now_s = begin_s;
        let mut step = *nominal;
        step.heading_rad = filter.pose.heading_rad + nominal.turn_rad() / 2.0;
        step.place_m = [filter.pose.x_m, filter.pose.y_m];
        let increment = filter.composer.step(&step);
        while let Some(sight) = sights.peek() {
            let seen_s = sight.t_s - delay_s;
            if seen_s > end_s + TIME_ROUNDING_S {
                break;
            }
            if seen_s >= begin_s - TIME_ROUNDING_S {
                let share = ((seen_s - now_s) / nominal.dt_s).max(0.0);
                if started {
                    filter.advance(&step, &increment, share);
                    filter.measure(sight, &step, k, sink);
                } else {
                    filter.start(sight, sigma_rad, &step);
                    started = true;
                }
                now_s = seen_s.max(now_s);
            }
            sights.next();
        }
        if started {
            filter.advance(&step, &increment, ((end_s - now_s) / nominal.dt_s).max(0.0));
        }
        begin_s = end_s;
    }
}

/// Times that differ by less are the same \[s\]: sums of steps are rounded.
const TIME_ROUNDING_S: f64 = 1e-7;

/// Where the filter starts, and the noise of that heading; `None` if no position was measured.
fn start_pose(
    motion: &Motion,
    sights: &[Sight],
    terms: &[Term<'_>],
    noise: &OdometryNoise,
) -> Option<(Pose, f64)> {
    let first = sights.iter().find(|it| it.position_m.is_some())?;
    let [x_m, y_m] = first.position_m?;
    let (heading_rad, sigma_rad) = match first.heading_rad {
        Some(heading_rad) => (heading_rad, noise.heading_sigma_rad),
        None => {
            let track = crate::predict::open_loop(motion, sights, terms);
            (track.start_from_positions()?.heading_rad, UNKNOWN_HEADING_SIGMA_RAD)
        }
    };
    Some((Pose::new(x_m, y_m, heading_rad), sigma_rad))
}

/// A move by a share of an increment: where it leads, and its derivatives by the start's heading
/// and by the increment.
pub(crate) struct Move {
    pub pose: Pose,
    /// Derivative of x and y by the heading.
    pub by_heading: [f64; 2],
    /// Derivative of x and y by the turn.
    by_turn: [f64; 2],
    /// sinc(turn/2) times the unit vector ahead.
    ahead: [f64; 2],
}

impl Move {
    pub fn new(pose: Pose, increment: &Increment, share: f64) -> Self {
        let turn = increment.turn_rad * share;
        let (travel_m, sideways_m) = (increment.travel_m * share, increment.sideways_m * share);
        let half = turn / 2.0;
        let (sin, cos) = (pose.heading_rad + half).sin_cos();
        let shorter = sinc(half);
        // d sinc(u) / du = (cos u - sinc u) / u, to u^3 where that would cancel.
        let slope = if half.abs() < 1e-3 { -half / 3.0 } else { (half.cos() - shorter) / half };
        let chord = [travel_m * cos - sideways_m * sin, travel_m * sin + sideways_m * cos];
        let moved = [shorter * chord[0], shorter * chord[1]];
        Self {
            pose: Pose {
                x_m: pose.x_m + moved[0] + increment.drift_m[0] * share,
                y_m: pose.y_m + moved[1] + increment.drift_m[1] * share,
                heading_rad: pose.heading_rad + turn,
            },
            by_heading: [-moved[1], moved[0]],
            by_turn: [0.5 * (slope * chord[0] - moved[1]), 0.5 * (slope * chord[1] + moved[0])],
            ahead: [shorter * cos, shorter * sin],
        }
    }

    /// What a small change of the increment moves.
    pub fn differential(&self, change: &Increment, share: f64) -> [f64; 3] {
        let [cos, sin] = self.ahead;
        let ahead = change.travel_m * cos - change.sideways_m * sin;
        let left = change.travel_m * sin + change.sideways_m * cos;
        [
            share * (ahead + self.by_turn[0] * change.turn_rad + change.drift_m[0]),
            share * (left + self.by_turn[1] * change.turn_rad + change.drift_m[1]),
            share * change.turn_rad,
        ]
    }
}

impl Filter<'_> {
    /// Equation (1), for a share of a step.
    fn advance(&mut self, step: &Step, increment: &Increment, share: f64) {
        if share == 0.0 {
            return;
        }
        let there = Move::new(self.pose, increment, share);
        let [gx, gy] = there.by_heading;
        let fade = self.noise.wobble_fade(step.dt_s * share);
        for (s, change) in self.sensitivity.iter_mut().zip(&self.composer.by_column) {
            let moved = there.differential(change, share);
            s[0] += gx * s[2] + moved[0];
            s[1] += gy * s[2] + moved[1];
            s[2] += moved[2];
            s[3..PSI].iter_mut().for_each(|it| *it *= fade);
        }
        self.wobble = self.wobble.map(|it| it * fade);
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
        p[3..PSI].iter_mut().flatten().for_each(|it| *it *= fade);
        let renewed = 1.0 - fade * fade;
        p[3][3] += renewed * self.noise.position_wobble_m.powi(2);
        p[4][4] += renewed * self.noise.position_wobble_m.powi(2);
        p[5][5] += renewed * self.noise.heading_wobble_rad.powi(2);
        let rolled = step.wheel_travel_m();
        let rolled_m = (rolled.left.abs() + rolled.right.abs()) / 2.0 * share;
        p[0][0] += self.noise.travel_variance_m2(rolled_m);
        p[1][1] += self.noise.travel_variance_m2(rolled_m);
        p[2][2] += self.noise.heading_variance_rad2(rolled_m);
        self.pose = there.pose;
    }

    /// The measured point relative to the pose, and its derivative by the heading, whose sine and cosine
    /// are given.
    fn offset_at(&self, [sin, cos]: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let [ahead, left] = [self.view.offset_m[0].value, self.view.offset_m[1].value];
        let offset = [cos * ahead - sin * left, sin * ahead + cos * left];
        (offset, [-offset[1], offset[0]])
    }

    /// Velocity in the fixed frame \[m/s, m/s, rad/s\], smoothed: that of a single step is a count
    /// or none, and goes with the error of that same count.
    fn velocity(&self, step: &Step) -> [f64; 3] {
        let (sin, cos) = self.pose.heading_rad.sin_cos();
        let speed = step.speed_mps();
        [speed * cos, speed * sin, step.turn_rate_rad_s()]
    }

    /// The first pose: it is known to within the noise, and so are its sensitivities.
    fn start(&mut self, sight: &Sight, heading_sigma_rad: f64, step: &Step) {
        let Some(position_m) = sight.position_m else { return };
        if let Some(heading_rad) = sight.heading_rad {
            self.pose.heading_rad = heading_rad;
        }
        let (sin, cos) = self.pose.heading_rad.sin_cos();
        let (offset, by_heading) = self.offset_at([sin, cos]);
        self.pose.x_m = position_m[0] - offset[0];
        self.pose.y_m = position_m[1] - offset[1];
        let heading_var = heading_sigma_rad * heading_sigma_rad;
        let position_var = self.noise.position_sigma_m * self.noise.position_sigma_m;
        let wobble_var =
            [self.noise.position_wobble_m, self.noise.heading_wobble_rad].map(|it| it * it);
        // pose = z - offset(theta) - e - psi - noise + tau velocity: what is not known of these goes
        // into the pose as well.
        let psi_var = self.noise.heading_offset_rad.powi(2);
        let tau_var = self.noise.clock_offset_s.powi(2);
        let independent = [position_var + wobble_var[0], heading_var + wobble_var[1] + psi_var];
        let lever = [-by_heading[0], -by_heading[1], 1.0];
        let velocity = self.velocity(step);
        let later: [f64; 3] = core::array::from_fn(|i| {
            lever[i] * velocity[2] + if i < 2 { velocity[i] } else { 0.0 }
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
        for (view, s) in self.view_by_column.iter().zip(&mut self.sensitivity) {
            let slope = |quantity| view_slope(view, quantity, velocity, [sin, cos]);
            let turned = -slope(Quantity::Heading);
            *s = [0.0; STATES];
            s[0] = -slope(Quantity::X) - by_heading[0] * turned;
            s[1] = -slope(Quantity::Y) - by_heading[1] * turned;
            s[2] = turned;
        }
    }

    /// Equations (2) and (3), for each number of a pose.
    fn measure(&mut self, sight: &Sight, step: &Step, index: usize, sink: &mut impl Sink) {
        let velocity = self.velocity(step);
        let (sin, cos) = self.pose.heading_rad.sin_cos();
        let position_var = self.noise.position_sigma_m * self.noise.position_sigma_m;
        let heading_var = self.noise.heading_sigma_rad * self.noise.heading_sigma_rad;
        let quantities = [
            (Quantity::X, sight.position_m.map(|it| it[0]), position_var),
            (Quantity::Y, sight.position_m.map(|it| it[1]), position_var),
            (Quantity::Heading, sight.heading_rad, heading_var),
        ];
        for (quantity, measured, noise_var) in quantities {
            let Some(measured) = measured else { continue };
            let (offset, by_heading) = self.offset_at([sin, cos]);
            let [ex, ey, turned] = self.wobble;
            let [psi, tau] = self.run;
            // dh/dx has a one at the quantity and one at its e; a position has its lever, a heading psi.
            let (axis, lever, by_psi, nu) = match quantity {
                Quantity::X => (0, by_heading[0], 0.0, measured - self.pose.x_m - offset[0] - ex),
                Quantity::Y => (1, by_heading[1], 0.0, measured - self.pose.y_m - offset[1] - ey),
                Quantity::Heading => {
                    (2, 0.0, 1.0, wrap(measured - self.pose.heading_rad - turned - psi))
                }
            };
            let by_tau = -velocity[axis];
            let nu = nu - by_tau * tau;
            let along = |row: &[f64; STATES]| {
                row[axis] + row[axis + 3] + lever * row[2] + by_psi * row[PSI] + by_tau * row[TAU]
            };
            let ph: [f64; STATES] = core::array::from_fn(|i| along(&self.covariance[i]));
            let variance = along(&ph) + noise_var;
            let weight = 1.0 / variance.sqrt();
            let gain: [f64; STATES] = core::array::from_fn(|i| ph[i] * (weight * weight));
            for (column, s) in self.sensitivity.iter_mut().enumerate() {
                let view = &self.view_by_column[column];
                let j = along(s) + view_slope(view, quantity, velocity, [sin, cos]);
                self.row[column] = j * weight;
                s.iter_mut().zip(gain).for_each(|(s, k)| *s -= k * j);
            }
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
            sink.row(Innovation { step: index, value: nu, variance }, &self.row);
        }
    }
}

/// dh/dp of one quantity by one column's view, with the sine and cosine of the heading.
fn view_slope(view: &View, quantity: Quantity, velocity: [f64; 3], [sin, cos]: [f64; 2]) -> f64 {
    let [ahead, left] = [view.offset_m[0].value, view.offset_m[1].value];
    let delay = view.delay_s.value;
    match quantity {
        Quantity::X => cos * ahead - sin * left - velocity[0] * delay,
        Quantity::Y => sin * ahead + cos * left - velocity[1] * delay,
        Quantity::Heading => -velocity[2] * delay,
    }
}
