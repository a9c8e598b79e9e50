//! A configuration outside the permitted ranges is refused by the name of the field.

use std::collections::BTreeSet;

use serde_json::Value;
use shared_proto::{Config, ConfigError};

/// The paths of all numbers below a value.
fn numbers(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Number(_) => {
            found.insert(path.to_string());
        }
        Value::Object(fields) => {
            for (name, value) in fields {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                numbers(value, &path, found);
            }
        }
        Value::Array(_) => panic!("{path}: a list in the configuration; extend this walk"),
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

fn to_json(config: &Config) -> Value {
    serde_json::to_value(config).expect("a configuration is JSON")
}

/// The factory configuration with one number changed.
///
/// JSON has no NaN, so the number travels as a mark that is then replaced in the struct's own bytes:
/// postcard writes an f64 as its eight bytes.
fn with(path: &str, value: f64) -> Config {
    const MARK: f64 = 12345.678901234567;
    let mut json = to_json(&Config::default());
    let slot = json.pointer_mut(&format!("/{}", path.replace('.', "/"))).expect("a field");
    *slot = MARK.into();
    let marked: Config = serde_json::from_value(json).expect("a configuration");
    let mut buffer = [0; 512];
    let bytes = postcard::to_slice(&marked, &mut buffer).expect("room");
    let at: Vec<usize> = bytes
        .windows(8)
        .enumerate()
        .filter(|(_, window)| *window == MARK.to_le_bytes())
        .map(|(at, _)| at)
        .collect();
    assert_eq!(at.len(), 1, "{path} stands once in the bytes");
    bytes[at[0]..at[0] + 8].copy_from_slice(&value.to_le_bytes());
    postcard::from_bytes(bytes).expect("a configuration")
}

/// The next number up, or down.
fn beside(value: f64, up: bool) -> f64 {
    if up { value.next_up() } else { value.next_down() }
}

#[test]
fn the_factory_configuration_is_valid() {
    assert_eq!(Config::default().validate(), Ok(()));
}

#[test]
fn the_sample_configuration_is_valid() {
    assert_eq!(crate::samples::config().validate(), Ok(()));
}

#[test]
fn every_number_of_the_configuration_has_a_range() {
    let mut found = BTreeSet::new();
    numbers(&to_json(&Config::default()), "", &mut found);
    let ranged: BTreeSet<String> = Config::FIELDS.iter().map(|f| f.path.to_string()).collect();
    assert_eq!(ranged.len(), Config::FIELDS.len(), "a path stands twice");
    assert_eq!(found, ranged);
}

#[test]
fn each_field_reads_the_number_that_it_names() {
    for field in Config::FIELDS {
        assert_eq!((field.read)(&with(field.path, 0.12345)), 0.12345, "{}", field.path);
    }
}

#[test]
fn both_ends_of_a_range_are_permitted() {
    for (number, field) in Config::FIELDS.iter().enumerate() {
        assert!(field.min < field.max, "{}", field.path);
        for value in [field.min, field.max] {
            match with(field.path, value).validate() {
                // Radius, counts and gear also bound each other, through the distance per count.
                Ok(()) | Err(ConfigError::DistancePerCount { .. }) => {}
                Err(error) => panic!("{number}: {} = {value}: {error}", field.path),
            }
        }
    }
}

#[test]
fn everything_outside_a_range_is_refused_by_name() {
    for (number, field) in Config::FIELDS.iter().enumerate() {
        let below = beside(field.min, false);
        let above = beside(field.max, true);
        for value in [below, above, -1e300, 1e300, f64::NEG_INFINITY, f64::INFINITY, f64::NAN] {
            let error = with(field.path, value).validate().expect_err(field.path);
            let ConfigError::OutOfRange { field: refused, value: given } = error else {
                panic!("{} = {value}: {error}", field.path);
            };
            assert_eq!(refused as usize, number, "{} = {value}", field.path);
            assert_eq!(given.to_bits(), value.to_bits());
            let text = error.to_string();
            for part in [field.path, field.unit, &field.min.to_string(), &field.max.to_string()] {
                assert!(text.contains(part), "{text:?} should contain {part:?}");
            }
        }
    }
}

#[test]
fn the_default_limits_leave_room_inside_every_range() {
    let config = Config::default();
    for field in Config::FIELDS {
        let value = (field.read)(&config);
        assert!((field.min..=field.max).contains(&value), "{} = {value}", field.path);
    }
}

#[test]
fn a_distance_per_count_that_no_encoder_has_is_refused_for_its_wheel() {
    // 2 pi 0.005 m / (10^6 * 1000): 31 pm.
    let mut fine = with("geometry.wheel_radius_m", 0.005);
    fine.encoder.right.counts_per_rev = 1e6;
    fine.encoder.right.gear_reduction = 1000.0;
    // 2 pi 1 m / (1 * 1): 6.3 m.
    let mut coarse = with("geometry.wheel_radius_m", 1.0);
    coarse.encoder.left.counts_per_rev = 1.0;
    for (config, wheel) in [(fine, "right"), (coarse, "left")] {
        let error = config.validate().unwrap_err();
        assert!(matches!(error, ConfigError::DistancePerCount { .. }), "{error}");
        assert!(error.to_string().contains(&format!("the {wheel} wheel")), "{error}");
    }
}

#[test]
fn meters_per_count_is_the_wheels_circumference_over_its_counts() {
    let mut config = Config::default();
    config.encoder.right.gear_reduction = 2.0;
    // The paper's robot, Q = 2 pi 0.036 m / 900 = 0.2513 mm.
    let left = config.meters_per_count(&config.encoder.left);
    let right = config.meters_per_count(&config.encoder.right);
    assert!((left - 0.000_251_327_412).abs() < 1e-12, "{left}");
    assert_eq!(right, left / 2.0);
}
