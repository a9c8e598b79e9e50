//! What two logs say: the robot, how the clocks go together, and the runs.
//!
//! ```text
//! wheels --unwrap--> radians --+                              +--> runs --mend--> axes --clocks--> a campaign
//! poses  --plane---> floor   --+--align--> one clock --cut----+
//! ```

mod hints;
mod nominal;
mod speed_alignment;

use std::collections::HashSet;
use std::path::Path;

use campaign::words::recording_error;
use campaign::{CampaignError, RobotFile};
use robot_model::clocks::{self, ClockFound};
use robot_model::kinematics::WheelPair;
use robot_model::recording::{
    Campaign, GyroSample, PoseMeasurement, Recording, RunKind, WheelSample,
};

use crate::alignment::{Alignment, Speeds};
use crate::cut::{Begins, CutOptions, Piece, ROLLED_MIN_RAD, cut};
use crate::gyro::yaw_rates;
use crate::log::{Note, PoseLog, WheelLog, error};
use crate::mend::{mend, words};
use crate::outliers::leave_out;
use crate::plane::{FlatPose, flat};
use crate::turns;
pub use hints::Hints;
use nominal::{in_radians, robot, units_per_m};
use speed_alignment::{aligned_by_speed, speeds_together};

/// A log, understood.
#[derive(Clone, Debug)]
pub struct Understood {
    /// The nominal robot.
    pub robot: RobotFile,
    /// Radius and track width were estimated from this log, as nobody gave them.
    pub is_estimated: [bool; 2],
    /// The runs, in order.
    pub runs: Vec<RunUnderstood>,
    /// What was left out, and why.
    pub left_out: Vec<LeftOut>,
    /// How the clocks go together.
    pub clock: ClockUnderstood,
    /// What else a user should know.
    pub notes: Vec<Note>,
    /// Speeds of wheels and poses on the clock of the wheels, and what makes metres of those of the wheels.
    pub speeds: Option<([Speeds; 2], Alignment)>,
}

/// One run.
#[derive(Clone, Debug)]
pub struct RunUnderstood {
    /// Its name, without a number.
    pub name: String,
    /// Its kind.
    pub kind: RunKind,
    /// Why it begins where it does.
    pub begins: Begins,
    /// When it began, by the clock of the wheels \[s\].
    pub started_s: f64,
    /// Wheels, poses and gyro on one clock, which begins with the run.
    pub recording: Recording,
    /// Voltages of the battery on the same clock \[s, V\].
    pub supply_v: Vec<(f64, f64)>,
}

/// A part of the log that is no run.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// By the clock of the wheels \[s\].
    pub from_s: f64,
    /// By the clock of the wheels \[s\].
    pub to_s: f64,
    /// Why.
    pub why: String,
}

/// How the clocks of wheels and poses go together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockUnderstood {
    /// How late the poses are: their time less that of the wheels, in the middle of the log \[s\].
    pub late_s: f64,
    /// Which share of the poses' time that of the wheels is short of, if their clock is faster.
    pub drift: f64,
    /// Its standard error \[s\]; zero if both were taken for one clock.
    pub sigma_s: f64,
    /// Runs had offsets of their own, or clocks of different rates.
    pub differs_by_run: bool,
}

/// Fewer samples are no log.
const SAMPLES_MIN: usize = 10;
/// Both in one bag, and apart by less: one clock, and the delay of a camera, which is left to `explain` \[s\].
const DELAY_MAX_S: f64 = 0.25;
/// Of one drive, clocks are brought together to milliseconds, and to this at worst \[s\].
const CLOCK_SIGMA_MAX_S: f64 = 0.04;
/// Fewer poses in a run show nothing.
const POSES_MIN: usize = 2;

