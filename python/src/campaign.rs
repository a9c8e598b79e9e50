//! A campaign that was read, and what can be asked of it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use campaign::model::{EffectEntry, ModelFile, custom_from_equation, equation_error, hint_for};
use campaign::words::recording_error;
use findings::headline::{Asked, headline};
use findings::json;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use robot_model::compare::{Comparer, RunPredicted};
use robot_model::effect::{Effect, custom::Per};
use robot_model::explain::{explain_given, model};
use robot_model::recording;
use robot_model::recording::{OdometryNoise, RecordingError};
use serde_json::{Value, json};

use crate::convert::{failed, to_bytes};
use crate::model::{Model, with_values};

/// A campaign folder as it was when it was read.
#[pyclass(frozen)]
pub struct Campaign {
    read: campaign::Campaign,
    campaign: recording::Campaign,
    /// What is wrong with the data without keeping a fit from being made.
    data: Vec<Value>,
    /// Its `model.toml`.
    model: ModelFile,
}

/// An equation of the user's own, with what is said about it.
#[derive(FromPyObject)]
struct Equation {
    equation: String,
    name: Option<String>,
    per: Option<String>,
    units: BTreeMap<String, String>,
    ranges: BTreeMap<String, [f64; 2]>,
}

/// A run: name, kind, whether it is held out; times, x, y, heading measured, x, y, heading predicted, as bytes.
type RunBytes<'py> = (String, &'static str, bool, [Bound<'py, PyBytes>; 7]);

#[pymethods]
impl Campaign {
    /// Reads and judges a folder.
    #[staticmethod]
    fn read(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        py.detach(|| Self::open(&folder)).map_err(failed)
    }

    /// The robot, the runs and what is suspicious, as JSON.
    fn facts(&self) -> String {
        let robot = &self.read.robot;
        let runs = self.campaign.runs.iter().map(|run| {
            json!({
                "name": run.name,
                "started_s": run.started_s,
                "payload_kg": run.payload_kg,
                "held_out": run.held_out,
                "duration_s": run.duration_s(),
            })
        });
        let facts = json!({
            "robot": {
                "name": robot.name,
                "wheel_radius_m": robot.wheel_radius_m,
                "track_width_m": robot.track_width_m,
                "counts_per_rev": robot.counts_per_rev,
                "gear_reduction": robot.gear_reduction,
                "position_sigma_m": robot.position_sigma_m,
                "heading_sigma_rad": robot.heading_sigma_rad,
            },
            "runs": runs.collect::<Vec<_>>(),
            "warnings": self.read.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        });
        facts.to_string()
    }

    /// Times and angles of both wheels of a run, as bytes.
    fn wheels<'py>(&self, py: Python<'py>, run: usize) -> PyResult<[Bound<'py, PyBytes>; 3]> {
        let run = self.campaign.runs.get(run).ok_or_else(|| failed("there is no such run"))?;
        let wheels = || run.wheels.iter();
        Ok([
            PyBytes::new(py, &to_bytes(wheels().map(|sample| sample.t_s))),
            PyBytes::new(py, &to_bytes(wheels().map(|sample| sample.phi_rad.left))),
            PyBytes::new(py, &to_bytes(wheels().map(|sample| sample.phi_rad.right))),
        ])
    }

    /// What `beeline explain --format json` prints, the effects that its model has already, and the model that the answer predicts
    /// other runs with.
    #[pyo3(signature = (tolerance_m=None))]
    fn explain(
        &self,
        py: Python<'_>,
        tolerance_m: Option<f64>,
    ) -> PyResult<(String, String, Model)> {
        py.detach(|| {
            let catalogue = self.model.catalogue();
            let in_model: Vec<&str> = self.model.effects.iter().map(EffectEntry::id).collect();
            let mut answer =
                explain_given(&self.campaign, &catalogue, &in_model).map_err(unusable)?;
            if let Some(tolerance_m) = tolerance_m {
                answer = answer.with_tolerance(tolerance_m);
            }
            let robot = &self.read.robot;
            let asked = Asked {
                runs: self.campaign.fitted_runs().count(),
                catalogue: &catalogue,
                nominal_m: [robot.wheel_radius_m, robot.track_width_m],
            };
            let told = json::answer(&answer, &headline(&answer, &asked), &self.data);
            let known = json::steps(&answer.known).to_string();
            let model = self.model_of(self.model.found(&answer, asked.runs));
            Ok((told.to_string(), known, model))
        })
    }

    /// What `beeline compare --format json` prints; without a model, of the folder's own.
    #[pyo3(signature = (model=None))]
    fn compare(&self, py: Python<'_>, model: Option<&Model>) -> PyResult<String> {
        py.detach(|| {
            let file = model.map_or(&self.model, |model| &model.file);
            let effects = with_values(file)?;
            let own: Vec<&dyn Effect> = file.own().collect();
            let comparer = Comparer::new(&self.campaign, &own).map_err(unusable)?;
            let comparison = comparer.compare(&effects);
            let nominal = (!effects.is_empty()).then(|| comparer.compare(&[]));
            let ids: Vec<&str> = effects.iter().map(|one| one.effect.facts().id).collect();
            Ok(json::compared(&ids, &comparison, nominal.as_ref()).to_string())
        })
    }

    /// Fits these effects, and equations of the user's own: what `beeline model fit --json` prints of it, and the model.
    fn fit(
        &self,
        py: Python<'_>,
        effects: Vec<String>,
        custom: Vec<Equation>,
    ) -> PyResult<(String, Model)> {
        py.detach(|| {
            let mut file = ModelFile { customs: self.model.customs.clone(), ..ModelFile::default() };
            // In the order of `beeline model add`.
            for equation in &custom {
                equation.declare(&mut file)?;
            }
            for id in &effects {
                let hint = || failed(format_args!("no effect `{id}`; {}", hint_for(id, &file)));
                let effect = file.find(id).ok_or_else(hint)?;
                file.effects.push(EffectEntry::unfitted(effect));
            }
            let fitted = model::fit(&self.campaign, &file.chosen()).map_err(unusable)?;
            if !fitted.is_finite() {
                return Err(failed(
                    "with this model the prediction is not finite on these runs; bound its expression, with tanh, min or max",
                ));
            }
            file.take_fit(&fitted, self.campaign.fitted_runs().count());
            Ok((json::fitted(&fitted).to_string(), self.model_of(file)))
        })
    }

    /// The poses that a model predicts for each run, beside those measured; without one, the nominal robot's.
    #[pyo3(signature = (model=None))]
    fn predict<'py>(&self, py: Python<'py>, model: Option<&Model>) -> PyResult<Vec<RunBytes<'py>>> {
        let runs = py.detach(|| {
            let effects = model.map(Model::with_values).transpose()?.unwrap_or_default();
            let fit = model.and_then(|model| model.file.fit);
            let noise = fit.map_or(OdometryNoise::TYPICAL, |fit| fit.noise);
            let comparer = Comparer::with_noise(&self.campaign, noise).map_err(unusable)?;
            Ok::<_, PyErr>(comparer.predicted(&effects))
        })?;
        Ok(runs.iter().map(|run| run_bytes(py, run)).collect())
    }
}

