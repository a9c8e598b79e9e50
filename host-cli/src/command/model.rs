//! `beeline model`: the effects that a user puts into the model, one by one.

use std::path::{Path, PathBuf};

use robot_model::effect::{Custom, Effect, KnownEffect};
use robot_model::estimation::{ErrorPair, Errors};
use robot_model::explain::model::{Model, fit};
use robot_model::recording::Campaign;
use serde_json::json;

use super::compare::{read, warn_if_single_run};
use super::model_arguments::{equations, names_are_free, split};
use super::motor_model;
use crate::cli::{AddArgs, Common, ModelCommand, RemoveArgs};
use crate::compare::LINE;
use crate::error::{Error, Result};
use crate::escape::shell_path;
use crate::explain::{errors_text, parameters};
use crate::table::{Cell, Table, wrapped};
use crate::ui::{BAD, BOLD, DIM, GOOD, paint, runs, say, warn};
use crate::{json, words};
use campaign::lock::FolderLock;
use campaign::model::{EffectEntry, ModelFile, equation_error, hint_for};

/// An effect and a campaign, where one forgets them.
const EXAMPLE: &str = "side_slip my-robot";

pub(super) fn run(common: &Common, command: &ModelCommand) -> Result<()> {
    match command {
        ModelCommand::Show { campaign, drivetrain: true } => motor_model::show(common, campaign),
        ModelCommand::Add(args) if args.drivetrain => motor_model::add(common, args),
        ModelCommand::Remove(args) if args.drivetrain => motor_model::remove(common, args),
        ModelCommand::Fit { campaign, drivetrain: true, .. } => motor_model::fit(common, campaign),
        ModelCommand::Show { campaign, .. } => show(common, campaign),
        ModelCommand::Add(args) => add(common, args),
        ModelCommand::Remove(args) => remove(common, args),
        ModelCommand::Fit { campaign, model, .. } => {
            let mut task = Task::new(campaign, model.as_deref())?;
            task.before.clear();
            if task.model.effects.is_empty() {
                return Err(Error::new(format_args!(
                    "{}: the model has no effects to fit",
                    task.file.display()
                ))
                .hint(format_args!(
                    "`beeline explain {0}`, then `beeline model add EFFECT {0}`",
                    shell_path(campaign)
                )));
            }
            task.change(common)
        }
    }
}

fn add(common: &Common, args: &AddArgs) -> Result<()> {
    let (effects, campaign) = split(&args.what, args.custom.is_empty(), "add", EXAMPLE)?;
    let mut task = Task::new(campaign, args.model.as_deref())?;
    let customs = equations::<Custom>(args)?;
    names_are_free(args, |id| task.model.customs.iter().any(|own| own.facts().id == id))?;
    for mut custom in customs {
        if let Some(per) = args.per {
            custom.per = per;
        }
        let effect = task
            .model
            .declare(&custom)
            .map_err(|error| equation_error(&custom.expression, &error))?;
        task.model.effects.push(EffectEntry::unfitted(effect));
    }
    for id in &effects {
        let effect = task.find(id)?;
        if task.model.effects.iter().any(|entry| entry.effect.facts().id == id) {
            return Err(Error::new(format_args!("{id} is in the model already"))
                .hint(format_args!("`beeline model fit {}` fits it again", shell_path(campaign))));
        }
        task.model.effects.push(EffectEntry::unfitted(effect));
    }
    task.change(common)
}

fn remove(common: &Common, args: &RemoveArgs) -> Result<()> {
    let (effects, campaign) = split(&args.what, true, "remove", EXAMPLE)?;
    let mut task = Task::new(campaign, args.model.as_deref())?;
    for id in &effects {
        if task.model.in_use().iter().any(|entry| entry.id() == id) {
            warn(format_args!(
                "{id} was compensated when these runs were recorded: without it `explain` will name it as missing"
            ));
        }
        let before = task.model.effects.len();
        task.model.effects.retain(|entry| entry.effect.facts().id != id);
        let declared = task.model.customs.len();
        task.model.customs.retain(|custom| custom.facts().id != id);
        if task.model.effects.len() == before && task.model.customs.len() == declared {
            let there: Vec<&str> = task.before.iter().map(|effect| effect.facts().id).collect();
            let there = if there.is_empty() { "no effects".into() } else { there.join(", ") };
            return Err(Error::new(format_args!("{id} is not in the model"))
                .hint(format_args!("the model has {there}")));
        }
    }
    task.change(common)
}

