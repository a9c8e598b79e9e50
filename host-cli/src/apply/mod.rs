//! What the firmware can compensate, from what a campaign says.
//!
//! ```text
//! R_L = R (1 + s) (1 - rho/2),   W_T = (1 + rho/2) / (1 - rho/2),   b' = b (1 + delta),   c' = c     (1)
//! ```
//!
//! R and b are the nominal robot of the campaign (`robot.toml`), rho of wheel_radius_ratio, s of
//! wheel_radius_scale, delta of track_width, c of heading_pull, which motions are steered against. Encoder counts
//! are recorded raw, so (1) is absolute: applying it twice is applying it once. R_L is in both wheels' distance per count Q, W_T in the right one's.
//!
//! What is written is as sure as its estimate:
//!
//! ```text
//! sd_W = sd_rho / (1 - rho/2)^2,   sd_b = b sd_delta                                      (2)
//! ```
//!
//! What the campaign does not show stays as it is in use: W_T without rho, the mean radius R_L (1 + W_T) / 2 without s.

use robot_model::effect::{ActsOn, FirmwareTerm, find};
use robot_model::explain::model::Model;
use robot_model::explain::{Answer, ParameterFound, StepFound};
use shared_proto::{Config, GeometryConfig, OdometryConfig};

use crate::campaign_recorder::samples::robot_file;
use crate::error::{Error, Result};
use campaign::RobotFile;
use campaign::mean_radius_m;
use campaign::model::{EffectEntry, ModelFile};

/// An effect that was found or chosen, and its parameters.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Its id.
    pub effect: String,
    /// All that the campaign cannot tell from this one, itself included.
    pub class: Vec<String>,
    /// Its parameters.
    pub parameters: Vec<ParameterFound>,
    /// The value by which the robot compensates this effect, where the runs do not confirm it.
    pub unconfirmed: Option<f64>,
    /// Whether it predicts other runs. What does not may be something else.
    pub used_to_predict: bool,
}

impl Estimate {
    /// Whether this is the effect of this id, or cannot be told from that.
    pub fn is(&self, id: &str) -> bool {
        self.class.iter().any(|other| other == id)
    }
}

/// What is to be done about an effect.
#[derive(Clone, Debug, PartialEq)]
pub enum Remedy {
    /// The value goes into the configuration.
    Compensated,
    /// The 95 % interval includes zero.
    Unsure,
    /// The value in use stays: the runs confirm neither that nor another one.
    Stays,
    /// It removes less than is left unexplained, so it may be something else.
    Small,
    /// The campaign does not say whether it is this or one of these.
    Ambiguous(Vec<String>),
    /// The effect is one of the measurement: nothing is wrong with the robot.
    Measurement,
    /// The firmware cannot compensate it; what can be done instead.
    Uncompensated(String),
}

/// A new configuration and why.
#[derive(Clone, Debug)]
pub struct Change {
    /// The geometry in use.
    pub before: GeometryConfig,
    /// The geometry to be written.
    pub after: GeometryConfig,
    /// How sure the odometry is, in use and to be written.
    pub odometry: [OdometryConfig; 2],
    /// Every effect, and what is done about it.
    pub remedies: Vec<(String, Remedy)>,
}

/// The effects that a campaign's explanation names: those that the robot compensates already at their new
/// values, and the missing ones. Their values are those of the model that predicts other runs.
pub fn estimates(answer: &Answer) -> Vec<Estimate> {
    let step = |step: &StepFound| {
        let alone = step.class.len() == 1;
        let predicts = answer.predicts_with.iter().find(|one| alone && one.effect == step.effect);
        Estimate {
            effect: step.effect.clone(),
            class: step.class.clone(),
            parameters: predicts.map_or(&step.parameters, |one| &one.parameters).clone(),
            unconfirmed: None,
            used_to_predict: step.used_to_predict,
        }
    };
    answer.known.iter().chain(&answer.steps).map(step).collect()
}

/// An effect that the robot compensates and these runs do not confirm, as this model has it.
pub fn unconfirmed(entry: &EffectEntry, fitted: &Model) -> Option<Estimate> {
    let effect = entry.id().to_owned();
    let parameters =
        fitted.effects.iter().find(|fitted| fitted.effect == effect)?.parameters.clone();
    let unconfirmed = entry.parameters.first().map(|parameter| parameter.value);
    let class = vec![effect.clone()];
    Some(Estimate { class, effect, parameters, unconfirmed, used_to_predict: true })
}

/// The effects of a campaign's model: whoever put one in has decided that it is this one.
pub fn chosen(model: &ModelFile) -> Vec<Estimate> {
    let entry = |entry: &EffectEntry| {
        let effect = entry.effect.facts().id.to_owned();
        Estimate {
            class: vec![effect.clone()],
            effect,
            parameters: entry.parameters.clone(),
            unconfirmed: None,
            used_to_predict: true,
        }
    };
    model.effects.iter().map(entry).collect()
}

/// What of the firmware's configuration compensates the effect of this id, if it is of the catalogue.
fn compensated_by(effect: &str) -> Option<FirmwareTerm> {
    find(effect)?.facts().compensated_by
}

