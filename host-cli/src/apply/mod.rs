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
//! What the campaign does not show stays as it is in use: W_T without rho, the mean radius R_L (1 + W_T) / 2 without s.

use robot_model::effect::{ActsOn, FirmwareTerm, find};
use robot_model::explain::model::Model;
use robot_model::explain::{Answer, ParameterFound};
use shared_proto::{Config, GeometryConfig};

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
    /// Every effect, and what is done about it.
    pub remedies: Vec<(String, Remedy)>,
}

/// The effects that a campaign's explanation names: those that the robot compensates already at their new
/// values, and the missing ones.
pub fn estimates(answer: &Answer) -> Vec<Estimate> {
    let step = |step: &robot_model::explain::StepFound| Estimate {
        effect: step.effect.clone(),
        class: step.class.clone(),
        parameters: step.parameters.clone(),
        unconfirmed: None,
    };
    answer.known.iter().chain(&answer.steps).map(step).collect()
}

/// An effect that the robot compensates and these runs do not confirm, as this model has it.
pub fn unconfirmed(entry: &EffectEntry, fitted: &Model) -> Option<Estimate> {
    let effect = entry.id().to_owned();
    let parameters =
        fitted.effects.iter().find(|fitted| fitted.effect == effect)?.parameters.clone();
    let unconfirmed = entry.parameters.first().map(|parameter| parameter.value);
    Some(Estimate { class: vec![effect.clone()], effect, parameters, unconfirmed })
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
        let (mut rho, mut s, mut delta, mut c) = (None, None, None, None);
        let mut remedies = Vec::new();
        for found in effects {
            let remedy = remedy(found);
            if remedy == Remedy::Compensated {
                let value = found.parameters.first().map(|parameter| parameter.value);
                match compensated_by(&found.effect) {
                    Some(FirmwareTerm::WheelWeight) => rho = value,
                    Some(FirmwareTerm::MeanRadius) => s = value,
                    Some(FirmwareTerm::HeadingPull) => c = value,
                    Some(FirmwareTerm::TrackWidth) => delta = value,
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
                after.wheel_weight = (1.0 + rho / 2.0) / (1.0 - rho / 2.0);
            }
            after.wheel_radius_m = 2.0 * mean_m / (1.0 + after.wheel_weight);
        }
        if let Some(delta) = delta {
            after.track_width_m = nominal.track_width_m * (1.0 + delta);
        }
        if let Some(c) = c {
            after.heading_pull_rad_per_m = c;
        }
        Ok(Self { before: config.geometry, after, remedies })
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
        differs(self.before.wheel_radius_m, self.after.wheel_radius_m)
            || differs(self.before.track_width_m, self.after.track_width_m)
            || differs(self.before.wheel_weight, self.after.wheel_weight)
            || (self.before.heading_pull_rad_per_m - self.after.heading_pull_rad_per_m).abs() > 1e-7
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
mod tests {
    use super::*;

    fn nominal(config: &Config) -> RobotFile {
        robot_file(config, None)
    }

    fn effect(id: &str, value: f64, class: &[&str]) -> Estimate {
        let parameter = ParameterFound {
            name: "p".into(),
            unit: "1".into(),
            value,
            sigma: 1e-4,
            low95: value - 2e-4,
            high95: value + 2e-4,
        };
        let class = class.iter().map(|id| (*id).to_owned()).collect();
        Estimate { effect: id.into(), class, parameters: vec![parameter], unconfirmed: None }
    }

    #[test]
    fn radii_and_track_go_into_the_configuration_whatever_is_in_use() {
        let effects = [
            effect("wheel_radius_ratio", -0.008, &["wheel_radius_ratio"]),
            effect("wheel_radius_scale", 0.002, &["wheel_radius_scale"]),
            effect("track_width", 0.01, &["track_width"]),
        ];
        let mut config = Config::default();
        let nominal = nominal(&config);
        let once = Change::new(&effects, &nominal, &config, None).unwrap();
        let g = once.after;
        assert!((g.wheel_radius_m - 0.036 * 1.002 * 1.004).abs() < 1e-12);
        assert!((g.wheel_weight - 0.996 / 1.004).abs() < 1e-12);
        assert!((g.track_width_m - 0.372 * 1.01).abs() < 1e-12);
        assert!(once.changes());
        config.geometry = g;
        let twice = Change::new(&effects, &nominal, &config, None).unwrap();
        assert!((twice.after.wheel_radius_m - g.wheel_radius_m).abs() < 1e-15);
        assert!(!twice.changes());
    }

    /// A robot that was calibrated before: W_T and radius are not what is nominal.
    fn calibrated() -> Config {
        let mut config = Config::default();
        config.geometry.wheel_weight = 1.008;
        config.geometry.wheel_radius_m *= 1.01;
        config
    }

    #[test]
    fn a_scale_alone_leaves_the_wheel_weight_in_use() {
        let (nominal, config) = (nominal(&Config::default()), calibrated());
        let effects = [
            effect("wheel_radius_ratio", 0.003, &["wheel_radius_ratio", "heading_pull"]),
            effect("wheel_radius_scale", 0.002, &["wheel_radius_scale"]),
        ];
        let g = Change::new(&effects, &nominal, &config, None).unwrap().after;
        assert_eq!(g.wheel_weight, 1.008);
        let mean_m = g.wheel_radius_m * (1.0 + g.wheel_weight) / 2.0;
        assert!((mean_m - 0.036 * 1.002).abs() < 1e-12, "{mean_m}");
    }

    #[test]
    fn a_ratio_alone_leaves_the_mean_radius_in_use() {
        let (nominal, config) = (nominal(&Config::default()), calibrated());
        let effects = [effect("wheel_radius_ratio", -0.006, &["wheel_radius_ratio"])];
        let g = Change::new(&effects, &nominal, &config, None).unwrap().after;
        assert!((g.wheel_weight - 0.997 / 1.003).abs() < 1e-12);
        let mean_m = |g: &GeometryConfig| g.wheel_radius_m * (1.0 + g.wheel_weight) / 2.0;
        assert!((mean_m(&g) - mean_m(&config.geometry)).abs() < 1e-12);
    }

    #[test]
    fn a_pull_alone_leaves_the_wheels_in_use() {
        let (nominal, config) = (nominal(&Config::default()), calibrated());
        let effects = [effect("heading_pull", -0.01, &["heading_pull"])];
        let change = Change::new(&effects, &nominal, &config, None).unwrap();
        assert!(change.changes());
        let expected = GeometryConfig { heading_pull_rad_per_m: -0.01, ..config.geometry };
        assert_eq!(change.after, expected);
    }

    #[test]
    fn a_track_alone_leaves_the_wheels_in_use() {
        let (nominal, config) = (nominal(&Config::default()), calibrated());
        let effects = [effect("track_width", 0.01, &["track_width"])];
        let g = Change::new(&effects, &nominal, &config, None).unwrap().after;
        let GeometryConfig { wheel_radius_m, wheel_weight, .. } = config.geometry;
        assert_eq!((g.wheel_radius_m, g.wheel_weight), (wheel_radius_m, wheel_weight));
    }

    #[test]
    fn what_cannot_be_told_from_something_else_is_not_written() {
        let config = Config::default();
        let effects = [effect("wheel_radius_ratio", 0.01, &["wheel_radius_ratio", "heading_pull"])];
        let change = Change::new(&effects, &nominal(&config), &config, None).unwrap();
        assert!(!change.changes());
        assert_eq!(change.remedies[0].1, Remedy::Ambiguous(vec!["heading_pull".into()]));
    }

    #[test]
    fn what_may_as_well_be_zero_is_not_written() {
        let config = Config::default();
        // Known to 1e-4, and no larger.
        let effects = [effect("track_width", 1e-4, &["track_width"])];
        let change = Change::new(&effects, &nominal(&config), &config, None).unwrap();
        assert!(!change.changes());
        assert_eq!(change.remedies[0].1, Remedy::Unsure);
    }

    #[test]
    fn a_compensation_that_the_runs_deny_goes_and_one_that_they_leave_open_stays() {
        let config = calibrated();
        // In use is 1.008: the runs say 1, to 2e-4.
        let unconfirmed = |value: f64, in_use: f64| Estimate {
            unconfirmed: Some(in_use),
            ..effect("wheel_radius_ratio", value, &["wheel_radius_ratio"])
        };
        let nominal = nominal(&Config::default());
        let change = Change::new(&[unconfirmed(1e-4, 0.008)], &nominal, &config, None).unwrap();
        assert!((change.after.wheel_weight - 1.0001).abs() < 1e-7);
        let change = Change::new(&[unconfirmed(1e-4, 2e-4)], &nominal, &config, None).unwrap();
        assert_eq!(change.remedies[0].1, Remedy::Stays);
        assert!(!change.changes());
    }

    #[test]
    fn slip_is_said_to_stay_and_a_late_camera_is_not_the_robots_fault() {
        let config = Config::default();
        let effects = [
            effect("side_slip", 0.02, &["side_slip"]),
            effect("measurement_delay", 0.04, &["measurement_delay"]),
        ];
        let change = Change::new(&effects, &nominal(&config), &config, None).unwrap();
        assert!(matches!(change.remedies[0].1, Remedy::Uncompensated(_)));
        assert_eq!(change.remedies[1].1, Remedy::Measurement);
        assert!(!change.changes());
    }

    #[test]
    fn the_campaign_of_another_robot_is_refused() {
        let config = Config::default();
        let smaller = RobotFile { wheel_radius_m: 0.0358, ..nominal(&config) };
        let of = |effects: &[Estimate]| Change::new(effects, &smaller, &config, None).unwrap();
        let ratio = effect("wheel_radius_ratio", 0.01, &["wheel_radius_ratio"]);
        let kept_m = of(std::slice::from_ref(&ratio)).other_radius_m(&smaller).unwrap();
        assert!((kept_m - mean_radius_m(&config.geometry)).abs() < 1e-12);
        let scale = effect("wheel_radius_scale", 0.004, &["wheel_radius_scale"]);
        assert_eq!(of(&[ratio.clone(), scale]).other_radius_m(&smaller), None);
        let same = Change::new(&[ratio], &nominal(&config), &config, None).unwrap();
        assert_eq!(same.other_radius_m(&nominal(&config)), None);
        let other = RobotFile { counts_per_rev: 1000.0, ..nominal(&config) };
        let error = Change::new(&[], &other, &config, None).unwrap_err().to_string();
        assert!(error.contains("counts_per_rev"), "{error}");
        let other = RobotFile { uid: Some("00aa".into()), ..nominal(&config) };
        let error = Change::new(&[], &other, &config, Some("00bb")).unwrap_err().to_string();
        assert!(error.contains("uid is 00aa, this robot has 00bb"), "{error}");
        assert!(Change::new(&[], &other, &config, Some("00AA")).is_ok());
        // A campaign of before uids were recorded, and a simulated robot.
        assert!(Change::new(&[], &nominal(&config), &config, Some("00bb")).is_ok());
        assert!(Change::new(&[], &other, &config, None).is_ok());
    }
}
