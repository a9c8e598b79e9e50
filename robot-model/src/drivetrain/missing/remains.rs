//! Does anything remain that no effect of the model explains? What could flexible functions still explain of experiments that they
//! were not fitted to?
//!
//! Each function adds a voltage. They come in groups, by what they depend on; a group that predicts other experiments better than
//! chance would, by a size worth speaking of, is structure.

use core::f64::consts::TAU;

use super::chance::{gains, p_value};
use super::least_squares::{Model, Problem};
use super::screening::{added_columns, linear_cross_validation};
use super::selection::{Judged, SIZE_M, SIZE_SHARE, Selected};
use crate::drivetrain::effect::{Acting, Moment, MotorEffect, MotorFacts, MotorParameter};

/// What a voltage that is missing depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Regressor {
    /// The wheel's speed.
    Speed,
    /// Its direction, or which wheel it is.
    Direction,
    /// The voltage that is applied.
    Voltage,
    /// What the motor works against: voltage less back-EMF.
    Load,
    /// The wheel's angle.
    Angle,
    /// Time since the campaign began.
    Time,
}

/// What remains.
#[derive(Clone, Debug, PartialEq)]
pub struct Remains {
    /// What flexible functions could still explain is beyond chance, and worth speaking of.
    pub structure: bool,
    /// What it depends on, most first.
    pub depends_on: Vec<Regressor>,
    /// How often chance gives the best group as much.
    pub p_value: f64,
    /// Root mean square of what that group explains \[m\].
    pub size_m: f64,
    /// Cross-validated error with that group, or of the model where none is better \[m\].
    pub floor_m: f64,
}

/// Six groups are tried.
const P_MAX: f64 = 0.002;
/// A group that explains less than this share of the error is not worth a word.
const LESS: f64 = 0.05;
/// The strengths of its functions that are usual \[V\].
const USUAL_V: f64 = 0.1;
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
    /// A wave of the wheel's angle: waves per turn, sine or cosine, which side.
    Wave(f64, bool, f64),
    /// sgn v, or v, by time to this power.
    Time(i32, bool),
}

impl MotorEffect for Function {
    fn facts(&self) -> &'static MotorFacts {
        &FACTS
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
            Self::Voltage(at) => volts.signum() * near(volts, at),
            Self::Load(power) => {
                let load = (volts - acting.motor.kv_v_s_per_m * v).abs() / scale;
                way * load.powi(power)
            }
            Self::Wave(waves, sine, side) if side == moment.side => {
                let (sin, cos) = (TAU * waves * moment.turns).sin_cos();
                if sine { sin } else { cos }
            }
            Self::Wave(..) => 0.0,
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
    confounded_with: &[],
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
const LOAD: &[Function] = &[Function::Load(1), Function::Load(2)];
const TIME: &[Function] =
    &[Function::Time(1, false), Function::Time(2, false), Function::Time(1, true)];

const fn waves(n: f64) -> [Function; 4] {
    [
        Function::Wave(n, false, 1.0),
        Function::Wave(n, true, 1.0),
        Function::Wave(n, false, -1.0),
        Function::Wave(n, true, -1.0),
    ]
}
static ANGLE: [[Function; 4]; 6] =
    [waves(1.0), waves(2.0), waves(3.0), waves(4.0), waves(5.0), waves(6.0)];

/// One group's functions, with their scale.
fn group(
    by: Regressor,
    selected: &Selected,
    volts_max: f64,
    time_s: f64,
) -> Vec<(&'static Function, f64)> {
    let with = |functions: &'static [Function], scale: f64| {
        functions.iter().map(|function| (function, scale)).collect::<Vec<_>>()
    };
    let speed = selected.excitation.speed_mps_max;
    match by {
        Regressor::Speed => with(SPEED, speed),
        Regressor::Direction => with(DIRECTION, speed),
        Regressor::Voltage => with(VOLTAGE, volts_max),
        Regressor::Load => with(LOAD, volts_max),
        Regressor::Angle => with(ANGLE.as_flattened(), 1.0),
        Regressor::Time => with(TIME, time_s),
    }
}

/// What remains beside a model.
pub(super) fn remains(problem: &Problem<'_>, selected: &Selected, last: &Judged) -> Remains {
    const ALL: [Regressor; 6] = [
        Regressor::Speed,
        Regressor::Direction,
        Regressor::Voltage,
        Regressor::Load,
        Regressor::Angle,
        Regressor::Time,
    ];
    let ends = problem.experiments.iter().map(|experiment| experiment.started_s);
    let time_s = ends.fold(1.0, f64::max);
    let volts_max = volts_max(problem);
    let resolution = problem.robot.resolution_m().powi(2);
    let floors: Vec<f64> =
        (0..last.costs.len()).map(|index| resolution * problem.len(index) as f64).collect();
    let before_m = problem.rms_m(&last.costs);
    let mut found: Vec<(Regressor, f64, f64)> = ALL
        .into_iter()
        .filter_map(|by| {
            let functions = group(by, selected, volts_max, time_s);
            let grown: Vec<(Model, f64)> = functions
                .iter()
                .map(|(function, scale)| {
                    (last.fitted.model.with(*function, &[STEP_V, *scale]), STEP_V)
                })
                .collect();
            let added = added_columns(problem, &last.fitted, &grown);
            let usual = vec![USUAL_V; functions.len()];
            let (_, costs) = linear_cross_validation(problem, &last.fitted, &added, &usual)?;
            let p = p_value(&gains(&last.costs, &costs, &floors));
            Some((by, problem.rms_m(&costs), p))
        })
        .collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    let size_of = |after_m: f64| (before_m * before_m - after_m * after_m).max(0.0).sqrt();
    let matters = |after_m: f64, p: f64| {
        p < P_MAX
            && after_m < (1.0 - LESS) * before_m
            && size_of(after_m) > (2.0 * SIZE_M).max(SIZE_SHARE * problem.robot.resolution_m())
    };
    let depends_on: Vec<Regressor> =
        found.iter().filter(|(_, after_m, p)| matters(*after_m, *p)).map(|found| found.0).collect();
    let best = found.first().map_or((before_m, 1.0), |(_, after_m, p)| (*after_m, *p));
    Remains {
        structure: !depends_on.is_empty(),
        depends_on,
        p_value: best.1,
        size_m: size_of(best.0),
        floor_m: best.0.min(before_m),
    }
}

/// The highest voltage of either motor \[V\].
pub(super) fn volts_max(problem: &Problem<'_>) -> f64 {
    let mut most = 1e-3_f64;
    for experiment in &problem.experiments {
        for pair in experiment.recording.samples().windows(2) {
            let dt_s = pair[1].t_s - pair[0].t_s;
            let volts = pair[1].applied_vs.since(pair[0].applied_vs);
            most = most.max(volts.left.abs().max(volts.right.abs()) / dt_s);
        }
    }
    most
}
