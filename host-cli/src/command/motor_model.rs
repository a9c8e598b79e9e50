//! `beeline model ... --drivetrain`: the effects that a user puts into the model of the motors, one by one.

use std::path::{Path, PathBuf};

use campaign::lock::FolderLock;
use campaign::motor_model::{MotorModelFile, motor_equation_error};
use robot_model::drivetrain::{
    ChosenModel, Experiment, KnownMotorEffect, MotorCustom, MotorEffect, fit_chosen,
};
use serde_json::json as value;

use super::model_arguments::{equations, names_are_free, split};
use super::motors::{in_words, read};
use crate::cli::{AddArgs, Common, RemoveArgs};
use crate::error::{Error, Result};
use crate::escape::shell_path;
use crate::json;
use crate::motors::{chance_alone, estimate, holds_zero, millimetres};
use crate::table::{Cell, Table};
use crate::ui::{BAD, BOLD, DIM, GOOD, Steps, note, paint, say};

/// An effect and a campaign, where one forgets them.
const EXAMPLE: &str = "backlash my-motors";

pub(super) fn add(common: &Common, args: &AddArgs) -> Result<()> {
    let (ids, campaign) = split(&args.what, args.custom.is_empty(), "add --drivetrain", EXAMPLE)?;
    let mut task = Task::new(campaign)?;
    let mut effects = task.before.clone();
    let customs = equations::<MotorCustom>(args)?;
    names_are_free(args, |id| task.model.customs.iter().any(|own| own.facts().id == id))?;
    for custom in customs {
        let declared = task.model.declare(&custom);
        let wrong = |error| motor_equation_error(&custom.expression, &error);
        effects.push(declared.map_err(|error| wrong(*error))?);
    }
    for id in &ids {
        let effect = task.model.find(id).ok_or_else(|| {
            let error = Error::new(format_args!("motors have no effect `{id}`"));
            match id.contains('=') {
                true => error.hint("an equation goes with --custom"),
                false => error.hint(task.model.ids()),
            }
        })?;
        if effects.iter().any(|own| own.facts().id == id) {
            return Err(Error::new(format_args!("{id} is in the model already")).hint(
                format_args!(
                    "`beeline model fit --drivetrain {}` fits it again",
                    shell_path(campaign)
                ),
            ));
        }
        effects.push(effect);
    }
    task.change(common, &effects)
}

pub(super) fn remove(common: &Common, args: &RemoveArgs) -> Result<()> {
    let (ids, campaign) = split(&args.what, true, "remove --drivetrain", EXAMPLE)?;
    let mut task = Task::new(campaign)?;
    let mut effects = task.before.clone();
    for id in &ids {
        let (before, declared) = (effects.len(), task.model.customs.len());
        let own = task.model.customs.iter().find(|own| own.facts().id == id);
        if let Some(own) = own.filter(|_| !common.json) {
            // To be pasted, if it was removed by mistake.
            note(format_args!("{id} was --custom \"{}\" --name {id}", own.facts().equation));
        }
        effects.retain(|effect| effect.facts().id != id);
        task.model.customs.retain(|own| own.facts().id != id);
        if effects.len() == before && task.model.customs.len() == declared {
            let there: Vec<&str> = task.before.iter().map(|effect| effect.facts().id).collect();
            let there = if there.is_empty() { "no effects".into() } else { there.join(", ") };
            return Err(Error::new(format_args!("{id} is not in the model of the motors"))
                .hint(format_args!("the model has {there}")));
        }
    }
    task.change(common, &effects)
}

pub(super) fn fit(common: &Common, campaign: &Path) -> Result<()> {
    let task = Task::new(campaign)?;
    if task.before.is_empty() {
        return Err(Error::new(format_args!(
            "{}: the model of the motors has no effects to fit",
            task.file.display()
        ))
        .hint(format_args!(
            "`beeline explain --drivetrain {0}`, then `beeline model add EFFECT --drivetrain {0}`",
            shell_path(campaign)
        )));
    }
    let effects = task.before.clone();
    task.change(common, &effects)
}

