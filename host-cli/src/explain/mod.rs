//! `beeline explain` in words: what is missing, why it is believed, what cannot be told apart, what was
//! rejected, what stays unexplained, and the run that would tell more.

mod next;

use robot_model::compare::Assumed;
use robot_model::effect::{Effect, Facts};
use robot_model::estimation::Errors;
use robot_model::explain::{Answer, HeldOut, ParameterFound, StepFound};

use crate::compare::LINE;
use crate::quantity::{friendly, friendly_exact, friendly_interval, p_value, probability};
use crate::table::{Cell, Table, wrapped};
use crate::ui::{BOLD, DIM, GOOD, WARN, paint, say};
use crate::words;
use campaign::model::EffectEntry;

pub(crate) use self::next::{gyro_words, no_next_run};
pub use self::next::{memory, next_run_command, reached, reached_again};

/// Width of the longest bar.
const BAR: usize = 24;

/// Effects of an answer at the values found; the catalogue has all that were asked about.
pub fn assumed<'a>(steps: &[StepFound], catalogue: &[&'a dyn Effect]) -> Vec<Assumed<'a>> {
    let step = |it: &StepFound| {
        let values = it.parameters.iter().map(|it| it.value).collect();
        let effect = catalogue.iter().find(|effect| effect.facts().id == it.effect)?;
        Some(Assumed { effect: *effect, values })
    };
    steps.iter().filter_map(step).collect()
}

/// What an answer's effects are added to.
pub fn before(answer: &Answer) -> &'static str {
    if answer.known.is_empty() { "nominal robot" } else { "the model" }
}

/// What was asked, for the words of the answer.
pub struct Subject<'a> {
    /// Name of the robot.
    pub robot: &'a str,
    /// The folder, as the user wrote it.
    pub campaign: &'a str,
    /// The options that reach the robot for the next run, as the user would write them.
    pub reached: &'a str,
    /// How many runs a model is fitted to.
    pub runs: usize,
    /// All effects that were asked about.
    pub catalogue: &'a [&'a dyn Effect],
    /// The effects that the user's model has already.
    pub in_model: &'a [EffectEntry],
    /// What each step comes to in one plain number, where one says it.
    pub combinations: &'a [Option<String>],
}

impl Subject<'_> {
    fn facts(&self, id: &str) -> Option<Facts<'_>> {
        self.catalogue.iter().map(|it| it.facts()).find(|it| it.id == id)
    }

    /// The plain name of an effect.
    pub fn name<'b>(&'b self, id: &'b str) -> &'b str {
        self.facts(id).map_or(id, |it| it.name)
    }
}

/// The main finding, in a sentence or two.
pub fn headline(answer: &Answer, subject: &Subject<'_>) -> String {
    let last =
        answer.steps.last().map_or(&answer.baseline.cross_validated, |it| &it.cross_validated);
    let of_what = if subject.runs == 1 { "on the run fitted to" } else { "on runs held out" };
    let error = format!("the error {of_what} {}", goes(&answer.baseline.cross_validated, last));
    let more = if answer.unexplained.structure {
        format!(
            ". Something is still unexplained: it depends on {}",
            words::depends_on(&answer.unexplained)
        )
    } else {
        String::new()
    };
    match answer.steps.as_slice() {
        [] if answer.unexplained.structure => format!(
            "No known effect explains what {} {}, but something is there: it depends on {}.",
            these(subject.runs),
            if subject.runs == 1 { "shows" } else { "show" },
            words::depends_on(&answer.unexplained)
        ),
        [] => format!(
            "Nothing is missing{} that {} could show: what is left is noise.",
            if answer.known.is_empty() { "" } else { " beside the model" },
            these(subject.runs)
        ),
        [one] if answer.known.is_empty() => {
            format!("One effect is missing: {}. With it {error}{more}.", says(one, subject))
        }
        [one] => {
            format!("One more effect is missing: {}. With it {error}{more}.", says(one, subject))
        }
        steps => {
            let names: Vec<String> = steps.iter().map(|it| says(it, subject)).collect();
            format!(
                "{}{} effects are missing: {}. With them {error}{more}.",
                count(steps.len()),
                if answer.known.is_empty() { "" } else { " more" },
                names.join("; ")
            )
        }
    }
}

/// `this run`, `these 21 runs`.
fn these(runs: usize) -> String {
    if runs == 1 { "this run".into() } else { format!("these {runs} runs") }
}

