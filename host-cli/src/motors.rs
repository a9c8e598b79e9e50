//! What the motors lack, in words.
//!
//! The answer is computed in `robot_model::drivetrain`; here it becomes sentences and tables.

use robot_model::drivetrain::{
    BaselineErrors, Estimate, KnownMotorEffect, MotorAnswer, MotorErrors, MotorStep,
};

use crate::ui::{BOLD, DIM, GOOD, WARN, paint, say};

pub use findings::words::motors::{
    WORTH_A_WORD, kind_id, kind_in_words, regressor_id, regressor_in_words, verdict,
};

/// So many of the effects that were tried are listed.
const LISTED: usize = 6;

/// Prints how far the model is off, with the effects that it has.
pub fn show_comparison(found: &BaselineErrors, names: &[&str], effects: &[&str]) {
    let BaselineErrors { errors, each_m, resolution_m, .. } = found;
    let times = errors.cross_validated_m / resolution_m;
    let with = match effects {
        [] => "the same kS, kV and kA for both".to_owned(),
        effects => format!("kS, kV, kA and {}", effects.join(", ")),
    };
    say(format_args!(
        "The model of the motors, with {with}, is off by {}.",
        paint(BOLD, millimetres(errors.cross_validated_m))
    ));
    say(format_args!(
        "Each experiment is predicted from its voltages, with the constants that the other {} give.",
        names.len().saturating_sub(1)
    ));
    say(format_args!(
        "The resolution of the counts hides {}{}.",
        millimetres(*resolution_m),
        if times > WORTH_A_WORD {
            format!(": the error is {times:.1} times that")
        } else {
            ", and nothing stands out above that".into()
        }
    ));
    show_held_out(errors);
    say("");
    show_constants(&found.constants);
    say("");
    say(format_args!("{}{:>11}", paint(DIM, format_args!("{:<24}", "experiment")), "off by [mm]"));
    let mut rows: Vec<_> = names.iter().zip(each_m).collect();
    rows.sort_by(|a, b| b.1.total_cmp(a.1));
    for (name, off_m) in rows {
        say(format_args!("{name:<24}{:>11.3}", off_m * 1e3));
    }
    if times > WORTH_A_WORD {
        say("");
        say("`beeline explain --drivetrain` says what is missing.");
    }
}

/// Prints what is missing.
pub fn show_answer(answer: &MotorAnswer) {
    say(paint(
        if answer.steps.is_empty() && !answer.unexplained.structure { GOOD } else { BOLD },
        verdict(answer),
    ));
    show_held_out(answer.steps.last().map_or(&answer.baseline, |step| &step.errors));
    for (index, step) in answer.steps.iter().enumerate() {
        say("");
        show_step(index + 1, step);
    }
    say("");
    show_constants(&answer.constants);
    say("");
    let head = paint(DIM, format_args!("{:<20}", "each effect alone"));
    say(format_args!("{head}{:>11}", "error [mm]"));
    let baseline_m = answer.baseline.cross_validated_m;
    say(format_args!("{:<20}{:>11.3}", "none", baseline_m * 1e3));
    for tried in answer.tried.iter().take(LISTED) {
        let times = tried.cross_validated_m * 1e3;
        say(format_args!(
            "{:<20}{times:>11.3}  {}",
            tried.effect.facts().id,
            tried.effect.facts().name
        ));
    }
    say(paint(
        DIM,
        "Errors are of experiments predicted by the others; those of this table to first order.",
    ));
    say("");
    let unexplained = &answer.unexplained;
    if unexplained.structure {
        let by: Vec<_> = unexplained.depends_on.iter().map(|by| regressor_in_words(*by)).collect();
        say(format_args!(
            "{} {} that no effect here explains. It depends on {}; explained, it would leave an error of {}.",
            paint(WARN, "unexplained:"),
            millimetres(unexplained.size_m),
            by.join(", "),
            millimetres(unexplained.floor_m)
        ));
    } else {
        say(
            "Flexible functions of speed, voltage, load, angle and time do not predict these experiments better.",
        );
    }
    if let Some(next) = &answer.next {
        let why = match next.separates.as_slice() {
            [] => "shows what the unexplained part depends on".into(),
            effects => format!("tells {} apart", ids(effects).join(" and ")),
        };
        say(format_args!("next: {}: {why}.", kind_in_words(next.kind)));
    }
}

fn show_step(number: usize, step: &MotorStep) {
    let facts = step.effect.facts();
    say(format_args!("{number}  {}  {}", paint(BOLD, facts.id), facts.name));
    say(format_args!("   {}", facts.equation));
    for parameter in &step.parameters {
        say(format_args!("   {}", estimate(parameter)));
    }
    say(format_args!("   positive: {}", facts.sign));
    say(format_args!(
        "   the error falls to {}; chance alone does that in one of {:.0} campaigns",
        millimetres(step.errors.cross_validated_m),
        1.0 / step.p_value
    ));
    if !step.class.is_empty() {
        let class = ids(&step.class).join(", ");
        say(format_args!("   {} {class}", paint(WARN, "these experiments cannot tell it from:")));
    }
    say(format_args!("   what to do: {}", facts.remedy));
}

/// Ids of effects.
pub(crate) fn ids(effects: &[KnownMotorEffect]) -> Vec<&str> {
    effects.iter().map(|effect| effect.facts().id).collect()
}

fn show_constants(constants: &[Estimate]) {
    for constant in constants {
        say(estimate(constant));
    }
}

fn show_held_out(errors: &MotorErrors) {
    if let Some(held_out_m) = errors.held_out_m {
        say(format_args!("On held-out runs the error is {}.", millimetres(held_out_m)));
    }
}

/// `kS  0.501 ± 0.002 V`
pub(crate) fn estimate(estimate: &Estimate) -> String {
    let &Estimate { ref name, ref unit, value, half_width_95 } = estimate;
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    if !half_width_95.is_finite() {
        return format!("{name}  {value:.3}{unit}, from a single experiment");
    }
    if half_width_95 == 0.0 {
        return format!("{name}  {value:.3}{unit}, of which these experiments tell nothing");
    }
    // Two digits of the half-width.
    let digits = (1.0 - half_width_95.log10().floor()).clamp(0.0, 7.0) as usize;
    format!("{name}  {value:.digits$} ± {half_width_95:.digits$}{unit}")
}

pub(crate) fn millimetres(length_m: f64) -> String {
    format!("{:.2} mm", length_m * 1e3)
}