impl Change {
    /// What these effects ask for on the robot with this configuration.
    ///
    /// `uid` is the robot's own number, in hexadecimal; none for a simulated one.
    pub fn new(
        effects: &[Estimate],
        nominal: &RobotFile,
        config: &Config,
        uid: Option<&str>,
    ) -> Result<Self> {
        same_robot(nominal, config, uid)?;
        let mut after = config.geometry;
        let mut odometry = config.odometry;
        let (mut rho, mut s, mut delta, mut c) = (None, None, None, None);
        let mut remedies = Vec::new();
        for found in effects {
            let remedy = remedy(found);
            if remedy == Remedy::Compensated {
                let first = found.parameters.first();
                let value = first.map(|parameter| parameter.value);
                match compensated_by(&found.effect) {
                    Some(FirmwareTerm::WheelWeight) => rho = first,
                    Some(FirmwareTerm::MeanRadius) => s = value,
                    Some(FirmwareTerm::HeadingPull) => c = value,
                    Some(FirmwareTerm::TrackWidth) => delta = first,
                    None => {}
                }
            }
            remedies.push((found.effect.clone(), remedy));
        }
        // (1); what the campaign does not show stays as it is.
        if rho.is_some() || s.is_some() {
            let in_use = config.geometry;
            let mean_m = match s {
                Some(s) => nominal.wheel_radius_m * (1.0 + s),
                None => mean_radius_m(&in_use),
            };
            if let Some(rho) = rho {
                let half = 1.0 - rho.value / 2.0;
                after.wheel_weight = (1.0 + rho.value / 2.0) / half;
                // (2)
                odometry.wheel_weight_sd = rho.sigma / (half * half);
            }
            after.wheel_radius_m = 2.0 * mean_m / (1.0 + after.wheel_weight);
        }
        if let Some(delta) = delta {
            after.track_width_m = nominal.track_width_m * (1.0 + delta.value);
            odometry.track_width_sd_m = nominal.track_width_m * delta.sigma;
        }
        if let Some(c) = c {
            after.heading_pull_rad_per_m = c;
        }
        let odometry = [config.odometry, odometry];
        Ok(Self { before: config.geometry, after, odometry, remedies })
    }

    /// The mean radius that stays in use, if the campaign is relative to another one and says nothing about it \[m\].
    pub fn other_radius_m(&self, nominal: &RobotFile) -> Option<f64> {
        /// Below what any campaign can tell, and above the digits of a file.
        const SAME: f64 = 1e-4;
        let stays_m = mean_radius_m(&self.after);
        let told = self.remedies.iter().any(|(effect, remedy)| {
            compensated_by(effect) == Some(FirmwareTerm::MeanRadius)
                && matches!(remedy, Remedy::Compensated | Remedy::Ambiguous(_))
        });
        let other = (stays_m / nominal.wheel_radius_m - 1.0).abs() > SAME;
        (other && !told).then_some(stays_m)
    }

    /// Whether the configuration would be another one.
    pub fn changes(&self) -> bool {
        // To less than what any campaign can tell.
        let differs = |a: f64, b: f64| (a - b).abs() > 1e-7 * a.abs();
        // Three digits are enough to say how sure something is.
        let as_sure = |a: f64, b: f64| (a - b).abs() <= 1e-3 * a.abs();
        let [now, new] = self.odometry;
        differs(self.before.wheel_radius_m, self.after.wheel_radius_m)
            || differs(self.before.track_width_m, self.after.track_width_m)
            || differs(self.before.wheel_weight, self.after.wheel_weight)
            || (self.before.heading_pull_rad_per_m - self.after.heading_pull_rad_per_m).abs() > 1e-7
            || !as_sure(now.wheel_weight_sd, new.wheel_weight_sd)
            || !as_sure(now.track_width_sd_m, new.track_width_sd_m)
    }
}

fn remedy(found: &Estimate) -> Remedy {
    let facts = find(&found.effect).map(|effect| effect.facts());
    let acts_on = facts.map(|facts| facts.acts_on);
    if acts_on.is_some_and(|acts_on| acts_on != ActsOn::Motion) {
        return Remedy::Measurement;
    }
    if compensated_by(&found.effect).is_none() {
        let what = facts.map_or("add this term to the odometry", |facts| facts.compensation);
        return Remedy::Uncompensated(what.to_owned());
    }
    let holds = |value: f64| {
        let outside = |of: &ParameterFound| of.low95 > value || of.high95 < value;
        found.parameters.first().is_none_or(|parameter| !outside(parameter))
    };
    match found.unconfirmed {
        Some(in_use) if holds(in_use) => return Remedy::Stays,
        None if holds(0.0) => return Remedy::Unsure,
        _ => {}
    }
    if !found.used_to_predict {
        return Remedy::Small;
    }
    if found.class.len() > 1 {
        let others = found.class.iter().filter(|other| **other != found.effect);
        return Remedy::Ambiguous(others.cloned().collect());
    }
    Remedy::Compensated
}

/// Refuses the campaign of another robot.
fn same_robot(nominal: &RobotFile, config: &Config, uid: Option<&str>) -> Result<()> {
    let here = RobotFile { uid: uid.map(str::to_owned), ..robot_file(config, None) };
    match nominal.difference(&here) {
        None => Ok(()),
        Some((name, there, here)) => Err(Error::new(format_args!(
            "this campaign is of another robot: its {name} is {there}, this robot has {here}"
        ))
        .hint("choose a campaign of this robot, or correct its configuration")),
    }
}

#[cfg(test)]
mod tests;