/// `falls from 25.8 mm, 61.2 mrad to 5.0 mm, 9.1 mrad`, or whatever it does, as far as the digits show.
fn goes(from: &Errors, to: &Errors) -> String {
    let (before, after) = (text(from), text(to));
    let tenths = |it: f64| (it * 1e4).round();
    let position = tenths(to.position_rms_m) - tenths(from.position_rms_m);
    let heading = tenths(to.heading_rms_rad) - tenths(from.heading_rms_rad);
    let verb = match (position, heading) {
        _ if before == after => return format!("stays at {before}"),
        (p, h) if p <= 0.0 && h <= 0.0 => "falls",
        (p, h) if p >= 0.0 && h >= 0.0 => "rises",
        _ => "goes",
    };
    format!("{verb} from {before} to {after}")
}

/// A small number in words.
pub(crate) fn count(n: usize) -> String {
    let words = ["Zero", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine"];
    words.get(n).map_or_else(|| n.to_string(), |it| (*it).to_owned())
}

/// An effect by its name; or by all that it cannot be told from.
fn says(step: &StepFound, subject: &Subject<'_>) -> String {
    let names: Vec<&str> = step.class.iter().map(|id| subject.name(id)).collect();
    names.join(" or ")
}

/// `25.8 mm, 61.2 mrad`.
pub fn text(errors: &Errors) -> String {
    if errors.heading_rms_rad > 0.0 {
        format!("{:.1} mm, {:.1} mrad", errors.position_rms_m * 1e3, errors.heading_rms_rad * 1e3)
    } else {
        format!("{:.1} mm", errors.position_rms_m * 1e3)
    }
}

/// `on the 2 runs kept aside (square)`.
pub fn where_aside(aside: &HeldOut) -> String {
    let kinds: Vec<&str> = aside.kinds.iter().map(|kind| kind.name()).collect();
    let kinds = kinds.join(", ");
    match aside.runs {
        1 => format!("on the run kept aside ({kinds})"),
        runs => format!("on the {runs} runs kept aside ({kinds})"),
    }
}

/// Prints an answer.
pub fn show(answer: &Answer, subject: &Subject<'_>) {
    wrapped(&headline(answer, subject), LINE).iter().for_each(|line| say(paint(BOLD, line)));
    say("");
    waterfall(answer, subject);
    if let Some(aside) = &answer.held_out {
        let (before, model) = (text(&aside.baseline), text(&aside.model));
        say(format_args!("{}  {before} \u{2192} {model}", paint(DIM, where_aside(aside))));
    }
    known(answer, subject);
    for (number, step) in answer.steps.iter().enumerate() {
        say("");
        let combination = subject.combinations.get(number).and_then(Option::as_deref);
        effect(number + 1, step, combination, subject);
    }
    if !answer.rejected.is_empty() {
        say("");
        say(paint(BOLD, "Looked at, and not believed"));
        let mut table = Table::new("lll");
        for it in &answer.rejected {
            table.row([it.effect.clone().into(), Cell::styled(DIM, words::reason(&it.reason))]);
        }
        table.say(2);
    }
    say("");
    unexplained(answer);
    say("");
    next_run(answer, subject);
}

/// The error on held-out runs as effects are added, as bars.
fn waterfall(answer: &Answer, subject: &Subject<'_>) {
    let most = answer.baseline.cross_validated.position_rms_m.max(f64::MIN_POSITIVE);
    let mut table = Table::new("llrrrl");
    let where_ = if subject.runs == 1 { "on the run fitted to" } else { "on runs held out" };
    let heads = ["", where_, "position", "heading", "p", ""];
    table.row(heads.map(|text| Cell::styled(DIM, text)));
    let mut row = |number: String, name: String, errors: &Errors, p: String| {
        let length =
            (errors.position_rms_m / most * BAR as f64).round().clamp(0.0, 2.0 * BAR as f64);
        let bar = "\u{2588}".repeat((length as usize).max(1));
        table.row([
            number.into(),
            name.into(),
            format!("{:.1} mm", errors.position_rms_m * 1e3).into(),
            format!("{:.1} mrad", errors.heading_rms_rad * 1e3).into(),
            p.into(),
            Cell::styled(GOOD, bar),
        ]);
    };
    row(String::new(), before(answer).into(), &answer.baseline.cross_validated, String::new());
    for (number, step) in answer.steps.iter().enumerate() {
        let name = match step.class.len() {
            0..=2 => format!("+ {}", says(step, subject)),
            // All of them are in the section of this effect.
            n => format!("+ {} or {} others", subject.name(&step.effect), n - 1),
        };
        row((number + 1).to_string(), name, &step.cross_validated, probability(step.p_value));
    }
    table.say(0);
}

/// What the model has already, and whether these runs bear it out.
fn known(answer: &Answer, subject: &Subject<'_>) {
    if subject.in_model.is_empty() {
        return;
    }
    say("");
    say(paint(BOLD, "In the model already"));
    let mut table = Table::new("ll");
    for entry in subject.in_model {
        let id = entry.id();
        let holds = |it: &&StepFound| it.class.iter().any(|other| other == id);
        let words = match answer.known.iter().find(holds) {
            Some(it) if it.effect == id => stands(entry, it),
            Some(it) => format!("stands, in a class with {}", it.effect),
            None => {
                let rejected = answer.rejected.iter().find(|it| it.effect == id);
                let why = rejected.map_or_else(String::new, |it| words::reason(&it.reason));
                format!("these runs do not bear it out: {why}")
            }
        };
        table.row([id.into(), Cell::styled(DIM, words)]);
    }
    table.say(2);
}

/// An effect of the model that these runs bear out: whether at the value that the model has.
fn stands(entry: &EffectEntry, found: &StepFound) -> String {
    let stands = format!("stands ({})", p_value(found.p_value));
    // Both are known to some 95 %; what is in use, exactly.
    let half = |it: &ParameterFound| (it.high95 - it.low95) / 2.0;
    let pairs = entry.parameters.iter().filter_map(|was| {
        let now = found.parameters.iter().find(|now| now.name == was.name)?;
        let off = (now.value - was.value).abs() > half(was).hypot(half(now));
        let value = friendly(now.value, now.sigma, &now.unit);
        Some((friendly_exact(was.value, now.sigma, &now.unit), value, off))
    });
    let pairs: Vec<(String, String, bool)> = pairs.collect();
    let worst = pairs.iter().find(|it| it.2).or(pairs.first());
    match worst {
        Some((was, now, true)) if entry.in_use => format!(
            "{stands}, but not at {was}, which is in use: these runs say {now}; `beeline apply` writes it"
        ),
        Some((was, now, true)) => format!(
            "{stands}, but not at {was}: these runs say {now}; `beeline model fit` fits it anew"
        ),
        Some((was, now, false)) if entry.in_use => {
            format!("{stands}, compensated: {was} is in use, these runs say {now}")
        }
        _ => stands,
    }
}

fn effect(number: usize, step: &StepFound, combination: Option<&str>, subject: &Subject<'_>) {
    let title = step.class.iter().map(String::as_str).collect::<Vec<_>>().join(" = ");
    say(format_args!("{number}  {}", paint(BOLD, title)));
    let put = |words: &str| {
        wrapped(words, LINE - 3).iter().for_each(|line| say(format_args!("   {line}")))
    };
    let facts = subject.facts(&step.effect);
    if let Some(facts) = facts {
        say(format_args!("   {}", paint(DIM, facts.equation)));
    }
    parameters(&step.parameters, 3);
    put(&format!("Why: {}.", words::why(step).trim_end_matches('.')));
    if step.class.len() > 1 {
        let common = combination
            .map_or_else(String::new, |it| format!(" Together: {it}, of whatever cause."));
        let words = format!("These runs cannot tell {} apart.{common}", step.class.join(", "));
        wrapped(&words, LINE - 3)
            .iter()
            .for_each(|line| say(format_args!("   {}", paint(WARN, line))));
    } else if let Some(it) = combination {
        put(&format!("In these runs: {it}."));
    }
    if let Some(facts) = facts.filter(|it| !it.compensation.is_empty()) {
        let which = if step.class.len() > 1 {
            format!(", if it is {}", step.effect)
        } else {
            String::new()
        };
        put(&format!("What can be done{which}: {}.", facts.compensation));
    }
}

/// Prints values with their 95 % intervals, a line each.
pub fn parameters(parameters: &[ParameterFound], indent: usize) {
    let mut table = Table::new("lll");
    for it in parameters {
        table.row([
            Cell::styled(DIM, &it.name),
            friendly(it.value, it.sigma, &it.unit).into(),
            Cell::styled(
                DIM,
                format!(
                    "95 %: {}",
                    friendly_interval(it.value, it.sigma, (it.low95, it.high95), &it.unit)
                ),
            ),
        ]);
    }
    table.say(indent);
}

fn unexplained(answer: &Answer) {
    let it = &answer.unexplained;
    if it.structure {
        say(paint(
            WARN,
            format_args!(
                "Still unexplained: an unknown effect that depends on {}",
                words::depends_on(it)
            ),
        ));
        say(format_args!(
            "   by chance as much with {}; `beeline report` shows its shape",
            p_value(it.p_value)
        ));
    } else {
        say(format_args!(
            "{}: what is left depends on nothing that was asked about ({})",
            paint(BOLD, "Nothing else"),
            p_value(it.p_value)
        ));
    }
}

fn next_run(answer: &Answer, subject: &Subject<'_>) {
    match &answer.next_run {
        Some(next) => {
            say(paint(BOLD, format_args!("Next: record {}", next.kind.name())));
            let words = format!(
                "It tells {} apart: {}.",
                next.separates.join(", "),
                words::promise(&next.promise)
            );
            wrapped(&words, LINE - 3).iter().for_each(|line| say(format_args!("   {line}")));
            let gyro = gyro_words(next).unwrap_or_default();
            wrapped(gyro, LINE - 3).iter().for_each(|line| say(format_args!("   {line}")));
            say(format_args!("   {}", next_run_command(next, subject)));
        }
        None => wrapped(&no_next_run(answer), LINE).iter().for_each(say),
    }
}

#[cfg(test)]
mod tests {
    use robot_model::estimation::ErrorPair;
    use robot_model::explain::Why;
    use robot_model::residuals::Unexplained;

    use super::*;

    fn errors(mm: f64, mrad: f64) -> Errors {
        Errors { position_rms_m: mm * 1e-3, heading_rms_rad: mrad * 1e-3, chi: 1.0 }
    }

    fn answer(class: &[&str], from: Errors, to: Errors) -> Answer {
        let step = StepFound {
            effect: class[0].into(),
            class: class.iter().map(|it| (*it).to_owned()).collect(),
            parameters: Vec::new(),
            train: to,
            cross_validated: to,
            p_value: 1e-9,
            why: Why::default(),
        };
        Answer {
            known: Vec::new(),
            baseline: ErrorPair { train: from, cross_validated: from },
            steps: vec![step],
            rejected: Vec::new(),
            unexplained: Unexplained {
                structure: false,
                depends_on: Vec::new(),
                p_value: 0.5,
                place_m: None,
                places: Vec::new(),
            },
            next_run: None,
            held_out: None,
        }
    }

    fn said(runs: usize, from: Errors, to: Errors) -> String {
        let subject = Subject {
            robot: "r",
            campaign: "r",
            reached: "--port sim",
            runs,
            catalogue: &[],
            combinations: &[],
            in_model: &[],
        };
        headline(&answer(&["gyro_bias"], from, to), &subject)
    }

    #[test]
    fn what_the_error_does_is_said_as_it_is() {
        for (runs, from, to, expected) in [
            (5, errors(25.8, 61.2), errors(5.0, 9.0), "on runs held out falls from 25.8 mm, 61.2"),
            (5, errors(25.8, 61.2), errors(25.8, 61.2), "held out stays at 25.8 mm, 61.2 mrad."),
            (5, errors(25.81, 61.2), errors(25.79, 61.2), "held out stays at 25.8 mm, 61.2 mrad."),
            (5, errors(5.0, 9.0), errors(5.5, 9.0), "rises from 5.0 mm, 9.0 mrad to 5.5 mm"),
            (5, errors(5.0, 9.0), errors(4.5, 9.1), "goes from 5.0 mm, 9.0 mrad to 4.5 mm"),
            (1, errors(5.0, 9.0), errors(4.5, 8.0), "on the run fitted to falls from 5.0 mm"),
        ] {
            let headline = said(runs, from, to);
            assert!(headline.contains(expected), "{headline}\n  does not say: {expected}");
        }
    }

    #[test]
    fn effects_that_no_run_tells_apart_are_named() {
        let here = errors(5.0, 9.0);
        assert!(no_next_run(&answer(&["scrub"], here, here)).contains("No further run"));
        let said = no_next_run(&answer(&["scrub", "slope", "side_slip"], here, here));
        assert_eq!(said, "No run that is known here would tell scrub from slope, side_slip.");
    }
}
