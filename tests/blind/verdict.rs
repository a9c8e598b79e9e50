//! Is the answer of `explain` right? One case, recorded, explained, and compared with the truth.

use std::time::Instant;

use robot_model::explain::explain;
use robot_model::explain::model::fit;
use robot_model::explain::{Answer, ParameterFound, StepFound};

use super::benchmark_robot::BenchmarkRobot;
use super::case::{Case, Kind};
use super::hard::{GEOMETRY, Hard};
use super::hidden_effects::also_there;
use super::noise_of_twins::noise_of_twins;
use super::plant::{Dose, Plant, Taken, Truth};
use super::strength::sigmas;

/// An answer whose error is more than this many times the noise, without a flag, fails in silence.
const SILENT: f64 = 1.4;
/// The reachable error is right within this share of the noise.
const REACHABLE_WITHIN: f64 = 0.15;
/// A clock is found if its offset is off by at most this \[s\]: a tenth of a camera's usual delay.
const CLOCK_S: f64 = 0.01;

/// The comparison of one answer with the truth.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The case.
    pub case: Case,
    /// By how many sigma each hidden effect stands out, in the fit that knows it; outside the catalogue in the plant of
    /// kinematics, how many times as far as noise it moves the robot.
    pub reached: Vec<f64>,
    /// For each hidden effect, whether it or a class with it was named.
    pub named: Vec<bool>,
    /// The effects found, each with its class.
    pub found: Vec<Vec<String>>,
    /// Of these, whether each is called worth correcting.
    pub matters: Vec<bool>,
    /// Effects found whose class holds none that is hidden.
    pub extra: usize,
    /// Of these, those called worth correcting, with their size over the tolerance.
    pub extra_matters: Vec<(String, f64)>,
    /// Whether something unexplained was reported.
    pub flagged: bool,
    /// Why the files were refused before anything was fitted, if they were. They are right, so this is a miss.
    pub refused: Option<String>,
    /// The regressors that the answer names, best first.
    pub depends_on: Vec<String>,
    /// The right regressors, outside the catalogue.
    pub regressors: Vec<&'static str>,
    /// Cross-validated error of the answer's model over that of the fit that knows the truth; outside the
    /// catalogue, over that of the same robot without the effect.
    pub cross_validated_ratio: f64,
    /// The same over the true noise level: of the fit that knows the truth, or where the plant knows its noise, of the
    /// true model with its true parameters.
    pub over_noise: f64,
    /// The answer's reachable error over the true noise level.
    pub reachable_ratio: f64,
    /// Where the clock of the poses is off, whether the answer says so, and by how much.
    pub clock_found: Option<bool>,
    /// For each parameter that the plant has as well: its name, and whether the 95 % interval covers it.
    pub covered: Vec<(String, bool)>,
    /// Duration of the explanation \[s\].
    pub explain_s: f64,
    /// The campaign itself, to look into.
    pub campaign: campaign::Campaign,
    /// The answer.
    pub answer: Answer,
}

impl Verdict {
    /// Whether every hidden effect stands out as its kind requires, to a factor of two. Some effects cannot be made
    /// that strong on this robot, or the model's equation fits only part of what the plant does. Outside the
    /// catalogue there is no upper limit, but in the plant of kinematics, which says how far it moves the robot.
    pub fn as_strong_as_required(&self) -> bool {
        let wanted = self.case.kind.sigmas().unwrap_or(0.0);
        let within = match (self.case.kind, self.case.plant) {
            // A ripple of a wheel's angle hardly adds up: as far as noise will do.
            (Kind::Outside, Plant::Kinematic) => 1.0..=12.0,
            (Kind::Outside, Plant::Forces) => wanted / 2.0..=f64::INFINITY,
            _ => wanted / 2.0..=2.0 * wanted,
        };
        self.reached.iter().all(|reached| within.contains(reached))
    }

    /// Whether the answer meets the bar of its kind.
    pub fn good(&self) -> bool {
        let right = match self.case.kind {
            Kind::Strong | Kind::Medium | Kind::Weak => self.named.iter().all(|named| *named),
            Kind::Two => self.named_apart(),
            Kind::Nothing | Kind::Nuisance => !self.false_alarm(),
            Kind::Outside => self.recognised(),
        };
        right && self.refused.is_none()
    }

    /// Whether there is anything to be found, a wrong data sheet and a clock that is off included.
    pub fn hides(&self) -> bool {
        !self.case.effects.is_empty() || !self.case.hard.effects().is_empty()
    }

    /// Whether much more than noise is left, and nothing is said about it.
    pub fn silent(&self) -> bool {
        // An error that is not a number is not small.
        let small = self.over_noise <= SILENT;
        self.hides() && !small && !self.flagged && self.refused.is_none()
    }

    /// Whether the answer's reachable error is the noise level.
    pub fn reachable_is_right(&self) -> bool {
        (self.reachable_ratio - 1.0).abs() <= REACHABLE_WITHIN && self.refused.is_none()
    }

    /// Of a sound robot, whether anything is called worth correcting.
    pub fn worth_nothing(&self) -> bool {
        self.extra_matters.is_empty() && !self.flagged && self.refused.is_none()
    }

