//! Experiments of one robot, on one clock, and what is known about it.

use crate::drivetrain::effect::Excitation;
use crate::drivetrain::recording::VoltageRecording;

/// One experiment of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// What was applied, and how far the wheels went. The travel counts on from one experiment to the next, if the counters do.
    pub recording: VoltageRecording,
    /// When it began, on the campaign's clock \[s\].
    pub started_s: f64,
    /// Heading at its beginning, 0 as the campaign began, left positive; by the counters \[rad\].
    pub heading_rad: f64,
    /// Nothing is fitted to it, and nothing chosen by it.
    pub held_out: bool,
}

/// What is known about the robot besides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownRobot {
    /// Radius of the wheels \[m\].
    pub wheel_radius_m: f64,
    /// Distance between the wheels' contacts \[m\].
    pub track_width_m: f64,
    /// Turns of the encoder per turn of its wheel.
    pub gear_reduction: f64,
    /// Travel per count \[m\].
    pub meters_per_count: f64,
}

impl KnownRobot {
    /// Circumference of a wheel \[m\].
    pub fn turn_m(&self) -> f64 {
        core::f64::consts::TAU * self.wheel_radius_m
    }

    /// What counts hide, root mean square: the first count and each later one are each off by 1/sqrt(12) of a count \[m\].
    pub fn resolution_m(&self) -> f64 {
        self.meters_per_count / 6.0_f64.sqrt()
    }
}

/// What these experiments excite.
pub(super) fn excitation(robot: &KnownRobot, experiments: &[&Experiment]) -> Excitation {
    let mut speed_mps_max = 0.0_f64;
    for experiment in experiments {
        let samples = experiment.recording.samples();
        // Over so long that a count is no speed.
        let window_s = 0.1;
        let mut early = 0;
        for sample in samples {
            while sample.t_s - samples[early].t_s > window_s {
                early += 1;
            }
            let dt_s = sample.t_s - samples[early].t_s;
            if dt_s > 0.5 * window_s {
                let moved = sample.travel_m.since(samples[early].travel_m);
                let speed_mps = moved.left.abs().max(moved.right.abs()) / dt_s;
                speed_mps_max = speed_mps_max.max(speed_mps);
            }
        }
    }
    Excitation {
        speed_mps_max: speed_mps_max.max(1e-3),
        gear_reduction: robot.gear_reduction,
        counts_per_wheel_turn: robot.turn_m() / robot.meters_per_count,
    }
}

/// A pause is at least so long \[s\].
const PAUSE_S_MIN: f64 = 6.0;

/// When the longest pause between two experiments ended \[s\]: meanwhile the robot may have driven or rested. Infinite without one.
pub(super) fn pause_end_s(experiments: &[&Experiment]) -> f64 {
    let end_s = |experiment: &Experiment| {
        let samples = experiment.recording.samples();
        experiment.started_s + samples[samples.len() - 1].t_s - samples[0].t_s
    };
    let pauses =
        experiments.windows(2).map(|pair| (pair[1].started_s - end_s(pair[0]), pair[1].started_s));
    let longest = pauses.max_by(|a, b| a.0.total_cmp(&b.0));
    longest
        .filter(|(pause_s, _)| *pause_s >= PAUSE_S_MIN)
        .map_or(f64::INFINITY, |longest| longest.1)
}

/// The highest voltage of either motor, mean between two samples \[V\].
pub(super) fn full_v(experiments: &[&Experiment]) -> f64 {
    let mut most = 1e-3_f64;
    for experiment in experiments {
        for pair in experiment.recording.samples().windows(2) {
            let dt_s = pair[1].t_s - pair[0].t_s;
            let volts = pair[1].applied_vs.since(pair[0].applied_vs);
            most = most.max(volts.left.abs().max(volts.right.abs()) / dt_s);
        }
    }
    most
}
