//! A campaign on the workbench: any model of it is fitted, compared and remembered; `explain` runs beside.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock};

use campaign::Campaign;
use campaign::lock::FolderLock;
use campaign::model::{EffectEntry, FitEntry, ModelFile, custom_from_equation, equation_error};
use robot_model::compare::{Comparer, EffectWithValues};
use robot_model::effect::{Effect, KnownEffect};
use robot_model::explain::model::{Model, ModelFitter};
use robot_model::explain::{Answer, Progress, explain_observed};
use robot_model::recording;
use serde_json::{Value, json};

use super::answer;
use super::look_ahead::LookAhead;
use super::request::ModelRequest;
use crate::error::Result;
use crate::escape::shell_path;
use crate::explain::{AnswerContext, headline, next_run_command, no_next_run, progress_line};
use crate::fit_cache::{FitCache, Question};
use crate::{json as shared, words};

/// So many models are remembered; then all are forgotten.
const REMEMBERED_MAX: usize = 400;

/// A campaign, and what the page may ask of it.
pub struct Workbench {
    folder: PathBuf,
    read: Campaign,
    campaign: recording::Campaign,
    /// The options that reach the robot for a next run.
    robot_options: String,
    fitter: ModelFitter,
    comparer: OnceLock<Comparer>,
    cache: FitCache,
    /// The model in the folder, with the equations that the user adds on the page.
    model: Mutex<ModelFile>,
    /// Effects that the robot compensated while it was recorded.
    in_use: Vec<String>,
    remembered: Mutex<HashMap<String, Arc<Value>>>,
    ahead: LookAhead,
    explanation: Mutex<Explanation>,
}

/// What `explain` has found so far.
#[derive(Default)]
struct Explanation {
    found: Vec<String>,
    answer: Option<Value>,
}

impl Workbench {
    /// A campaign that was read from this folder.
    pub fn new(
        folder: &Path,
        (read, campaign): (Campaign, recording::Campaign),
        robot_options: String,
        cache: FitCache,
    ) -> Result<Self> {
        let model = ModelFile::read_or_empty(&ModelFile::place(folder))?;
        let in_use = model.in_use().iter().map(|entry| entry.id().to_owned()).collect();
        let fitter = ModelFitter::new(&campaign)?;
        Ok(Self {
            folder: folder.to_owned(),
            read,
            campaign,
            robot_options,
            fitter,
            comparer: OnceLock::new(),
            cache,
            model: Mutex::new(model),
            in_use,
            remembered: Mutex::default(),
            ahead: LookAhead::default(),
            explanation: Mutex::default(),
        })
    }

    /// What holds whatever the model.
    pub fn campaign(&self) -> Value {
        let model = self.model().clone();
        let in_use: Vec<&str> = self.in_use.iter().map(String::as_str).collect();
        let folder = self.folder.to_string_lossy();
        let paths = self.comparer().paths(&[]);
        answer::campaign(&self.read.robot.name, &folder, (&model, &in_use), &paths)
    }

    /// A model, and what it leaves; the error is for the page to show.
    pub fn model_answer(&self, request: &ModelRequest) -> std::result::Result<Arc<Value>, String> {
        let waiting = self.ahead.wait();
        let answer = self.known_or_computed(request);
        drop(waiting);
        if answer.is_ok() && !request.quick {
            self.ahead.note(request);
        }
        answer
    }

    /// Computes what may be asked for next while nobody waits, on one core. Does not return.
    pub fn look_ahead(&self) {
        let Ok(one_core) = rayon::ThreadPoolBuilder::new().num_threads(1).build() else { return };
        let compute = |request: &ModelRequest| {
            // Whoever asks for it is told what is wrong with it.
            let _ = one_core.install(|| self.known_or_computed(request));
        };
        self.ahead.run(|| self.likely(), || self.ids(), compute);
    }

    /// All effects, those that `explain` has found first.
    fn likely(&self) -> Vec<String> {
        let explanation = locked(&self.explanation);
        let steps = explanation.answer.as_ref().and_then(|answer| answer["steps"].as_array());
        let found = steps.into_iter().flatten().filter_map(|step| step["effect"].as_str());
        let mut ids: Vec<String> = found.map(str::to_owned).collect();
        let others = self.ids().into_iter().filter(|id| !ids.contains(id));
        let others: Vec<String> = others.collect();
        ids.extend(others);
        ids
    }

