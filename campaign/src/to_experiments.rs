//! Converts a campaign as read into experiments with the motors: voltages and counts. Poses are not needed.

use std::f64::consts::TAU;
use std::path::Path;

use robot_model::drivetrain::{Experiment, KnownRobot, Sample, VoltageRecording};
use robot_model::kinematics::WheelPair;

use crate::error::{CampaignError, Place};
use crate::recorded::{Campaign, Run};
use crate::row::Row;

/// Longest time between two rows, in the middle of a run \[s\].
const GAP_S_MAX: f64 = 0.2;
/// Faster by its counts no wheel is \[m/s\].
const SPEED_MPS_MAX: f64 = 50.0;

/// One run as an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorRun {
    /// File name without `.csv`.
    pub name: String,
    /// What was applied, and how far the wheels went.
    pub experiment: Experiment,
}

/// The experiments of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiments {
    /// What is known about the robot.
    pub robot: KnownRobot,
    /// The runs that have voltages and turn a wheel.
    pub runs: Vec<MotorRun>,
    /// Those that were left out: without voltages, or without motion.
    pub left_out: Vec<String>,
    /// Without `started_s` of every run, nothing can be said about changes with time.
    pub has_times: bool,
}

impl Campaign {
    /// The runs as experiments with the motors. `folder` is only named.
    pub fn experiments(&self, folder: &Path) -> Result<Experiments, CampaignError> {
        let robot = &self.robot;
        let per_turn = robot.counts_per_rev * robot.gear_reduction;
        let known = KnownRobot {
            wheel_radius_m: robot.wheel_radius_m,
            track_width_m: robot.track_width_m,
            gear_reduction: robot.gear_reduction,
            meters_per_count: TAU * robot.wheel_radius_m / per_turn,
        };
        let has_times = self.runs.iter().all(|run| run.facts.started_s.is_some());
        let first_s =
            self.runs.iter().filter_map(|run| run.facts.started_s).fold(f64::MAX, f64::min);
        let (mut runs, mut left_out) = (Vec::new(), Vec::new());
        let mut first_m: Option<WheelPair<f64>> = None;
        for run in &self.runs {
            let samples = samples(run, known.meters_per_count, robot.supply_v);
            believable(&run.name, &samples, folder)?;
            let moves = samples.iter().any(|sample| {
                let moved = sample.travel_m.since(samples[0].travel_m);
                moved.left != 0.0 || moved.right != 0.0
            });
            match VoltageRecording::new(samples) {
                Some(recording) if moves => {
                    let begins_m = recording.samples()[0].travel_m;
                    let since_m = begins_m.since(*first_m.get_or_insert(begins_m));
                    let heading_rad = (since_m.right - since_m.left) / known.track_width_m;
                    let started_s = if has_times {
                        run.facts.started_s.unwrap_or(first_s) - first_s
                    } else {
                        0.0
                    };
                    let held_out = run.facts.held_out;
                    let experiment = Experiment { recording, started_s, heading_rad, held_out };
                    runs.push(MotorRun { name: run.name.clone(), experiment });
                }
                _ => left_out.push(run.name.clone()),
            }
        }
        if runs.is_empty() {
            let problem = "no run has voltages of both motors and turns a wheel";
            let hint = "the columns are left_v and right_v, or left_duty and right_duty with bus_v; \
                        `beeline tune --record FOLDER` writes such a campaign";
            return Err(CampaignError::new(Place::whole(folder), problem, hint));
        }
        Ok(Experiments { robot: known, runs, left_out, has_times })
    }
}

/// Motors answer within a fraction of a second, and no wheel is faster than a train: an error where rows say otherwise.
fn believable(run: &str, samples: &[Sample], folder: &Path) -> Result<(), CampaignError> {
    let error = |problem: String, hint: &str| {
        let file = folder.join("runs").join(format!("{run}.csv"));
        Err(CampaignError::new(Place::whole(&file), problem, hint))
    };
    let mut gaps_s: Vec<f64> = samples.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).collect();
    gaps_s.sort_by(f64::total_cmp);
    if let Some(gap_s) = gaps_s.get(gaps_s.len() / 2).filter(|gap_s| **gap_s > GAP_S_MAX) {
        return error(
            format!(
                "a row every {gap_s:.3} s: motors answer faster, so that their constants cannot be told"
            ),
            "record at least 5 rows a second, better 200; if t_s is in milliseconds, give it in seconds",
        );
    }
    let fastest = samples.windows(2).filter(|pair| pair[1].t_s > pair[0].t_s).find(|pair| {
        let moved = pair[1].travel_m.since(pair[0].travel_m);
        moved.left.abs().max(moved.right.abs()) > SPEED_MPS_MAX * (pair[1].t_s - pair[0].t_s)
    });
    match fastest {
        Some(pair) => error(
            format!(
                "after {:.3} s a wheel goes faster than {SPEED_MPS_MAX:.0} m/s by its counts",
                pair[0].t_s
            ),
            "a counter that was set back, or a wrong digit; counts_per_rev or wheel_radius_m in robot.toml may be wrong as well",
        ),
        None => Ok(()),
    }
}

