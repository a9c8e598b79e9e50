//! What `explain` answers, in the shape of its JSON (schema 1).

use serde::Serialize;

pub use crate::structure::{PlaceSeen, Unexplained};

/// The whole answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// Version of this shape.
    pub schema: u32,
    /// Effects that the user's model has already and these runs bear out; not part of the JSON.
    #[serde(skip)]
    pub known: Vec<StepFound>,
    /// The nominal robot; with the known effects, where there are any.
    pub baseline: ErrorPair,
    /// Effects found, in order of evidence; each with the errors once it and those before it are in.
    pub steps: Vec<StepFound>,
    /// Effects looked at and not believed.
    pub rejected: Vec<Rejected>,
    /// What is left over.
    pub unexplained: Unexplained,
    /// The cheapest run that would tell more.
    pub next_run: Option<NextRun>,
    /// What it comes to on the runs kept aside, if there are any; no part of the JSON.
    #[serde(skip)]
    pub aside: Option<Aside>,
}

/// Errors on runs that were kept aside: nothing was fitted to them, and nothing chosen by them.
#[derive(Clone, Debug, PartialEq)]
pub struct Aside {
    /// How many runs.
    pub runs: usize,
    /// Their kinds, each once, in the order of the campaign.
    pub kinds: Vec<String>,
    /// Of the nominal robot; with the known effects, where there are any.
    pub baseline: Errors,
    /// Of the model, fitted to all other runs.
    pub model: Errors,
}

/// Errors on the runs fitted to, and on runs held out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorPair {
    /// Fitted to all runs.
    pub train: Errors,
    /// Each run predicted by a fit to all others.
    pub heldout: Errors,
}

/// How far predicted and measured tracks lie apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Root of the mean squared distance, from the best start \[m\].
    pub position_rms_m: f64,
    /// Root of the mean squared heading error \[rad\].
    pub heading_rms_rad: f64,
    /// Root of the mean squared whitened residual; 1 is noise.
    pub chi: f64,
}

/// One effect found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepFound {
    /// Its id.
    pub effect: String,
    /// All that this campaign cannot tell from it, itself included.
    pub class: Vec<String>,
    /// Its parameters, fitted with those of all steps.
    pub parameters: Vec<ParameterFound>,
    /// Errors on the runs fitted to.
    pub train: Errors,
    /// Errors on runs held out.
    pub heldout: Errors,
    /// By chance at least as much gain, given all other effects.
    pub p_value: f64,
    /// Why it is believed.
    pub why: String,
}

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterFound {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Best value.
    pub value: f64,
    /// Standard error.
    pub sigma: f64,
    /// Lower end of the 95 % interval.
    pub low95: f64,
    /// Upper end of the 95 % interval.
    pub high95: f64,
}

/// One effect not believed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rejected {
    /// Its id.
    pub effect: String,
    /// Why not.
    pub reason: String,
    /// Errors on runs held out, were it added.
    pub heldout: Errors,
}

/// A run worth making.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NextRun {
    /// What to drive.
    pub kind: String,
    /// The effects that it tells apart.
    pub separates: Vec<String>,
    /// What it would show.
    pub why: String,
}