pub(super) fn show(common: &Common, campaign: &Path) -> Result<()> {
    if !campaign.exists() {
        return Err(Error::new(format_args!("{} does not exist", campaign.display()))
            .hint("give a campaign folder, or a motors.toml"));
    }
    let is_folder = campaign.is_dir();
    let file = if is_folder { MotorModelFile::place(campaign) } else { campaign.to_owned() };
    let model = MotorModelFile::read_or_empty(&file)?;
    if common.json {
        let effects: Vec<_> = model
            .effects
            .iter()
            .map(|entry| {
                let values = entry.values.iter().map(|(name, fitted)| {
                    value!({
                        "name": name,
                        "unit": fitted.unit,
                        "value": fitted.value,
                        "half_width_95": fitted.half_width_95,
                    })
                });
                value!({"effect": entry.effect.facts().id, "parameters": values.collect::<Vec<_>>()})
            })
            .collect();
        say(value!({"schema": 1, "model": file, "effects": effects}));
        return Ok(());
    }
    if model.effects.is_empty() {
        say(format_args!("{}: motors with kS, kV and kA, no effects", campaign.display()));
    }
    let chosen = |id: &str| model.effects.iter().any(|entry| entry.effect.facts().id == id);
    for own in model.customs.iter().filter(|own| !chosen(own.facts().id)) {
        let facts = own.facts();
        say(format_args!("{}  declared, not in the model", paint(BOLD, facts.id)));
        say(format_args!("    {}", paint(DIM, facts.equation)));
    }
    for entry in &model.effects {
        let facts = entry.effect.facts();
        say(format_args!("{}  {}", paint(BOLD, facts.id), facts.name));
        say(format_args!("    {}", paint(DIM, facts.equation)));
        if entry.values.is_empty() {
            say("    not fitted yet: `beeline model fit --drivetrain CAMPAIGN`");
        }
        for parameter in facts.parameters {
            if let Some(fitted) = entry.values.get(&*parameter.name) {
                say(format_args!(
                    "    {}",
                    estimate(&robot_model::drivetrain::Estimate {
                        name: parameter.name.clone(),
                        unit: parameter.unit.clone(),
                        value: fitted.value,
                        half_width_95: fitted.half_width_95.unwrap_or(0.0),
                        is_at_end: false,
                    })
                ));
            }
        }
    }
    Ok(())
}

/// A campaign with the model of its motors, about to be changed.
struct Task {
    robot: String,
    known: robot_model::drivetrain::KnownRobot,
    experiments: Vec<Experiment>,
    file: PathBuf,
    /// The effects before the change.
    before: Vec<KnownMotorEffect>,
    /// The model as it was read, and effects of the user's own as they are declared.
    model: MotorModelFile,
    /// Held until the model is written: what was read stays as it is.
    _lock: FolderLock,
}

impl Task {
    fn new(folder: &Path) -> Result<Self> {
        if !folder.is_dir() {
            // What is wrong with it, this says best.
            read(folder)?;
        }
        let lock = FolderLock::take(folder)?;
        let (robot, found, experiments) = read(folder)?;
        let file = MotorModelFile::place(folder);
        let model = MotorModelFile::read_or_empty(&file)?;
        let before = model.chosen();
        Ok(Self { robot, known: found.robot, experiments, file, before, model, _lock: lock })
    }

