//! Where a model says that the robot is while it drives, and how sure that is.
//!
//! ```text
//! path   = the model at its values, driven by the wheels' turns since the motion began
//! s^2(d) = sum_j ((path(theta_j + sigma_j) - path) . n)^2 + k_theta^2 d^3 / 3 + k_s^2 d        (1)
//! ```
//!
//! s is one sigma across the path, n points across it, and d is how far the robot has rolled: what the parameters leave open,
//! and the random walk of heading and place (Kelly, "Linearized error propagation in odometry", IJRR 2004).

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use campaign::model::in_use::effects;
use campaign::model::{EffectEntry, ModelFile};
use campaign::{Campaign, RobotFile};
use robot_model::compare::{Comparer, EffectWithValues};
use robot_model::effect::KnownEffect;
use robot_model::kinematics::Pose;
use robot_model::recording::{self, OdometryNoise, PoseMeasurement, Recording, WheelSample};
use serde_json::{Value, json};
use shared_proto::Telemetry;

use super::driven::Driven;
use super::robot::Robot;
use crate::error::{Error, Result};
use crate::escape::seen;
use crate::wheel_angles::turns;

/// The path is predicted anew this often.
const EVERY: Duration = Duration::from_millis(200);

/// A path has at most so many points.
const POINTS_MAX: usize = 200;

/// How well radii and track width of a robot without a model are known, one sigma: as `beeline calibrate --tolerance` assumes.
const TOLERANCE: f64 = 0.005;

/// What predicts.
pub struct Predictor {
    /// The nominal robot of the campaign; without one, that of the configuration.
    robot: Option<recording::Robot>,
    /// What the campaign found.
    entries: Vec<EffectEntry>,
    noise: OdometryNoise,
    /// What it is, for the page.
    name: String,
}

impl Predictor {
    /// The configured robot, whose radii and track width are not exact.
    pub fn configured() -> Self {
        Self {
            robot: None,
            entries: Vec::new(),
            noise: OdometryNoise::TYPICAL,
            name: format!("as configured, radii and track width \u{b1} {} %", TOLERANCE * 100.0),
        }
    }

    /// The model of a campaign.
    pub fn of_campaign(folder: &Path) -> Result<Self> {
        let file = ModelFile::place(folder);
        if !file.is_file() {
            return Err(Error::new(format_args!("{} has no model", folder.display())).hint(
                "`beeline model add` fits one, and the page of `beeline serve FOLDER` saves one",
            ));
        }
        let model = ModelFile::read(&file)?;
        if let Some(entry) = model.effects.iter().find(|entry| entry.parameters.is_empty()) {
            return Err(Error::new(format_args!(
                "{}: {} has no values yet",
                file.display(),
                entry.id()
            ))
            .hint("`beeline model fit` fits them"));
        }
        let (read, recordings) = Campaign::read_both(folder)?;
        let robot = recordings.into_model(&read, folder)?.robot;
        let noise = model.fit.map_or(OdometryNoise::TYPICAL, |fit| fit.noise);
        let ids: Vec<&str> = model.effects.iter().map(EffectEntry::id).collect();
        let name = format!("{}: {}", seen(&folder.to_string_lossy()), ids.join(", "));
        Ok(Self { robot: Some(robot), entries: model.effects, noise, name })
    }