/// Understands two logs. `same_clock`: both are of one recorder, whose stamps should agree.
pub fn understand(
    mut wheels: WheelLog,
    poses: &PoseLog,
    hints: &Hints,
    same_clock: bool,
) -> Result<Understood, CampaignError> {
    for (file, what, count) in [
        (&wheels.file, &wheels.what, wheels.t_s.len()),
        (&poses.file, &poses.what, poses.poses.len()),
    ] {
        if count < SAMPLES_MIN {
            let problem = format!("{what} has only {count} samples");
            return Err(error(
                file,
                problem,
                "choose another topic or column, or record for longer",
            ));
        }
    }
    if turns::are_of_two_robots(&wheels) {
        let problem =
            format!("{} goes to and fro from sample to sample, as of two robots", wheels.what);
        let hint = "record each robot under a name of its own, as /robot1/joint_states";
        return Err(error(&wheels.file, problem, hint));
    }
    let mut notes: Vec<Note> =
        turns::unwrap(&mut wheels).into_iter().map(|said| Note::new(&wheels.file, said)).collect();
    let counts_per_rev = in_radians(&mut wheels, hints)?;
    let (yaw_rates, said) = yaw_rates(&wheels);
    notes.extend(said.map(|said| Note::new(&wheels.file, said)));
    let mut flat = flat(poses);
    notes.extend(flat.said.drain(..).map(|said| Note::new(&poses.file, said)));
    let (speeds, alignment, said) = aligned_by_speed(&mut wheels, poses, &flat.poses, hints)?;
    notes.extend(said);
    let are_related = same_clock && alignment.late_s.abs() < DELAY_MAX_S && alignment.drift == 0.0;
    let (late_s, drift) =
        if are_related { (0.0, 0.0) } else { (alignment.late_s, alignment.drift) };
    if !are_related {
        flat.poses.iter_mut().for_each(|pose| pose.t_s = alignment.by_wheels_s(pose.t_s));
    }
    let speeds = speeds_together(speeds, &alignment, late_s);
    let (robot, is_estimated) = robot(&wheels, poses, hints, counts_per_rev, &alignment)?;
    let options = CutOptions { units_per_m: units_per_m(&alignment, hints), ..hints.cut };
    let pieces = cut(&wheels.t_s, &wheels.turned, &flat.poses, options);
    if pieces.is_empty() {
        let hint = "a run begins and ends at standstill; give a log in which the robot drives";
        let problem = format!(
            "the robot drives nowhere in this log: in no move does a wheel turn by {ROLLED_MIN_RAD} rad"
        );
        return Err(error(&wheels.file, problem, hint));
    }
    let mut understood = Understood {
        robot,
        is_estimated,
        runs: Vec::new(),
        left_out: Vec::new(),
        clock: ClockUnderstood { late_s, drift, sigma_s: 0.0, differs_by_run: false },
        notes,
        speeds: Some((speeds, alignment)),
    };
    understood.take_runs(&wheels, &flat.poses, &pieces);
    drop(flat);
    let WheelLog { file, gyro_and_supply, .. } = wheels;
    understood.take_yaw_rates(&yaw_rates);
    understood.finish(&file, &poses.file, are_related)?;
    understood.take_supply(&gyro_and_supply.supply_v);
    Ok(understood)
}

impl Understood {
    /// When the first run began, or what was left out before it, by the clock of the wheels \[s\].
    pub fn begin_s(&self) -> f64 {
        let runs = self.runs.iter().map(|run| run.started_s);
        let left_out = self.left_out.iter().map(|left| left.from_s);
        runs.chain(left_out).fold(f64::INFINITY, f64::min)
    }

    /// Takes out what is left of the clocks' drift, which shows better by the runs than by their speeds; in a short log, twice.
    fn correct_drift(&mut self, campaign: &mut Campaign) {
        for _ in 0..2 {
            let Ok(Some(drift)) = clocks::drift(campaign) else { return };
            for run in &mut campaign.runs {
                let from_middle_s = run.started_s.unwrap_or(0.0) - drift.middle_s;
                let poses = run.measured_poses.iter_mut();
                poses.for_each(|pose| pose.t_s -= drift.rate * (from_middle_s + pose.t_s));
            }
            self.clock.drift += drift.rate * (1.0 - self.clock.drift);
        }
    }

    /// By the speeds of wheels and poses, one wheel counts backwards.
    fn one_reversed(&self) -> bool {
        self.speeds.as_ref().is_some_and(|(_, alignment)| alignment.one_reversed)
    }

