//! The extended Kalman filter over one run: independent residuals, and their derivatives by every parameter, in one
//! pass.
//!
//! A pose error grows along the path, so the errors of a track are not independent. The filter follows the measured
//! poses; its innovation nu with variance s is independent of all others. The same gain K acts on the sensitivities:
//!
//! ```text
//! move:     x <- f(x),  P <- F P F' + Q,            S <- F S + df/dp                     (1)
//! measure:  nu = z - h(x),  s = H P H' + r,  K = P H'/s
//!           j = H S + dh/dp                         row: (nu, j) / sqrt(s)               (2)
//!           x <- x + K nu,  P <- (1 - K H) P,       S <- S - K j                         (3)
//! ```
//!
//! The state is x = (x, y, theta, e_x, e_y, e_theta, psi, tau, delta), S = dx/dp, h = pose(t - tau - delta u) + e + psi:
//! e is a coloured error of the measured pose, which fades within a second or so instead of growing along the path;
//! psi is the angle between the sensor's heading and the robot's; tau is the offset between the clocks of sensor and
//! encoders in the middle of the run, delta how much larger it is at the end, with u from -1 at the first pose to 1 at the
//! last. psi, tau and delta are nuisance parameters of a run, as its start is: drawn anew for every run with a spread
//! from [`OdometryNoise`], and never evidence for an effect. A heading that drifts by an effect of the model is taken back
//! by that before it is used.
//! The rows of (2) are an ordinary least squares problem in the parameters.
//! The first measured pose starts the filter.
//! The three numbers of a pose update the filter one after the other, which is the same as together.
//!
//! The heading at which effects of the world act ([`Step::heading_rad`]) is the filter's own. That their turn depends on it
//! is in S, and left out of F; that a drift by a user's own equation does is of second order, and left out.
//!
//! State and covariance are in [`crate::estimation::state`]; the rows are added up in
//! [`crate::estimation::normal_equations`].

use crate::effect::composition::{Composer, Increment, Terms};
use crate::effect::definition::View;
use crate::estimation::predict::open_loop;
use crate::estimation::sensitivities::Sensitivities;
use crate::estimation::state::{Quantity, ScalarMeasurement, State, Update, Variances};
use crate::estimation::transition::{TIME_ROUNDING_S, Transition, within};
use crate::kinematics::pose::Pose;
use crate::numeric::angle::Direction;
use crate::numeric::lanes::Number;
use crate::recording::motion::{Motion, Step};
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run::PoseMeasurement;

/// Heading sigma of a start at which no heading was measured \[rad\]. The heading was estimated from the whole track;
/// with a larger sigma the first positions would turn it.
pub(crate) const UNKNOWN_HEADING_SIGMA_RAD: f64 = 0.05;

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

/// Receives the rows of the filter.
pub(crate) trait FilterObserver {
    /// One innovation with its whitened derivatives j / sqrt(s).
    fn row(&mut self, innovation: Innovation, whitened: &[f64]);

    /// The robot moves by a share of a step.
    fn motion(&mut self, _step: &Step, _increment: &Increment, _share: f64) {}

    /// A pose is measured here: the first one, which starts the filter, or a later one.
    fn pose(&mut self, _measurement: &PoseMeasurement, _step: &Step, _pose: Pose) {}
}

/// The filter over one run.
pub(crate) struct Filter<'a> {
    composer: Composer<'a>,
    view: View,
    /// The columns on which the view depends, and how.
    views: Vec<(usize, View)>,
    noise: Variances<f64>,
    state: State<f64>,
    sensitivities: Sensitivities,
    row: Vec<f64>,
    times: TimeOfRun,
    /// When the run began \[s\].
    start_s: f64,
}

