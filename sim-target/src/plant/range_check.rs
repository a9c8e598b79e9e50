//! Refusing values that no robot has.

use core::fmt;

use shared_proto::Readable;

/// A parameter outside its range.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterError {
    /// Path of the field in [`PlantParameters`], `motor.left.resistance_ohm`.
    pub field: String,
    /// Its value.
    pub value: f64,
    /// What it must be instead.
    pub expected: String,
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}: must be {}", self.field, Readable(self.value), self.expected)
    }
}

impl core::error::Error for ParameterError {}

/// Checks the fields below a prefix, such as `motor.left.`.
pub(crate) struct RangeCheck<'a>(pub &'a str);

impl RangeCheck<'_> {
    /// Refuses a value outside a range, both ends included, and one that is not a number.
    pub fn within(
        &self,
        field: &str,
        value: f64,
        min: f64,
        max: f64,
    ) -> Result<(), ParameterError> {
        if value >= min && value <= max {
            return Ok(());
        }
        let expected = format!("from {min} to {max}");
        Err(ParameterError { field: format!("{}{field}", self.0), value, expected })
    }
}
