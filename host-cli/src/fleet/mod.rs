//! Many campaigns: of many robots, or of one robot on many dates.
//!
//! Each is explained; then all of a kind are fitted with the same effects, so that their values can be compared. What the values
//! say is judged in `robot_model::fleet`.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `places.rs` | which campaigns there are, and when each was driven |
//! | `words.rs` | what is found, in sentences |
//! | `page.rs`, `drawing.rs` | the page: values over time |
//! | `table.rs` | every value in a row of its own, for programs |

mod drawing;
mod page;
mod places;
mod table;
mod words;

use std::path::{Path, PathBuf};

use campaign::model::ModelFile;
use campaign::words::recording_error;
use campaign::{Campaign, CampaignError, RobotFile};
use findings::headline::{Asked, headline};
use robot_model::effect::{Effect, Role};
use robot_model::estimation::ErrorPair;
use robot_model::explain::model::{Model, ModelFitter};
use robot_model::explain::{ParameterFound, explain_given};
use robot_model::fleet::{Found, Judgement, Measured, common_effects, judge};
use robot_model::recording;

pub use page::page;
pub use places::{Dated, campaigns};
pub use table::{csv, json};
pub use words::{Finding, findings_of, nothing_found};

/// All campaigns, judged.
pub struct Fleet<'a> {
    /// Robots of the same data sheet, the most campaigns first.
    pub kinds: Vec<Kind<'a>>,
    /// Folders that could not be used, and why.
    pub left_out: Vec<(PathBuf, String)>,
}

/// Robots with the same nominal numbers.
pub struct Kind<'a> {
    /// These numbers, in words.
    pub name: String,
    /// Names of the robots.
    pub robots: Vec<String>,
    /// Their campaigns, by robot, then by date.
    pub campaigns: Vec<Studied>,
    /// What all were fitted with.
    pub parameters: Vec<FleetParameter<'a>>,
}

impl Kind<'_> {
    /// Whether there are several robots or days: else there is nothing to compare, and a drawing would be one dot.
    pub fn is_comparable(&self) -> bool {
        let days = || self.campaigns.iter().filter_map(|one| one.dated.days);
        let (first, last) = days()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), day| {
                (first.min(day), last.max(day))
            });
        self.robots.len() > 1 || last - first >= 1.0
    }
}

/// One campaign.
pub struct Studied {
    /// Its folder.
    pub folder: PathBuf,
    /// Number of its robot in [`Kind::robots`].
    pub robot: usize,
    /// When it was driven.
    pub dated: Dated,
    /// The main finding.
    pub verdict: String,
    /// Errors of the nominal robot, and of a model of all effects that its kind has.
    pub errors: [ErrorPair; 2],
    /// Effects that are missing and matter.
    pub missing: Vec<String>,
    found: Vec<Found>,
    /// Until it is fitted with what its kind has.
    campaign: Option<recording::Campaign>,
}

/// One parameter of a kind.
pub struct FleetParameter<'a> {
    /// The effect.
    pub effect: &'a dyn Effect,
    /// Its value in each campaign; `None` if the runs do not determine it.
    pub values: Vec<Option<ParameterFound>>,
    /// Name and unit.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What the values say.
    pub judgement: Judgement,
}

/// What tells robots of one data sheet from others.
type Sheet = [u64; 4];

/// Studies campaigns; `progress` is told the share that is done.
pub fn study<'a>(
    folders: &[PathBuf],
    catalogue: &[&'a dyn Effect],
    mut progress: impl FnMut(f64),
) -> Fleet<'a> {
    let mut kinds: Vec<(Sheet, Kind)> = Vec::new();
    let mut left_out = Vec::new();
    for (number, folder) in folders.iter().enumerate() {
        match explained(folder, catalogue) {
            Ok((robot, studied)) => join(&mut kinds, &robot, studied),
            Err(error) => left_out.push((folder.clone(), error)),
        }
        // Explaining takes longer than fitting what was found.
        progress(0.8 * (number + 1) as f64 / folders.len() as f64);
    }
    let mut kinds: Vec<Kind> = kinds.into_iter().map(|(_, kind)| kind).collect();
    kinds.sort_by_key(|kind| std::cmp::Reverse(kind.campaigns.len()));
    let total: usize = kinds.iter().map(|kind| kind.campaigns.len()).sum();
    let mut done = 0;
    for kind in &mut kinds {
        let robots = &kind.robots;
        kind.campaigns.sort_by(|a, b| {
            let days = |one: &Studied| one.dated.days.unwrap_or(f64::NEG_INFINITY);
            let names = robots[a.robot].cmp(&robots[b.robot]);
            names.then(days(a).total_cmp(&days(b))).then(a.folder.cmp(&b.folder))
        });
        fit_all(kind, catalogue, &mut left_out, || {
            done += 1;
            progress(0.8 + 0.2 * done as f64 / total.max(1) as f64);
        });
    }
    kinds.retain(|kind| !kind.campaigns.is_empty());
    judge_all(&mut kinds);
    Fleet { kinds, left_out }
}