    /// Takes the pieces of the log as runs; those without poses are left out.
    fn take_runs(&mut self, wheels: &WheelLog, poses: &[FlatPose], pieces: &[Piece]) {
        for (number, piece) in pieces.iter().enumerate() {
            let times = &wheels.t_s[piece.from..=piece.to];
            let (from_s, to_s) = (times[0], times[times.len() - 1]);
            let from = poses.partition_point(|pose| pose.t_s < from_s);
            let to = poses.partition_point(|pose| pose.t_s <= to_s).max(from);
            if to - from < POSES_MIN {
                let why = "no pose was measured in it".into();
                self.left_out.push(LeftOut { from_s, to_s, why });
                continue;
            }
            let samples = times.iter().zip(&wheels.turned[piece.from..=piece.to]);
            let recording = Recording {
                // A name for now: the order in the log.
                name: number.to_string(),
                started_s: Some(from_s),
                wheels: samples
                    .map(|(t_s, [left, right])| WheelSample {
                        t_s: t_s - from_s,
                        phi_rad: WheelPair::new(*left, *right),
                    })
                    .collect(),
                measured_poses: poses[from..to]
                    .iter()
                    .map(|pose| PoseMeasurement {
                        t_s: pose.t_s - from_s,
                        position_m: Some(pose.position_m),
                        heading_rad: pose.heading_rad,
                    })
                    .collect(),
                ..Recording::default()
            };
            let kind = RunKind::Rest;
            self.runs.push(RunUnderstood {
                name: String::new(),
                kind,
                begins: piece.begins,
                started_s: from_s,
                recording,
                supply_v: Vec::new(),
            });
        }
    }

    /// Gives each run its yaw rates.
    fn take_yaw_rates(&mut self, yaw_rates: &[GyroSample]) {
        for run in &mut self.runs {
            let own = within(yaw_rates, run.started_s, &run.recording, |sample| sample.t_s);
            let shifted = own.iter().map(|s| GyroSample { t_s: s.t_s - run.started_s, ..*s });
            run.recording.gyro = shifted.collect();
        }
    }

    /// Gives each run its voltages.
    fn take_supply(&mut self, supply_v: &[(f64, f64)]) {
        for run in &mut self.runs {
            let own = within(supply_v, run.started_s, &run.recording, |sample| sample.0);
            run.supply_v = own.iter().map(|(t_s, volts)| (t_s - run.started_s, *volts)).collect();
        }
    }

    /// Mends the axes, brings the clocks together exactly, leaves out what contradicts itself, and names what is left.
    fn finish(
        &mut self,
        wheels: &Path,
        poses: &Path,
        are_related: bool,
    ) -> Result<(), CampaignError> {
        if self.runs.is_empty() {
            let problem = format!("none of {} runs has measured poses", self.left_out.len());
            return Err(error(
                poses,
                problem,
                "the poses must cover the drive; check that both logs are of the same time",
            ));
        }
        let robot = self.robot.to_model();
        let begun: Vec<(String, Begins)> =
            self.runs.iter().map(|run| (run.recording.name.clone(), run.begins)).collect();
        // A long log is large: of its samples there are as few copies as can be.
        let runs = self.runs.drain(..).map(|run| run.recording).collect();
        let mut campaign = Campaign { robot, runs };
        let (said, of_runs) = mend(&mut campaign, self.one_reversed())
            .map_err(|undecided| error(wheels, undecided.problem, undecided.hint))?;
        self.notes.extend(said.into_iter().map(|said| Note::new(poses, said)));
        let faulty: HashSet<&str> = of_runs
            .iter()
            .filter(|found| !found.what.is_minor())
            .filter_map(|found| found.run.as_deref())
            .collect();
        if 2 * faulty.len() > campaign.runs.len() {
            let problem = format!(
                "in {} of {} runs the poses contradict the wheels",
                faulty.len(),
                campaign.runs.len()
            );
            return Err(error(poses, problem, "check that wheels and poses are of the same robot"));
        }
        for run in campaign.runs.iter().filter(|run| faulty.contains(run.name.as_str())) {
            let found = of_runs.iter().find(|found| found.run.as_ref() == Some(&run.name));
            let why = found.map_or_else(String::new, |found| words(&found.what));
            let from_s = run.started_s.unwrap_or(0.0);
            self.left_out.push(LeftOut { from_s, to_s: from_s + run.duration_s(), why });
        }
        campaign.runs.retain(|run| !faulty.contains(run.name.as_str()));
        self.notes.extend(leave_out(&mut campaign).map(|said| Note::new(poses, said)));
        if !are_related {
            self.correct_drift(&mut campaign);
        }
        let aligned =
            if are_related { clocks::align(&campaign) } else { clocks::align_unrelated(&campaign) };
        drop(campaign);
        let (campaign, clocks) =
            aligned.map_err(|why| error(wheels, recording_error(&why), "record the log again"))?;
        self.clock.add(&clocks, campaign.runs.len());
        self.clock.check(poses)?;
        for mut recording in campaign.runs {
            let kind = RunKind::of(&robot, &recording)
                .map_err(|why| error(wheels, recording_error(&why), "record the log again"))?;
            let begins = begun
                .iter()
                .find(|(name, _)| *name == recording.name)
                .map_or(Begins::SetOff, |(_, begins)| *begins);
            let name = name(kind, &recording);
            recording.name.clone_from(&name);
            let started_s = recording.started_s.unwrap_or(0.0);
            let supply_v = Vec::new();
            self.runs.push(RunUnderstood { name, kind, begins, started_s, recording, supply_v });
        }
        self.left_out.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
        Ok(())
    }
}