/// From the last row at rest before the first voltage on; empty without voltages.
fn samples(run: &Run, meters_per_count: f64, supply_v: Option<f64>) -> Vec<Sample> {
    let mut all: Vec<Sample> = Vec::new();
    let mut applied_vs = WheelPair::both(0.0);
    let mut before: Option<&Row> = None;
    let mut first_volts = None;
    for row in &run.rows {
        let (Some(left), Some(right)) = (row.counts.left, row.counts.right) else { continue };
        if let Some(before) = before {
            let dt_s = row.t_s - before.t_s;
            let Some(volts) = mean_volts(before, row, supply_v) else { continue };
            applied_vs.left += volts.left * dt_s;
            applied_vs.right += volts.right * dt_s;
            if first_volts.is_none() && (volts.left != 0.0 || volts.right != 0.0) {
                first_volts = Some(all.len());
            }
        }
        let travel_m = WheelPair::new(left * meters_per_count, right * meters_per_count);
        all.push(Sample { t_s: row.t_s, travel_m, applied_vs });
        before = Some(row);
    }
    match first_volts {
        Some(first) => all.split_off(first.saturating_sub(1)),
        None => Vec::new(),
    }
}

/// The motors' voltages between two rows: as measured, or by duty and supply.
fn mean_volts(before: &Row, row: &Row, supply_v: Option<f64>) -> Option<WheelPair<f64>> {
    if let (Some(left), Some(right)) = (row.applied_v.left, row.applied_v.right) {
        return Some(WheelPair::new(left, right));
    }
    let volts = |row: &Row| {
        let bus_v = row.bus_v.or(supply_v)?;
        Some(WheelPair::new(row.duty.left? * bus_v, row.duty.right? * bus_v))
    };
    let (then, now) = (volts(before)?, volts(row)?);
    Some(then.toward(now, 0.5))
}

#[cfg(test)]
mod tests {
    use shared_proto::WheelPair as Pair;

    use super::*;
    use crate::robot_toml::{RobotFile, RunFacts};

    fn campaign(rows: Vec<Row>) -> Campaign {
        let robot = RobotFile::of(&shared_proto::Config::default());
        let run = Run { name: "01_steps".into(), facts: RunFacts::default(), rows };
        Campaign { robot, runs: vec![run], copies: Vec::new(), warnings: Vec::new() }
    }

    fn row(step: usize, counts: f64) -> Row {
        let t_s = 0.01 * step as f64;
        Row { t_s, counts: Pair::both(Some(counts)), ..Row::default() }
    }

    #[test]
    fn measured_voltages_are_summed_up_and_the_rest_before_them_is_left_out() {
        let volts = [0.0, 0.0, 0.0, 2.0, 4.0, 4.0];
        let rows = volts.iter().enumerate().map(|(step, volts)| Row {
            applied_v: Pair::both(Some(*volts)),
            ..row(step, step as f64)
        });
        let found = campaign(rows.collect()).experiments(Path::new("x")).unwrap();
        let samples = found.runs[0].experiment.recording.samples();
        assert_eq!(samples.len(), 4);
        assert!((samples[3].applied_vs.left - 0.1).abs() < 1e-12, "{samples:?}");
        let step_m = TAU * 0.036 / 900.0;
        assert!((samples[1].travel_m.left - samples[0].travel_m.left - step_m).abs() < 1e-9);
    }

    #[test]
    fn duty_and_supply_take_their_place_and_without_both_nothing_is_made_up() {
        let with = |bus_v: Option<f64>| {
            let rows = (0..6).map(|step| Row {
                duty: Pair::both(Some(if step > 1 { 0.5 } else { 0.0 })),
                bus_v,
                ..row(step, step as f64)
            });
            campaign(rows.collect()).experiments(Path::new("x"))
        };
        let found = with(Some(12.0)).unwrap();
        let samples = found.runs[0].experiment.recording.samples();
        let end = samples[samples.len() - 1].applied_vs.right;
        assert!((end - (0.5 + 3.0) * 6.0 * 0.01).abs() < 1e-12, "{end}");
        let error = with(None).unwrap_err().to_string();
        assert!(error.contains("no run has voltages"), "{error}");
    }

    #[test]
    fn rows_in_milliseconds_and_counts_that_jump_are_errors_with_their_file() {
        let with = |times: f64, last: f64| {
            let rows = (0..6).map(|step| {
                let counts = if step == 5 { last } else { step as f64 };
                let row = row(step, counts);
                Row { t_s: times * row.t_s, applied_v: Pair::both(Some(2.0)), ..row }
            });
            campaign(rows.collect()).experiments(Path::new("x"))
        };
        assert!(with(1.0, 5.0).is_ok());
        let error = with(1000.0, 5.0).unwrap_err().to_string();
        assert!(error.contains("01_steps.csv") && error.contains("a row every 10"), "{error}");
        let error = with(1.0, 1_073_741_824.0).unwrap_err().to_string();
        assert!(error.contains("faster than 50 m/s"), "{error}");
    }
}