/// Runs the filter over a run.
pub(crate) fn whiten(
    motion: &Motion,
    measurements: &[PoseMeasurement],
    terms: Terms<'_, '_>,
    noise: &OdometryNoise,
    observer: &mut impl FilterObserver,
) {
    let Some(start) = start_pose(motion, measurements, terms) else { return };
    let (composer, columns) = (Composer::new(terms), terms.columns());
    let (view, view_by_column) = composer.view();
    let views = view_by_column.into_iter().enumerate().filter(|(_, view)| *view != View::NONE);
    let mut filter = Filter {
        composer,
        view,
        views: views.collect(),
        noise: Variances::of(noise),
        state: State::new(start.to_array()),
        sensitivities: Sensitivities::new(columns),
        row: vec![0.0; columns],
        times: TimeOfRun::of(within(motion, measurements).map(|pose| pose.t_s)),
        start_s: motion.start_s,
    };
    let delay_s = view.delay_s.value;
    let drifted_rad = |t_s: f64| view.heading_drift_rad_s.value * (t_s - motion.start_s);
    let without_drift = |pose: &PoseMeasurement| PoseMeasurement {
        heading_rad: pose.heading_rad.map(|measured| measured - drifted_rad(pose.t_s)),
        ..*pose
    };
    let mut measurements = within(motion, measurements).map(without_drift).peekable();
    let last = motion.steps.len().saturating_sub(1);
    let mut started = false;
    let mut begin_s = motion.start_s;
    for (k, nominal) in motion.steps.iter().enumerate() {
        let end_s = begin_s + nominal.dt_s;
        let mut now_s = begin_s;
        let mut step = *nominal;
        step.heading_rad = filter.state.heading_rad() + nominal.turn_rad() / 2.0;
        step.place_m = filter.state.position_m();
        let increment = filter.composer.step(&step);
        // A pose measured a moment before the first step or after the last was measured at rest.
        while let Some(measurement) =
            measurements.next_if(|pose| k == last || pose.t_s - delay_s <= end_s + TIME_ROUNDING_S)
        {
            let seen_s = (measurement.t_s - delay_s).clamp(now_s, end_s.max(now_s));
            let share = (seen_s - now_s) / nominal.dt_s;
            if started {
                filter.advance(&step, &increment, share, observer);
                filter.measure(&measurement, &step, k, observer);
            } else {
                filter.dead_reckon(&increment, share);
                if measurement.position_m.is_none() {
                    now_s = seen_s;
                    continue;
                }
                filter.start(&measurement, &step);
                started = true;
            }
            observer.pose(&measurement, &step, filter.state.pose());
            now_s = seen_s;
        }
        let share = ((end_s - now_s) / nominal.dt_s).max(0.0);
        if started {
            filter.advance(&step, &increment, share, observer);
        } else {
            filter.dead_reckon(&increment, share);
        }
        begin_s = end_s;
    }
}

/// The pose at the first sample of the wheels; `None` if no position was measured, or if nothing determines the
/// heading.
fn start_pose(
    motion: &Motion,
    measurements: &[PoseMeasurement],
    terms: Terms<'_, '_>,
) -> Option<Pose> {
    let first = within(motion, measurements).find(|pose| pose.position_m.is_some())?;
    let [x_m, y_m] = first.position_m?;
    let heading_rad = match first.heading_rad {
        // The first measurement sets the heading anew.
        Some(heading_rad) => heading_rad,
        None => {
            let track = open_loop(motion, measurements, terms);
            let from_heading = track.start_heading_from_headings();
            let from_positions = || {
                // Whether positions determine a heading must not depend on the model.
                let nominal = open_loop(motion, measurements, Terms::Fixed(&[]));
                let determined = nominal.spread_m() > HEADING_SPREAD_M;
                determined
                    .then(|| track.start_from_positions())
                    .flatten()
                    .map(|start| start.heading_rad)
            };
            from_heading.or_else(from_positions)?
        }
    };
    Some(Pose::new(x_m, y_m, heading_rad))
}

/// Positions closer together than this tell nothing about a heading \[m\]: in a spin they are a circle of a marker off
/// the middle, whatever its direction.
const HEADING_SPREAD_M: f64 = 0.03;

impl Filter<'_> {
    /// Moves the pose alone, before the filter starts.
    fn dead_reckon(&mut self, increment: &Increment, share: f64) {
        let there = Transition::new(self.state.pose(), increment, share).pose;
        self.state.set_pose(there.to_array());
    }

    /// Equation (1), for a share of a step.
    fn advance(
        &mut self,
        step: &Step,
        increment: &Increment,
        share: f64,
        observer: &mut impl FilterObserver,
    ) {
        if share == 0.0 {
            return;
        }
        observer.motion(step, increment, share);
        let there = Transition::new(self.state.pose(), increment, share);
        let fade = self.noise.wobble_fade(step.dt_s * share);
        self.sensitivities.advance(&there, &self.composer.slopes, share, fade);
        self.state.predict(there.pose.to_array(), there.by_heading, fade);
        let rolled_m = step.rolled_m() * share;
        self.state.add_process_noise(&self.noise, rolled_m, fade);
    }

    /// The measured point relative to the pose, and its derivative by the heading, which faces this direction.
    fn offset_at(&self, facing: Direction) -> ([f64; 2], [f64; 2]) {
        offset_at(self.view.offset_m.map(|jet| jet.value), facing)
    }

    /// Velocity of the measured point in the fixed frame \[m/s, m/s, rad/s\], smoothed: that of a single
    /// step is one count or none, and shares the error of that count.
    fn velocity(&self, step: &Step, facing: Direction) -> [f64; 3] {
        velocity_of([step.speed_mps(), step.turn_rate_rad_s()], facing, self.offset_at(facing).1)
    }

    /// Starts at the first pose, with the covariance of its measurement, and with its sensitivities.
    fn start(&mut self, measurement: &PoseMeasurement, step: &Step) {
        let Some(position_m) = measurement.position_m else { return };
        let known = measurement.heading_rad;
        let heading_var = known.map_or(UNKNOWN_HEADING_SIGMA_RAD.powi(2), |_| self.noise.heading());
        let heading_rad = known.unwrap_or(self.state.heading_rad());
        let facing = Direction::of(heading_rad);
        let (offset, by_heading) = self.offset_at(facing);
        self.state.set_pose([position_m[0] - offset[0], position_m[1] - offset[1], heading_rad]);
        let velocity = self.velocity(step, facing);
        self.state.start(&self.noise, heading_var, by_heading, velocity);
        let since_s = measurement.t_s - self.start_s;
        for (column, view) in &self.views {
            let slope = |quantity| view_slope(view, quantity, (velocity, since_s), facing);
            let turned = -slope(Quantity::Heading);
            let x = -slope(Quantity::X) - by_heading[0] * turned;
            let y = -slope(Quantity::Y) - by_heading[1] * turned;
            self.sensitivities.start(*column, [x, y, turned]);
        }
    }

    /// Equations (2) and (3), for each number of a pose.
    fn measure(
        &mut self,
        measurement: &PoseMeasurement,
        step: &Step,
        index: usize,
        observer: &mut impl FilterObserver,
    ) {
        let mut facing = Direction::of(self.state.heading_rad());
        let velocity = self.velocity(step, facing);
        let since_s = measurement.t_s - self.start_s;
        for (quantity, measured) in numbers(measurement) {
            if quantity == Quantity::Y {
                // x has turned the heading, and the measured point on the body with it.
                facing = Direction::of(self.state.heading_rad());
            }
            let (offset, by_heading) = self.offset_at(facing);
            let when = self.times.of_pose(measurement.t_s);
            let scalar =
                ScalarMeasurement { quantity, measured, offset, by_heading, velocity, when };
            let update = self.state.innovation(&self.noise, &scalar);
            let weight = 1.0 / update.variance.sqrt();
            self.row.fill(0.0);
            for (column, view) in &self.views {
                self.row[*column] = view_slope(view, quantity, (velocity, since_s), facing);
            }
            self.sensitivities.measure(&update.reading, &update.gain, weight, &mut self.row);
            self.state.update(&update);
            let Update { nu: value, variance, .. } = update;
            observer.row(Innovation { step: index, value, variance }, &self.row);
        }
    }
}