/// A campaign with its model, about to be changed.
struct Task {
    robot: String,
    campaign: Campaign,
    file: PathBuf,
    model: ModelFile,
    /// The effects before the change.
    before: Vec<KnownEffect>,
    /// Held until the model is written: what was read stays as it is.
    _lock: FolderLock,
}

impl Task {
    fn new(folder: &Path, model: Option<&Path>) -> Result<Self> {
        let file = model.map_or_else(|| ModelFile::place(folder), Path::to_owned);
        let beside = file.parent().filter(|beside| !beside.as_os_str().is_empty());
        let lock = match beside {
            // What is wrong with the folder, `read` says better.
            Some(beside) if !beside.is_dir() => {
                read(folder)?;
                FolderLock::take(beside)?
            }
            beside => FolderLock::take(beside.unwrap_or(Path::new(".")))?,
        };
        let (read, campaign) = read(folder)?;
        warn_if_single_run(&campaign);
        let model = ModelFile::read_or_empty(&file)?;
        let before = model.effects.iter().map(|entry| entry.effect.clone()).collect();
        Ok(Self { robot: read.robot.name, campaign, file, model, before, _lock: lock })
    }

    fn find(&self, id: &str) -> Result<KnownEffect> {
        self.model.find(id).ok_or_else(|| {
            Error::new(format_args!("there is no effect `{id}`")).hint(hint_for(id, &self.model))
        })
    }

    /// Fits before and after, writes the model, and says what it came to.
    fn change(mut self, common: &Common) -> Result<()> {
        let before: Vec<&dyn Effect> = self.before.iter().map(|effect| &**effect).collect();
        let before = fit(&self.campaign, &before)?;
        let after = fit(&self.campaign, &self.model.chosen())?;
        if !after.is_finite() {
            let old: Vec<&str> = self.before.iter().map(|effect| effect.facts().id).collect();
            let new = after
                .effects
                .iter()
                .map(|effect| effect.effect.as_str())
                .filter(|id| !old.contains(id));
            let added = new.collect::<Vec<_>>().join(", ");
            let with = if added.is_empty() { "this model".to_owned() } else { added };
            return Err(Error::new(format_args!(
                "with {with} the prediction is not finite on these runs; nothing was written"
            ))
            .hint("bound its expression, with tanh, min or max, or scale what stands in exp"));
        }
        self.model.take_fit(&after, self.campaign.fitted_runs().count());
        self.model.write(&self.file, &self.robot)?;
        let old: Vec<&str> = self.before.iter().map(|effect| effect.facts().id).collect();
        let new = |id: &str| !old.contains(&id);
        if common.json {
            say(to_json(&before, &after, &self.file));
        } else {
            changed(&self, &before, &after, &new);
        }
        Ok(())
    }
}

fn changed(task: &Task, before: &Model, after: &Model, new: &dyn Fn(&str) -> bool) {
    let names = |model: &Model| match model.effects.as_slice() {
        [] => "nominal".to_owned(),
        effects => format!("{} effect{}", effects.len(), if effects.len() == 1 { "" } else { "s" }),
    };
    let mut table = Table::new("lrrr");
    let dim = |text: String| Cell::styled(DIM, text);
    table.row([
        dim("error, root mean square".into()),
        dim(format!("before ({})", names(before))),
        dim(format!("after ({})", names(after))),
        dim("change".into()),
    ]);
    let mut row = |name: &str, of: &dyn Fn(&Model) -> f64, unit: &str, held_out: bool| {
        let (a, b) = (of(before), of(after));
        let change = if a > 0.0 { 100.0 * (b / a - 1.0) } else { 0.0 };
        let style = match held_out {
            true if change < -1.0 => GOOD,
            true if change > 1.0 => BAD,
            _ => DIM,
        };
        table.row([
            name.into(),
            format!("{:.1} {unit}", a * 1e3).into(),
            format!("{:.1} {unit}", b * 1e3).into(),
            Cell::styled(style, format!("{change:+.0} %")),
        ]);
    };
    row("fitted", &|model| model.errors.fitted.position_rms_m, "mm", false);
    row("", &|model| model.errors.fitted.heading_rms_rad, "mrad", false);
    row("cross-validated", &|model| model.errors.cross_validated.position_rms_m, "mm", true);
    row("", &|model| model.errors.cross_validated.heading_rms_rad, "mrad", true);
    if after.held_out.is_some() {
        row("on held-out runs", &|model| held_out_errors(model).position_rms_m, "mm", true);
        row("", &|model| held_out_errors(model).heading_rms_rad, "mrad", true);
    }
    table.say(0);
    say("");
    effects(after, &|id| new(id));
    say("");
    say(paint(DIM, format_args!("{} written", task.file.display())));
}

