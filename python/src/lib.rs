//! The part of the Python package `beeline` that computes: see `beeline/_beeline.pyi` for what it offers.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `campaign.rs` | a campaign that was read, and what can be asked of it |
//! | `convert.rs` | errors and arrays as Python sees them |
//! | `fleet.rs` | many robots |
//! | `model.rs` | effects with values |
//! | `write.rs` | campaigns of arrays and of logs |
//!
//! What is found goes to Python as the JSON that the command prints, so the numbers are the same; tracks go as bytes.
//! Python's classes are made of both in `beeline/`. Whatever takes time runs without the interpreter's lock.

#![allow(missing_docs, reason = "what Python sees is documented in `_beeline.pyi`")]

mod campaign;
mod convert;
mod fleet;
mod model;
mod write;

use pyo3::prelude::*;

use convert::BeelineError;

#[pymodule]
fn _beeline(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("BeelineError", module.py().get_type::<BeelineError>())?;
    module.add_class::<campaign::Campaign>()?;
    module.add_class::<model::Model>()?;
    module.add_function(wrap_pyfunction!(fleet::common_effects, module)?)?;
    module.add_function(wrap_pyfunction!(fleet::judge, module)?)?;
    module.add_function(wrap_pyfunction!(write::write_arrays, module)?)?;
    module.add_function(wrap_pyfunction!(write::write_logs, module)?)
}
