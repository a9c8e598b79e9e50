//! Does anything remain that no effect of the model explains? What could flexible functions still explain of experiments that they
//! were not fitted to?
//!
//! Each function adds a voltage. They come in groups, by what they depend on; a group that predicts other experiments better than
//! chance would, by a size worth speaking of, is structure.

use core::f64::consts::TAU;

use nalgebra::DMatrix;

use super::least_squares::{Model, Problem};
use super::modes::Modes;
use super::screening::{added_columns, linear_cross_validation};
use super::selection::{Gain, Judged, SIZE_SHARE, Selected, gain};
use super::voltage_changes;
use crate::drivetrain::effect::{
    Acting, KnownMotorEffect, Moment, MotorEffect, MotorFacts, MotorParameter,
};

/// What a voltage that is missing depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotorRegressor {
    /// The wheel's speed.
    Speed,
    /// Its direction, or which wheel it is.
    Direction,
    /// The voltage that is applied.
    Voltage,
    /// How the voltage changes: it lags.
    VoltageChange,
    /// What the motor works against: voltage less back-EMF.
    Load,
    /// The wheel's angle: what holds or brakes it there.
    Angle,
    /// The encoder's angle: lines that are not evenly spaced.
    Counts,
    /// Time since the campaign began.
    Time,
}

/// What remains.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorUnexplained {
    /// What flexible functions could still explain is beyond chance, and worth speaking of.
    pub structure: bool,
    /// What it depends on, most first.
    pub depends_on: Vec<MotorRegressor>,
    /// How often chance gives the best group as much.
    pub p_value: f64,
    /// Root mean square of what that group explains \[m\].
    pub size_m: f64,
    /// Cross-validated error with that group, or of the model where none is better \[m\].
    pub floor_m: f64,
}

/// Eight groups are tried.
const P_MAX: f64 = 0.002;
/// A group that explains less than this, root mean square, is not worth a word \[m\].
const UNEXPLAINED_M: f64 = 6e-5;
/// Nor one that explains less than this share of the error.
const LESS: f64 = 0.05;
/// The strengths of its functions that are usual \[V\].
const USUAL_V: f64 = 0.1;
/// Usual shares of a voltage that lag.
const USUAL_LAG: f64 = 0.5;
/// Columns are differences over this \[V\].
const STEP_V: f64 = 0.03;

/// A function, and the number that scales it.
#[derive(Clone, Copy, Debug)]
enum Function {
    /// sgn v, near this share of the highest speed.
    Friction(f64),
    /// One way, near this share of the highest speed; opposite on both sides if true.
    OneWay(f64, bool),
    /// sgn v, opposite on both sides, near this share of the highest speed.
    Side(f64),
    /// sgn V, near this share of the highest voltage.
    Voltage(f64),
    /// sgn v |V - kV v| to this power.
    Load(i32),
    /// sgn(V - kV v) max(0, |V - kV v| - this share of the highest voltage): what a limited current lacks.
    LoadBeyond(f64),
    /// A wave of the wheel's angle: waves per turn, sine or cosine, which side.
    Wave(f64, bool, f64),
    /// The same, of its friction.
    RubbingWave(f64, bool, f64),
    /// sgn v, or v, by time to this power.
    Time(i32, bool),
}

impl MotorEffect for Function {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        let [amplitude_v, scale] = [p[0], p[1]];
        let (v, volts) = (moment.speed_mps.0, moment.volts.0);
        let near = |at: f64, center: f64| (1.0 - (at.abs() / scale - center).abs() / 0.25).max(0.0);
        let way = if v == 0.0 { 0.0 } else { v.signum() };
        let value = match *self {
            Self::Friction(at) => way * near(v, at),
            Self::OneWay(at, mirrored) => near(v, at) * if mirrored { moment.side } else { 1.0 },
            Self::Side(at) => moment.side * way * near(v, at),
            // Where no voltage is applied, none is missing: a bent duty does not push a robot that rolls out.
            Self::Voltage(_) if volts == 0.0 => 0.0,
            Self::Voltage(at) => volts.signum() * near(volts, at),
            Self::Load(power) => {
                let load = (volts - acting.motor.kv_v_s_per_m * v).abs() / scale;
                way * load.powi(power)
            }
            Self::LoadBeyond(share) => {
                let load = (volts - acting.motor.kv_v_s_per_m * v) / scale;
                load.signum() * (load.abs() - share).max(0.0)
            }
            Self::Wave(waves, sine, side) if side == moment.side => {
                let (sin, cos) = (TAU * waves * moment.turns).sin_cos();
                if sine { sin } else { cos }
            }
            Self::RubbingWave(waves, sine, side) if side == moment.side => {
                let (sin, cos) = (TAU * waves * moment.turns).sin_cos();
                way * if sine { sin } else { cos }
            }
            Self::Wave(..) | Self::RubbingWave(..) => 0.0,
            Self::Time(power, by_speed) => {
                let strength = (moment.t_s / scale).powi(power);
                strength * if by_speed { 3.0 * v } else { way }
            }
        };
        acting.volts -= amplitude_v * value;
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "",
    name: "",
    equation: "",
    parameters: &[
        MotorParameter::amplitude("x", "V", USUAL_V, 10.0),
        MotorParameter::shape("scale", "", 1e-9, 1e9),
    ],
    sign: "",
    shown_by: "",
    remedy: "",
};

