//! The numbers of a controller, from a campaign: for each program those that it knows.
//!
//! A controller computes odometry by equation (1) of [`geometry`](crate::geometry). It knows scale and ratio of the radii, and
//! the track width, or fewer. They are fitted to the campaign by themselves, whatever else its model has: without the rest of
//! the model, its own numbers would not be the best. What that costs against the model is a [`Cost`].

use std::path::Path;

use campaign::model::ModelFile;
use campaign::words::recording_error;
use campaign::{CampaignError, RobotFile};
use robot_model::compare::{Comparer, EffectWithValues};
use robot_model::effect::{ActsOn, CATALOGUE, Effect, find};
use robot_model::estimation::ErrorPair;
use robot_model::explain::model::{Model, ModelFitter};
use robot_model::recording::{Campaign, RecordingError};

use super::target::{EFFECTS, Target};
use crate::geometry::Geometry;
use crate::log::error;

/// How often `diff_drive_controller` publishes by default \[Hz\].
pub(super) const PUBLISH_HZ: f64 = 50.0;

/// What is as improbable by chance is there.
const CHANCE: f64 = 1e-3;

/// What a controller is told.
#[derive(Clone, Debug, PartialEq)]
pub struct Controller {
    /// The program.
    pub target: Target,
    /// Radii and track width, as the program can have them.
    pub geometry: Geometry,
    /// Without its rounding.
    pub(super) exact: Geometry,
    /// Variances of x, y and heading by odometry, within a run like these \[m^2, rad^2\].
    pub pose_variances: [f64; 2],
    /// Variances of speed and turn rate in one message \[m^2/s^2, rad^2/s^2\].
    pub twist_variances: [f64; 2],
    /// Errors of the nominal robot and of these numbers.
    pub errors: [ErrorPair; 2],
    /// What the program cannot be told.
    pub cost: Option<Cost>,
}

/// What a program cannot be told.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    /// Effects by their names, and fractions that it rounds.
    pub effects: Vec<String>,
    /// Position errors (rms) on this campaign: of the program's numbers, and of the model, or of radii and track width if it has
    /// no other effect \[m\].
    pub position_m: [f64; 2],
}

impl Controller {
    /// Fits the numbers of a program to a campaign. `folder` is only named in errors.
    pub fn of(
        folder: &Path,
        robot: &RobotFile,
        campaign: &Campaign,
        model: &ModelFile,
        target: Target,
    ) -> Result<Self, CampaignError> {
        let cannot = |why: RecordingError| {
            error(folder, recording_error(&why), "`beeline compare` says more")
        };
        let fitted = fitted(campaign, target.effects()).map_err(cannot)?;
        let measured = of_measurement(&fitted);
        let exact = geometry(robot, &fitted);
        let rounded = target.rounded(&exact, robot);
        let speed_mps = mean_speed_mps(campaign);
        // A random walk over the time of one message: var(v) = k_s^2 v dt / dt^2.
        let per_message = |walk: f64| walk * walk * speed_mps * PUBLISH_HZ;
        let within = fitted.errors.fitted;
        let cost = cost(robot, campaign, model, target, (&exact, &rounded, &measured));
        Ok(Self {
            target,
            geometry: rounded,
            exact,
            pose_variances: [within.position_rms_m.powi(2) / 2.0, within.heading_rms_rad.powi(2)],
            twist_variances: [
                per_message(fitted.noise.travel_walk),
                per_message(fitted.noise.heading_walk),
            ],
            errors: [fitted.nominal, fitted.errors],
            cost: cost.map_err(cannot)?,
        })
    }
}

/// These effects, fitted, and beside them what was wrong with the measurement, as far as there is evidence: where a marker sits
/// and how late a pose comes are no errors of an odometry.
fn fitted(campaign: &Campaign, ids: &[&str]) -> Result<Model, RecordingError> {
    let asked: Vec<&dyn Effect> = ids.iter().filter_map(|id| find(id)).collect();
    let fitter = ModelFitter::new(campaign)?;
    let measurement = CATALOGUE.iter().copied().filter(is_of_measurement);
    let with_all = fitter.fit(&[&asked[..], &measurement.collect::<Vec<_>>()].concat());
    let is_there = |effect: &&dyn Effect| {
        let found = with_all.effects.iter().find(|found| found.effect == effect.facts().id);
        found.is_some_and(|found| {
            let verdict = &found.verdict;
            verdict.p_value < CHANCE && verdict.cross_validated_gain > 0.0 && !verdict.implausible
        })
    };
    let kept = CATALOGUE.iter().copied().filter(is_of_measurement).filter(is_there);
    Ok(fitter.fit(&[&asked[..], &kept.collect::<Vec<_>>()].concat()))
}

