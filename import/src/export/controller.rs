//! The parameters of ROS 2's `diff_drive_controller`, from a campaign.
//!
//! The controller computes odometry by equation (1) of [`geometry`](crate::geometry). It knows three numbers: scale and ratio of the radii, and the track width. They are fitted to the campaign by
//! themselves, whatever else its model has: without the rest of the model, its own three numbers would not be the best. What
//! that costs against the model is a [`Cost`].

use std::fmt::Write as _;

use campaign::model::ModelFile;
use campaign::{CampaignError, RobotFile};
use robot_model::compare::{Comparer, EffectWithValues};
use robot_model::effect::{Effect, find};
use robot_model::estimation::ErrorPair;
use robot_model::explain::model::{Model, fit};
use robot_model::recording::Campaign;
use std::path::Path;

use crate::geometry::Geometry;
use crate::log::error;

/// The effects that equation (1) can express.
const EFFECTS: [&str; 3] = ["wheel_radius_scale", "wheel_radius_ratio", "track_width"];
/// How often the controller publishes by default \[Hz\].
const PUBLISH_HZ: f64 = 50.0;
/// The variance of what is not measured.
const UNKNOWN: f64 = 1e6;

/// What a controller is told.
#[derive(Clone, Debug, PartialEq)]
pub struct Controller {
    /// Radii and track width.
    pub geometry: Geometry,
    /// Variances of x, y and heading by odometry, within a run like these \[m^2, rad^2\].
    pub pose_variances: [f64; 2],
    /// Variances of speed and turn rate in one message \[m^2/s^2, rad^2/s^2\].
    pub twist_variances: [f64; 2],
    /// Errors of the nominal robot and of these numbers.
    pub errors: [ErrorPair; 2],
    /// What the model says beyond them.
    pub cost: Option<Cost>,
}

/// Effects of a model that the controller cannot express.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    /// Their names.
    pub effects: Vec<String>,
    /// Position errors (rms) on this campaign: of the three numbers, and of the model \[m\].
    pub position_m: [f64; 2],
}

impl Controller {
    /// Fits the controller's numbers to a campaign. `folder` is only named in errors.
    pub fn of(
        folder: &Path,
        robot: &RobotFile,
        campaign: &Campaign,
        model: &ModelFile,
    ) -> Result<Self, CampaignError> {
        let cannot = |why: &dyn std::fmt::Display| {
            error(folder, why.to_string(), "`beeline compare` says more")
        };
        let effects: Vec<&dyn Effect> = EFFECTS.iter().filter_map(|id| find(id)).collect();
        let fitted = fit(campaign, &effects).map_err(|why| cannot(&why))?;
        let value = |id: &str| value(&fitted, id);
        let (scale, ratio, track) = (value(EFFECTS[0]), value(EFFECTS[1]), value(EFFECTS[2]));
        let speed_mps = mean_speed_mps(campaign);
        // A random walk over the time of one message: var(v) = k_s^2 v dt / dt^2.
        let per_message = |walk: f64| walk * walk * speed_mps * PUBLISH_HZ;
        let within = fitted.errors.fitted;
        let cost = cost(campaign, model, &fitted).map_err(|why| cannot(&why))?;
        Ok(Self {
            geometry: Geometry {
                wheel_radius_m: robot.wheel_radius_m,
                radius_multipliers: [-0.5, 0.5].map(|half| (1.0 + scale) * (1.0 + half * ratio)),
                wheel_separation_m: robot.track_width_m,
                separation_multiplier: 1.0 + track,
            },
            pose_variances: [within.position_rms_m.powi(2) / 2.0, within.heading_rms_rad.powi(2)],
            twist_variances: [
                per_message(fitted.noise.travel_walk),
                per_message(fitted.noise.heading_walk),
            ],
            errors: [fitted.nominal, fitted.errors],
            cost,
        })
    }

    /// The parameters as YAML, for a controller of this name.
    pub fn to_yaml(&self, robot: &str) -> String {
        let [nominal, errors] = self.errors;
        let mm = |m: f64| m * 1e3;
        // A comment ends with its line, and a name is a text from outside.
        let robot: String = robot.chars().filter(|c| !c.is_control()).collect();
        let mut yaml = format!(
            "# diff_drive_controller, from a campaign of: {robot}\n\
             # error of the odometry, root mean square: {:.1} mm with the nominal numbers, {:.1} mm with these\n",
            mm(nominal.fitted.position_rms_m),
            mm(errors.fitted.position_rms_m)
        );
        if let Some(cost) = &self.cost {
            let _ = writeln!(
                yaml,
                "# not expressible: {}; with the whole model {:.1} mm",
                cost.effects.join(", "),
                mm(cost.position_m[1])
            );
        }
        let Geometry { wheel_radius_m, radius_multipliers: [left, right], .. } = self.geometry;
        let Geometry { wheel_separation_m, separation_multiplier, .. } = self.geometry;
        let [pose, heading] = self.pose_variances;
        let [speed, rate] = self.twist_variances;
        let unknown = "1000000.0, 1000000.0, 1000000.0";
        debug_assert_eq!(UNKNOWN, 1_000_000.0);
        let _ = write!(
            yaml,
            "diff_drive_controller:\n  ros__parameters:\n    \
             wheel_separation: {wheel_separation_m:.6}\n    wheel_separation_multiplier: {separation_multiplier:.6}\n    \
             wheel_radius: {wheel_radius_m:.6}\n    left_wheel_radius_multiplier: {left:.6}\n    right_wheel_radius_multiplier: {right:.6}\n    \
             # x, y, z, roll, pitch, yaw: of the pose within a run like those of the campaign, and of one message at {PUBLISH_HZ:.0} Hz\n    \
             pose_covariance_diagonal: [{pose:.3e}, {pose:.3e}, {unknown}, {heading:.3e}]\n    \
             twist_covariance_diagonal: [{speed:.3e}, {speed:.3e}, {unknown}, {rate:.3e}]\n"
        );
        yaml
    }
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

/// What a model says beyond the three numbers, if it has values.
fn cost(
    campaign: &Campaign,
    model: &ModelFile,
    fitted: &Model,
) -> Result<Option<Cost>, robot_model::recording::RecordingError> {
    let Ok(effects) = model.effects_with_values() else { return Ok(None) };
    let beyond: Vec<String> = effects
        .iter()
        .map(|effect| effect.effect.facts())
        .filter(|facts| !EFFECTS.contains(&facts.id))
        .map(|facts| facts.name.to_owned())
        .collect();
    if beyond.is_empty() {
        return Ok(None);
    }
    let own: Vec<&dyn Effect> = model.own().collect();
    let comparer = Comparer::new(campaign, &own)?;
    let three: Vec<EffectWithValues<'_>> = EFFECTS
        .iter()
        .filter_map(|id| {
            Some(EffectWithValues {
                effect: find(id)?,
                values: vec![value(fitted, id)],
                up_to_mps: None,
            })
        })
        .collect();
    let error_m = |effects: &[EffectWithValues<'_>]| comparer.compare(effects).position_m.rms;
    Ok(Some(Cost { effects: beyond, position_m: [error_m(&three), error_m(&effects)] }))
}
