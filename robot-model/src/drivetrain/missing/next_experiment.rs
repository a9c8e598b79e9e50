//! Which experiment would tell more? The one whose travel, by the models that cannot be told apart, differs most.

use super::classes::Rival;
use super::experiment::Experiment;
use super::least_squares::{Fitted, Problem};
use super::unexplained::{MotorRegressor, MotorUnexplained};
use crate::drivetrain::effect::KnownMotorEffect;
use crate::drivetrain::recording::{Sample, VoltageRecording};
use crate::kinematics::WheelPair;

/// An experiment that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExperimentKind {
    /// The voltage rises slowly from zero until the wheels turn, both ways.
    SlowRamp,
    /// Just above break-away, over several turns, both ways.
    Creep,
    /// Steps at several voltages up to the highest, both ways.
    Steps,
    /// The highest voltage, with one wheel and with both.
    OneWheel,
    /// A step, and then no voltage until the robot stands.
    RollOut,
    /// Forwards and at once backwards, several times.
    Reversals,
    /// On the spot, both ways.
    Spins,
    /// The first experiment once more, after some minutes of driving.
    FirstAgain,
}

/// The experiment that would tell more.
#[derive(Clone, Debug, PartialEq)]
pub struct NextExperiment {
    /// What to drive.
    pub kind: ExperimentKind,
    /// Which effects it tells apart; none where it is to show what something that remains depends on.
    pub separates: Vec<KnownMotorEffect>,
    /// How far apart they would lead, root mean square \[m\].
    pub apart_m: f64,
}

/// Models that lead apart by less than this share of what counts hide are one.
const APART_SHARE: f64 = 0.02;

const KINDS: [ExperimentKind; 8] = [
    ExperimentKind::SlowRamp,
    ExperimentKind::Creep,
    ExperimentKind::Steps,
    ExperimentKind::OneWheel,
    ExperimentKind::RollOut,
    ExperimentKind::Reversals,
    ExperimentKind::Spins,
    ExperimentKind::FirstAgain,
];

/// The experiment that tells an effect from its best rival; without rivals the one that shows what remains.
pub(super) fn next_experiment(
    problem: &Problem<'_>,
    found: &Fitted,
    rivals: &[&(&KnownMotorEffect, Vec<Rival>)],
    unexplained: &MotorUnexplained,
) -> Option<NextExperiment> {
    let (own, of_own) = match rivals.iter().find(|(_, rivals)| !rivals.is_empty()) {
        Some((own, of_own)) => (*own, &of_own[0]),
        None => return to_show(unexplained),
    };
    let apart = KINDS.into_iter().map(|kind| {
        let experiment = driven(kind, found, problem);
        let travel = |fitted: &Fitted| {
            let model = &fitted.model;
            problem.simulation(&model.effects, &model.at).travel_m(&experiment)
        };
        let (a, b) = (travel(found), travel(&of_own.fitted));
        let squares = a.iter().zip(&b).map(|(a, b)| {
            let off = a.since(*b);
            off.left * off.left + off.right * off.right
        });
        (kind, (squares.sum::<f64>() / (2 * a.len()) as f64).sqrt())
    });
    let (kind, apart_m) = apart.max_by(|a, b| a.1.total_cmp(&b.1))?;
    // No experiment tells an effect from one that does the same.
    let is_seen = apart_m > APART_SHARE * problem.robot.resolution_m();
    is_seen.then(|| NextExperiment {
        kind,
        separates: vec![own.clone(), of_own.effect.clone()],
        apart_m,
    })
}

fn to_show(unexplained: &MotorUnexplained) -> Option<NextExperiment> {
    let kind = match unexplained.depends_on.first()? {
        MotorRegressor::Speed | MotorRegressor::Direction => ExperimentKind::Steps,
        MotorRegressor::Voltage => ExperimentKind::RollOut,
        MotorRegressor::VoltageChange => ExperimentKind::Reversals,
        MotorRegressor::Load => ExperimentKind::OneWheel,
        MotorRegressor::Angle | MotorRegressor::Counts => ExperimentKind::Creep,
        MotorRegressor::Time => ExperimentKind::FirstAgain,
    };
    Some(NextExperiment { kind, separates: Vec::new(), apart_m: unexplained.size_m })
}

/// The voltages of an experiment for these motors, recorded every 5 ms; no travel.
fn driven(kind: ExperimentKind, found: &Fitted, problem: &Problem<'_>) -> Experiment {
    let most_v = problem.full_v;
    let creep_v = (1.15 * found.model.at[0]).max(0.04 * most_v);
    // Left, right \[V\], for so long \[s\]; a ramp from zero if it says so.
    let steps: Vec<(f64, f64, f64, bool)> = match kind {
        ExperimentKind::SlowRamp => {
            let high_v = 1.5 * creep_v;
            vec![(high_v, high_v, 4.0, true), (0.0, 0.0, 0.5, false), (-high_v, -high_v, 4.0, true)]
        }
        ExperimentKind::Creep => {
            vec![(creep_v, creep_v, 5.0, false), (-creep_v, -creep_v, 5.0, false)]
        }
        ExperimentKind::Steps => [0.3, 0.6, 1.0]
            .iter()
            .flat_map(|share| {
                let v = share * most_v;
                [(v, v, 0.6, false), (0.0, 0.0, 0.4, false), (-v, -v, 0.6, false)]
            })
            .collect(),
        ExperimentKind::OneWheel => {
            vec![(most_v, 0.0, 0.6, false), (most_v, most_v, 0.6, false), (0.0, most_v, 0.6, false)]
        }
        ExperimentKind::RollOut => {
            let v = 0.6 * most_v;
            [v, -v, v, -v]
                .iter()
                .flat_map(|v| [(*v, *v, 0.3, false), (0.0, 0.0, 0.5, false)])
                .collect()
        }
        ExperimentKind::Reversals => {
            let v = 0.5 * most_v;
            [v, -v, v, -v, v, -v].iter().map(|v| (*v, *v, 0.3, false)).collect()
        }
        ExperimentKind::Spins => {
            let v = 0.5 * most_v;
            vec![(-v, v, 0.7, false), (0.0, 0.0, 0.4, false), (v, -v, 0.7, false)]
        }
        ExperimentKind::FirstAgain => vec![(0.5 * most_v, 0.5 * most_v, 1.0, false)],
    };
    let started = problem.experiments.iter().map(|experiment| experiment.started_s);
    let later_s = if kind == ExperimentKind::FirstAgain { 180.0 } else { 10.0 };
    let mut applied_vs = WheelPair::both(0.0);
    let travel_m = WheelPair::both(0.0);
    let mut samples = vec![Sample { t_s: 0.0, travel_m, applied_vs }];
    for (left_v, right_v, duration_s, ramp) in steps {
        let count = (duration_s / 0.005_f64).round() as usize;
        for step in 1..=count {
            let share = if ramp { step as f64 / count as f64 } else { 1.0 };
            applied_vs.left += 0.005 * left_v * share;
            applied_vs.right += 0.005 * right_v * share;
            let t_s = 0.005 * samples.len() as f64;
            samples.push(Sample { t_s, travel_m, applied_vs });
        }
    }
    let last = &problem.experiments[0].recording;
    let recording = VoltageRecording::new(samples).unwrap_or_else(|| last.clone());
    let started_s = started.fold(0.0, f64::max) + later_s;
    Experiment { recording, started_s, heading_rad: 0.0, held_out: false }
}
