//! What the motors lack, in words.
//!
//! The answer is computed in `robot_model::drivetrain`; here it becomes sentences and tables.

use std::path::Path;

use robot_model::drivetrain::{
    BaselineErrors, Estimate, KnownMotorEffect, MotorAnswer, MotorErrors, MotorParameter,
    MotorRole, MotorStep,
};

use crate::escape::shell_path;
use crate::ui::{BOLD, DIM, GOOD, WARN, paint, say};

pub use findings::words::motors::{
    WORTH_A_WORD, kind_id, kind_in_words, regressor_id, unexplained_in_words, verdict,
};

/// So many of the effects that were tried are listed.
const LISTED: usize = 6;

/// Prints how far the model is off, with the effects that it has.
pub fn show_comparison(found: &BaselineErrors, names: &[&str], effects: &[&str], campaign: &Path) {
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
        let campaign = shell_path(campaign);
        say(format_args!("`beeline explain --drivetrain {campaign}` says what is missing."));
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
        "Errors are of experiments predicted by the others; those of this table to first order. Named above is what is best when fitted in full.",
    ));
    say("");
    match unexplained_in_words(answer) {
        Some(words) => say(format_args!("{} {words}", paint(WARN, "unexplained:"))),
        None => say(
            "Flexible functions of speed, voltage, load, angle and time do not predict these experiments better.",
        ),
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
    if let Some(words) = holds_zero(facts.parameters, &step.parameters) {
        say(paint(DIM, format_args!("   {words}")));
    }
    say(format_args!("   positive: {}", facts.sign));
    say(format_args!(
        "   the error falls to {}; chance alone does that in {}",
        millimetres(step.errors.cross_validated_m),
        chance_alone(step.p_value)
    ));
    if !step.class.is_empty() {
        let class = ids(&step.class).join(", ");
        say(format_args!("   {} {class}", paint(WARN, "these experiments cannot tell it from:")));
    }
    say(format_args!("   what to do: {}", facts.remedy));
}

/// What to say of an effect that is beyond chance although an interval of its amplitudes holds zero.
pub(crate) fn holds_zero(facts: &[MotorParameter], found: &[Estimate]) -> Option<String> {
    let is_of_zero = |(known, found): &(&MotorParameter, &Estimate)| {
        known.role == MotorRole::Amplitude && found.value.abs() < found.half_width_95
    };
    let mut names = facts.iter().zip(found).filter(is_of_zero).map(|(known, _)| &*known.name);
    let first = names.next()?;
    let names = names.fold(first.to_owned(), |names, name| format!("{names}, {name}"));
    Some(format!(
        "the interval of {names} holds zero: kinds of experiments disagree about the size, not about whether it is there"
    ))
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
    let &Estimate { ref name, ref unit, value, half_width_95, is_at_end } = estimate;
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    let end = if is_at_end { ", at the end of its range" } else { "" };
    if !half_width_95.is_finite() {
        return format!("{name}  {}{unit}, from a single experiment{end}", three_digits(value));
    }
    if half_width_95 == 0.0 {
        let value = three_digits(value);
        return format!("{name}  {value}{unit}, of which these experiments tell nothing{end}");
    }
    if !(1e-5..1e6).contains(&half_width_95) {
        return format!("{name}  {} ± {half_width_95:.1e}{unit}{end}", three_digits(value));
    }
    // Two digits of the half-width.
    let digits = (1.0 - half_width_95.log10().floor()).clamp(0.0, 7.0) as usize;
    let shown = format!("{value:.digits$}");
    let shown = if shown.bytes().any(|byte| byte.is_ascii_digit() && byte != b'0') {
        shown
    } else {
        // No minus before zero.
        format!("{:.digits$}", 0.0)
    };
    format!("{name}  {shown} ± {half_width_95:.digits$}{unit}{end}")
}

/// Three digits after the point, or a power of ten where they would not do.
fn three_digits(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        0.01..1e6 => format!("{value:.3}"),
        _ => format!("{value:.2e}"),
    }
}

/// How rarely chance does it, as the test can tell: by 4000 draws of signs.
pub(crate) fn chance_alone(p_value: f64) -> String {
    const DRAWS: f64 = 4000.0;
    if p_value * DRAWS < 1.5 {
        format!("less than one of {DRAWS:.0} campaigns")
    } else {
        format!("one of {:.0} campaigns", 1.0 / p_value)
    }
}

pub(crate) fn millimetres(length_m: f64) -> String {
    format!("{:.2} mm", length_m * 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_their_half_widths_leave() {
        let told = |value: f64, half_width_95: f64, is_at_end: bool| {
            let (name, unit) = ("k".into(), "V".into());
            estimate(&Estimate { name, unit, value, half_width_95, is_at_end })
        };
        assert_eq!(told(0.5012, 0.0021, false), "k  0.5012 ± 0.0021 V");
        assert_eq!(told(-0.3, 56.0, false), "k  0 ± 56 V");
        assert_eq!(told(2e-9, 3.2e-10, false), "k  2.00e-9 ± 3.2e-10 V");
        assert_eq!(
            told(-5_876_613.0, 8.6e6, true),
            "k  -5.88e6 ± 8.6e6 V, at the end of its range"
        );
        assert_eq!(told(0.0, 0.0, false), "k  0 V, of which these experiments tell nothing");
        assert_eq!(told(1.0, f64::INFINITY, false), "k  1.000 V, from a single experiment");
        assert_eq!(chance_alone(1.0 / 4001.0), "less than one of 4000 campaigns");
        assert_eq!(chance_alone(0.004), "one of 250 campaigns");
        let known = [MotorParameter::amplitude("k", "V", 0.3, 24.0)];
        let found = |value: f64| Estimate {
            name: "k".into(),
            unit: "V".into(),
            value,
            half_width_95: 0.49,
            is_at_end: false,
        };
        assert_eq!(holds_zero(&known, &[found(0.6)]), None);
        assert!(
            holds_zero(&known, &[found(0.24)])
                .is_some_and(|words| words.contains("of k holds zero"))
        );
    }
}