    /// All effects, in the order of the catalogue.
    fn ids(&self) -> Vec<String> {
        let model = self.model();
        model.catalogue().iter().map(|effect| effect.facts().id.to_owned()).collect()
    }

    /// The values alone, and what they leave of these runs: for a page to show until the rest is there.
    fn quick(&self, effects: &[KnownEffect]) -> Value {
        let chosen: Vec<&dyn Effect> = effects.iter().map(|effect| &**effect).collect();
        let values = self.fitter.values(&chosen, *self.comparer().noise());
        let values: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
        let mut value = self.by_hand(effects, &values);
        value["by_hand"] = json!(false);
        value["quick"] = json!(true);
        value
    }

    fn known_or_computed(&self, request: &ModelRequest) -> std::result::Result<Arc<Value>, String> {
        let effects = request.known(&self.model())?;
        let key = request.key();
        if let Some(known) = locked(&self.remembered).get(&key) {
            return Ok(Arc::clone(known));
        }
        if request.quick && request.values().is_none() {
            return Ok(Arc::new(self.quick(&effects)));
        }
        let value = Arc::new(match request.values() {
            Some(values) => self.by_hand(&effects, &values),
            None => self.fitted(&effects)?,
        });
        let mut remembered = locked(&self.remembered);
        if remembered.len() >= REMEMBERED_MAX {
            remembered.clear();
        }
        remembered.insert(key, Arc::clone(&value));
        Ok(value)
    }

    fn fitted(&self, effects: &[KnownEffect]) -> std::result::Result<Value, String> {
        let model = self.fit(effects)?;
        let values = model.effects.iter().map(|effect| {
            effect.parameters.iter().map(|parameter| parameter.value).collect::<Vec<f64>>()
        });
        let terms = with_values(effects, values);
        let comparer = self.comparer();
        Ok(answer::fitted(&model, &comparer.paths(&terms), &comparer.curves(&terms)))
    }

    fn fit(&self, effects: &[KnownEffect]) -> std::result::Result<Model, String> {
        let chosen: Vec<&dyn Effect> = effects.iter().map(|effect| &**effect).collect();
        let model = self.fitter.fit(&chosen);
        if model.is_finite() {
            return Ok(model);
        }
        let names: Vec<&str> = chosen.iter().map(|effect| effect.facts().id).collect();
        Err(format!("with {} the prediction is not finite on these runs", names.join(", ")))
    }

    fn by_hand(&self, effects: &[KnownEffect], values: &[&[f64]]) -> Value {
        let terms = with_values(effects, values.iter().map(|values| values.to_vec()));
        let comparer = self.comparer();
        let effect = |(effect, values): (&KnownEffect, &&[f64])| {
            let facts = effect.facts();
            let parameters = facts.parameters.iter().zip(*values).map(
                |(known, value)| json!({"name": known.name, "unit": known.unit, "value": value}),
            );
            json!({"id": facts.id, "parameters": parameters.collect::<Vec<_>>()})
        };
        let effects = effects.iter().zip(values).map(effect).collect();
        answer::by_hand(effects, &comparer.paths(&terms), &comparer.curves(&terms))
    }

    /// An equation of the user's own as a further effect; the error points into it.
    pub fn add_equation(&self, equation: &str) -> std::result::Result<Value, Value> {
        let told =
            |error: campaign::CampaignError| json!({"error": error.problem, "hint": error.hint});
        let custom = custom_from_equation(equation).map_err(told)?;
        let mut model = self.model();
        let same = |own: &Arc<_>| {
            let own: &robot_model::effect::CustomEffect = own;
            own.facts().equation == custom.equation()
        };
        if let Some(own) = model.customs.iter().find(|own| same(own)) {
            return Ok(answer::facts(&own.facts()));
        }
        let effect =
            model.declare(&custom).map_err(|error| told(equation_error(equation, &error)))?;
        let facts = answer::facts(&effect.facts());
        Ok(facts)
    }

    /// Checks an equation without adding it.
    pub fn check_equation(equation: &str) -> std::result::Result<Value, Value> {
        let told =
            |error: campaign::CampaignError| json!({"error": error.problem, "hint": error.hint});
        let custom = custom_from_equation(equation).map_err(told)?;
        let built = custom.build().map_err(|error| told(equation_error(equation, &error)))?;
        Ok(answer::facts(&built.facts()))
    }