impl ClockUnderstood {
    /// By which share the poses' clock runs faster than that of the wheels.
    pub fn rate(&self) -> f64 {
        self.drift / (1.0 - self.drift)
    }

    /// Refuses clocks that go together too roughly.
    fn check(&self, poses: &Path) -> Result<(), CampaignError> {
        if self.sigma_s <= CLOCK_SIGMA_MAX_S {
            return Ok(());
        }
        let problem = format!(
            "wheels and poses go together only roughly, with clocks {:.2} ± {:.2} s apart",
            self.late_s, self.sigma_s
        );
        Err(error(poses, problem, "check that wheels and poses are of the same robot and drive"))
    }

    /// Adds what was found run by run.
    fn add(&mut self, clocks: &[ClockFound], runs: usize) {
        let mut offsets: Vec<f64> = clocks.iter().map(|clock| clock.offset_s).collect();
        offsets.sort_by(f64::total_cmp);
        // Runs that are not named have none.
        offsets.resize(runs.max(offsets.len()), 0.0);
        offsets.sort_by(f64::total_cmp);
        let Some(middle_s) = offsets.get(offsets.len() / 2) else { return };
        self.late_s += middle_s;
        self.sigma_s = clocks.iter().map(|clock| clock.offset_sigma_s).fold(0.0, f64::max);
        self.differs_by_run = clocks
            .iter()
            .any(|clock| clock.rate != 0.0 || (clock.offset_s - middle_s).abs() > 1e-9)
            || clocks.len() < runs && !clocks.is_empty();
    }
}

/// The samples of a run.
fn within<'a, T>(
    samples: &'a [T],
    started_s: f64,
    recording: &Recording,
    time_s: impl Fn(&T) -> f64,
) -> &'a [T] {
    let from = samples.partition_point(|sample| time_s(sample) < started_s);
    let ends_s = started_s + recording.duration_s();
    let to = samples.partition_point(|sample| time_s(sample) <= ends_s);
    &samples[from..to.max(from)]
}

/// The name of a run by its kind, and by which way it turned.
fn name(kind: RunKind, recording: &Recording) -> String {
    let (first, last) =
        (&recording.wheels[0].phi_rad, &recording.wheels[recording.wheels.len() - 1].phi_rad);
    let turned = (last.right - first.right) - (last.left - first.left);
    let side = if turned >= 0.0 { "left" } else { "right" };
    match kind {
        RunKind::Spin | RunKind::Arc | RunKind::Square => format!("{}_{side}", kind.name()),
        kind => kind.name().replace('-', "_"),
    }
}