    /// Where the data sheet is wrong: whether all three of its numbers are named.
    pub fn geometry_named(&self) -> Option<bool> {
        let named = |id: &str| self.found.iter().any(|class| class.iter().any(|one| one == id));
        (self.case.hard == Hard::Geometry)
            .then(|| GEOMETRY.into_iter().all(named) && self.refused.is_none())
    }

    /// Whether each of two hidden effects has a step of its own that names it.
    fn named_apart(&self) -> bool {
        let [first, second] = self.case.effects.as_slice() else { return false };
        let names = |step: &Vec<String>, id: &str| step.iter().any(|name| name == id);
        // A delay may be told as a clock, which is no step.
        if let Some(clock) =
            self.case.effects.iter().position(|one| one.id() == "measurement_delay")
            && self.clock_found == Some(true)
        {
            return self.named[1 - clock];
        }
        self.found.iter().enumerate().any(|(i, one)| {
            let others = self.found.iter().enumerate().filter(|(j, _)| *j != i);
            names(one, first.id()) && others.into_iter().any(|(_, other)| names(other, second.id()))
        })
    }

    /// The class sizes of those steps that name a hidden effect: one is an answer, many are a list.
    pub fn class_sizes(&self) -> Vec<usize> {
        let hidden = |step: &&Vec<String>| {
            step.iter().any(|member| self.case.effects.iter().any(|effect| effect.id() == member))
        };
        self.found.iter().filter(hidden).map(Vec::len).collect()
    }

    /// Whether an effect or structure was reported where there is none.
    pub fn false_alarm(&self) -> bool {
        let alarm = self.extra > 0 || self.flagged || self.refused.is_some();
        self.case.effects.is_empty() && alarm
    }

    /// Outside the catalogue: structure flagged, or a stand-in that is as good as the truth.
    pub fn recognised(&self) -> bool {
        let stands_in = self.extra > 0 || !self.case.hard.effects().is_empty();
        self.flagged || (stands_in && self.cross_validated_ratio <= 1.1)
    }

    /// Outside the catalogue and flagged: whether a right regressor was named first. Of a list of four, one is
    /// right by chance.
    pub fn regressor_named(&self) -> Option<bool> {
        (self.case.kind == Kind::Outside && self.flagged && !self.regressors.is_empty()).then(
            || {
                self.depends_on
                    .first()
                    .is_some_and(|regressor| self.regressors.contains(&regressor.as_str()))
            },
        )
    }
}

/// Records a case, has it explained, and compares the answer with the truth.
///
/// # Errors
/// What went wrong, for a person to read.
pub fn verdict_on(case: &Case) -> Result<Verdict, String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let robot = BenchmarkRobot::new(case);
    let (taken, mut reached, without) = robot.record()?;

    // From here to the answer, nothing has access to what is hidden.
    let refused = taken.campaign.to_model(std::path::Path::new("campaign")).err();
    let refused = refused.map(|error| error.to_string());
    let began = Instant::now();
    let answer = explain(&taken.measured).map_err(|error| text(&error))?;
    let explain_s = began.elapsed().as_secs_f64();

    let all: Vec<Dose> =
        (0..case.effects.len()).map(|index| Dose { index, strength: 0.0 }).collect();
    // A fit that knows the truth does not describe a robot of forces to the last detail; its second campaign does.
    // Other noise may stop a robot that just managed its first one: then that fit is all there is.
    let twin_m = robot.twin(&taken).ok().flatten().map(|twin| {
        let oracle = fit(&taken.mended, &robot.known(&all)).map_err(|error| text(&error))?;
        noise_of_twins([&taken.mended, &twin], &oracle, answer.noise)
    });
    let twin_m = twin_m.transpose()?;
    let true_m = match (&without, case.kind, taken.noise_m) {
        (Some(without), ..) => {
            let oracle = fit(&without.mended, &robot.known(&[])).map_err(|error| text(&error))?;
            oracle.errors.cross_validated.position_rms_m
        }
        (None, Kind::Outside, Some(noise_m)) => noise_m,
        _ => {
            let oracle = fit(&taken.mended, &robot.known(&all)).map_err(|error| text(&error))?;
            reached = case.effects.iter().map(|hidden| sigmas(&oracle, hidden.id())).collect();
            oracle.errors.cross_validated.position_rms_m
        }
    };
    let verdict = compare(&robot, taken, answer, (true_m, twin_m), (reached, explain_s));
    Ok(Verdict { refused, ..verdict })
}

/// Where only ends are measured, two estimates of the same noise differ by less than this factor.
const ENDS_TELL: f64 = 1.5;