    /// Writes these effects, fitted, as the campaign's `model.toml`, in place of what it holds.
    pub fn save(&self, request: &ModelRequest) -> std::result::Result<Value, String> {
        if request.values().is_some() {
            return Err("values set by hand are not saved: fit them first".to_owned());
        }
        let effects = request.known(&self.model())?;
        let model = self.fit(&effects)?;
        let file = ModelFile::place(&self.folder);
        let _lock = FolderLock::take(&self.folder).map_err(|error| error.to_string())?;
        let entry = |(effect, fitted): (KnownEffect, &robot_model::explain::model::ModelEffect)| {
            EffectEntry { parameters: fitted.parameters.clone(), ..EffectEntry::unfitted(effect) }
        };
        let saved = ModelFile {
            customs: self.model().customs.clone(),
            effects: effects.into_iter().zip(&model.effects).map(entry).collect(),
            fit: Some(FitEntry {
                runs: self.campaign.fitted_runs().count(),
                nominal: model.nominal,
                errors: model.errors,
                noise: model.noise,
            }),
        };
        saved.write(&file, &self.read.robot.name).map_err(|error| error.to_string())?;
        *self.model() = saved;
        Ok(json!({"file": file, "next": format!("beeline compare {}", shell_path(&self.folder))}))
    }

    /// What `explain` has found: the lines so far, and its answer once it is done.
    pub fn explanation(&self) -> Value {
        let explanation = locked(&self.explanation);
        json!({"found": explanation.found, "answer": explanation.answer})
    }

    /// Explains the campaign from the robot as it was recorded. Takes seconds; the lines appear as they are found.
    pub fn explain(&self) {
        // The first model asked for need not wait for it.
        self.comparer();
        let model = self.model().clone();
        let catalogue = model.catalogue();
        let in_use: Vec<&str> = self.in_use.iter().map(String::as_str).collect();
        let mut observer = |progress: Progress<'_>| {
            let line = progress_line(&progress, &catalogue);
            locked(&self.explanation).found.push(line);
        };
        let question =
            Question { campaign: &self.campaign, catalogue: &catalogue, in_model: &in_use };
        let answer = self.cache.answer(&question, || {
            explain_observed(&self.campaign, &catalogue, &in_use, Some(&mut observer))
        });
        let value = match answer {
            Ok(answer) => self.told(&answer, &catalogue),
            Err(error) => json!({"error": error.to_string()}),
        };
        locked(&self.explanation).answer = Some(value);
    }

    /// An answer of `explain` with what the page says about it.
    fn told(&self, answer: &Answer, catalogue: &[&dyn Effect]) -> Value {
        let robot = &self.read.robot;
        let context = AnswerContext {
            robot: &robot.name,
            campaign: self.folder.to_string_lossy().into_owned(),
            robot_options: self.robot_options.clone(),
            runs: self.campaign.fitted_runs().map(|run| run.name.clone()).collect(),
            motions: self.campaign.motions(),
            catalogue,
            in_model: &[],
            combinations: Vec::new(),
            nominal_m: [robot.wheel_radius_m, robot.track_width_m],
        };
        let mut value = shared::answer(answer, &headline(answer, &context), &[]);
        value["next"] = match &answer.next_run {
            Some(next) => json!({
                "words": format!(
                    "Record {}: it tells {} apart ({}).",
                    next.kind.name(), words::listed(&next.separates), words::predicted(&next.predicted)
                ),
                "command": next_run_command(next, &context),
            }),
            None => {
                let (words, command) = no_next_run(answer, &context);
                json!({"words": words, "command": command})
            }
        };
        value
    }

    fn comparer(&self) -> &Comparer {
        self.comparer.get_or_init(|| {
            let model = self.model().clone();
            self.cache
                .comparer(&self.campaign, &model)
                .expect("the fitter has prepared the same campaign already")
        })
    }

    fn model(&self) -> MutexGuard<'_, ModelFile> {
        locked(&self.model)
    }
}

/// A lock whose holder panicked guards whole values all the same: each is replaced in one step.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

fn with_values(
    effects: &[KnownEffect],
    values: impl Iterator<Item = Vec<f64>>,
) -> Vec<EffectWithValues<'_>> {
    let term = |(effect, values): (_, Vec<f64>)| {
        let effect: &KnownEffect = effect;
        EffectWithValues { effect: &**effect, values, up_to_mps: None }
    };
    effects.iter().zip(values).map(term).collect()
}
