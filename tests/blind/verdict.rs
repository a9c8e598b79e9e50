//! Is the answer of `explain` right? One case, recorded, explained, and compared with the truth.

use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use robot_model::effect::Effect;
use robot_model::explain::explain;
use robot_model::explain::model::{Model, fit};
use robot_model::explain::{Answer, ParameterFound};
use sim_target::Scenario;

use super::case::{Case, Kind};
use super::field::{PERIOD_MS, plan, record, sound};
use super::hide::{Hidden, REFERENCE, regressors, with_companions};
use super::strength::{scaled, sigmas, visibility};

/// The comparison of one answer with the truth.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The case.
    pub case: Case,
    /// By how many sigma each hidden effect stands out, in the fit that knows it.
    pub reached: Vec<f64>,
    /// For each hidden effect, whether it or a class with it was named.
    pub named: Vec<bool>,
    /// The effects found, each with its class.
    pub found: Vec<Vec<String>>,
    /// Effects found whose class holds none that is hidden.
    pub extra: usize,
    /// Whether something unexplained was reported.
    pub flagged: bool,
    /// The regressors that the answer names, best first.
    pub depends_on: Vec<String>,
    /// The right regressors, outside the catalogue.
    pub regressors: Vec<&'static str>,
    /// Cross-validated error of the answer's model over that of the fit that knows the truth; outside the
    /// catalogue, over that of the same robot without the effect.
    pub cross_validated_ratio: f64,
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
    /// catalogue there is no upper limit.
    pub fn as_strong_as_required(&self) -> bool {
        let wanted = self.case.kind.sigmas().unwrap_or(0.0);
        let most = if self.case.kind == Kind::Outside { f64::INFINITY } else { 2.0 * wanted };
        self.reached.iter().all(|reached| (wanted / 2.0..=most).contains(reached))
    }

    /// Whether the answer meets the bar of its kind.
    pub fn good(&self) -> bool {
        match self.case.kind {
            Kind::Strong | Kind::Medium | Kind::Weak => self.named.iter().all(|named| *named),
            Kind::Two => self.named_apart(),
            Kind::Nothing | Kind::Nuisance => !self.false_alarm(),
            Kind::Outside => self.recognised(),
        }
    }

    /// Whether each of two hidden effects has a step of its own that names it.
    fn named_apart(&self) -> bool {
        let [first, second] = self.case.effects.as_slice() else { return false };
        let names = |step: &Vec<String>, id: &str| step.iter().any(|name| name == id);
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
        self.case.effects.is_empty() && (!self.found.is_empty() || self.flagged)
    }

    /// Outside the catalogue: structure flagged, or a stand-in that is as good as the truth.
    pub fn recognised(&self) -> bool {
        self.flagged || (!self.found.is_empty() && self.cross_validated_ratio <= 1.1)
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

/// How many times a strength is tried and scaled before the campaign is recorded.
const TRIALS: usize = 2;
/// A strength within this factor, in e-folds, is not tried again: effects are not linear.
const NEAR: f64 = 0.7;

/// Records the campaign, with weaker effects where the robot cannot drive it.
fn drivable<T>(
    hidden: &mut [Hidden],
    run: &impl Fn(&[Hidden]) -> Result<T, String>,
) -> Result<T, String> {
    const TIMES: usize = 8;
    let mut outcome = run(hidden);
    for _ in 0..TIMES {
        if outcome.is_ok() {
            break;
        }
        hidden.iter_mut().for_each(|secret| secret.strength *= 0.7);
        outcome = run(hidden);
    }
    outcome
}

/// A recorded campaign: the robot, its files, and the same as a fit reads them.
type Recorded = (Scenario, campaign::Campaign, robot_model::recording::Campaign);

/// Scales the strength of one effect until it stands out alone by `wanted` sigma.
fn scale_strength(
    secret: &mut Hidden,
    wanted: f64,
    sound: &Scenario,
    run: &impl Fn(&[Hidden]) -> Result<Recorded, String>,
) -> Result<(), String> {
    for _ in 0..TRIALS {
        let mut alone = [secret.possible_in(sound)];
        let (_, _, measured) = drivable(&mut alone, run)?;
        let known = with_companions(secret.effect);
        let model = fit(&measured, &known).map_err(|error| error.to_string())?;
        let reached = sigmas(&model, secret.effect.id());
        secret.strength = scaled(alone[0].strength, wanted, reached);
        if (reached / wanted).ln().abs() < NEAR {
            break;
        }
    }
    *secret = secret.possible_in(sound);
    Ok(())
}

/// The effects of the fit that knows the truth, each once.
fn true_effects(case: &Case) -> Vec<&'static dyn Effect> {
    let mut truth: Vec<&'static dyn Effect> = Vec::new();
    for effect in case.effects.iter().flat_map(|hidden| with_companions(*hidden)) {
        if truth.iter().all(|known| known.facts().id != effect.facts().id) {
            truth.push(effect);
        }
    }
    truth
}

