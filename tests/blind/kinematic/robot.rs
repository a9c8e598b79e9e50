//! A robot of this plant, drawn by seed, and its recorded campaign.

use campaign::{Campaign, RobotFile, Row, Run, RunFacts};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::drive::{Body, Start, drive};
use super::mechanism::{Hidden, Mechanism};
use super::normal;
use super::planned_run::{DT_S, PlannedRun, Wheels, planned_runs, turn_wheels};
use super::track_distance::Pose;

/// Steps between two rows of counts, two poses, two yaw rates; and the first pose and yaw rate: never at one time.
const COUNTS: [usize; 2] = [50, 0];
const POSES: [usize; 2] = [100, 7];
const RATES: [usize; 2] = [50, 23];
/// From one run to the next \[s\].
const BETWEEN_S: f64 = 25.0;
/// Noise of the yaw rate sensor \[rad/s\].
const GYRO_SIGMA_RAD_S: f64 = 0.002;

/// A robot and who measures it.
#[derive(Clone, Debug)]
pub struct Robot {
    seed: u64,
    body: Body,
    counts_per_rev: f64,
    /// Noise of the camera: each coordinate \[m\], heading \[rad\].
    pub camera: [f64; 2],
    /// Start beside the mark: each coordinate \[m\], heading \[rad\].
    start: [f64; 2],
    gyro: bool,
}

/// A recorded campaign, and what its poses would be without noise.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Its files.
    pub campaign: Campaign,
    /// For each run, times and poses that a camera without noise would see of the robot, if rolling had none either.
    pub ideal: Vec<Vec<(f64, Pose)>>,
    /// The same with what is always there alone.
    pub sound: Vec<Vec<(f64, Pose)>>,
}

impl Robot {
    /// The robot of a seed; `crooked`: its starts are crooked and its camera is another one.
    pub fn new(seed: u64, crooked: bool, needs_gyro: bool) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x6b69_6e65);
        let mut between = |low: f64, high: f64| rng.random_range(low..high);
        let times = between(0.5, 2.0);
        let body = Body {
            // In whole tenths of a millimetre, as on a data sheet.
            radius_m: (between(0.03, 0.06) * 1e4).round() * 1e-4,
            track_m: (between(0.28, 0.42) * 1e3).round() * 1e-3,
            gear: if between(0.0, 1.0) < 0.5 { 1.0 } else { 3.0 },
            fastest_mps: between(0.3, 0.35),
            travel_walk: 4e-4 * times,
            heading_walk: 6e-4 * times,
            curvature_walk: 2e-4 * times,
        };
        let camera = if crooked { between(0.5, 2.0) } else { between(0.8, 1.25) };
        Self {
            seed,
            body,
            counts_per_rev: 2048.0,
            camera: [1e-3 * camera, 2e-3 * camera],
            start: if crooked { [0.05, 0.1] } else { [0.01, 0.02] },
            gyro: between(0.0, 1.0) < 0.5 || needs_gyro,
        }
    }

    /// The greatest rate of a wheel in the campaign \[rad/s\].
    pub fn fastest_rad_s(&self) -> f64 {
        self.body.fastest_mps / self.body.radius_m
    }

    /// Records the usual campaign with what is hidden, of which `always` is no secret; the noise is the same whatever
    /// is hidden.
    pub fn record(
        &self,
        (always, hidden): (&[Hidden], &[Hidden]),
        knows_its_camera: bool,
    ) -> Recorded {
        let mut start = Start { pose: [0.0; 3], phi_rad: [0.0; 2], time_s: 0.0 };
        let (mut runs, mut ideal, mut sound) = (Vec::new(), Vec::new(), Vec::new());
        for (index, run) in
            planned_runs(self.body.track_m, self.body.fastest_mps).into_iter().enumerate()
        {
            let wheels = turn_wheels(&run);
            let seed = self.seed.wrapping_mul(0x9e37_79b9).wrapping_add(index as u64);
            let mut placed = ChaCha8Rng::seed_from_u64(seed ^ (1 << 50));
            let off =
                [self.start[0], self.start[0], self.start[1]].map(|s| s * normal(&mut placed));
            start.pose = [off[0], off[1], run.heading_rad + off[2]];
            let track = |hidden: &[Hidden], rng: Option<ChaCha8Rng>| {
                drive(&self.body, (&run, &wheels), start, hidden, rng)
            };
            let rolling = ChaCha8Rng::seed_from_u64(seed ^ (1 << 51));
            let driven = track(hidden, Some(rolling));
            let noise = ChaCha8Rng::seed_from_u64(seed ^ (1 << 52));
            let rows = self.rows(&wheels, &driven, start.phi_rad, hidden, noise);
            ideal.push(see(&track(hidden, None), hidden));
            sound.push(see(&track(always, None), always));
            runs.push(recorded_run(index, &run, start.time_s, rows));
            let last = wheels[wheels.len() - 1].rolled_m;
            start.phi_rad = [0, 1].map(|i| start.phi_rad[i] + last[i] / self.body.radius_m);
            start.time_s += wheels.len() as f64 * DT_S + BETWEEN_S;
        }
        let facts = runs.iter().map(|run| run.facts.clone()).collect();
        let robot = self.file(facts, knows_its_camera);
        Recorded {
            campaign: Campaign { robot, runs, copies: Vec::new(), warnings: Vec::new() },
            ideal,
            sound,
        }
    }

    fn file(&self, runs: Vec<RunFacts>, knows_its_camera: bool) -> RobotFile {
        RobotFile {
            name: "kinematic".into(),
            wheel_radius_m: self.body.radius_m,
            track_width_m: self.body.track_m,
            counts_per_rev: self.counts_per_rev,
            gear_reduction: self.body.gear,
            position_sigma_m: knows_its_camera.then_some(self.camera[0]),
            heading_sigma_rad: knows_its_camera.then_some(self.camera[1]),
            runs,
            ..RobotFile::default()
        }
    }

    /// Whole counts, poses with white noise, and yaw rates, each at its own times.
    fn rows(
        &self,
        wheels: &[Wheels],
        driven: &[Pose],
        phi_rad: [f64; 2],
        hidden: &[Hidden],
        mut rng: ChaCha8Rng,
    ) -> Vec<Row> {
        let per_rad = self.counts_per_rev * self.body.gear / core::f64::consts::TAU;
        let each = |[every, first]: [usize; 2]| (first..wheels.len()).step_by(every);
        let mut rows = Vec::new();
        for k in each(COUNTS) {
            let mut row = Row { t_s: time_s(k), ..Row::default() };
            let counts = [0, 1].map(|i| {
                ((phi_rad[i] + wheels[k].rolled_m[i] / self.body.radius_m) * per_rad).floor()
            });
            (row.counts.left, row.counts.right) = (Some(counts[0]), Some(counts[1]));
            rows.push(row);
        }
        for (t_s, pose) in see(driven, hidden) {
            let noise = [self.camera[0], self.camera[0], self.camera[1]];
            let [x_m, y_m, heading_rad] =
                [0, 1, 2].map(|i| Some(pose[i] + noise[i] * normal(&mut rng)));
            rows.push(Row { t_s, x_m, y_m, heading_rad, ..Row::default() });
        }
        let [bias_rad_s, scale] = [Mechanism::GyroBias, Mechanism::GyroScale].map(|mechanism| {
            let found = hidden.iter().find(|hidden| hidden.mechanism == mechanism);
            found.map_or(0.0, |hidden| hidden.p[0])
        });
        for k in each(RATES).filter(|k| self.gyro && k + 1 < driven.len()) {
            let rate_rad_s = (driven[k + 1][2] - driven[k - 1][2]) / (2.0 * DT_S);
            let read =
                rate_rad_s * (1.0 + scale) + bias_rad_s + GYRO_SIGMA_RAD_S * normal(&mut rng);
            rows.push(Row { t_s: time_s(k), gyro_z_rad_s: Some(read), ..Row::default() });
        }
        rows.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
        rows
    }
}

