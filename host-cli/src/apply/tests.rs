//! What goes into a configuration, and what does not.

use findings::empty_answer::{nothing_found, step_of};
use robot_model::explain::Averaged;

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
    let (effect, parameters) = (id.into(), vec![parameter]);
    Estimate { effect, class, parameters, unconfirmed: None, used_to_predict: true }
}

#[test]
fn what_may_be_something_else_is_not_written() {
    let pull = effect("heading_pull", 0.008, &["heading_pull"]);
    assert_eq!(remedy(&pull), Remedy::Compensated);
    assert_eq!(remedy(&Estimate { used_to_predict: false, ..pull }), Remedy::Small);
}

#[test]
fn values_are_those_that_predict_other_runs() {
    let of = |id: &str, value: f64| effect(id, value, &[id]).parameters;
    let step = |id: &str| StepFound { parameters: of(id, 0.011), ..step_of(&[id]) };
    let predicts = Averaged {
        effect: "track_width".to_owned(),
        parameters: of("track_width", 0.007),
        up_to_mps: None,
    };
    // Gear backlash, which predicts nothing, had bent the track width.
    let mut backlash = step("backlash");
    backlash.used_to_predict = false;
    let steps = vec![step("track_width"), backlash];
    let answer = Answer { steps, predicts_with: vec![predicts], ..nothing_found() };
    let found: Vec<f64> = estimates(&answer).iter().map(|one| one.parameters[0].value).collect();
    assert_eq!(found, [0.007, 0.011]);
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
    let [in_use, sure] = once.odometry;
    assert_eq!(in_use, config.odometry);
    assert!((sure.wheel_weight_sd - 1e-4 / (1.004 * 1.004)).abs() < 1e-12);
    assert!((sure.track_width_sd_m - 0.372e-4).abs() < 1e-12);
    assert_eq!(sure.noise_m_per_sqrt_m, in_use.noise_m_per_sqrt_m);
    config.geometry = g;
    assert!(Change::new(&effects, &nominal, &config, None).unwrap().changes(), "surer");
    config.odometry = sure;
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
    let change = Change::new(&effects, &nominal, &config, None).unwrap();
    let (g, [now, new]) = (change.after, change.odometry);
    assert_eq!(new.wheel_weight_sd, now.wheel_weight_sd);
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
