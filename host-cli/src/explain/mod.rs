//! `beeline explain` in words: what is missing, the evidence for it, what cannot be told apart, what was
//! rejected, what stays unexplained, and the run that would tell more.

mod context;
mod next_run;
mod progress;

use campaign::model::EffectEntry;
pub use findings::headline::{
    before, effects_with_values, errors_text, net_changes, on_held_out, wrong_in_robot_toml,
};
use findings::headline::{effect_names, kind_of_error};
use robot_model::estimation::Errors;
use robot_model::explain::{Answer, ParameterFound, StepFound};

use crate::compare::LINE;
use crate::quantity::{interval_in_unit, p_value, probability, value_in_unit, value_with_sigma};
use crate::table::{Cell, Table, wrapped};
use crate::ui::{BOLD, DIM, GOOD, WARN, paint, say};
use crate::words;

pub use self::context::{AnswerContext, headline};
pub use self::next_run::{flash_option, next_run_command, next_run_options, robot_options};
pub(crate) use self::next_run::{gyro_words, no_next_run};
pub use self::progress::explained;
pub(crate) use self::progress::progress_line;

/// Width of the longest bar.
const BAR: usize = 24;

/// Prints an answer.
pub fn show(answer: &Answer, context: &AnswerContext<'_>) {
    wrapped(&headline(answer, context), LINE).iter().for_each(|line| say(paint(BOLD, line)));
    clocks(answer);
    let opinion = answer.alternative_fit.map(words::second_opinion);
    wrapped(opinion.unwrap_or_default(), LINE).iter().for_each(say);
    say("");
    waterfall(answer, context);
    if let Some(held_out) = &answer.held_out {
        let (before, model) = (errors_text(&held_out.baseline), errors_text(&held_out.model));
        say(format_args!("{}  {before} \u{2192} {model}", paint(DIM, on_held_out(held_out))));
    }
    known(answer, context);
    for (number, step) in answer.steps.iter().enumerate() {
        say("");
        let combination = context.combinations.get(number).and_then(Option::as_deref);
        effect(number + 1, step, combination, context);
    }
    fitted_along(answer);
    if !answer.rejected.is_empty() {
        say("");
        say(paint(BOLD, "Considered and rejected"));
        let mut table = Table::new("lll");
        for rejected in &answer.rejected {
            let reason = words::reason(&rejected.reason);
            table.row([rejected.effect.clone().into(), Cell::styled(DIM, reason)]);
        }
        table.say(2);
    }
    say("");
    unexplained(answer);
    say("");
    next_run(answer, context);
}

/// Radii and track width that are no finding of their own.
fn fitted_along(answer: &Answer) {
    if answer.fitted_along.is_empty() {
        return;
    }
    say("");
    say(paint(BOLD, "Fitted along"));
    let mut table = Table::new("llll");
    for found in &answer.fitted_along {
        for ParameterFound { name, unit, value, sigma, low95, high95 } in &found.parameters {
            let interval = interval_in_unit(*value, *sigma, (*low95, *high95), unit);
            table.row([
                found.effect.clone().into(),
                Cell::styled(DIM, name),
                value_with_sigma(*value, *sigma, unit).into(),
                Cell::styled(DIM, format!("95 %: {interval}")),
            ]);
        }
    }
    table.say(2);
    let why = "Radii and track width are measured together; by itself, this may be chance.";
    say(format_args!("  {}", paint(DIM, why)));
}

