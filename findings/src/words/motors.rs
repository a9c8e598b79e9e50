//! The answer in a sentence, and the names of what it speaks of.

use robot_model::drivetrain::{ExperimentKind, MotorAnswer, MotorRegressor};

/// An error of so many times what counts hide is worth a word.
pub const WORTH_A_WORD: f64 = 1.5;

/// The answer in a sentence or two.
pub fn verdict(answer: &MotorAnswer) -> String {
    let error = |error_m: f64| format!("{:.2} mm", error_m * 1e3);
    let baseline = error(answer.baseline.cross_validated_m);
    let hidden = error(answer.resolution_m);
    let Some(last) = answer.steps.last() else {
        let remains = if answer.unexplained.structure {
            "Something is missing that no effect here explains."
        } else {
            "No effect is missing that these experiments could show."
        };
        return format!(
            "{remains} The error is {baseline}, predicted by the other experiments; counts hide {hidden}."
        );
    };
    let names: Vec<&str> = answer.steps.iter().map(|step| step.effect.facts().name).collect();
    let found = match names.as_slice() {
        [one] => format!("One effect is missing: {one}. With it"),
        more => format!("{} effects are missing: {}. With them", more.len(), more.join("; ")),
    };
    let after = error(last.errors.cross_validated_m);
    let falls = last.errors.cross_validated_m < answer.baseline.cross_validated_m;
    let change = if after == baseline {
        format!("stays at {baseline}")
    } else {
        format!("{} from {baseline} to {after}", if falls { "falls" } else { "rises" })
    };
    let rest = if answer.unexplained.structure { " Something else is unexplained." } else { "" };
    format!("{found} the cross-validated error {change}; counts hide {hidden}.{rest}")
}

/// What remains, and to what the error would fall if it were explained; None if nothing does.
pub fn unexplained_in_words(answer: &MotorAnswer) -> Option<String> {
    let millimetres = |length_m: f64| format!("{:.2} mm", length_m * 1e3);
    let unexplained = &answer.unexplained;
    let left = answer.steps.last().map_or(&answer.baseline, |step| &step.errors);
    let by: Vec<_> = unexplained.depends_on.iter().map(|by| regressor_in_words(*by)).collect();
    unexplained.structure.then(|| {
        format!(
            "{} of travel, root mean square, that no effect here explains. It depends on {}; explained, the error would fall from {} to {}.",
            millimetres(unexplained.size_m),
            by.join("; "),
            millimetres(left.cross_validated_m),
            millimetres(unexplained.floor_m)
        )
    })
}

/// What something depends on, for people.
pub fn regressor_in_words(by: MotorRegressor) -> &'static str {
    match by {
        MotorRegressor::Speed => "the speed",
        MotorRegressor::Direction => "the direction or the side",
        MotorRegressor::Voltage => "the voltage",
        MotorRegressor::VoltageChange => "changes of the voltage (it may lag)",
        MotorRegressor::Load => "what the motors work against",
        MotorRegressor::Angle => "the wheel's angle",
        MotorRegressor::Counts => "the encoder's angle (its lines may be uneven)",
        MotorRegressor::Time => "the time",
    }
}

/// The same, for programs.
pub fn regressor_id(by: MotorRegressor) -> &'static str {
    match by {
        MotorRegressor::Speed => "speed",
        MotorRegressor::Direction => "direction",
        MotorRegressor::Voltage => "voltage",
        MotorRegressor::VoltageChange => "voltage_change",
        MotorRegressor::Load => "load",
        MotorRegressor::Angle => "angle",
        MotorRegressor::Counts => "counts",
        MotorRegressor::Time => "time",
    }
}

/// An experiment, for people.
pub fn kind_in_words(kind: ExperimentKind) -> &'static str {
    match kind {
        ExperimentKind::SlowRamp => "a voltage that rises slowly until the wheels turn, both ways",
        ExperimentKind::Creep => "creeping over several turns just above break-away, both ways",
        ExperimentKind::Steps => "steps at several voltages up to the highest, both ways",
        ExperimentKind::OneWheel => "the highest voltage at one wheel, then at both",
        ExperimentKind::RollOut => "steps, after each of which the robot rolls out",
        ExperimentKind::Reversals => "forwards and at once backwards, several times",
        ExperimentKind::Spins => "turns on the spot, both ways",
        ExperimentKind::FirstAgain => "the first experiment again after some minutes of driving",
    }
}

/// The same, for programs.
pub fn kind_id(kind: ExperimentKind) -> &'static str {
    match kind {
        ExperimentKind::SlowRamp => "slow_ramp",
        ExperimentKind::Creep => "creep",
        ExperimentKind::Steps => "steps",
        ExperimentKind::OneWheel => "one_wheel",
        ExperimentKind::RollOut => "roll_out",
        ExperimentKind::Reversals => "reversals",
        ExperimentKind::Spins => "spins",
        ExperimentKind::FirstAgain => "first_again",
    }
}
