//! One robot of a case, by either plant, recorded with what it hides.

use campaign::{Campaign, Row};
use robot_model::kinematics::WheelPair;
use robot_model::recording::{GyroSample, PoseMeasurement, Recording, WheelSample};

use super::hard::{Difficulty, Hard, WOBBLE};
use super::kinematic::track_distance::{Pose, squares};

/// Where a robot comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Plant {
    /// The simulator's: forces, tyres, motors, firmware in the loop.
    Forces,
    /// The second one: kinematics alone.
    Kinematic,
}

impl Plant {
    /// Both.
    pub const BOTH: [Self; 2] = [Self::Forces, Self::Kinematic];

    /// Its name in tables and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Forces => "forces",
            Self::Kinematic => "kinematic",
        }
    }
}

/// One of the case's effects, and how strong.
#[derive(Clone, Copy, Debug)]
pub struct Dose {
    /// Its index among the case's effects.
    pub index: usize,
    /// Its strength; 1 is typical in the field.
    pub strength: f64,
}

/// A true number: effect, parameter, value.
pub type Truth = (String, &'static str, f64);

/// Poses of each run without any noise, with what is hidden and without; a plant that knows its noise has them.
#[derive(Clone, Debug)]
pub struct Ideal {
    /// With what is hidden: times and poses of each run.
    pub hidden: Vec<Vec<(f64, Pose)>>,
    /// Without.
    pub sound: Vec<Vec<(f64, Pose)>>,
    /// Noise of the camera: each coordinate \[m\], heading \[rad\].
    pub camera: [f64; 2],
}

/// A campaign as the plant gives it.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Its files.
    pub campaign: Campaign,
    /// The true numbers of geometry, and those of what is hidden.
    pub truth: Vec<Truth>,
    /// Without noise.
    pub ideal: Option<Ideal>,
}

/// A robot of a case.
pub trait Robot {
    /// Records these effects; they are weakened where the robot cannot drive otherwise.
    ///
    /// # Errors
    /// What went wrong, for a person to read.
    fn record(&self, doses: &mut [Dose]) -> Result<Recorded, String>;

    /// Records the same effects once more, with all noise drawn anew; `None` if the plant knows its noise.
    fn record_twin(&self, _doses: &[Dose]) -> Option<Result<Recorded, String>> {
        None
    }

    /// Weakens an effect until it is physical.
    fn possible(&self, dose: Dose) -> Dose;
}

/// A campaign with its difficulty.
#[derive(Clone, Debug)]
pub struct Taken {
    /// The files as their owner has them.
    pub campaign: Campaign,
    /// The same as a fit reads them; no check has refused anything.
    pub measured: robot_model::recording::Campaign,
    /// With the right data sheet and one clock: what a fit that knows the truth reads.
    pub mended: robot_model::recording::Campaign,
    /// What is hidden, as strong as it became.
    pub doses: Vec<Dose>,
    /// The true numbers, relative to the data sheet as it is.
    pub truth: Vec<Truth>,
    /// Error of the true model with its true parameters \[m\], where the plant knows it.
    pub noise_m: Option<f64>,
    /// How far what is hidden moves the robot, root mean square from the best start \[m\], where the plant knows it.
    pub moved_m: Option<f64>,
}

/// Records a robot and makes its campaign hard.
///
/// # Errors
/// What went wrong, for a person to read.
pub fn take(
    robot: &dyn Robot,
    difficulty: &Difficulty,
    doses: &mut [Dose],
) -> Result<Taken, String> {
    let Recorded { mut campaign, mut truth, ideal } = robot.record(doses)?;
    difficulty.spoil_poses(&mut campaign);
    let mended = unchecked(&campaign);
    let wobble = if difficulty.hard == Hard::Wobble { WOBBLE } else { [0.0; 2] };
    let levels = ideal.map(|ideal| levels(&campaign, &ideal, wobble));
    difficulty.spoil_files(&mut campaign);
    for (effect, _, value) in &mut truth {
        match effect.as_str() {
            "wheel_radius_scale" => *value = (1.0 + *value) * (1.0 + difficulty.radius) - 1.0,
            "track_width" => *value = (1.0 + *value) * (1.0 + difficulty.track) - 1.0,
            _ => {}
        }
    }
    let measured = unchecked(&campaign);
    let (noise_m, moved_m) = levels.unzip();
    Ok(Taken { campaign, measured, mended, doses: doses.to_vec(), truth, noise_m, moved_m })
}