/// The cross-validated error as effects are added, as bars.
fn waterfall(answer: &Answer, context: &AnswerContext<'_>) {
    let most = answer.baseline.cross_validated.position_rms_m.max(f64::MIN_POSITIVE);
    // Where only positions are measured, nothing is known of headings.
    let has_headings = answer.baseline.cross_validated.heading_rms_rad > 0.0;
    let mut table = Table::new("llrrrl");
    let heading = if has_headings { "heading" } else { "" };
    let heads = ["", kind_of_error(context.runs.len()), "position", heading, "p", ""];
    table.row(heads.map(|text| Cell::styled(DIM, text)));
    let mut row = |number: String, name: String, errors: &Errors, p: String| {
        let length =
            (errors.position_rms_m / most * BAR as f64).round().clamp(0.0, 2.0 * BAR as f64);
        let bar = "\u{2588}".repeat((length as usize).max(1));
        table.row([
            number.into(),
            name.into(),
            format!("{:.1} mm", errors.position_rms_m * 1e3).into(),
            match has_headings {
                true => format!("{:.1} mrad", errors.heading_rms_rad * 1e3).into(),
                false => "".into(),
            },
            p.into(),
            Cell::styled(GOOD, bar),
        ]);
    };
    row(String::new(), before(answer).into(), &answer.baseline.cross_validated, String::new());
    for (number, step) in answer.steps.iter().enumerate() {
        let name = match step.class.len() {
            0..=2 => format!("+ {}", effect_names(step, &context.asked())),
            // All of them are in the section of this effect.
            n => format!("+ {} or {} others", context.name(&step.effect), n - 1),
        };
        row((number + 1).to_string(), name, &step.cross_validated, probability(step.p_value));
    }
    let floor = words::error_floor(&answer.unexplained);
    row(String::new(), floor.into(), &answer.reachable, String::new());
    table.say(0);
}

/// Clocks of wheels and poses that do not agree, which was corrected before anything was fitted; headings whose zero differs;
/// what happened once.
fn clocks(answer: &Answer) {
    let zeros = words::heading_zeros(&answer.noise);
    let sudden = answer.unexplained.sudden.iter().map(words::sudden_motion);
    for line in words::clocks(&answer.clocks).into_iter().chain(zeros).chain(sudden) {
        wrapped(&line, LINE).iter().for_each(|line| say(paint(WARN, line)));
    }
}

/// What the model already has, and whether these runs confirm it.
fn known(answer: &Answer, context: &AnswerContext<'_>) {
    if context.in_model.is_empty() {
        return;
    }
    say("");
    say(paint(BOLD, "Already in the model"));
    let mut table = Table::new("ll");
    for entry in context.in_model {
        let id = entry.id();
        let holds = |step: &&StepFound| step.class.iter().any(|other| other == id);
        let words = match answer.known.iter().find(holds) {
            Some(step) if step.effect == id => confirmed(entry, step),
            Some(step) => format!("confirmed, but not told apart from {}", step.effect),
            None if answer.fitted_along.iter().any(|found| found.effect == id) => {
                "by itself not confirmed by these runs; fitted along with the others".to_owned()
            }
            None => {
                let rejected = answer.rejected.iter().find(|rejected| rejected.effect == id);
                let why =
                    rejected.map_or_else(String::new, |rejected| words::reason(&rejected.reason));
                format!("not confirmed by these runs: {why}")
            }
        };
        table.row([id.into(), Cell::styled(DIM, words)]);
    }
    table.say(2);
}

/// An effect of the model that these runs confirm: whether at the value that the model has.
fn confirmed(entry: &EffectEntry, found: &StepFound) -> String {
    let confirmed = format!("confirmed ({})", p_value(found.p_value));
    // Both are known to some 95 %; what is in use, exactly.
    let half = |parameter: &ParameterFound| (parameter.high95 - parameter.low95) / 2.0;
    let pairs = entry.parameters.iter().filter_map(|was| {
        let now = found.parameters.iter().find(|now| now.name == was.name)?;
        let off = (now.value - was.value).abs() > half(was).hypot(half(now));
        let value = value_with_sigma(now.value, now.sigma, &now.unit);
        Some((value_in_unit(was.value, now.sigma, &now.unit), value, off))
    });
    let pairs: Vec<(String, String, bool)> = pairs.collect();
    let worst = pairs.iter().find(|(_, _, off)| *off).or(pairs.first());
    match worst {
        Some((was, now, true)) if entry.in_use => format!(
            "{confirmed}, but at {now}, not at the {was} in use; `beeline apply` writes the new value"
        ),
        Some((was, now, true)) => {
            format!("{confirmed}, but at {now}, not at {was}; `beeline model fit` fits it again")
        }
        Some((was, now, false)) if entry.in_use => {
            format!("{confirmed}, compensated: {was} is in use, these runs give {now}")
        }
        _ => confirmed,
    }
}

