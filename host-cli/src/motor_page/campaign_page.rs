//! The page of a campaign of motors: what is missing in their model.

use std::fmt::Write;

use campaign::MotorRun;
use robot_model::drivetrain::{BaselineErrors, MotorAnswer};

use super::{begin, experiments, section, table};
use crate::escape::html as escape;
use crate::motors::{chance_alone, estimate, ids, millimetres, unexplained_in_words, verdict};

/// So many of the effects that were tried are listed.
const LISTED: usize = 16;

/// The page.
pub fn of_campaign(
    name: &str,
    runs: &[MotorRun],
    baseline: &BaselineErrors,
    answer: &MotorAnswer,
) -> String {
    let mut html = begin(name, "what its motors lack");
    let _ = writeln!(
        html,
        "<p class=\"sub\">{} \u{b7} {} experiments</p>\n<h1>{}</h1>",
        escape(name),
        runs.len(),
        escape(&verdict(answer))
    );
    effects(&mut html, answer);
    section(
        &mut html,
        "Each effect alone",
        "The error of experiments that are predicted by the others, to first order, with one effect beside kS, kV and kA.",
    );
    let none =
        vec!["none".to_owned(), String::new(), millimetres(answer.baseline.cross_validated_m)];
    let tried = answer.tried.iter().take(LISTED).map(|tried| {
        let off = millimetres(tried.cross_validated_m);
        let facts = tried.effect.facts();
        vec![facts.id.to_owned(), facts.name.to_owned(), off]
    });
    table(&mut html, &["effect", "", "error"], std::iter::once(none).chain(tried));
    section(&mut html, "The constants", "With the effects above.");
    let constants = answer.constants.iter().map(|constant| vec![estimate(constant)]);
    table(&mut html, &["constant, \u{b1} half a 95 % interval"], constants);
    measured_and_modelled(&mut html, runs, baseline, answer);
    html.push_str("</body></html>\n");
    html
}

fn effects(html: &mut String, answer: &MotorAnswer) {
    for (index, step) in answer.steps.iter().enumerate() {
        let facts = step.effect.facts();
        let _ = write!(
            html,
            "<div class=\"card\"><h3><span class=\"n\">{}</span>{}</h3><p><code>{}</code></p>",
            index + 1,
            escape(facts.name),
            escape(facts.equation)
        );
        for parameter in &step.parameters {
            let _ = write!(html, "<p>{}</p>", escape(&estimate(parameter)));
        }
        let _ = write!(
            html,
            "<p>The error is {} with it; chance alone does that in {}.</p>",
            millimetres(step.errors.cross_validated_m),
            chance_alone(step.p_value)
        );
        if !step.class.is_empty() {
            let class = ids(&step.class).join(", ");
            let _ = write!(
                html,
                "<p class=\"class\">These experiments cannot tell it from: {}.</p>",
                escape(&class)
            );
        }
        let _ = writeln!(html, "<p>What to do: {}.</p></div>", escape(facts.remedy));
    }
    if let Some(words) = unexplained_in_words(answer) {
        let _ = writeln!(html, "<p class=\"class\">Unexplained: {}</p>", escape(&words));
    }
}

fn measured_and_modelled(
    html: &mut String,
    runs: &[MotorRun],
    baseline: &BaselineErrors,
    answer: &MotorAnswer,
) {
    let words = match answer.steps.is_empty() {
        true => {
            "Measured less modelled travel, with the constants above; the largest errors of the table's first row first. Where a curve leaves zero, something is missing."
        }
        false => {
            "Measured less modelled travel, with the effects above; pale, without them. The largest errors of the table's first row first. Where a curve still leaves zero, something is missing."
        }
    };
    section(html, "Measured and modelled", words);
    let fitted = runs.iter().filter(|run| !run.experiment.held_out);
    let mut worst: Vec<_> = fitted.zip(&answer.left).zip(baseline.each_m.iter().copied()).collect();
    worst.sort_by(|a, b| b.1.total_cmp(&a.1));
    experiments::legend(html);
    for ((run, left), _) in worst {
        let pale = (!answer.steps.is_empty()).then_some(left.baseline_m.as_slice());
        let recording = &run.experiment.recording;
        experiments::draw(html, &run.name, recording, &left.with_effects_m, pale);
    }
    experiments::end(html);
}