/// The same robot's second campaign with other noise, as a fit that knows the truth reads it; `None` if the plant knows
/// its noise.
///
/// # Errors
/// What went wrong, for a person to read.
pub fn take_twin(
    robot: &dyn Robot,
    difficulty: &Difficulty,
    doses: &[Dose],
) -> Result<Option<robot_model::recording::Campaign>, String> {
    let Some(recorded) = robot.record_twin(doses) else { return Ok(None) };
    let mut campaign = recorded?.campaign;
    difficulty.drawn_anew().spoil_poses(&mut campaign);
    Ok(Some(unchecked(&campaign)))
}

/// Noise, and how far what is hidden moves the robot \[m\], on the runs that are not held out.
fn levels(campaign: &Campaign, ideal: &Ideal, wobble: [f64; 2]) -> (f64, f64) {
    let scales = [0, 1].map(|i| ideal.camera[i].hypot(wobble[i]));
    let (mut noise, mut moved, mut poses) = (0.0, 0.0, 0);
    for (index, run) in campaign.runs.iter().enumerate().filter(|(_, run)| !run.facts.held_out) {
        let (times, seen): (Vec<f64>, Vec<Pose>) = run.rows.iter().filter_map(pose).unzip();
        let at = |track: &[(f64, Pose)]| -> Vec<Pose> {
            let near = |t_s: &f64| {
                let after = track.partition_point(|(other_s, _)| *other_s < t_s - 1e-6);
                track[after.min(track.len() - 1)].1
            };
            times.iter().map(near).collect()
        };
        let (hidden, sound) = (at(&ideal.hidden[index]), at(&ideal.sound[index]));
        let (sum, n) = squares(&seen, &hidden, scales);
        noise += sum;
        poses += n;
        moved += squares(&hidden, &sound, scales).0;
    }
    let mean = |sum: f64| (sum / poses.max(1) as f64).sqrt();
    (mean(noise), mean(moved))
}

/// Time and pose of a row that has a whole one.
fn pose(row: &Row) -> Option<(f64, Pose)> {
    Some((row.t_s, [row.x_m?, row.y_m?, row.heading_rad?]))
}

/// A campaign for `robot-model`, without the checks that may refuse it.
fn unchecked(campaign: &Campaign) -> robot_model::recording::Campaign {
    let robot = campaign.robot.to_model();
    let runs = campaign.runs.iter().map(|run| {
        let mut recording = Recording {
            name: run.name.clone(),
            started_s: run.facts.started_s,
            payload_kg: run.facts.payload_kg.unwrap_or(0.0),
            held_out: run.facts.held_out,
            ..Recording::default()
        };
        for row in &run.rows {
            let t_s = row.t_s;
            if let (Some(left), Some(right)) = (row.counts.left, row.counts.right) {
                let phi_rad =
                    WheelPair::new(left * robot.rad_per_count, right * robot.rad_per_count);
                recording.wheels.push(WheelSample { t_s, phi_rad });
            }
            if let Some((_, [x_m, y_m, heading_rad])) = pose(row) {
                recording.measured_poses.push(PoseMeasurement {
                    t_s,
                    position_m: Some([x_m, y_m]),
                    heading_rad: Some(heading_rad),
                });
            }
            if let Some(rate_rad_s) = row.gyro_z_rad_s {
                recording.gyro.push(GyroSample { t_s, rate_rad_s });
            }
        }
        recording
    });
    let runs = runs.collect();
    robot_model::recording::Campaign { robot, runs }
}
