//! What `explain` answers, in the shape of its JSON (schema 1).

use serde::Serialize;

use crate::estimation::errors::{ErrorPair, Errors};
use crate::residuals::unexplained::Unexplained;

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
    pub held_out: Option<HeldOut>,
}

/// Errors on runs that were kept aside: nothing was fitted to them, and nothing chosen by them.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// How many runs.
    pub runs: usize,
    /// Their kinds, each once, in the order of the campaign.
    pub kinds: Vec<String>,
    /// Of the nominal robot; with the known effects, where there are any.
    pub baseline: Errors,
    /// Of the model, fitted to all other runs.
    pub model: Errors,
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
    #[serde(rename = "heldout")]
    pub cross_validated: Errors,
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
    #[serde(rename = "heldout")]
    pub cross_validated: Errors,
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

/// A probability with its name: `p = 0.03`, `p < 1e-99`.
pub(crate) fn p_text(p: f64) -> String {
    match p {
        p if p >= 0.01 => format!("p = {p:.2}"),
        p if p >= 0.001 => format!("p = {p:.3}"),
        p if p > 1e-99 => format!("p = {p:.0e}"),
        _ => "p < 1e-99".to_owned(),
    }
}
