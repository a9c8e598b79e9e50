//! Converts a campaign as read into the one that `robot-model` takes: wheel angles, poses and the
//! yaw rate, each with its own times. What else may be wrong with a run is tested in `checks`.

use std::path::Path;

use robot_model::checks::{DataHypothesis, data_hypotheses, heading_offset};
use robot_model::clocks::align_roughly;
use robot_model::kinematics::WheelPair;
use robot_model::recording::{GyroSample, PoseMeasurement, Recording, Robot, WheelSample};

use crate::checks;
use crate::error::{CampaignError, Place, Warning};
use crate::recorded::{Campaign, Run};
use crate::robot_toml::RobotFile;
use crate::row::Row;
use crate::words::recording_problem;

/// The runs of a campaign as `robot-model` takes them, and what is wrong with them.
#[derive(Clone, Debug, PartialEq)]
pub struct Recordings {
    pub(crate) robot: Robot,
    pub(crate) runs: Vec<Recording>,
    pub(crate) data_hypotheses: Vec<DataHypothesis>,
    /// By how much the headings of all runs were turned, as recorded; here they are not \[rad\].
    pub(crate) turned_rad: Option<f64>,
}

impl Recordings {
    pub(crate) fn of(campaign: &Campaign) -> Self {
        let robot = campaign.robot.to_model();
        let mut runs: Vec<Recording> =
            campaign.runs.iter().map(|run| run.to_model(&robot)).collect();
        let are_valid = runs.iter().all(|run| run.validate().is_ok());
        let turned_rad = if are_valid { heading_offset(&robot, &runs) } else { None };
        let poses = runs.iter_mut().flat_map(|run| &mut run.measured_poses);
        for heading_rad in poses.filter_map(|pose| pose.heading_rad.as_mut()) {
            *heading_rad -= turned_rad.unwrap_or(0.0);
        }
        let data_hypotheses = match are_valid {
            true => {
                let recorded = robot_model::recording::Campaign { robot, runs: runs.clone() };
                data_hypotheses(&robot, &align_roughly(&recorded).runs)
            }
            false => Vec::new(),
        };
        Self { robot, runs, data_hypotheses, turned_rad }
    }

    /// What is wrong with the data, the best explanation first; empty if nothing is, or if a run cannot be used.
    pub fn data_hypotheses(&self) -> &[DataHypothesis] {
        &self.data_hypotheses
    }

    /// The same in words, each with where it is and what to do. `folder` is only named.
    pub fn data_errors(&self, campaign: &Campaign, folder: &Path) -> Vec<CampaignError> {
        checks::data_errors(folder, campaign, &self.data_hypotheses)
    }

    /// What is odd about the runs without being an error. `folder` is only named.
    pub(crate) fn warnings(&self, campaign: &Campaign, folder: &Path) -> Vec<Warning> {
        let robot_and_runs = (&self.robot, &self.runs[..]);
        checks::warnings(folder, campaign, robot_and_runs, &self.data_hypotheses, self.turned_rad)
    }

    /// The campaign for `robot-model`, if one robot can have driven it. `folder` is only named in
    /// errors.
    pub fn into_model(
        self,
        campaign: &Campaign,
        folder: &Path,
    ) -> Result<robot_model::recording::Campaign, CampaignError> {
        for (run, recording) in campaign.runs.iter().zip(&self.runs) {
            let file = folder.join("runs").join(format!("{}.csv", run.name));
            recording.validate().map_err(|error| {
                let hint = "a run needs encoder counts of both wheels in at least two rows";
                CampaignError::new(Place::whole(&file), recording_problem(error.problem), hint)
            })?;
        }
        checks::check(folder, campaign, (&self.robot, &self.runs), &self.data_hypotheses)?;
        if campaign.runs.iter().all(|run| run.facts.held_out) {
            let problem = match campaign.runs.len() {
                1 => "the only run is held out, so none is left to fit".to_owned(),
                n => format!("all {n} runs are held out, so none is left to fit"),
            };
            let place = Place::whole(&folder.join("robot.toml"));
            let hint = "remove held_out = true from the runs that a model is to be fitted to";
            return Err(CampaignError::new(place, problem, hint));
        }
        if !campaign.runs.iter().any(|run| run.has_poses() && !run.facts.held_out) {
            let headings = self.runs.iter().any(|run| !run.measured_poses.is_empty());
            let problem = match headings {
                true => {
                    "no run of this campaign has measured positions; headings alone are not enough"
                }
                false => "no run of this campaign has measured poses",
            };
            let mut rows = campaign.runs.iter().flat_map(|run| &run.rows);
            let hint = match rows.any(|row| row.applied_v.left.is_some()) {
                // Those of `tune --record`.
                true => {
                    "these runs have voltages: explain, compare and report them with --drivetrain"
                }
                false => {
                    "fill in x_m, y_m and heading_rad, at least at the start and the end of a run"
                }
            };
            return Err(CampaignError::new(Place::whole(folder), problem, hint));
        }
        Ok(robot_model::recording::Campaign { robot: self.robot, runs: self.runs })
    }
}