/// A time in whole milliseconds \[s\].
fn time_s(step: usize) -> f64 {
    step as f64 * DT_S
}

/// What a camera without noise sees of a track: late, and of a point that may be off the middle.
fn see(track: &[Pose], hidden: &[Hidden]) -> Vec<(f64, Pose)> {
    let of = |mechanism: Mechanism| {
        hidden
            .iter()
            .find(|hidden| hidden.mechanism == mechanism)
            .map_or([0.0; 4], |hidden| hidden.p)
    };
    let late_s = of(Mechanism::MeasurementDelay)[0];
    let [ahead_m, left_m, ..] = of(Mechanism::MarkerOffset);
    let drift_rad_s = of(Mechanism::HeadingDrift)[0];
    let [every, first] = POSES;
    let last = track.len() - 1;
    let seen = (first..track.len()).step_by(every).map(|k| {
        let at = (k as f64 - late_s / DT_S).clamp(0.0, last as f64);
        let (low, share) = (at.floor() as usize, at.fract());
        let (a, b) = (track[low], track[(low + 1).min(last)]);
        let pose = [0, 1, 2].map(|i| a[i] + share * (b[i] - a[i]));
        let (sin, cos) = pose[2].sin_cos();
        let point = [
            pose[0] + ahead_m * cos - left_m * sin,
            pose[1] + ahead_m * sin + left_m * cos,
            pose[2] + drift_rad_s * time_s(k),
        ];
        (time_s(k), point)
    });
    seen.collect()
}

fn recorded_run(index: usize, run: &PlannedRun, started_s: f64, rows: Vec<Row>) -> Run {
    let name = format!("{:02}_{}", index + 1, run.name);
    let facts = RunFacts {
        name: name.clone(),
        started_s: Some(started_s),
        payload_kg: (run.payload_kg > 0.0).then_some(run.payload_kg),
        held_out: run.held_out,
        ..RunFacts::default()
    };
    Run { name, facts, rows }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_campaign_can_be_read_and_its_noise_is_that_of_its_camera() {
        let recorded = Robot::new(3, false, true).record((&[], &[]), true);
        let folder = std::path::Path::new("campaign");
        let measured = recorded.campaign.to_model(folder).expect("a sound robot");
        assert!(measured.runs.iter().all(|run| run.validate().is_ok() && !run.gyro.is_empty()));
        let rest = &measured.runs[0].measured_poses;
        let sum: f64 = rest
            .iter()
            .zip(&recorded.ideal[0])
            .map(|(seen, (_, ideal))| (seen.position_m.unwrap()[0] - ideal[0]).powi(2))
            .sum();
        let sigma_m = (sum / rest.len() as f64).sqrt();
        assert!((0.0005..0.002).contains(&sigma_m), "{sigma_m}");
    }
}