    /// Fits before and after, writes the model, and says what it came to.
    fn change(self, common: &Common, effects: &[KnownMotorEffect]) -> Result<()> {
        let steps = Steps::new(common.json);
        steps.now("fitting the model before");
        let fitted = |effects| fit_chosen(&self.known, &self.experiments, effects);
        // Fitted again it is compared with motors without effects.
        let same = effects.len() == self.before.len();
        let old: &[KnownMotorEffect] = if same { &[] } else { &self.before };
        let before = fitted(old).map_err(in_words)?;
        steps.now("fitting the model after");
        let after = fitted(effects).map_err(in_words)?;
        drop(steps);
        MotorModelFile::write(&self.file, &self.robot, &self.model.customs, &after)?;
        if common.json {
            say(value!({
                "schema": 1,
                "model": self.file,
                "before": json::motor_errors(&before.errors),
                "after": json::motor_errors(&after.errors),
                "resolution_m": after.resolution_m,
                "constants": json::motor_estimates(&after.constants),
                "effects": json::chosen_effects(&after),
            }));
        } else {
            let campaign = shell_path(self.file.parent().unwrap_or(Path::new(".")));
            changed(&before, &after, &campaign.to_string(), |id| {
                old.iter().all(|effect| effect.facts().id != id)
            });
            say("");
            say(paint(DIM, format_args!("{} written", self.file.display())));
        }
        Ok(())
    }
}

fn changed(before: &ChosenModel, after: &ChosenModel, campaign: &str, new: impl Fn(&str) -> bool) {
    let names = |model: &ChosenModel| match model.effects.len() {
        0 => "kS, kV, kA".to_owned(),
        1 => "1 effect".to_owned(),
        several => format!("{several} effects"),
    };
    let mut table = Table::new("lrrr");
    let dim = |text: String| Cell::styled(DIM, text);
    table.row([
        dim("error, root mean square".into()),
        dim(format!("before ({})", names(before))),
        dim(format!("after ({})", names(after))),
        dim("change".into()),
    ]);
    let mut row = |name: &str, before_m: f64, after_m: f64, tells: bool| {
        let change = if before_m > 0.0 { 100.0 * (after_m / before_m - 1.0) } else { 0.0 };
        let style = match tells {
            true if change < -1.0 => GOOD,
            true if change > 1.0 => BAD,
            _ => DIM,
        };
        table.row([
            name.into(),
            millimetres(before_m).into(),
            millimetres(after_m).into(),
            Cell::styled(style, format!("{change:+.0} %")),
        ]);
    };
    let (b, a) = (&before.errors, &after.errors);
    row("fitted", b.fitted_m, a.fitted_m, false);
    row("cross-validated", b.cross_validated_m, a.cross_validated_m, true);
    if let (Some(before_m), Some(after_m)) = (b.held_out_m, a.held_out_m) {
        row("on held-out experiments", before_m, after_m, true);
    }
    table.say(0);
    say(format_args!("The resolution of the counts hides {}.", millimetres(after.resolution_m)));
    say("");
    for effect in &after.effects {
        let facts = effect.effect.facts();
        let mark = if new(facts.id) { "+ " } else { "  " };
        say(format_args!("{mark}{}  {}", paint(BOLD, facts.id), facts.name));
        for parameter in &effect.parameters {
            say(format_args!("    {}", estimate(parameter)));
        }
        let zero = holds_zero(facts.parameters, &effect.parameters).filter(|_| effect.matters);
        if let Some(words) = zero {
            say(paint(DIM, format_args!("    {words}")));
        }
        let without = millimetres(effect.without_m);
        let (style, words) = match effect.matters {
            true => (GOOD, "needed: without it the error is"),
            false => (BAD, "not needed: without it the error is"),
        };
        let chance = match effect.matters {
            true => format!("; chance alone gives as much in {}", chance_alone(effect.p_value)),
            false => String::new(),
        };
        say(format_args!("    {}", paint(style, format_args!("{words} {without}{chance}"))));
        if effect.without_m < after.errors.cross_validated_m {
            let id = facts.id;
            say(format_args!(
                "    worse with it: `beeline model remove {id} --drivetrain {campaign}`"
            ));
        }
    }
    if after.effects.is_empty() {
        say("  no effects: kS, kV and kA alone");
    }
}