const SPEED: &[Function] = &[
    Function::Friction(0.0),
    Function::Friction(0.25),
    Function::Friction(0.5),
    Function::Friction(0.75),
    Function::Friction(1.0),
];
const DIRECTION: &[Function] = &[
    Function::OneWay(0.0, false),
    Function::OneWay(0.5, false),
    Function::OneWay(1.0, false),
    Function::OneWay(0.0, true),
    Function::OneWay(0.5, true),
    Function::OneWay(1.0, true),
    Function::Side(0.0),
    Function::Side(0.5),
    Function::Side(1.0),
];
const VOLTAGE: &[Function] = &[
    Function::Voltage(0.2),
    Function::Voltage(0.4),
    Function::Voltage(0.6),
    Function::Voltage(0.8),
    Function::Voltage(1.0),
];
const LOAD: &[Function] =
    &[Function::Load(1), Function::Load(2), Function::LoadBeyond(0.15), Function::LoadBeyond(0.35)];
const TIME: &[Function] =
    &[Function::Time(1, false), Function::Time(2, false), Function::Time(1, true)];

const fn waves(n: f64) -> [Function; 8] {
    [
        Function::Wave(n, false, 1.0),
        Function::Wave(n, true, 1.0),
        Function::Wave(n, false, -1.0),
        Function::Wave(n, true, -1.0),
        Function::RubbingWave(n, false, 1.0),
        Function::RubbingWave(n, true, 1.0),
        Function::RubbingWave(n, false, -1.0),
        Function::RubbingWave(n, true, -1.0),
    ]
}
static ANGLE: [[Function; 8]; 6] =
    [waves(1.0), waves(2.0), waves(3.0), waves(4.0), waves(5.0), waves(6.0)];

/// Waves of the counts, per turn of the encoder or of its wheel \[m\].
const USUAL_COUNTS_M: f64 = 1e-3;

/// Travel that uneven lines add, per metre of amplitude: sine and cosine of each wheel, once and twice a turn of the encoder
/// and, behind a gear, of the wheel.
fn counts_columns(problem: &Problem<'_>) -> (Vec<DMatrix<f64>>, usize) {
    let (gear, turn_m) = (problem.robot.gear_reduction, problem.robot.turn_m());
    let mut waves = vec![gear, 2.0 * gear];
    if (gear - 1.0).abs() > 1e-6 {
        waves.extend([1.0, 2.0]);
    }
    let columns = problem.experiments.iter().map(|experiment| {
        let samples = experiment.recording.samples();
        let mut columns = DMatrix::zeros(2 * samples.len(), 4 * waves.len());
        for (i, n) in waves.iter().enumerate() {
            let of = |travel_m: f64| (TAU * n * travel_m / turn_m).sin_cos();
            let (left_0, right_0) = (of(samples[0].travel_m.left), of(samples[0].travel_m.right));
            for (row, sample) in samples.iter().enumerate() {
                let (left, right) = (of(sample.travel_m.left), of(sample.travel_m.right));
                let added = [
                    (left.0 - left_0.0, 0.0),
                    (left.1 - left_0.1, 0.0),
                    (0.0, right.0 - right_0.0),
                    (0.0, right.1 - right_0.1),
                ];
                for (column, (left, right)) in added.into_iter().enumerate() {
                    let [common, differential] = problem.weights.weighted(left, right);
                    columns[(2 * row, 4 * i + column)] = common;
                    columns[(2 * row + 1, 4 * i + column)] = differential;
                }
            }
        }
        columns
    });
    (columns.collect(), 4 * waves.len())
}

