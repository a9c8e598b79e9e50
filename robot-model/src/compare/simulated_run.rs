//! A run as a model predicts it, measured with drawn noise: how far off would measurements be if the model were right?

use crate::estimation::predict::Track;
use crate::kinematics::pose::Pose;
use crate::numeric::random::Random;
use crate::recording::campaign::PreparedRun;
use crate::recording::motion::Step;
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run::PoseMeasurement;

/// A root mean square does not need every measurement: more than this many are thinned out.
const MEASUREMENTS_MAX: usize = 200;

/// A predicted run whose measurements are drawn again and again.
pub(super) struct SimulatedRun<'a> {
    track: Track,
    noise: &'a OdometryNoise,
    /// For each measurement.
    moments: Vec<Moment>,
}

/// What the noise of one measurement depends on.
struct Moment {
    /// `None` for the first.
    moved: Option<Moved>,
    sin_cos: (f64, f64),
    speed_mps: f64,
    turn_rate_rad_s: f64,
}

/// The motion since the measurement before.
struct Moved {
    by_m: [f64; 2],
    heading_sigma_rad: f64,
    travel_sigma_m: f64,
    fade: f64,
}

impl<'a> SimulatedRun<'a> {
    /// Of a run, with its predicted track and this noise.
    pub fn new(run: &PreparedRun, track: &Track, noise: &'a OdometryNoise) -> Self {
        let track = thinned(track);
        let mut before: Option<(Pose, usize, f64)> = None;
        let each = track.measured.iter().zip(&track.predicted).zip(&track.step);
        let moments = each.map(|((measurement, pose), step)| {
            let moved = before.map(|(from, from_step, from_s)| {
                let steps = &run.motion.steps[from_step..*step];
                let rolled_m: f64 = steps.iter().map(Step::rolled_m).sum();
                Moved {
                    by_m: [pose.x_m - from.x_m, pose.y_m - from.y_m],
                    heading_sigma_rad: noise.heading_variance_rad2(rolled_m).sqrt(),
                    travel_sigma_m: noise.travel_variance_m2(rolled_m).sqrt(),
                    fade: noise.wobble_fade(measurement.t_s - from_s),
                }
            });
            before = Some((*pose, *step, measurement.t_s));
            let moving = &run.motion.steps[*step];
            Moment {
                moved,
                sin_cos: pose.heading_rad.sin_cos(),
                speed_mps: moving.speed_mps(),
                turn_rate_rad_s: moving.turn_rate_rad_s(),
            }
        });
        let moments = moments.collect();
        Self { track, noise, moments }
    }

    /// The run, measured with drawn noise.
    pub fn drawn(&self, random: &mut Random) -> Track {
        let noise = self.noise;
        // Error of dead reckoning: in the fixed frame, and of the heading.
        let mut off = [0.0_f64; 3];
        let mut wobble = [(); 3].map(|()| random.normal());
        let scale = [noise.position_wobble_m, noise.position_wobble_m, noise.heading_wobble_rad];
        let turned_rad = noise.heading_offset_rad * random.normal();
        let late_s = noise.clock_offset_s * random.normal();
        let each = self.track.measured.iter().zip(&self.track.predicted).zip(&self.moments);
        let measured = each.map(|((measurement, pose), moment)| {
            if let Some(moved) = &moment.moved {
                let wander_rad = random.normal() * moved.heading_sigma_rad;
                let lever_rad = off[2] + wander_rad / 2.0;
                off[0] += -lever_rad * moved.by_m[1] + moved.travel_sigma_m * random.normal();
                off[1] += lever_rad * moved.by_m[0] + moved.travel_sigma_m * random.normal();
                off[2] += wander_rad;
                let fresh = (1.0 - moved.fade * moved.fade).sqrt();
                wobble = wobble.map(|part| moved.fade * part + fresh * random.normal());
            }
            let white = [noise.position_sigma_m, noise.position_sigma_m, noise.heading_sigma_rad]
                .map(|sigma| sigma * random.normal());
            let behind_m = -late_s * moment.speed_mps;
            let (sin, cos) = moment.sin_cos;
            let turned_late_rad = turned_rad - late_s * moment.turn_rate_rad_s;
            let of_run = [behind_m * cos, behind_m * sin, turned_late_rad];
            let error: [f64; 3] =
                core::array::from_fn(|i| off[i] + of_run[i] + scale[i] * wobble[i] + white[i]);
            let position_m =
                measurement.position_m.map(|_| [pose.x_m + error[0], pose.y_m + error[1]]);
            let heading_rad = measurement.heading_rad.map(|_| pose.heading_rad + error[2]);
            PoseMeasurement { t_s: measurement.t_s, position_m, heading_rad }
        });
        let measured = measured.collect();
        Track { measured, predicted: self.track.predicted.clone(), step: self.track.step.clone() }
    }
}

/// A track with at most [`MEASUREMENTS_MAX`] measurements, the last among them.
fn thinned(track: &Track) -> Track {
    let count = track.measured.len();
    let every = count.div_ceil(MEASUREMENTS_MAX).max(1);
    let kept: Vec<usize> = (0..count).filter(|k| k % every == 0 || k + 1 == count).collect();
    Track {
        measured: kept.iter().map(|k| track.measured[*k]).collect(),
        predicted: kept.iter().map(|k| track.predicted[*k]).collect(),
        step: kept.iter().map(|k| track.step[*k]).collect(),
    }
}
