//! The filter's innovations for any noise, quickly: the motion between two measured poses in one piece.
//!
//! The noise is estimated with fixed effects, in hundreds of passes over the same runs. The motion between two
//! measurements is the same in all passes, so its steps are added up once:
//!
//! ```text
//! pose' = pose + R(theta) motion + drift                                               (1)
//! var(theta') += k^2 d,   var(x', y') += (n-1)(2n-1)/(6 n^2) g g' k^2 d,
//! cov(x' y', theta') += (n-1)/(2n) g k^2 d                                            (2)
//! ```
//!
//! (2) is the process noise of n steps of the filter in [`crate::estimation::ekf`] along an even motion; g is the
//! derivative of its end by the heading at its beginning. Noises that differ a little, for derivatives, go through the
//! run in lanes beside each other. The search for the noise itself is in [`crate::estimation::most_likely_noise`].

use crate::effect::composition::Increment;
use crate::estimation::ekf::{
    FilterObserver, Innovation, TimeOfRun, UNKNOWN_HEADING_SIGMA_RAD, numbers, offset_at,
    velocity_of,
};
use crate::estimation::gyro::{GyroSegment, follow};
use crate::estimation::state::{Quantity, ScalarMeasurement, State, Variances};
use crate::estimation::transition::Transition;
use crate::kinematics::pose::Pose;
use crate::numeric::angle::{Direction, sinc};
use crate::numeric::lanes::Number;
use crate::recording::motion::Step;
use crate::recording::run::PoseMeasurement;

/// The motion from one measured pose to the next.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// In the frame of the robot at its beginning, and the direction of its turn.
    motion: Pose,
    turned: Direction,
    /// In the fixed frame \[m\].
    drift_m: [f64; 2],
    dt_s: f64,
    rolled_m: f64,
    steps: f64,
    /// At its end: the measurement; speed and turn rate \[m/s, rad/s\].
    measurement: PoseMeasurement,
    speed: [f64; 2],
}

impl Segment {
    const NONE: Self = Self {
        motion: Pose::ORIGIN,
        turned: Direction { sin: 0.0, cos: 1.0 },
        drift_m: [0.0; 2],
        dt_s: 0.0,
        rolled_m: 0.0,
        steps: 0.0,
        measurement: PoseMeasurement { t_s: 0.0, position_m: None, heading_rad: None },
        speed: [0.0; 2],
    };
}

/// One run in segments; a observer of the filter that builds them.
#[derive(Clone, Debug)]
pub(crate) struct NoiseSegments {
    segments: Vec<Segment>,
    /// Heading at the first measured pose \[rad\].
    heading_rad: f64,
    /// The measured point on the body \[m\].
    offset_m: [f64; 2],
    open: Segment,
    gyro: Vec<GyroSegment>,
}

impl FilterObserver for NoiseSegments {
    fn motion(&mut self, step: &Step, increment: &Increment, share: f64) {
        let level = Increment { drift_m: [0.0; 2], ..*increment };
        let open = &mut self.open;
        open.motion = Transition::new(open.motion, &level, share).pose;
        open.drift_m[0] += increment.drift_m[0] * share;
        open.drift_m[1] += increment.drift_m[1] * share;
        open.dt_s += step.dt_s * share;
        open.rolled_m += step.rolled_m() * share;
        open.steps += 1.0;
    }

    fn pose(&mut self, measurement: &PoseMeasurement, step: &Step, pose: Pose) {
        if self.segments.is_empty() {
            self.heading_rad = pose.heading_rad;
        }
        let speed = [step.speed_mps(), step.turn_rate_rad_s()];
        let open = core::mem::replace(&mut self.open, Segment::NONE);
        let turned = Direction::of(open.motion.heading_rad);
        self.segments.push(Segment { measurement: *measurement, speed, turned, ..open });
    }

    fn row(&mut self, _: Innovation, _: &[f64]) {}
}

impl NoiseSegments {
    /// To be filled by the filter; `offset_m` is the measured point on the body \[m\].
    pub fn new(offset_m: [f64; 2], gyro: Vec<GyroSegment>) -> Self {
        Self { segments: Vec::new(), heading_rad: 0.0, offset_m, open: Segment::NONE, gyro }
    }