/// One group's functions, with their scale.
fn group(
    by: MotorRegressor,
    selected: &Selected,
    volts_max: f64,
    time_s: f64,
) -> Vec<(&'static Function, f64)> {
    let with = |functions: &'static [Function], scale: f64| {
        functions.iter().map(|function| (function, scale)).collect::<Vec<_>>()
    };
    let speed = selected.screen.excitation.speed_mps_max;
    match by {
        MotorRegressor::Speed => with(SPEED, speed),
        MotorRegressor::Direction => with(DIRECTION, speed),
        MotorRegressor::Voltage => with(VOLTAGE, volts_max),
        MotorRegressor::Load => with(LOAD, volts_max),
        MotorRegressor::Angle => with(ANGLE.as_flattened(), 1.0),
        MotorRegressor::Time => with(TIME, time_s),
        MotorRegressor::Counts | MotorRegressor::VoltageChange => Vec::new(),
    }
}

/// What remains beside a model.
pub(super) fn unexplained(
    problem: &Problem<'_>,
    selected: &Selected,
    last: &Judged,
) -> MotorUnexplained {
    const ALL: [MotorRegressor; 8] = [
        MotorRegressor::Speed,
        MotorRegressor::Direction,
        MotorRegressor::Voltage,
        MotorRegressor::VoltageChange,
        MotorRegressor::Load,
        MotorRegressor::Angle,
        MotorRegressor::Time,
        MotorRegressor::Counts,
    ];
    let ends = problem.experiments.iter().map(|experiment| experiment.started_s);
    let time_s = ends.fold(1.0, f64::max);
    let mut found: Vec<(MotorRegressor, Vec<Modes>, Gain)> = ALL
        .into_iter()
        .filter_map(|by| {
            if by == MotorRegressor::Counts {
                let (added, len) = counts_columns(problem);
                let usual = vec![USUAL_COUNTS_M; len];
                let (_, costs) = linear_cross_validation(problem, &last.fitted, &added, &usual)?;
                let gain = gain(problem, &last.costs, &costs);
                return Some((by, costs, gain));
            }
            if by == MotorRegressor::VoltageChange {
                let added = voltage_changes::columns(problem, &last.fitted);
                let usual = vec![USUAL_LAG; voltage_changes::FUNCTIONS];
                let (_, costs) = linear_cross_validation(problem, &last.fitted, &added, &usual)?;
                let gain = gain(problem, &last.costs, &costs);
                return Some((by, costs, gain));
            }
            let functions = group(by, selected, problem.full_v, time_s);
            let grown: Vec<(Model, f64)> = functions
                .iter()
                .map(|(function, scale)| {
                    let function = KnownMotorEffect::BuiltIn(*function);
                    (last.fitted.model.with(function, &[STEP_V, *scale]), STEP_V)
                })
                .collect();
            let added = added_columns(problem, &last.fitted, &grown);
            let usual = vec![USUAL_V; functions.len()];
            let (_, costs) = linear_cross_validation(problem, &last.fitted, &added, &usual)?;
            let gain = gain(problem, &last.costs, &costs);
            Some((by, costs, gain))
        })
        .collect();
    found.sort_by(|a, b| problem.weighted(&a.1).total_cmp(&problem.weighted(&b.1)));
    let least_m = UNEXPLAINED_M.max(SIZE_SHARE * problem.robot.resolution_m());
    let matters = |gain: &Gain| gain.p_value < P_MAX && gain.less > LESS && gain.size_m > least_m;
    let depends_on: Vec<MotorRegressor> =
        found.iter().filter(|(.., gain)| matters(gain)).map(|found| found.0).collect();
    let before_m = problem.rms_m(&last.costs);
    let best = found.first();
    MotorUnexplained {
        structure: !depends_on.is_empty(),
        depends_on,
        p_value: best.map_or(1.0, |(.., gain)| gain.p_value),
        size_m: best.map_or(0.0, |(.., gain)| gain.size_m),
        floor_m: best.map_or(before_m, |(_, costs, _)| problem.rms_m(costs).min(before_m)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drivetrain::effect::moments;
    use crate::drivetrain::model::WheelMotor;
    use crate::kinematics::WheelPair;

    /// A robot that rolls out: nothing is applied, so nothing of it is missing.
    #[test]
    fn what_depends_on_the_voltage_is_zero_without_one() {
        let acts = |volts: f64| {
            let pair = WheelPair::both;
            let moment = moments(pair(0.2), (pair(volts), 12.0), pair(0.0), (1.0, 1.0, 0.0)).left;
            let mut acting = Acting { volts, motor: WheelMotor::default() };
            VOLTAGE.iter().for_each(|function| function.act(&[0.1, 10.0], &moment, &mut acting));
            acting.volts - volts
        };
        assert_eq!(acts(0.0), 0.0);
        assert!(acts(3.0) < 0.0 && acts(-3.0) == -acts(3.0));
    }
}
