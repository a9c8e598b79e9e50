//! A configuration as bytes: one list of values.
//!
//! Serde's derived code handles each part of the structure separately. Formats for people need that, but on
//! a board the code takes three kilobytes. A format without names gets one list of values in the same order
//! instead: the same bytes, as the golden bytes show.

use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::config::{Config, NUMBERS};
use crate::name::Name;

/// How many flags a configuration has.
const FLAGS: usize = 6;

/// Name, numbers, flags, the driver's name and what it does at a fault.
const VALUES: usize = 1 + NUMBERS + FLAGS + 2;

/// How many flags follow this number.
const fn flags_behind(number: usize) -> usize {
    match number {
        // The left encoder's.
        5 => 1,
        // The right encoder's, and both motors'.
        7 => 3,
        // The driver's enable and fault lines'.
        35 => 2,
        _ => 0,
    }
}

impl Config {
    fn flags(&self) -> [&bool; FLAGS] {
        let Self { encoder, motor, driver, .. } = self;
        [
            &encoder.left.reversed,
            &encoder.right.reversed,
            &motor.left.reversed,
            &motor.right.reversed,
            &driver.enable_inverted,
            &driver.fault_inverted,
        ]
    }

    fn flags_mut(&mut self) -> [&mut bool; FLAGS] {
        let Self { encoder, motor, driver, .. } = self;
        [
            &mut encoder.left.reversed,
            &mut encoder.right.reversed,
            &mut motor.left.reversed,
            &mut motor.right.reversed,
            &mut driver.enable_inverted,
            &mut driver.fault_inverted,
        ]
    }
}

/// Compares bit for bit, as a configuration is stored and read back.
impl PartialEq for Config {
    fn eq(&self, other: &Self) -> bool {
        let bits = |config: &Self| config.numbers().map(|number| number.to_bits());
        self.name == other.name
            && bits(self) == bits(other)
            && self.flags() == other.flags()
            && (self.driver.name, self.driver.at_fault)
                == (other.driver.name, other.driver.at_fault)
    }
}

impl Serialize for Config {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if serializer.is_human_readable() {
            return Config::serialize(self, serializer);
        }
        let mut values = serializer.serialize_tuple(VALUES)?;
        values.serialize_element(&self.name)?;
        let mut flags = self.flags().into_iter();
        for (number, value) in self.numbers().into_iter().enumerate() {
            values.serialize_element(value)?;
            for flag in flags.by_ref().take(flags_behind(number)) {
                values.serialize_element(flag)?;
            }
        }
        values.serialize_element(&self.driver.name)?;
        values.serialize_element(&self.driver.at_fault)?;
        values.end()
    }
}

impl<'de> Deserialize<'de> for Config {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            Config::deserialize(deserializer)
        } else {
            deserializer.deserialize_tuple(VALUES, Values)
        }
    }
}

/// Reads the list.
struct Values;

impl<'de> Visitor<'de> for Values {
    type Value = Config;

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("a configuration")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<Config, A::Error> {
        let mut config = Config { name: next::<Name, A>(&mut values)?, ..Config::default() };
        let mut flags = [false; FLAGS];
        let mut places = flags.iter_mut();
        for (number, place) in config.numbers_mut().into_iter().enumerate() {
            *place = next(&mut values)?;
            for flag in places.by_ref().take(flags_behind(number)) {
                *flag = next(&mut values)?;
            }
        }
        for (place, flag) in config.flags_mut().into_iter().zip(flags) {
            *place = flag;
        }
        config.driver.name = next(&mut values)?;
        config.driver.at_fault = next(&mut values)?;
        Ok(config)
    }
}

fn next<'de, T: Deserialize<'de>, A: SeqAccess<'de>>(values: &mut A) -> Result<T, A::Error> {
    values.next_element()?.ok_or_else(|| A::Error::custom("a value is missing"))
}

impl Config {
    /// The configuration of these bytes, as in a message; compiled here, for size.
    #[inline(never)]
    pub fn from_postcard(bytes: &[u8]) -> Option<Self> {
        postcard::from_bytes(bytes).ok()
    }

    /// Its bytes as in a message; returns how many.
    #[inline(never)]
    pub fn to_postcard(&self, room: &mut [u8]) -> Option<usize> {
        postcard::to_slice(self, room).ok().map(|bytes| bytes.len())
    }
}
