//! Effects with values.

use std::path::{Path, PathBuf};

use campaign::model::ModelFile;
use pyo3::prelude::*;
use robot_model::compare::EffectWithValues;

use crate::convert::failed;

/// A model as in `model.toml`.
#[pyclass(frozen, module = "beeline._beeline")]
pub struct Model {
    pub file: ModelFile,
    /// The name of the robot that it was fitted to.
    pub robot: String,
}

#[pymethods]
impl Model {
    /// Reads a `model.toml`.
    #[staticmethod]
    fn read(file: PathBuf) -> PyResult<Self> {
        let model = ModelFile::read(&file).map_err(failed)?;
        Ok(Self { file: model, robot: "unnamed robot".to_owned() })
    }

    /// Writes it as a `model.toml`.
    fn write(&self, file: PathBuf) -> PyResult<()> {
        self.file.write(&file, &self.robot).map_err(failed)
    }

    /// Of the text of a `model.toml`.
    #[staticmethod]
    fn of_text(text: &str, robot: String) -> PyResult<Self> {
        let file = ModelFile::parse(Path::new("model.toml"), text).map_err(failed)?;
        Ok(Self { file, robot })
    }

    /// For `pickle`: other processes get its text.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String))> {
        let of_text = py.get_type::<Self>().getattr("of_text")?;
        Ok((of_text, (self.file.to_text(&self.robot), self.robot.clone())))
    }

    /// The ids of its effects.
    fn effects(&self) -> Vec<String> {
        self.file.effects.iter().map(|entry| entry.id().to_owned()).collect()
    }
}

impl Model {
    /// Its effects; an error if one has no values.
    pub fn with_values(&self) -> PyResult<Vec<EffectWithValues<'_>>> {
        with_values(&self.file)
    }
}

/// The effects of a model; an error if one has no values.
pub fn with_values(model: &ModelFile) -> PyResult<Vec<EffectWithValues<'_>>> {
    model
        .effects_with_values()
        .map_err(|id| failed(format_args!("{id} has no values yet; fit it first")))
}