impl Campaign {
    /// The campaign for `robot-model`. `folder` is only named in errors.
    pub fn to_model(
        &self,
        folder: &Path,
    ) -> Result<robot_model::recording::Campaign, CampaignError> {
        Recordings::of(self).into_model(self, folder)
    }

    /// Whether poses are known only at the beginning and the end of runs, as measured with a tape.
    pub fn is_measured_at_ends(&self) -> bool {
        let poses = || self.runs.iter().map(Run::poses);
        poses().any(|count| count > 0) && poses().all(|count| count <= 2)
    }

    /// The runs without measured poses, from which nothing can be learnt.
    pub fn without_poses(&self) -> Vec<&str> {
        let blind = self.runs.iter().filter(|run| !run.has_poses());
        blind.map(|run| run.name.as_str()).collect()
    }
}

impl RobotFile {
    /// The nominal robot for `robot_model`.
    pub fn to_model(&self) -> Robot {
        Robot {
            wheel_radius_m: self.wheel_radius_m,
            track_width_m: self.track_width_m,
            gear_reduction: self.gear_reduction,
            rad_per_count: std::f64::consts::TAU / (self.counts_per_rev * self.gear_reduction),
            position_sigma_m: self.position_sigma_m,
            heading_sigma_rad: self.heading_sigma_rad,
        }
    }
}

impl Run {
    /// The number of rows with a measured pose.
    fn poses(&self) -> usize {
        let posed = |row: &&Row| row.x_m.is_some() || row.heading_rad.is_some();
        self.rows.iter().filter(posed).count()
    }

    /// Whether the run has a measured position, and a position or heading measured after it.
    fn has_poses(&self) -> bool {
        let position = |row: &&Row| row.x_m.is_some() && row.y_m.is_some();
        let measured = |row: &&Row| position(row) || row.heading_rad.is_some();
        self.rows.iter().skip_while(|row| !position(row)).filter(measured).count() > 1
    }

    /// The run as `robot-model` takes it, driven by this robot.
    pub fn to_recording(&self, robot: &RobotFile) -> Recording {
        self.to_model(&robot.to_model())
    }

    fn to_model(&self, robot: &Robot) -> Recording {
        let mut recording = Recording {
            name: self.name.clone(),
            started_s: self.facts.started_s,
            payload_kg: self.facts.payload_kg.unwrap_or(0.0),
            held_out: self.facts.held_out,
            ..Recording::default()
        };
        for row in &self.rows {
            let t_s = row.t_s;
            if let (Some(left), Some(right)) = (row.counts.left, row.counts.right) {
                let phi_rad =
                    WheelPair::new(left, right).map(|counts| counts * robot.rad_per_count);
                recording.wheels.push(WheelSample { t_s, phi_rad });
            }
            let position_m = row.x_m.zip(row.y_m).map(|(x_m, y_m)| [x_m, y_m]);
            if position_m.is_some() || row.heading_rad.is_some() {
                recording.measured_poses.push(PoseMeasurement {
                    t_s,
                    position_m,
                    heading_rad: row.heading_rad,
                });
            }
            if let Some(rate_rad_s) = row.gyro_z_rad_s {
                recording.gyro.push(GyroSample { t_s, rate_rad_s });
            }
        }
        recording
    }
}