    /// The path in the frame of the odometry, and one sigma across it; `None` for what cannot be computed with.
    pub(super) fn predict(&self, driven: &Driven) -> Option<Value> {
        let first = driven.frames.first()?;
        let nominal = RobotFile::of(&driven.config);
        let robot = self.robot.unwrap_or_else(|| nominal.to_model());
        let terms = match self.robot {
            Some(_) => self.entries.iter().filter_map(Uncertain::of_entry).collect(),
            None => configured(&effects(&nominal, &driven.config)),
        };
        let wheels: Vec<WheelSample> =
            driven.frames.iter().map(|frame| sample(frame, driven)).collect();
        let rolled_m = rolled_m(&wheels, robot.wheel_radius_m);
        let comparer = comparer(robot, wheels, self.noise)?;
        let path = |moved: Option<usize>| -> Option<Vec<Pose>> {
            let model: Vec<EffectWithValues<'_>> =
                (0..terms.len()).map(|k| terms[k].with_values(Some(k) == moved)).collect();
            Some(comparer.predicted(&model).into_iter().next()?.predicted)
        };
        let at_best = path(None)?;
        let mut variance: Vec<f64> = rolled_m
            .iter()
            .map(|d| {
                self.noise.heading_variance_rad2(*d) * d * d / 3.0
                    + self.noise.travel_variance_m2(*d)
            })
            .collect();
        // (1)
        for moved in (0..terms.len()).filter(|k| terms[*k].sigma > 0.0) {
            for ((sum, best), other) in variance.iter_mut().zip(&at_best).zip(path(Some(moved))?) {
                *sum += other.seen_from(*best).y_m.powi(2);
            }
        }
        let start = Pose::new(
            first.pose.x_um as f64 * 1e-6,
            first.pose.y_um as f64 * 1e-6,
            first.pose.heading_urad as f64 * 1e-6,
        );
        let every = at_best.len().div_ceil(POINTS_MAX).max(1);
        let last = at_best.len() - 1;
        let kept = |k: &usize| k.is_multiple_of(every) || *k == last;
        let round = |metres: f64| (metres * 1e5).round() / 1e5;
        let points: Vec<[f64; 4]> = (0..at_best.len())
            .filter(kept)
            .map(|k| {
                let pose = start.compose(at_best[k]);
                [pose.x_m, pose.y_m, pose.heading_rad, variance[k].sqrt()].map(round)
            })
            .collect();
        points
            .iter()
            .flatten()
            .all(|number| number.is_finite())
            .then(|| json!({"of": self.name, "began_us": first.t_us, "points": points}))
    }
}

/// An effect at its values, one of which may be off by a sigma.
struct Uncertain {
    effect: KnownEffect,
    values: Vec<f64>,
    /// Of the value with this number.
    moved: usize,
    sigma: f64,
    up_to_mps: Option<f64>,
}

impl Uncertain {
    /// The least certain of the values stands for the effect: most effects have one.
    fn of_entry(entry: &EffectEntry) -> Option<Self> {
        let parameters = &entry.parameters;
        let (moved, found) =
            parameters.iter().enumerate().max_by(|(_, a), (_, b)| a.sigma.total_cmp(&b.sigma))?;
        Some(Self {
            effect: entry.effect.clone(),
            values: parameters.iter().map(|parameter| parameter.value).collect(),
            moved,
            sigma: found.sigma,
            up_to_mps: entry.up_to_mps,
        })
    }

    fn with_values(&self, is_moved: bool) -> EffectWithValues<'_> {
        let mut values = self.values.clone();
        if is_moved {
            values[self.moved] += self.sigma;
        }
        EffectWithValues { effect: &*self.effect, values, up_to_mps: self.up_to_mps }
    }
}

/// What a configuration compensates, and how well the geometry of a robot is known that nobody has measured.
fn configured(in_use: &[EffectEntry]) -> Vec<Uncertain> {
    let known: Vec<Uncertain> = in_use.iter().filter_map(Uncertain::of_entry).collect();
    // The radii are each known by themselves: their ratio is off by root two of it, their mean by one over that.
    let open = [
        ("wheel_radius_ratio", TOLERANCE * std::f64::consts::SQRT_2),
        ("wheel_radius_scale", TOLERANCE / std::f64::consts::SQRT_2),
        ("track_width", TOLERANCE),
    ];
    let mut terms = known;
    for (id, sigma) in open {
        match terms.iter_mut().find(|term| term.effect.facts().id == id) {
            Some(term) => term.sigma = sigma,
            None => terms.extend(KnownEffect::find(id, &[]).map(|effect| Uncertain {
                values: vec![0.0; effect.facts().parameters.len()],
                effect,
                moved: 0,
                sigma,
                up_to_mps: None,
            })),
        }
    }
    terms
}

fn sample(frame: &Telemetry, driven: &Driven) -> WheelSample {
    WheelSample { t_s: frame.t_us as f64 * 1e-6, phi_rad: turns(frame, &driven.config) }
}

/// How far the robot has rolled, on the mean of both wheels, sample by sample \[m\].
fn rolled_m(wheels: &[WheelSample], radius_m: f64) -> Vec<f64> {
    let mut rolled_m = vec![0.0; wheels.len()];
    for k in 1..wheels.len() {
        let turned =
            |side: fn(&WheelSample) -> f64| (side(&wheels[k]) - side(&wheels[k - 1])).abs();
        let mean_rad = (turned(|at| at.phi_rad.left) + turned(|at| at.phi_rad.right)) / 2.0;
        rolled_m[k] = rolled_m[k - 1] + radius_m * mean_rad;
    }
    rolled_m
}