    /// The innovations nu of the run and their variances s, with this noise.
    pub fn innovations<T: Number>(&self, noise: &Variances<T>, mut seen: impl FnMut(T, T)) {
        if let Some(first) = self.segments.first() {
            let mut filter = self.started(noise, first);
            let times = TimeOfRun::of(self.segments.iter().map(|segment| segment.measurement.t_s));
            for segment in &self.segments[1..] {
                filter.advance(segment);
                let when = times.of_pose(segment.measurement.t_s);
                for (quantity, measured) in numbers(&segment.measurement) {
                    let (nu, variance) = filter.measure(quantity, measured, when);
                    seen(nu, variance);
                }
            }
        }
        follow(&self.gyro, noise, |_, nu, variance, _| seen(nu, variance));
    }

    /// A filter at the first measured pose.
    fn started<'n, T: Number>(&self, noise: &'n Variances<T>, first: &Segment) -> Filter<'n, T> {
        let heading_rad = T::of(self.heading_rad);
        let state = State::new([T::of(0.0), T::of(0.0), heading_rad]);
        let facing = Direction::of(heading_rad);
        let (offset, by_heading) = offset_at(self.offset_m, facing);
        let velocity = velocity_of(first.speed, facing, by_heading);
        let (offset_m, fade) = (self.offset_m, (0.0, T::of(1.0)));
        let mut filter = Filter {
            noise,
            state,
            facing,
            heading_rad,
            offset_m,
            fade,
            offset,
            by_heading,
            velocity,
        };
        if let Some(position_m) = first.measurement.position_m {
            let [x_m, y_m] = [0, 1].map(|axis| T::of(position_m[axis]) - offset[axis]);
            filter.state.set_pose([x_m, y_m, heading_rad]);
            let estimated = T::of(UNKNOWN_HEADING_SIGMA_RAD.powi(2));
            let known = first.measurement.heading_rad.map(|_| noise.heading());
            filter.state.start(noise, known.unwrap_or(estimated), by_heading, velocity);
        }
        filter
    }
}

/// The filter at a measured pose of a run.
struct Filter<'n, T> {
    noise: &'n Variances<T>,
    state: State<T>,
    /// The direction of this heading, which is that of the state but for its last changes.
    facing: Direction<T>,
    heading_rad: T,
    offset_m: [f64; 2],
    /// By how much e faded in the last segment, which took so long \[s\]: most take as long.
    fade: (f64, T),
    /// As in [`ScalarMeasurement`].
    offset: [T; 2],
    by_heading: [T; 2],
    velocity: [T; 3],
}

impl<T: Number> Filter<'_, T> {
    /// To the end of a segment: (1) and (2).
    fn advance(&mut self, segment: &Segment) {
        self.face();
        let moved_m = [segment.motion.x_m, segment.motion.y_m];
        let (ahead, by_heading) = offset_at(moved_m, self.facing);
        let turned = Direction { sin: T::of(segment.turned.sin), cos: T::of(segment.turned.cos) };
        self.facing = self.facing.turned(turned);
        self.heading_rad += T::of(segment.motion.heading_rad);
        let (state, noise) = (&mut self.state, self.noise);
        let [x_m, y_m] = state.position_m();
        let there = [
            x_m + ahead[0] + T::of(segment.drift_m[0]),
            y_m + ahead[1] + T::of(segment.drift_m[1]),
            self.heading_rad,
        ];
        if self.fade.0 != segment.dt_s {
            self.fade = (segment.dt_s, noise.wobble_fade(segment.dt_s));
        }
        state.predict(there, by_heading, self.fade.1);
        state.add_process_noise(noise, segment.rolled_m, self.fade.1);
        state.couple_heading_noise(noise, segment.rolled_m, by_heading, segment.steps);
        (self.offset, self.by_heading) = offset_at(self.offset_m, self.facing);
        self.velocity = velocity_of(segment.speed, self.facing, self.by_heading);
    }

    /// The innovation of one number of the pose measured there, and its variance.
    fn measure(&mut self, quantity: Quantity, measured: f64, when: f64) -> (T, T) {
        if quantity == Quantity::Y && self.offset_m != [0.0; 2] {
            // x has turned the heading, and the measured point on the body with it.
            self.face();
            (self.offset, self.by_heading) = offset_at(self.offset_m, self.facing);
        }
        let Self { offset, by_heading, velocity, .. } = *self;
        let scalar = ScalarMeasurement { quantity, measured, offset, by_heading, velocity, when };
        let update = self.state.innovation(self.noise, &scalar);
        self.state.update(&update);
        (update.nu, update.variance)
    }

    /// Faces where the state heads.
    fn face(&mut self) {
        let by_rad = self.state.heading_rad() - self.heading_rad;
        self.facing = self.facing.turned(Direction::of_small(by_rad, sinc(by_rad)));
        self.heading_rad = self.state.heading_rad();
    }
}
