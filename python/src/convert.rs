//! Errors and arrays as Python sees them.

use pyo3::exceptions::PyException;
use pyo3::{PyErr, create_exception};

create_exception!(_beeline, BeelineError, PyException, "What is wrong, where, and what to try.");

/// An error of ours as Python sees it.
pub fn failed(error: impl std::fmt::Display) -> PyErr {
    BeelineError::new_err(error.to_string())
}

/// `f64`s as bytes, as `numpy.frombuffer` takes them.
pub fn to_bytes(numbers: impl IntoIterator<Item = f64>) -> Vec<u8> {
    numbers.into_iter().flat_map(f64::to_ne_bytes).collect()
}

/// `f64`s of bytes, as `numpy.ndarray.tobytes` gives them.
pub fn of_bytes(bytes: &[u8]) -> Vec<f64> {
    bytes.as_chunks().0.iter().map(|chunk| f64::from_ne_bytes(*chunk)).collect()
}
