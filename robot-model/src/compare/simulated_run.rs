//! A run as a model predicts it, measured with drawn noise: how far off would measurements be if the model were right?

use crate::estimation::predict::PredictedTrack;
use crate::kinematics::pose::Pose;
use crate::numeric::random::Random;
use crate::recording::campaign::PreparedRun;
use crate::recording::motion::Step;
use crate::recording::odometry_noise::OdometryNoise;

/// A root mean square does not need every measurement: more than this many are thinned out.
const MEASUREMENTS_MAX: usize = 200;

/// A predicted run whose measurements are drawn again and again.
pub(super) struct SimulatedRun<'a> {
    /// As predicted, and as it was last measured.
    track: PredictedTrack,
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
    pub fn new(run: &PreparedRun, track: &PredictedTrack, noise: &'a OdometryNoise) -> Self {
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

    /// The run, measured with noise drawn anew.
    pub fn draw(&mut self, random: &mut Random) -> &PredictedTrack {
        let noise = self.noise;
        // Error of dead reckoning: in the fixed frame, and of the heading.
        let mut off = [0.0_f64; 3];
        let scale = [noise.position_wobble_m, noise.position_wobble_m, noise.heading_wobble_rad];
        let wobbles = scale.iter().any(|sigma| *sigma > 0.0);
        let mut wobble = if wobbles { three_normals(random) } else { [0.0; 3] };
        let [of_angle, of_clock] = random.two_normals();
        let turned_rad = noise.heading_offset_rad * of_angle;
        let late_s = noise.clock_offset_s * of_clock;
        let track = &mut self.track;
        let each = track.measured.iter_mut().zip(&track.predicted).zip(&self.moments);
        for ((measurement, pose), moment) in each {
            let ([x, y], [turn, wander]) = (random.two_normals(), random.two_normals());
            if let Some(moved) = &moment.moved {
                let wander_rad = wander * moved.heading_sigma_rad;
                let lever_rad = off[2] + wander_rad / 2.0;
                let travel = random.two_normals();
                off[0] += -lever_rad * moved.by_m[1] + moved.travel_sigma_m * travel[0];
                off[1] += lever_rad * moved.by_m[0] + moved.travel_sigma_m * travel[1];
                off[2] += wander_rad;
                if wobbles {
                    let fresh = (1.0 - moved.fade * moved.fade).sqrt();
                    let drawn = three_normals(random);
                    for (part, drawn) in wobble.iter_mut().zip(drawn) {
                        *part = moved.fade * *part + fresh * drawn;
                    }
                }
            }
            let white = [
                noise.position_sigma_m * x,
                noise.position_sigma_m * y,
                noise.heading_sigma_rad * turn,
            ];
            let behind_m = -late_s * moment.speed_mps;
            let (sin, cos) = moment.sin_cos;
            let turned_late_rad = turned_rad - late_s * moment.turn_rate_rad_s;
            let of_run = [behind_m * cos, behind_m * sin, turned_late_rad];
            let error: [f64; 3] =
                core::array::from_fn(|i| off[i] + of_run[i] + scale[i] * wobble[i] + white[i]);
            measurement.position_m =
                measurement.position_m.map(|_| [pose.x_m + error[0], pose.y_m + error[1]]);
            measurement.heading_rad = measurement.heading_rad.map(|_| pose.heading_rad + error[2]);
        }
        track
    }
}

fn three_normals(random: &mut Random) -> [f64; 3] {
    let ([x, y], [turn, _]) = (random.two_normals(), random.two_normals());
    [x, y, turn]
}

/// A track with at most [`MEASUREMENTS_MAX`] measurements, the last among them.
fn thinned(track: &PredictedTrack) -> PredictedTrack {
    let count = track.measured.len();
    let every = count.div_ceil(MEASUREMENTS_MAX).max(1);
    let kept: Vec<usize> = (0..count).filter(|k| k % every == 0 || k + 1 == count).collect();
    PredictedTrack {
        measured: kept.iter().map(|k| track.measured[*k]).collect(),
        predicted: kept.iter().map(|k| track.predicted[*k]).collect(),
        step: kept.iter().map(|k| track.step[*k]).collect(),
    }
}