/// Explains the campaign in a folder.
fn explained(folder: &Path, catalogue: &[&dyn Effect]) -> Result<(RobotFile, Studied), String> {
    let words = |error: CampaignError| error.to_string();
    let (read, recordings) = Campaign::read_both(folder).map_err(words)?;
    let campaign = recordings.into_model(&read, folder).map_err(words)?;
    let model = ModelFile::read_or_empty(&ModelFile::place(folder)).map_err(words)?;
    // From the robot as recorded, whatever effects its model has been given since.
    let in_use: Vec<&str> = model.in_use().iter().map(|entry| entry.id()).collect();
    let answer =
        explain_given(&campaign, catalogue, &in_use).map_err(|error| recording_error(&error))?;
    let asked = Asked {
        runs: campaign.fitted_runs().count(),
        catalogue,
        nominal_m: [read.robot.wheel_radius_m, read.robot.track_width_m],
    };
    let missing = answer.steps.iter().filter(|step| step.is_missing());
    let studied = Studied {
        folder: folder.to_owned(),
        robot: 0,
        dated: places::dated(folder, &read),
        verdict: headline(&answer, &asked),
        errors: [answer.baseline; 2],
        missing: missing.map(|step| step.class.join(" or ")).collect(),
        found: Found::of(&answer),
        campaign: Some(campaign),
    };
    Ok((read.robot, studied))
}

/// Puts a campaign to its robot and kind.
fn join(kinds: &mut Vec<(Sheet, Kind)>, robot: &RobotFile, studied: Studied) {
    let sheet =
        [robot.wheel_radius_m, robot.track_width_m, robot.counts_per_rev, robot.gear_reduction]
            .map(f64::to_bits);
    let at = kinds.iter().position(|(other, _)| *other == sheet).unwrap_or_else(|| {
        let name = format!(
            "wheel radius {:.1} mm, track width {:.1} mm",
            1e3 * robot.wheel_radius_m,
            1e3 * robot.track_width_m
        );
        let (robots, campaigns, parameters) = Default::default();
        kinds.push((sheet, Kind { name, robots, campaigns, parameters }));
        kinds.len() - 1
    });
    let kind = &mut kinds[at].1;
    // Two robots may have one name, and no two have one number.
    let name = match &robot.uid {
        Some(uid) => format!("{} ({uid})", robot.name),
        None => robot.name.clone(),
    };
    let number = kind.robots.iter().position(|other| *other == name).unwrap_or_else(|| {
        kind.robots.push(name);
        kind.robots.len() - 1
    });
    kind.campaigns.push(Studied { robot: number, ..studied });
}

/// Fits every campaign of a kind with the effects that any of them shows.
fn fit_all<'a>(
    kind: &mut Kind<'a>,
    catalogue: &[&'a dyn Effect],
    left_out: &mut Vec<(PathBuf, String)>,
    mut done: impl FnMut(),
) {
    let found: Vec<Found> = kind.campaigns.iter().flat_map(|one| one.found.clone()).collect();
    let effects = common_effects(&found, catalogue);
    let mut models: Vec<Model> = Vec::new();
    kind.campaigns.retain_mut(|one| {
        let fitted = one.campaign.take().map(|campaign| ModelFitter::new(&campaign));
        done();
        match fitted {
            Some(Ok(fitter)) => {
                let model = fitter.fit(&effects);
                one.errors = [model.nominal, model.errors];
                models.push(model);
                true
            }
            Some(Err(error)) => {
                left_out.push((one.folder.clone(), recording_error(&error)));
                false
            }
            None => false,
        }
    });
    for (k, effect) in effects.iter().enumerate() {
        let amplitudes = effect.facts().parameters.iter().enumerate();
        for (j, known) in amplitudes.filter(|(_, known)| known.role == Role::Amplitude) {
            let value = |model: &Model| {
                let found = model.effects.get(k)?.parameters.get(j)?;
                let is_lacking = model.effects[k].verdict.lacking.is_some();
                let sound = found.sigma > 0.0 && found.sigma.is_finite() && found.value.is_finite();
                (sound && !is_lacking).then(|| found.clone())
            };
            kind.parameters.push(FleetParameter {
                effect: *effect,
                values: models.iter().map(value).collect(),
                name: known.name.to_string(),
                unit: known.unit.to_string(),
                judgement: judge(&[Vec::new()]).swap_remove(0),
            });
        }
    }
}

/// Judges all parameters of all kinds at once.
fn judge_all(kinds: &mut [Kind]) {
    let measured = |kind: &Kind, parameter: &FleetParameter| -> Vec<Measured> {
        let each = kind.campaigns.iter().zip(&parameter.values);
        let value = |(one, value): (&Studied, &Option<ParameterFound>)| {
            let found = value.as_ref()?;
            let (robot, at_days) = (one.robot, one.dated.days);
            Some(Measured { robot, at_days, value: found.value, sigma: found.sigma })
        };
        each.filter_map(value).collect()
    };
    let asked: Vec<Vec<Measured>> = kinds
        .iter()
        .flat_map(|kind| kind.parameters.iter().map(|parameter| measured(kind, parameter)))
        .collect();
    let parameters = kinds.iter_mut().flat_map(|kind| &mut kind.parameters);
    for (parameter, judgement) in parameters.zip(judge(&asked)) {
        parameter.judgement = judgement;
    }
}