/// Records a case, has it explained, and compares the answer with the truth.
///
/// # Errors
/// What went wrong, for a person to read.
pub fn verdict_on(case: &Case) -> Result<Verdict, String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let plan = plan();
    let truth = true_effects(case);
    let sound = sound(case.seed, case.kind, &case.effects);
    // Every other user can say how good the camera is.
    let knows_its_camera = ChaCha8Rng::seed_from_u64(case.seed ^ (1 << 32)).random_bool(0.5);
    let run = |hidden: &[Hidden]| -> Result<Recorded, String> {
        let mut scenario = sound.clone();
        for secret in hidden {
            secret.hide(&mut scenario);
        }
        scenario.validate().map_err(|error| text(&error))?;
        let mut campaign = record(&scenario, &plan, PERIOD_MS).map_err(|error| text(&error))?;
        if !knows_its_camera {
            campaign.robot.position_sigma_m = None;
            campaign.robot.heading_sigma_rad = None;
        }
        let measured =
            campaign.to_model(std::path::Path::new("campaign")).map_err(|error| text(&error))?;
        Ok((scenario, campaign, measured))
    };

    let mut hidden: Vec<Hidden> = case
        .effects
        .iter()
        .enumerate()
        .map(|(k, effect)| Hidden {
            effect: *effect,
            strength: REFERENCE,
            seed: case.seed ^ ((k as u64 + 1) << 40),
        })
        .collect();
    if let (Some(wanted), true) = (case.kind.sigmas(), case.kind != Kind::Outside) {
        for secret in &mut hidden {
            scale_strength(secret, wanted, &sound, &run)?;
        }
    }
    let without = if case.kind == Kind::Outside { Some(run(&[])?.2) } else { None };
    let mut shows = Vec::new();
    let (mut scenario, mut campaign, mut measured) = drivable(&mut hidden, &run)?;
    if let (Some(without), Some(wanted)) = (&without, case.kind.sigmas()) {
        let reached = visibility(without, &measured).map_err(|error| text(&error))?;
        shows = vec![reached];
        if reached < wanted {
            hidden[0].strength = scaled(hidden[0].strength, 1.5 * wanted, reached);
            hidden[0] = hidden[0].possible_in(&sound);
            (scenario, campaign, measured) = drivable(&mut hidden, &run)?;
            shows = vec![visibility(without, &measured).map_err(|error| text(&error))?];
        }
    }

    // From here to the answer, nothing has access to what is hidden.
    let began = Instant::now();
    let answer = explain(&measured).map_err(|error| text(&error))?;
    let explain_s = began.elapsed().as_secs_f64();

    let oracle = match &without {
        Some(without) => fit(without, &[]),
        None => fit(&measured, &truth),
    };
    let oracle = oracle.map_err(|error| text(&error))?;
    if without.is_none() {
        shows = case.effects.iter().map(|hidden| sigmas(&oracle, hidden.id())).collect();
    }
    let covered = covered(&answer, &hidden, &scenario);
    Ok(compare(case, campaign, answer, &oracle, (shows, covered), explain_s))
}

fn compare(
    case: &Case,
    campaign: campaign::Campaign,
    answer: Answer,
    oracle: &Model,
    (reached, covered): (Vec<f64>, Vec<(String, bool)>),
    explain_s: f64,
) -> Verdict {
    let found: Vec<Vec<String>> = answer.steps.iter().map(|step| step.class.clone()).collect();
    let holds = |class: &[String], id: &str| class.iter().any(|member| member == id);
    let after =
        answer.steps.last().map_or(answer.baseline.cross_validated, |step| step.cross_validated);
    Verdict {
        reached,
        named: case
            .effects
            .iter()
            .map(|hidden| found.iter().any(|class| holds(class, hidden.id())))
            .collect(),
        extra: found
            .iter()
            .filter(|class| {
                let known = case.effects.iter().flat_map(|hidden| with_companions(*hidden));
                !known.into_iter().any(|effect| holds(class, effect.facts().id))
            })
            .count(),
        flagged: answer.unexplained.structure,
        depends_on: answer
            .unexplained
            .depends_on
            .iter()
            .map(|regressor| regressor.name().to_owned())
            .collect(),
        regressors: case
            .effects
            .iter()
            .flat_map(|hidden| regressors(*hidden).iter().copied())
            .collect(),
        cross_validated_ratio: after.position_rms_m / oracle.errors.cross_validated.position_rms_m,
        found,
        covered,
        explain_s,
        case: case.clone(),
        campaign,
        answer,
    }
}

/// For each parameter found that is also a number of the plant, whether its interval covers the truth.
fn covered(answer: &Answer, hidden: &[Hidden], scenario: &Scenario) -> Vec<(String, bool)> {
    let mut covered = Vec::new();
    for step in &answer.steps {
        if !hidden.iter().any(|hidden| hidden.effect.id() == step.effect) {
            continue;
        }
        for (name, value) in super::hide::true_parameters(&step.effect, scenario) {
            let holds = |parameter: &&ParameterFound| parameter.name == name;
            if let Some(found) = step.parameters.iter().find(holds) {
                let name = format!("{}.{name}", step.effect);
                covered.push((name, found.low95 <= value && value <= found.high95));
            }
        }
    }
    covered
}
