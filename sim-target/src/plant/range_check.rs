//! Range checks of parameters.

use core::fmt;

use shared_proto::Readable;

/// A parameter outside its range.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterError {
    /// Path of the field in [`PlantParameters`](super::PlantParameters), `motor.left.resistance_ohm`.
    pub field: String,
    /// Its value.
    pub value: f64,
    /// The permitted values.
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
    /// Refuses NaN, and a value outside a range; both ends are permitted.
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