fn compare(
    robot: &BenchmarkRobot<'_>,
    taken: Taken,
    answer: Answer,
    (true_m, twin_m): (f64, Option<f64>),
    (reached, explain_s): (Vec<f64>, f64),
) -> Verdict {
    let case = robot.case;
    // Of two poses a run, what is position error and what is heading error depends on the weights that a fit gives
    // them: there, the fit that knows the truth is the measure.
    let known_m = taken.noise_m.filter(|_| case.hard != Hard::Ends);
    // Twenty poses tell the noise to a sixth, and that of the twins is of other poses.
    let twins_m = twin_m.filter(|twins_m| {
        case.hard != Hard::Ends || case.kind == Kind::Outside || true_m > ENDS_TELL * twins_m
    });
    let noise_m = twins_m.or(known_m).unwrap_or(true_m);
    let after =
        answer.steps.last().map_or(answer.baseline.cross_validated, |step| step.cross_validated);
    let holds = |step: &StepFound, id: &str| step.class.iter().any(|member| member == id);
    let extra: Vec<&StepFound> = answer.steps.iter().filter(|step| !is_there(case, step)).collect();
    let clock_found = clock_found(robot, &taken.truth, &answer);
    Verdict {
        reached,
        named: case
            .effects
            .iter()
            .map(|hidden| {
                let clock = hidden.id() == "measurement_delay" && clock_found == Some(true);
                clock || answer.steps.iter().any(|step| holds(step, hidden.id()))
            })
            .collect(),
        found: answer.steps.iter().map(|step| step.class.clone()).collect(),
        matters: answer.steps.iter().map(|step| step.matters).collect(),
        extra: extra.len(),
        extra_matters: extra
            .iter()
            .filter(|step| step.matters)
            .map(|step| (step.effect.clone(), step.effect_size_m / answer.tolerance_m))
            .collect(),
        flagged: answer.unexplained.structure || answer.set_aside.is_some(),
        refused: None,
        depends_on: answer
            .unexplained
            .depends_on
            .iter()
            .map(|regressor| regressor.name().to_owned())
            .collect(),
        regressors: case
            .effects
            .iter()
            .flat_map(|hidden| hidden.regressors().iter().copied())
            .collect(),
        cross_validated_ratio: after.position_rms_m / true_m,
        over_noise: after.position_rms_m / noise_m,
        reachable_ratio: answer.reachable.position_rms_m / noise_m,
        clock_found,
        covered: covered(case, &answer, &taken.truth),
        explain_s,
        case: case.clone(),
        campaign: taken.campaign,
        answer,
    }
}

/// Whether a step's class holds something that the plant has.
fn is_there(case: &Case, step: &StepFound) -> bool {
    let holds = |id: &str| step.class.iter().any(|member| member == id);
    let companions = case.effects.iter().flat_map(|secret| secret.with_companions());
    let forces = case.effects.iter().filter_map(|secret| secret.of_forces());
    let plants = companions
        .map(|effect| effect.facts().id)
        .chain(forces.flat_map(|effect| also_there(effect).iter().copied()));
    plants.chain(case.hard.effects().iter().copied()).any(holds)
}

/// Whether the answer says how late the poses are, as a clock or as a delay; `None` if they are not.
fn clock_found(robot: &BenchmarkRobot<'_>, truth: &[Truth], answer: &Answer) -> Option<bool> {
    let delay = truth.iter().find(|known| known.0 == "measurement_delay");
    let late_s = robot.difficulty.late_s + delay.map_or(0.0, |known| known.2);
    let near = |offset_s: f64| (offset_s - late_s).abs() <= CLOCK_S;
    let clocks = &answer.clocks;
    let as_clock = !clocks.is_empty() && clocks.iter().all(|clock| near(clock.offset_s));
    let as_delay = answer.steps.iter().any(|step| {
        step.effect == "measurement_delay" && step.parameters.iter().any(|tau| near(tau.value))
    });
    (late_s != 0.0).then_some(as_clock || as_delay)
}

/// For each parameter found that is also a number of the plant, whether its interval covers the truth.
///
/// On a wrong data sheet, the parameters of other motions are relative to wrong speeds; only those of the data sheet
/// itself and of measurements count. In the plant of forces a hidden effect changes radii and track as well.
fn covered(case: &Case, answer: &Answer, truth: &[Truth]) -> Vec<(String, bool)> {
    let wrong = case.hard == Hard::Geometry;
    let geometry_is_known =
        case.effects.is_empty() || (case.plant == Plant::Kinematic && case.kind != Kind::Outside);
    let counts = |id: &str| {
        let hidden = case.effects.iter().any(|secret| secret.id() == id);
        let of_motion =
            !["measurement_delay", "marker_offset", "gyro_bias", "gyro_scale"].contains(&id);
        match wrong {
            true if GEOMETRY.contains(&id) => hidden || geometry_is_known,
            true => hidden && !of_motion,
            // A clock that is off is not a delay.
            false => hidden && !(case.hard == Hard::Clock && id == "measurement_delay"),
        }
    };
    let mut covered = Vec::new();
    for step in answer.steps.iter().filter(|step| counts(&step.effect)) {
        for (_, name, value) in truth.iter().filter(|known| known.0 == step.effect) {
            let holds = |parameter: &&ParameterFound| parameter.name == *name;
            if let Some(found) = step.parameters.iter().find(holds) {
                let name = format!("{}.{name}", step.effect);
                covered.push((name, found.low95 <= *value && *value <= found.high95));
            }
        }
    }
    covered
}
