//! The runs of a campaign as trajectories: as measured, by odometry with given radii and track width, and as a model predicts
//! them.

use std::fmt::Write as _;

use robot_model::compare::RunPredicted;
use robot_model::recording::{Campaign, Recording};

use super::telemetry::Telemetry;

/// A pose at a time: time \[s\], x, y \[m\], heading \[rad\].
type Timed = (f64, [f64; 3]);

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// The run.
    pub run: String,
    /// When it began, on one clock for all \[s\].
    pub started_s: f64,
    /// Angles of the left and the right wheel over time \[s, rad\].
    pub wheels: Vec<(f64, [f64; 2])>,
    /// As measured: a heading where there is one.
    pub measured: Vec<(f64, [f64; 2], Option<f64>)>,
    /// What a model predicts for each measured pose, at its time by the clock of the wheels, where it was asked
    /// ([`Trajectory::add_predictions`]).
    pub predicted: Vec<Option<Timed>>,
    /// By odometry, from the first measured pose on.
    pub odometry: Vec<Timed>,
    /// Travel and turn per second before each sample of the odometry \[m/s, rad/s\].
    pub speeds: Vec<[f64; 2]>,
    /// What else the robot told of itself; for bags alone.
    pub telemetry: Telemetry,
}

/// Between two runs, where nobody knows when they began \[s\].
const BETWEEN_S: f64 = 10.0;

impl Trajectory {
    /// All runs of a campaign, by these radii and this track width \[m\].
    pub fn all(campaign: &Campaign, radii_m: [f64; 2], track_width_m: f64) -> Vec<Self> {
        let mut next_s = 0.0;
        campaign
            .runs
            .iter()
            .map(|run| {
                let started_s = run.started_s.unwrap_or(next_s);
                next_s = started_s + run.duration_s() + BETWEEN_S;
                Self::of(run, started_s, radii_m, track_width_m)
            })
            .collect()
    }

    fn of(run: &Recording, started_s: f64, radii_m: [f64; 2], track_width_m: f64) -> Self {
        let wheels: Vec<(f64, [f64; 2])> = run
            .wheels
            .iter()
            .map(|sample| (sample.t_s, [sample.phi_rad.left, sample.phi_rad.right]))
            .collect();
        let measured: Vec<_> = run
            .measured_poses
            .iter()
            .filter_map(|pose| Some((pose.t_s, pose.position_m?, pose.heading_rad)))
            .collect();
        let start = measured
            .first()
            .map_or([0.0; 3], |(_, [x, y], heading)| [*x, *y, heading.unwrap_or(0.0)]);
        let steps = steps(&wheels, radii_m, track_width_m);
        let odometry = odometry(&wheels, &steps, start);
        let speeds = speeds(&wheels, &steps);
        let (run, telemetry) = (run.name.clone(), Telemetry::default());
        let predicted = vec![None; measured.len()];
        Self { run, started_s, wheels, measured, predicted, odometry, speeds, telemetry }
    }

    /// Adds what a model predicts for the measured poses of these runs.
    pub fn add_predictions(all: &mut [Self], runs: &[RunPredicted]) {
        for one in all {
            let Some(run) = runs.iter().find(|run| run.run == one.run) else { continue };
            // By the clock of the wheels their times may be others; they are in the same order, but for those that no model
            // predicts.
            let mut poses = run.measured.iter().zip(&run.predicted);
            for ((_, position_m, _), predicted) in one.measured.iter().zip(&mut one.predicted) {
                let mut ahead = poses.clone();
                let found = ahead.find(|(measured, _)| measured.position_m == Some(*position_m));
                let Some((measured, pose)) = found else { continue };
                *predicted = Some((measured.t_s, [pose.x_m, pose.y_m, pose.heading_rad]));
                poses = ahead;
            }
        }
    }

    /// Measured minus predicted, at the time of each prediction: ahead and to the left of the predicted robot \[m\], and in
    /// heading \[rad\], NaN where none was measured.
    pub(super) fn residuals(&self) -> impl Iterator<Item = Timed> {
        let both = self.measured.iter().zip(&self.predicted);
        both.filter_map(|((t_s, [x, y], heading), predicted)| {
            let (_, [predicted_x, predicted_y, predicted_heading]) = (*predicted)?;
            let (sin, cos) = predicted_heading.sin_cos();
            let (dx, dy) = (x - predicted_x, y - predicted_y);
            let turned = heading.map_or(f64::NAN, |heading| {
                let turned = heading - predicted_heading;
                turned.sin().atan2(turned.cos())
            });
            Some((*t_s, [dx * cos + dy * sin, dy * cos - dx * sin, turned]))
        })
    }

    /// Adds what the robot told of itself in the runs of this name.
    pub fn add_telemetry(all: &mut [Self], runs: &[campaign::Run]) {
        for one in all {
            if let Some(run) = runs.iter().find(|run| run.name == one.run) {
                one.telemetry = Telemetry::of(&run.rows);
            }
        }
    }

    /// The measured poses as a TUM trajectory, for example for `evo`.
    pub fn measured_tum(&self) -> String {
        let poses = self
            .measured
            .iter()
            .map(|(t_s, [x, y], heading)| (*t_s, [*x, *y, heading.unwrap_or(0.0)]));
        tum(self.started_s, poses)
    }

