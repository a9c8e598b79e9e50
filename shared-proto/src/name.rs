//! Names of robots and boards.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Longest [`Name`] in bytes.
pub const NAME_LEN_MAX: usize = 24;

/// The name of a robot or a board: at most [`NAME_LEN_MAX`] bytes of UTF-8.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[serde(transparent)]
pub struct Name(heapless::String<NAME_LEN_MAX>);

impl Name {
    /// The name, or `None` if it is longer than [`NAME_LEN_MAX`] bytes.
    pub fn new(name: &str) -> Option<Self> {
        name.try_into().ok().map(Self)
    }

    /// The name as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl core::fmt::Display for Name {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Name {
    fn format(&self, f: defmt::Formatter) {
        defmt::write!(f, "{}", self.as_str());
    }
}