fn effect(number: usize, step: &StepFound, combination: Option<&str>, context: &AnswerContext<'_>) {
    let title = step.class.iter().map(String::as_str).collect::<Vec<_>>().join(" or ");
    say(format_args!("{number}  {}", paint(BOLD, title)));
    let put = |words: &str| {
        wrapped(words, LINE - 3).iter().for_each(|line| say(format_args!("   {line}")))
    };
    let facts = context.facts(&step.effect);
    if let Some(facts) = facts {
        say(format_args!("   {}", paint(DIM, facts.equation)));
    }
    parameters(&step.parameters, 3);
    put(&format!("Evidence: {}.", words::evidence(step).trim_end_matches('.')));
    put(&format!("Worth: {}.", words::worth(step)));
    if step.class.len() > 1 {
        let common = combination
            .map_or_else(String::new, |change| format!(" Their combined effect: {change}."));
        let words = format!("These runs cannot tell {} apart.{common}", words::listed(&step.class));
        wrapped(&words, LINE - 3)
            .iter()
            .for_each(|line| say(format_args!("   {}", paint(WARN, line))));
    } else if let Some(change) = combination {
        put(&format!("In these runs: {change}."));
    }
    if let Some(facts) = facts.filter(|facts| !facts.compensation.is_empty()) {
        let which =
            if step.class.len() > 1 { format!(" if it is {}", step.effect) } else { String::new() };
        put(&format!("Remedy{which}: {}.", facts.compensation));
    }
}

/// Prints parameters with their 95 % intervals, one per line.
pub fn parameters(parameters: &[ParameterFound], indent: usize) {
    let mut table = Table::new("lll");
    for parameter in parameters {
        let ParameterFound { name, unit, value, sigma, low95, high95 } = parameter;
        let interval = interval_in_unit(*value, *sigma, (*low95, *high95), unit);
        table.row([
            Cell::styled(DIM, name),
            value_with_sigma(*value, *sigma, unit).into(),
            Cell::styled(DIM, format!("95 %: {interval}")),
        ]);
    }
    table.say(indent);
}

fn unexplained(answer: &Answer) {
    let residuals = &answer.unexplained;
    if residuals.structure {
        say(paint(
            WARN,
            format_args!(
                "Still unexplained: the residuals depend on {}",
                words::depends_on(residuals)
            ),
        ));
        let size = if residuals.size_m >= 5e-5 {
            format!(
                "{:.1} mm (rms), which add in squares to the error floor; ",
                1e3 * residuals.size_m
            )
        } else {
            String::new()
        };
        let p = p_value(residuals.p_value);
        say(format_args!("   {size}{p}; `beeline report` shows the shape"));
        if let Some(text) = words::runs_off(residuals).filter(|_| answer.set_aside.is_none()) {
            wrapped(&text, LINE - 3).iter().for_each(|line| say(format_args!("   {line}")));
        }
        if let Some(found) = &residuals.expression {
            let text = words::expression(found);
            wrapped(&text, LINE - 3).iter().for_each(|line| say(format_args!("   {line}")));
        }
    } else {
        say(format_args!(
            "{}: the residuals depend on none of the variables tested{} ({})",
            paint(BOLD, "Nothing else is missing"),
            if residuals.slight.is_empty() { "" } else { " by more than a little" },
            p_value(residuals.p_value)
        ));
    }
    if let Some(text) = words::slight(residuals) {
        wrapped(&text, LINE - 3).iter().for_each(|line| say(format_args!("   {line}")));
    }
    if let Some(text) = words::driven_again(residuals) {
        wrapped(&text, LINE - 3).iter().for_each(|line| say(format_args!("   {line}")));
    }
}

fn next_run(answer: &Answer, context: &AnswerContext<'_>) {
    match &answer.next_run {
        Some(next) => {
            say(paint(BOLD, format_args!("Next: record {}", next.kind.name())));
            let predicted = words::predicted(&next.predicted);
            let text = format!("It tells {} apart: {predicted}.", words::listed(&next.separates));
            wrapped(&text, LINE - 3).iter().for_each(|line| say(format_args!("   {line}")));
            let gyro = gyro_words(next).unwrap_or_default();
            wrapped(gyro, LINE - 3).iter().for_each(|line| say(format_args!("   {line}")));
            say(format_args!("   {}", next_run_command(next, context)));
        }
        None => {
            let (words, command) = no_next_run(answer, context);
            wrapped(&words, LINE).iter().for_each(say);
            command.iter().for_each(|command| say(format_args!("   {command}")));
        }
    }
}