    /// What is predicted as a TUM trajectory, at the times of the measured poses.
    pub fn predicted_tum(&self) -> String {
        let both = self.measured.iter().zip(&self.predicted);
        let poses = both.filter_map(|((t_s, ..), predicted)| Some((*t_s, (*predicted)?.1)));
        tum(self.started_s, poses)
    }

    /// The odometry as a TUM trajectory.
    pub fn odometry_tum(&self) -> String {
        tum(self.started_s, self.odometry.iter().copied())
    }
}

/// How far the robot went and turned before each sample; nothing before the first.
fn steps(wheels: &[(f64, [f64; 2])], radii_m: [f64; 2], track_width_m: f64) -> Vec<[f64; 2]> {
    let mut before: Option<[f64; 2]> = None;
    let step = |(_, phi_rad): &(f64, [f64; 2])| {
        let from = before.replace(*phi_rad).unwrap_or(*phi_rad);
        let rolled = [0, 1].map(|side| radii_m[side] * (phi_rad[side] - from[side]));
        [(rolled[0] + rolled[1]) / 2.0, (rolled[1] - rolled[0]) / track_width_m]
    };
    wheels.iter().map(step).collect()
}

/// Where steps lead: each is an arc.
fn odometry(wheels: &[(f64, [f64; 2])], steps: &[[f64; 2]], start: [f64; 3]) -> Vec<Timed> {
    let mut pose = start;
    wheels
        .iter()
        .zip(steps)
        .map(|((t_s, _), [travel, turn])| {
            let half = turn / 2.0;
            let chord = if half.abs() < 1e-9 { *travel } else { travel * half.sin() / half };
            let (sin, cos) = (pose[2] + half).sin_cos();
            pose = [pose[0] + chord * cos, pose[1] + chord * sin, pose[2] + turn];
            (*t_s, pose)
        })
        .collect()
}

/// How fast the steps were.
fn speeds(wheels: &[(f64, [f64; 2])], steps: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut before_s: Option<f64> = None;
    let speeds = wheels.iter().zip(steps).map(|((t_s, _), step)| {
        let dt_s = before_s.replace(*t_s).map_or(0.0, |before_s| t_s - before_s);
        step.map(|part| if dt_s > 0.0 { part / dt_s } else { 0.0 })
    });
    speeds.collect()
}

fn tum(started_s: f64, poses: impl Iterator<Item = Timed>) -> String {
    let mut text = String::new();
    for (t_s, [x, y, heading]) in poses {
        let (sin, cos) = (heading / 2.0).sin_cos();
        let _ = writeln!(text, "{:.6} {x:.7} {y:.7} 0 0 0 {sin:.9} {cos:.9}", started_s + t_s);
    }
    text
}

/// All runs in one CSV table. A row has the wheels and the odometry, or a measured pose and what the model predicts for it.
pub fn table(trajectories: &[Trajectory]) -> String {
    let mut text = "run,t_s,left_rad,right_rad,odometry_x_m,odometry_y_m,odometry_heading_rad,x_m,y_m,heading_rad,\
                    predicted_t_s,predicted_x_m,predicted_y_m,predicted_heading_rad\n"
        .to_owned();
    for one in trajectories {
        // The name of a file may have an end of a line in it, and a separator.
        let name: String = one.run.chars().map(|c| if c.is_control() { '?' } else { c }).collect();
        let quoted = format!("\"{}\"", name.replace('"', "\"\""));
        let run = if name.contains([',', '"']) { &quoted } else { &name };
        let wheels = one.wheels.iter().zip(&one.odometry).map(
            |((t_s, [left, right]), (_, [x, y, heading]))| {
                (*t_s, format!("{left:.7},{right:.7},{x:.7},{y:.7},{heading:.7},,,,,,,"))
            },
        );
        let poses = one.measured.iter().zip(&one.predicted);
        let poses = poses.map(|((t_s, [x, y], heading), predicted)| {
            let heading = heading.map_or_else(String::new, |heading| format!("{heading:.7}"));
            let predicted = predicted.map_or_else(
                || ",,,".to_owned(),
                |(t_s, [x, y, heading])| format!("{t_s:.6},{x:.7},{y:.7},{heading:.7}"),
            );
            (*t_s, format!(",,,,,{x:.7},{y:.7},{heading},{predicted}"))
        });
        let mut rows: Vec<(f64, String)> = wheels.chain(poses).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (t_s, cells) in rows {
            let _ = writeln!(text, "{run},{t_s:.6},{cells}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odometry_goes_straight_and_round() {
        // A quarter of a circle of 1 m to the left, wheels of 0.1 m and 0.2 m, 0.5 m apart, in two steps.
        let quarter = std::f64::consts::FRAC_PI_2;
        let wheels = [0.0, 0.5, 1.0]
            .map(|share| (share, [share * 0.75 * quarter / 0.1, share * 1.25 * quarter / 0.2]));
        let steps = steps(&wheels, [0.1, 0.2], 0.5);
        let poses = odometry(&wheels, &steps, [1.0, 2.0, 0.0]);
        let (_, [x, y, heading]) = poses[2];
        assert!(
            (x - 2.0).abs() < 1e-12 && (y - 3.0).abs() < 1e-12 && (heading - quarter).abs() < 1e-12,
            "{poses:?}"
        );
        let [_, [travel_mps, turn_rad_s], _] = speeds(&wheels, &steps)[..] else { panic!("three") };
        assert!((travel_mps - quarter).abs() < 1e-12 && (turn_rad_s - quarter).abs() < 1e-12);
    }
}