/// The motion as a run that begins at the origin, with a place to be predicted at each sample.
fn comparer(
    robot: recording::Robot,
    wheels: Vec<WheelSample>,
    noise: OdometryNoise,
) -> Option<Comparer> {
    let begins_s = wheels.first()?.t_s;
    let place = |sample: &WheelSample| {
        let is_first = sample.t_s == begins_s;
        PoseMeasurement {
            t_s: sample.t_s,
            position_m: is_first.then_some([0.0, 0.0]),
            heading_rad: is_first.then_some(0.0),
        }
    };
    let measured_poses = wheels.iter().map(place).collect();
    let run = Recording { name: "now".to_owned(), wheels, measured_poses, ..Recording::default() };
    Comparer::with_noise(&recording::Campaign { robot, runs: vec![run] }, noise).ok()
}

/// Predicts again and again, until the robot's page ends.
pub fn predict_for(robot: &Arc<Robot>, predictor: &Predictor) {
    let mut seen = None;
    loop {
        std::thread::sleep(EVERY);
        let Some(driven) = robot.driven() else { continue };
        let now = driven.frames.last().map(|frame| frame.t_us);
        if now != seen {
            seen = now;
            robot.set_prediction(predictor.predict(&driven));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use shared_proto::{Config, State, WheelPair, WheelTelemetry};

    use super::*;

    /// Both wheels roll so far, in steps of a centimetre.
    fn driven(metres: f64) -> Driven {
        let config = Config::default();
        let encoder = config.encoder.left;
        let per_m = encoder.counts_per_rev * encoder.gear_reduction
            / (TAU * config.geometry.wheel_radius_m);
        let frame = |k: u32| {
            let counts = (f64::from(k) * 0.01 * per_m).round() as i64;
            Telemetry {
                number: k,
                t_us: u64::from(k) * 40_000,
                state: State::Driving,
                probing: false,
                wheels: WheelPair::both(WheelTelemetry { counts, ..WheelTelemetry::default() }),
                supply_mv: 12_000,
                // It stands somewhere when it begins, and faces left.
                pose: shared_proto::Pose { x_um: 1_000_000, y_um: 0, heading_urad: 1_570_796 },
                deviation: shared_proto::PoseDeviation::default(),
            }
        };
        let frames = (0..=(metres / 0.01).round() as u32).map(frame).collect();
        Driven { config, frames }
    }

    fn points(predicted: &Value) -> Vec<[f64; 4]> {
        serde_json::from_value(predicted["points"].clone()).unwrap()
    }

    #[test]
    fn the_configured_robot_goes_straight_on_and_nobody_knows_how_straight() {
        let predicted = Predictor::configured().predict(&driven(2.0)).unwrap();
        let points = points(&predicted);
        assert!(points.len() <= POINTS_MAX + 1);
        let [x, y, heading, sigma] = *points.last().unwrap();
        assert!((x - 1.0).abs() < 1e-3 && (y - 2.0).abs() < 2e-3, "{x} {y}");
        assert!((heading - std::f64::consts::FRAC_PI_2).abs() < 1e-3);
        // A ratio of the radii that is off by rho turns the robot by rho d / b, and moves it aside by half of that times d.
        let aside = TOLERANCE * std::f64::consts::SQRT_2 * 4.0 / (2.0 * 0.372);
        assert!(sigma > 0.95 * aside && sigma < 1.3 * aside, "{sigma} for {aside}");
        assert_eq!(points[0][3], 0.0);
    }

    #[test]
    fn what_the_configuration_compensates_bends_the_path() {
        let mut driven = driven(2.0);
        driven.config.geometry.wheel_weight = 0.99;
        let [x, ..] = *points(&Predictor::configured().predict(&driven).unwrap()).last().unwrap();
        // The right wheel is smaller: to the right, which is ahead of where it began, seen from above.
        assert!(x > 1.04, "{x}");
    }

    #[test]
    fn the_model_of_a_campaign_predicts_and_one_without_values_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let error = Predictor::of_campaign(folder.path()).map(drop).unwrap_err();
        assert!(error.to_string().contains("has no model"), "{error}");
    }
}
