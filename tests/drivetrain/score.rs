//! What `explain --drivetrain` says about a case, and whether that is right.

use campaign::Experiments;
use robot_model::drivetrain::{
    Experiment, MotorAnswer, MotorStep, MotorUnexplained, baseline_errors, missing,
};

use super::case::{Case, Kind};
use super::hidden::Hidden;

/// A substitute may be so many times as far off as the robot without what is hidden.
const AS_GOOD: f64 = 1.1;

/// The judgement on one campaign.
#[derive(Clone, Debug)]
pub struct Score {
    /// Its kind.
    pub kind: Kind,
    /// Right, by the kind's rule; None if nothing was recorded.
    pub right: Option<bool>,
    /// An effect is named that is not there, nor in a class with one that is.
    pub false_alarm: bool,
    /// Whether intervals hold the plant's own numbers.
    pub covers: Vec<bool>,
    /// In a line.
    pub text: String,
}

/// Records a case, explains it, and judges the answer.
pub fn judge(seed: u64, case: &Case) -> Score {
    let folder = tempfile::tempdir().expect("there is a folder for temporary files");
    match case.record(&folder.path().join("motors")) {
        Ok(found) => judge_recorded(seed, case, &found),
        Err(why) => refused(case, &why),
    }
}

fn refused(case: &Case, why: &str) -> Score {
    Score {
        kind: case.kind,
        right: None,
        false_alarm: false,
        covers: Vec::new(),
        text: format!("{:?} {:?}: REFUSED {why}", case.kind, case.hidden),
    }
}

/// Explains a recording of a case, and judges the answer.
pub fn judge_recorded(seed: u64, case: &Case, found: &Experiments) -> Score {
    let experiments: Vec<Experiment> =
        found.runs.iter().map(|run| run.experiment.clone()).collect();
    let answer = match missing(&found.robot, &experiments) {
        Ok(answer) => answer,
        Err(why) => return refused(case, &format!("{why:?}")),
    };
    let is_named = |id: &str| answer.steps.iter().any(|step| answers(step).contains(&id));
    let ids: Vec<&str> = case.hidden.iter().filter_map(|hidden| hidden.id()).collect();
    let false_alarm =
        answer.steps.iter().any(|step| !answers(step).iter().any(|id| ids.contains(id)));
    let after_m = answer.steps.last().map_or(answer.baseline, |step| step.errors).cross_validated_m;
    let right = match case.kind {
        Kind::Strong | Kind::Weak | Kind::Two => ids.iter().all(|id| is_named(id)),
        Kind::Nothing => answer.steps.is_empty() && !answer.unexplained.structure,
        Kind::Outside => {
            answer.unexplained.structure || {
                let sound = sound_error_m(seed, case);
                after_m <= AS_GOOD * sound
            }
        }
    };
    let covers = covers(case, &answer);
    let held = covers.iter().filter(|held| **held).count();
    let intervals = format!("intervals {held} of {}", covers.len());
    let said: Vec<String> = answer
        .steps
        .iter()
        .map(|step| {
            let named = answers(step).join("|");
            format!("{named} {:.3} mm p {:.4}", step.size_m * 1e3, step.p_value)
        })
        .collect();
    let text = format!(
        "{:?} {:?}: {}{}{} {:.3} -> {:.3} mm, counts {:.3}, {} experiments, {}, {intervals}",
        case.kind,
        case.hidden,
        if right { "" } else { "MISS " },
        if false_alarm { "TOO MANY " } else { "" },
        said.join("; "),
        answer.baseline.cross_validated_m * 1e3,
        after_m * 1e3,
        answer.resolution_m * 1e3,
        answer.experiments,
        flag(&answer.unexplained)
    );
    Score { kind: case.kind, right: Some(right), false_alarm, covers, text }
}

/// The effect that is named, and those of its class.
fn answers(step: &MotorStep) -> Vec<&str> {
    let all = core::iter::once(&step.effect).chain(&step.class);
    all.map(|effect| effect.facts().id).collect()
}

fn flag(unexplained: &MotorUnexplained) -> String {
    let MotorUnexplained { structure, depends_on, p_value, size_m, floor_m } = unexplained;
    if *structure {
        format!("flag {depends_on:?} {:.3}", size_m * 1e3)
    } else {
        format!("no flag, p {p_value:.3}, to {:.3}", floor_m * 1e3)
    }
}

/// How far the baseline is off on the same robot with nothing hidden.
fn sound_error_m(seed: u64, case: &Case) -> f64 {
    let folder = tempfile::tempdir().expect("there is a folder for temporary files");
    let Ok(found) = case.sound(seed).record(&folder.path().join("motors")) else { return f64::NAN };
    let experiments: Vec<Experiment> =
        found.runs.iter().map(|run| run.experiment.clone()).collect();
    baseline_errors(&found.robot, &experiments)
        .map_or(f64::NAN, |found| found.errors.cross_validated_m)
}

/// Whether the intervals hold the plant's own numbers, of what has one: kV of a robot whose motors have one; the effect's.
fn covers(case: &Case, answer: &MotorAnswer) -> Vec<bool> {
    let plant = case.plant();
    let motor = &plant.motor.left;
    let radius_m = plant.geometry.wheel_radius_m.left;
    let k = motor.wheel_torque_constant_nm_per_a();
    let volts_per_nm = motor.resistance_ohm / k;
    let mut covers = Vec::new();
    let mut hold = |value: f64, half_width: f64, truth: f64| {
        covers.push((value - truth).abs() <= half_width);
    };
    if answer
        .steps
        .iter()
        .all(|step| case.hidden.iter().any(|hidden| hidden.id() == Some(step.effect.facts().id)))
        && case.hidden.iter().all(|hidden| {
            hidden
                .id()
                .is_some_and(|id| answer.steps.iter().any(|step| step.effect.facts().id == id))
        })
    {
        if case.kind == Kind::Nothing || case.hidden == [Hidden::TransportDelay] {
            let kv = (k + motor.viscous_torque_nms * volts_per_nm) / radius_m;
            hold(answer.constants[1].value, answer.constants[1].half_width_95, kv);
        }
        for step in &answer.steps {
            let p = &step.parameters[0];
            match step.effect.facts().id {
                "dead_band" => hold(p.value, p.half_width_95, plant.bridge.dead_band_v),
                "transport_delay" => {
                    // The duty of a tick is on the motor from its end on.
                    hold(p.value, p.half_width_95, f64::from(plant.bridge.delay_ms) * 1e-3);
                }
                "quadratic_drag" => {
                    let q = plant.motor_defects.left.drag_nms2 * volts_per_nm / radius_m.powi(2);
                    hold(p.value, p.half_width_95, q);
                }
                "load_torque" => {
                    let weight_n = plant.body.mass_kg * plant.floor.gravity_mps2;
                    let push_nm = 0.5 * weight_n * plant.floor.slope_rad.sin() * radius_m;
                    let way = plant.floor.downhill_rad.cos();
                    hold(p.value, p.half_width_95, way * push_nm * volts_per_nm);
                }
                _ => {}
            }
        }
    }
    covers
}