fn is_of_measurement(effect: &&dyn Effect) -> bool {
    effect.facts().acts_on == ActsOn::Measurement
}

/// What was wrong with the measurement, as it was fitted.
fn of_measurement(fitted: &Model) -> Vec<EffectWithValues<'static>> {
    let found = fitted.effects.iter().filter_map(|found| {
        let effect = find(&found.effect).filter(is_of_measurement)?;
        let values = found.parameters.iter().map(|parameter| parameter.value).collect();
        Some(EffectWithValues { effect, values, up_to_mps: None })
    });
    found.collect()
}

/// The numbers that fitted effects say.
fn geometry(robot: &RobotFile, fitted: &Model) -> Geometry {
    let [scale, ratio, track] = EFFECTS.map(|id| value(fitted, id));
    Geometry {
        wheel_radius_m: robot.wheel_radius_m,
        radius_multipliers: [-0.5, 0.5].map(|half| (1.0 + scale) * (1.0 + half * ratio)),
        wheel_separation_m: robot.track_width_m,
        separation_multiplier: 1.0 + track,
    }
}

/// The effects that numbers are.
fn effects_of(geometry: &Geometry) -> Vec<EffectWithValues<'static>> {
    let [left, right] = geometry.radius_multipliers;
    let values = [
        (left + right) / 2.0 - 1.0,
        2.0 * (right - left) / (right + left),
        geometry.separation_multiplier - 1.0,
    ];
    let with_value = |(id, value): (&str, f64)| {
        Some(EffectWithValues { effect: find(id)?, values: vec![value], up_to_mps: None })
    };
    EFFECTS.into_iter().zip(values).filter_map(with_value).collect()
}

fn value(model: &Model, id: &str) -> f64 {
    let effect = model.effects.iter().find(|effect| effect.effect == id);
    effect.and_then(|effect| effect.parameters.first()).map_or(0.0, |parameter| parameter.value)
}

/// Mean speed of the rims while a wheel turns \[m/s\].
fn mean_speed_mps(campaign: &Campaign) -> f64 {
    let (mut rolled_m, mut moving_s) = (0.0, 0.0);
    for pair in campaign.fitted_runs().flat_map(|run| run.wheels.windows(2)) {
        let turned = pair[0].phi_rad.zip(pair[1].phi_rad).map(|(a, b)| (b - a).abs());
        let step_m = campaign.robot.wheel_radius_m * turned.mean();
        if step_m > 0.0 {
            rolled_m += step_m;
            moving_s += pair[1].t_s - pair[0].t_s;
        }
    }
    if moving_s > 0.0 { rolled_m / moving_s } else { 0.0 }
}

/// What a program cannot be told of a campaign, if there is anything: its numbers are given exact and as it rounds them.
fn cost(
    robot: &RobotFile,
    campaign: &Campaign,
    model: &ModelFile,
    target: Target,
    (exact, rounded, measured): (&Geometry, &Geometry, &[EffectWithValues<'static>]),
) -> Result<Option<Cost>, RecordingError> {
    let accepted = model.effects_with_values().unwrap_or_default();
    let facts = accepted.iter().map(|effect| effect.effect.facts());
    let beyond =
        facts.filter(|facts| !EFFECTS.contains(&facts.id) && facts.acts_on != ActsOn::Measurement);
    let mut names: Vec<String> = beyond.map(|facts| facts.name.to_owned()).collect();
    let is_whole_model = !names.is_empty();
    let missing = EFFECTS.into_iter().filter(|id| !target.effects().contains(id));
    names.extend(missing.filter_map(|id| Some(find(id)?.facts().name.to_owned())));
    if rounded != exact {
        names.push("fractions of a count".to_owned());
    }
    if names.is_empty() {
        return Ok(None);
    }
    let own: Vec<&dyn Effect> = model.own().collect();
    let comparer = Comparer::new(campaign, &own)?;
    let error_m = |effects: &[EffectWithValues<'_>]| comparer.compare(effects).position_m.rms;
    let whole_m = if is_whole_model {
        let is_in_model = |one: &&EffectWithValues<'_>| {
            let id = one.effect.facts().id;
            accepted.iter().any(|effect| effect.effect.facts().id == id)
        };
        let beside = measured.iter().filter(|one| !is_in_model(one)).cloned();
        error_m(&accepted.iter().cloned().chain(beside).collect::<Vec<_>>())
    } else {
        let all = fitted(campaign, &EFFECTS)?;
        error_m(&[effects_of(&geometry(robot, &all)), of_measurement(&all)].concat())
    };
    let own_m = error_m(&[effects_of(rounded), measured.to_vec()].concat());
    // A model that is worse than the program's numbers tells nothing of what these lack.
    Ok((own_m >= whole_m).then_some(Cost { effects: names, position_m: [own_m, whole_m] }))
}
