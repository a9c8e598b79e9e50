//! Campaigns of arrays and of logs of other programs: both become a folder, which is read as any other.

use std::path::PathBuf;

use campaign::{CampaignError, CampaignWriter, Column, RobotFile, RunFacts};
use import::controller_file;
use import::geometry::Geometry;
use import::source::{Choice, Sources};
use import::text::parse_mappings;
use import::understand::{Hints, understand};
use pyo3::prelude::*;
use robot_model::kinematics::WheelPair;
use robot_model::recording::{GyroSample, PoseMeasurement, Recording, WheelSample};

use crate::convert::{failed, of_bytes};

/// The nominal robot.
#[derive(FromPyObject)]
pub struct Robot {
    name: String,
    wheel_radius_m: f64,
    track_width_m: f64,
    counts_per_rev: f64,
    gear_reduction: f64,
    position_sigma_m: Option<f64>,
    heading_sigma_rad: Option<f64>,
}

impl Robot {
    fn file(self) -> RobotFile {
        RobotFile {
            name: self.name,
            wheel_radius_m: self.wheel_radius_m,
            track_width_m: self.track_width_m,
            counts_per_rev: self.counts_per_rev,
            gear_reduction: self.gear_reduction,
            position_sigma_m: self.position_sigma_m,
            heading_sigma_rad: self.heading_sigma_rad,
            ..RobotFile::default()
        }
    }
}

/// One run; arrays are bytes.
#[derive(FromPyObject)]
pub struct Run {
    name: String,
    started_s: Option<f64>,
    payload_kg: Option<f64>,
    held_out: bool,
    t_s: Vec<u8>,
    left_rad: Vec<u8>,
    right_rad: Vec<u8>,
    pose_t_s: Vec<u8>,
    x_m: Vec<u8>,
    y_m: Vec<u8>,
    heading_rad: Vec<u8>,
    gyro_t_s: Vec<u8>,
    gyro_rad_s: Vec<u8>,
}

impl Run {
    /// As `robot-model` takes it. Arrays have the same lengths; what is not finite was not measured.
    fn recording(&self) -> Recording {
        let measured = |value: f64| value.is_finite().then_some(value);
        let [t_s, left, right] = [&self.t_s, &self.left_rad, &self.right_rad].map(|b| of_bytes(b));
        let wheels = t_s.iter().zip(left.iter().zip(&right)).map(|(t_s, (left, right))| {
            WheelSample { t_s: *t_s, phi_rad: WheelPair::new(*left, *right) }
        });
        let [pose_t_s, x, y, heading] =
            [&self.pose_t_s, &self.x_m, &self.y_m, &self.heading_rad].map(|b| of_bytes(b));
        let poses = (0..pose_t_s.len()).map(|k| PoseMeasurement {
            t_s: pose_t_s[k],
            position_m: measured(x[k]).zip(measured(y[k])).map(|(x_m, y_m)| [x_m, y_m]),
            heading_rad: measured(heading[k]),
        });
        let [gyro_t_s, rates] = [&self.gyro_t_s, &self.gyro_rad_s].map(|b| of_bytes(b));
        let gyro = gyro_t_s.iter().zip(&rates);
        Recording {
            name: self.name.clone(),
            wheels: wheels.collect(),
            measured_poses: poses.collect(),
            gyro: gyro.map(|(t_s, rate)| GyroSample { t_s: *t_s, rate_rad_s: *rate }).collect(),
            ..Recording::default()
        }
    }
}

/// Writes a campaign folder.
#[pyfunction]
pub fn write_arrays(py: Python<'_>, folder: PathBuf, robot: Robot, runs: Vec<Run>) -> PyResult<()> {
    let robot = robot.file();
    py.detach(|| -> Result<(), CampaignError> {
        let writer = CampaignWriter::open(&folder, &robot)?;
        let rad_per_count = robot.to_model().rad_per_count;
        for run in &runs {
            let recording = run.recording();
            let mut columns = vec![Column::X, Column::Y, Column::Heading];
            columns.extend((!recording.gyro.is_empty()).then_some(Column::GyroZ));
            let mut file = writer.start_run(&run.name, &columns)?;
            for row in import::write::rows(&recording, &[], rad_per_count) {
                file.push(&row)?;
            }
            file.finish(RunFacts {
                started_s: run.started_s,
                payload_kg: run.payload_kg,
                held_out: run.held_out,
                ..RunFacts::default()
            })?;
        }
        Ok(())
    })
    .map_err(failed)
}

/// What is said about logs, as the options of `beeline import`.
#[derive(FromPyObject)]
pub struct Logs {
    sources: Vec<PathBuf>,
    wheels: Option<[String; 2]>,
    pose: Option<String>,
    odometry: Option<String>,
    controller: Option<PathBuf>,
    imu: Option<String>,
    mapping: Option<String>,
    name: Option<String>,
    wheel_radius_m: Option<f64>,
    track_width_m: Option<f64>,
    counts_per_rev: Option<f64>,
    gear_reduction: Option<f64>,
    rest_s: f64,
}

/// Imports logs into a folder; what was done and is to be known.
#[pyfunction]
pub fn write_logs(py: Python<'_>, folder: PathBuf, logs: Logs) -> PyResult<Vec<String>> {
    py.detach(|| {
        let mappings = logs.mapping.as_deref().map(parse_mappings).transpose().map_err(failed)?;
        let mappings = mappings.unwrap_or_default();
        let controller = logs.controller.as_deref().map(controller_file::read).transpose();
        let controller = controller.map_err(failed)?;
        let sheet = logs.wheel_radius_m.zip(logs.track_width_m);
        let sheet = sheet.map(|(radius_m, width_m)| Geometry::nominal(radius_m, width_m));
        let of_odometry = controller.map(|controller| controller.geometry).or(sheet);
        if logs.odometry.is_some() && controller.is_some_and(|controller| controller.is_open_loop) {
            return Err(failed("by open_loop, this odometry is what was commanded, and not what the wheels did"));
        }
        let odometry = match (logs.odometry, of_odometry) {
            (Some(_), None) => {
                return Err(failed(
                    "odometry needs the numbers that it was computed with: controller, or wheel_radius_m and track_width_m",
                ));
            }
            (topic, geometry) => topic.zip(geometry),
        };
        let of = controller.map(|controller| controller.geometry);
        let hints = Hints {
            name: logs.name.or_else(|| import::write::name_of(&folder)),
            wheel_radius_m: logs.wheel_radius_m.or(of.map(|of| of.wheel_radius_m)),
            track_width_m: logs.track_width_m.or(of.map(|of| of.wheel_separation_m)),
            counts_per_rev: logs.counts_per_rev,
            gear_reduction: logs.gear_reduction,
            cut: import::cut::CutOptions { rest_s: logs.rest_s, ..Default::default() },
        };
        let choice =
            Choice { wheels: logs.wheels, odometry, pose: logs.pose, imu: logs.imu, mappings };
        let understood = Sources::open(&logs.sources, &choice.mappings).and_then(|sources| {
            let chosen = sources.choose(&choice)?;
            let mut understood =
                understand(chosen.wheels, &chosen.poses, &hints, chosen.same_clock)?;
            understood.notes.splice(0..0, chosen.notes);
            import::write::write(&understood, &folder, false)?;
            Ok(understood)
        });
        let understood = understood.map_err(failed)?;
        Ok(understood.notes.iter().map(ToString::to_string).collect())
    })
}