/// The times of the poses of a run, as numbers from -1 to 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimeOfRun {
    middle_s: f64,
    per_s: f64,
}

impl TimeOfRun {
    /// For poses that were measured at these times, in order.
    pub fn of(mut times_s: impl Iterator<Item = f64>) -> Self {
        let first_s = times_s.next().unwrap_or(0.0);
        let last_s = times_s.last().unwrap_or(first_s);
        let half_s = (last_s - first_s) / 2.0;
        let per_s = if half_s > 0.0 { half_s.recip() } else { 0.0 };
        Self { middle_s: first_s + half_s, per_s }
    }

    /// When a pose was measured.
    pub fn of_pose(self, t_s: f64) -> f64 {
        (t_s - self.middle_s) * self.per_s
    }
}

/// Where a point of the body is, relative to the pose in the fixed frame, and its derivative by the heading, which faces
/// this direction.
pub(crate) fn offset_at<T: Number>(
    [ahead, left]: [f64; 2],
    Direction { sin, cos }: Direction<T>,
) -> ([T; 2], [T; 2]) {
    let (ahead, left) = (T::of(ahead), T::of(left));
    let offset = [cos * ahead - sin * left, sin * ahead + cos * left];
    (offset, [-offset[1], offset[0]])
}

/// Velocity of a point in the fixed frame, from the robot's speed and turn rate; `by_heading` is the derivative
/// of its position by the heading.
pub(crate) fn velocity_of<T: Number>(
    [speed_mps, turn_rate_rad_s]: [f64; 2],
    facing: Direction<T>,
    by_heading: [T; 2],
) -> [T; 3] {
    let (speed_mps, turn_rate_rad_s) = (T::of(speed_mps), T::of(turn_rate_rad_s));
    [
        speed_mps * facing.cos + turn_rate_rad_s * by_heading[0],
        speed_mps * facing.sin + turn_rate_rad_s * by_heading[1],
        turn_rate_rad_s,
    ]
}

/// The numbers of a measured pose, those that are there.
pub(crate) fn numbers(measurement: &PoseMeasurement) -> impl Iterator<Item = (Quantity, f64)> {
    let [x, y] = [0, 1].map(|axis| measurement.position_m.map(|position_m| position_m[axis]));
    let all = [(Quantity::X, x), (Quantity::Y, y), (Quantity::Heading, measurement.heading_rad)];
    all.into_iter().filter_map(|(quantity, measured)| Some((quantity, measured?)))
}

/// dh/dp of one quantity by one column's view, with the time since the run began \[s\] and the direction of the heading.
fn view_slope(
    view: &View,
    quantity: Quantity,
    (velocity, since_s): ([f64; 3], f64),
    Direction { sin, cos }: Direction,
) -> f64 {
    let [ahead, left] = [view.offset_m[0].value, view.offset_m[1].value];
    let delay = view.delay_s.value;
    match quantity {
        Quantity::X => cos * ahead - sin * left - velocity[0] * delay,
        Quantity::Y => sin * ahead + cos * left - velocity[1] * delay,
        Quantity::Heading => view.heading_drift_rad_s.value * since_s - velocity[2] * delay,
    }
}

#[cfg(test)]
mod tests;
