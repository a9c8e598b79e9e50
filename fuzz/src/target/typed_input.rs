//! What a person types, and the file with a robot's configuration.

use std::path::Path;
use std::str::FromStr;

use host_cli::config_text::{self, flatten};
use host_cli::port::Port;
use host_cli::quantity::{
    Acceleration, Angle, Distance, Length, Speed, Time, TurnRate, join_units,
};
use host_link::address::Address;
use host_link::listen::Listen;
use shared_proto::Config;

use crate::bytes::text;
use crate::target::frames::in_its_ranges;

/// `field=value`.
pub fn config_set(input: &[u8]) {
    let Some((field, value)) = text(input).and_then(|text| text.split_once('=')) else { return };
    let before = Config::default();
    let Ok(after) = config_text::set(&before, field, value) else { return };
    assert!(after.validate().is_ok(), "{after:?}");
    in_its_ranges(&after);
    let (before, flat) = (flatten(&before).unwrap(), flatten(&after).unwrap());
    for ((name, old), (_, new)) in before.iter().zip(&flat) {
        assert!(name == field || old == new, "{field} changed {name}");
        let shown = new.as_str().map_or_else(|| new.to_string(), str::to_owned);
        let again = config_text::set(&after, name, &shown).unwrap_or_else(|e| panic!("{name} {e}"));
        assert_eq!(again, after);
    }
}

/// What `beeline config export` writes.
pub fn config_file(input: &[u8]) {
    let Some(text) = text(input) else { return };
    let file = Path::new("robot.toml");
    let Ok(config) = config_text::parse(file, text) else { return };
    assert!(config.validate().is_ok());
    in_its_ranges(&config);
    let written = toml::to_string(&config).expect("what was read can be written");
    let again = config_text::parse(file, &written).unwrap_or_else(|e| panic!("{e}\n{written}"));
    assert_eq!(config, again);
}

/// A word of the command line, as each type that it may be.
pub fn quantity(input: &[u8]) {
    let Some(text) = text(input) else { return };
    finite::<Length>(text, |length| length.m);
    finite::<Angle>(text, |angle| angle.rad);
    finite::<TurnRate>(text, |rate| rate.rad_s);
    finite::<Time>(text, |time| time.s);
    finite::<Distance>(text, |distance| distance.m(0.036));
    finite::<Speed>(text, |speed| speed.mps(0.036));
    finite::<Acceleration>(text, |acceleration| acceleration.mps2(0.036));
    assert!(join_units(text).iter().all(|part| !part.is_empty()));
    if let Ok(port) = Port::from_str(text) {
        assert_eq!(Port::from_str(&port.to_string()).as_ref(), Ok(&port));
    }
    if let Ok(address) = Address::from_str(text) {
        assert_eq!(Address::from_str(&address.to_string()).as_ref(), Ok(&address));
    }
    let _ = Listen::from_str(text);
}

fn finite<T: FromStr>(text: &str, value: impl Fn(T) -> f64)
where
    T::Err: std::fmt::Display,
{
    match text.parse::<T>() {
        Ok(quantity) => assert!(value(quantity).is_finite(), "{text}"),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}
