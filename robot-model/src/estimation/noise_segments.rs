//! The filter's innovations for any noise, quickly: the motion between two measured poses in one piece.
//!
//! The noise is estimated with fixed effects, in hundreds of passes over the same runs. The motion between two
//! measurements is the same in all passes, so its steps are added up once:
//!
//! ```text
//! pose' = pose + R(theta) moved + drift                                               (1)
//! var(theta') += k^2 d,   var(x', y') += (n-1)(2n-1)/(6 n^2) g g' k^2 d,
//! cov(x' y', theta') += (n-1)/(2n) g k^2 d                                            (2)
//! ```
//!
//! (2) is the process noise of n steps of the filter in [`crate::estimation::ekf`] along an even motion; g is the
//! derivative of its end by the heading at its beginning. The search for the noise itself is in
//! [`crate::estimation::most_likely_noise`].

use crate::effect::composition::Increment;
use crate::estimation::ekf::{Innovation, Sink, UNKNOWN_HEADING_SIGMA_RAD, numbers, velocity_of};
use crate::estimation::gyro::GyroSegment;
use crate::estimation::most_likely_noise::Whitened;
use crate::estimation::state::{Quantity, ScalarMeasurement, State};
use crate::estimation::transition::Transition;
use crate::kinematics::pose::Pose;
use crate::recording::motion::Step;
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run::PoseMeasurement;

/// The motion from one measured pose to the next.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// In the frame of the robot at its beginning.
    moved: Pose,
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
        moved: Pose::ORIGIN,
        drift_m: [0.0; 2],
        dt_s: 0.0,
        rolled_m: 0.0,
        steps: 0.0,
        measurement: PoseMeasurement { t_s: 0.0, position_m: None, heading_rad: None },
        speed: [0.0; 2],
    };
}

/// One run in segments; a sink of the filter that builds them.
#[derive(Clone, Debug)]
pub(crate) struct NoiseSegments {
    segments: Vec<Segment>,
    /// Heading at the first measured pose \[rad\].
    heading_rad: f64,
    /// The measured point on the body \[m\].
    offset_m: [f64; 2],
    open: Segment,
    pub gyro: Vec<GyroSegment>,
}

impl Sink for NoiseSegments {
    fn moved(&mut self, step: &Step, increment: &Increment, share: f64) {
        let level = Increment { drift_m: [0.0; 2], ..*increment };
        let open = &mut self.open;
        open.moved = Transition::new(open.moved, &level, share).pose;
        open.drift_m[0] += increment.drift_m[0] * share;
        open.drift_m[1] += increment.drift_m[1] * share;
        open.dt_s += step.dt_s * share;
        open.rolled_m += step.rolled_m() * share;
        open.steps += 1.0;
    }

    fn pose_measured(&mut self, measurement: &PoseMeasurement, step: &Step, pose: Pose) {
        if self.segments.is_empty() {
            self.heading_rad = pose.heading_rad;
        }
        let speed = [step.speed_mps(), step.turn_rate_rad_s()];
        let open = core::mem::replace(&mut self.open, Segment::NONE);
        self.segments.push(Segment { measurement: *measurement, speed, ..open });
    }

    fn row(&mut self, _: Innovation, _: &[f64]) {}
}

impl NoiseSegments {
    /// To be filled by the filter; `offset_m` is the measured point on the body \[m\].
    pub fn new(offset_m: [f64; 2], gyro: Vec<GyroSegment>) -> Self {
        Self { segments: Vec::new(), heading_rad: 0.0, offset_m, open: Segment::NONE, gyro }
    }

    /// How many rows there are at most.
    pub fn rows(&self) -> usize {
        3 * self.segments.len() + self.gyro.len()
    }

    /// The innovations of the run with this noise.
    pub fn whitened(&self, noise: &OdometryNoise, rows: &mut Vec<Whitened>) {
        let Some(first) = self.segments.first() else { return };
        let mut state = State::new(Pose::new(0.0, 0.0, self.heading_rad));
        self.start(&mut state, noise, first);
        for segment in &self.segments[1..] {
            let [sin, cos] = sin_cos(state.pose.heading_rad);
            let ahead = [
                cos * segment.moved.x_m - sin * segment.moved.y_m,
                sin * segment.moved.x_m + cos * segment.moved.y_m,
            ];
            let there = Pose::new(
                state.pose.x_m + ahead[0] + segment.drift_m[0],
                state.pose.y_m + ahead[1] + segment.drift_m[1],
                state.pose.heading_rad + segment.moved.heading_rad,
            );
            let by_heading = [-ahead[1], ahead[0]];
            let fade = noise.wobble_fade(segment.dt_s);
            state.predict(there, by_heading, fade);
            state.add_process_noise(noise, segment.rolled_m, fade);
            state.couple_heading_noise(noise, segment.rolled_m, by_heading, segment.steps);
            let direction = sin_cos(state.pose.heading_rad);
            let (mut offset, mut by_heading) = self.offset_at(direction);
            let velocity = velocity_of(segment.speed[0], segment.speed[1], direction, by_heading);
            for (quantity, measured) in numbers(&segment.measurement) {
                if quantity == Quantity::Y && self.offset_m != [0.0; 2] {
                    // x has turned the heading, and the measured point on the body with it.
                    (offset, by_heading) = self.offset_at(sin_cos(state.pose.heading_rad));
                }
                let scalar = ScalarMeasurement { quantity, measured, offset, by_heading, velocity };
                let update = state.innovation(noise, &scalar);
                state.update(&update);
                rows.push((update.nu, update.variance));
            }
        }
    }

    fn start(&self, state: &mut State, noise: &OdometryNoise, first: &Segment) {
        let Some(position_m) = first.measurement.position_m else { return };
        let [sin, cos] = sin_cos(self.heading_rad);
        let (offset, by_heading) = self.offset_at([sin, cos]);
        state.pose.x_m = position_m[0] - offset[0];
        state.pose.y_m = position_m[1] - offset[1];
        let velocity = velocity_of(first.speed[0], first.speed[1], [sin, cos], by_heading);
        let known = first.measurement.heading_rad.is_some();
        let sigma_rad = if known { noise.heading_sigma_rad } else { UNKNOWN_HEADING_SIGMA_RAD };
        state.start(noise, sigma_rad, by_heading, velocity);
    }

    fn offset_at(&self, [sin, cos]: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let [ahead, left] = self.offset_m;
        let offset = [cos * ahead - sin * left, sin * ahead + cos * left];
        (offset, [-offset[1], offset[0]])
    }
}

fn sin_cos(angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    [sin, cos]
}