/// Errors of a model on the held-out runs.
fn held_out_errors(model: &Model) -> Errors {
    model.held_out.as_ref().map(|held_out| held_out.model).unwrap_or_default()
}

/// Each effect with its parameters and its verdict.
fn effects(model: &Model, new: &dyn Fn(&str) -> bool) {
    for effect in &model.effects {
        let mark = if new(&effect.effect) { "+ " } else { "  " };
        say(format_args!("{mark}{}", paint(BOLD, &effect.effect)));
        parameters(&effect.parameters, 4);
        let style = if effect.verdict.better() { GOOD } else { BAD };
        for line in wrapped(&words::verdict(&effect.verdict), LINE - 4) {
            say(format_args!("    {}", paint(style, line)));
        }
    }
}

fn to_json(before: &Model, after: &Model, file: &Path) -> serde_json::Value {
    let held_out = |model: &Model| json::held_out(model.held_out.as_ref());
    json!({
        "schema": 1,
        "model": file,
        "before": json::pair(&before.errors),
        "after": json::pair(&after.errors),
        "aside": {"before": held_out(before), "after": held_out(after)},
        "effects": json::effects(after),
    })
}

fn show(common: &Common, campaign: &Path) -> Result<()> {
    // A model file, or a campaign folder with one in it.
    let file = if campaign.is_dir() { ModelFile::place(campaign) } else { campaign.to_owned() };
    if !campaign.exists() {
        return Err(Error::new(format_args!("{} does not exist", campaign.display()))
            .hint("give a campaign folder, or a model.toml"));
    }
    let model = ModelFile::read_or_empty(&file)?;
    if common.json {
        let effects: Vec<_> = model
            .effects
            .iter()
            .map(|entry| json!({"effect": entry.effect.facts().id, "parameters": json::parameters(&entry.parameters)}))
            .collect();
        let errors = model.fit.as_ref().map(|fit| json::pair(&fit.errors));
        say(json!({"schema": 1, "model": file, "effects": effects, "errors": errors}));
        return Ok(());
    }
    if model.effects.is_empty() {
        say(format_args!("{}: the nominal robot, no effects", campaign.display()));
    }
    for entry in &model.effects {
        let facts = entry.effect.facts();
        say(format_args!("{}  {}", paint(BOLD, facts.id), facts.name));
        say(format_args!("    {}", paint(DIM, facts.equation)));
        if entry.in_use {
            say("    in use on the robot when these runs were recorded");
        }
        if entry.parameters.is_empty() {
            say("    not fitted yet: `beeline model fit CAMPAIGN`");
        }
        parameters(&entry.parameters, 4);
    }
    let unused = model
        .customs
        .iter()
        .filter(|own| model.effects.iter().all(|entry| entry.effect.facts().id != own.facts().id));
    for own in unused {
        say(format_args!(
            "{}  {} (declared, not in the model)",
            paint(BOLD, own.facts().id),
            own.facts().equation
        ));
    }
    if let Some(fit) = &model.fit {
        say("");
        let mut table = Table::new("lrr");
        table.row(["", "nominal", "with this model"].map(|head| Cell::styled(DIM, head)));
        let mut row = |name: String, of: &dyn Fn(&ErrorPair) -> Errors| {
            let [nominal, fitted] = [&fit.nominal, &fit.errors].map(|pair| errors_text(&of(pair)));
            table.row([name.into(), nominal.into(), fitted.into()]);
        };
        row(format!("fitted ({})", runs(fit.runs)), &|errors| errors.fitted);
        row("cross-validated".into(), &|errors| errors.cross_validated);
        table.say(0);
    }
    Ok(())
}