/// A recording that cannot be used.
fn unusable(error: RecordingError) -> PyErr {
    failed(recording_error(&error))
}

impl Campaign {
    fn open(folder: &Path) -> Result<Self, campaign::CampaignError> {
        let (read, recordings) = campaign::Campaign::read_both(folder)?;
        let data = json::data_hypotheses(&read, &recordings, folder);
        let campaign = recordings.into_model(&read, folder)?;
        let model = ModelFile::read_or_empty(&ModelFile::place(folder))?;
        Ok(Self { read, campaign, data, model })
    }

    fn model_of(&self, file: ModelFile) -> Model {
        Model { file, robot: self.read.robot.name.clone() }
    }
}

impl Equation {
    /// Declares it, and puts it into a model.
    fn declare(&self, model: &mut ModelFile) -> PyResult<()> {
        let mut custom = custom_from_equation(&self.equation).map_err(failed)?;
        if let Some(name) = &self.name {
            custom.id.clone_from(name);
        }
        if let Some(per) = &self.per {
            let known = Per::ALL.into_iter().find(|known| known.name() == per);
            custom.per = known
                .ok_or_else(|| failed(format_args!("per `{per}`: use second, metre or radian")))?;
        }
        let wrong = |error| failed(equation_error(&self.equation, &error));
        let own = custom.parameters().map_err(wrong)?;
        if let Some(name) =
            self.units.keys().chain(self.ranges.keys()).find(|name| !own.contains(name))
        {
            return Err(failed(format_args!("{} has no parameter `{name}`", self.equation)));
        }
        custom.units.extend(self.units.clone());
        custom.ranges.extend(self.ranges.clone());
        let effect = model.declare(&custom).map_err(|error| wrong(*error))?;
        model.effects.push(EffectEntry::unfitted(effect));
        Ok(())
    }
}

fn run_bytes<'py>(py: Python<'py>, run: &RunPredicted) -> RunBytes<'py> {
    let measured = |of: fn(&recording::PoseMeasurement) -> Option<f64>| {
        run.measured.iter().map(move |one| of(one).unwrap_or(f64::NAN)).collect()
    };
    let predicted = |of: fn(&robot_model::kinematics::Pose) -> f64| {
        run.predicted.iter().map(of).collect::<Vec<f64>>()
    };
    let columns: [Vec<f64>; 7] = [
        measured(|one| Some(one.t_s)),
        measured(|one| Some(one.position_m?[0])),
        measured(|one| Some(one.position_m?[1])),
        measured(|one| one.heading_rad),
        predicted(|pose| pose.x_m),
        predicted(|pose| pose.y_m),
        predicted(|pose| pose.heading_rad),
    ];
    let bytes = columns.map(|column| PyBytes::new(py, &to_bytes(column)));
    (run.run.clone(), run.kind.name(), run.held_out, bytes)
}
