//! The result of a calibration: as text, as JSON, and as a picture.

use std::path::Path;

use serde_json::{Value, json};

use super::next_steps;
use crate::calibrate::{Decision, Measurement, Outcome};
use crate::calibration_page::{CalibrationReport, ProfileNumbers, to_html, to_svg};
use crate::cli::{CalibrateArgs, Common};
use crate::command::drive::straight;
use crate::command::identify::display_name;
use crate::command::wheel_weight;
use crate::error::{Error, Result};
use crate::quantity::{LengthUnit, plus_minus};
use crate::ui::{BOLD, DIM, GOOD, WARN, paint, say, say_text};
use campaign::file::write_whole;

/// The error of a picture that cannot be written.
pub(super) fn cannot_draw(file: &Path, error: impl std::fmt::Display) -> Error {
    Error::new(format_args!("cannot write the picture {}: {error}", file.display()))
}

/// Prints the result, and draws it.
pub(super) fn finish(common: &Common, args: &CalibrateArgs, outcome: Outcome) -> Result<()> {
    let after = match &outcome.decision {
        Decision::Corrected(after) => Some(after),
        Decision::NotBetter(after) => {
            let change = mm(ended_m(&outcome.before), ended_m(after));
            return Err(Error::said_no(format_args!(
                "the new W_T did not reduce the error ({change}); the old one is restored"
            ))
            .hint(next_steps::after_no_better(args))
            .details(to_json(&outcome, None)));
        }
        Decision::NotRepeatable(after, control) => {
            return Err(not_repeatable(&outcome, after, control));
        }
        Decision::CannotTell => return Err(cannot_tell(args, &outcome)),
        Decision::AlreadyStraight | Decision::NotARadius => None,
    };
    let report = after.map(|after| report(common, args, &outcome, after));
    if let Some(report) = &report {
        write_whole(&args.output, draw(report, &args.output).as_bytes()).map_err(|error| {
            cannot_draw(&args.output, error).hint("the calibration itself is done and saved")
        })?;
    }
    if common.json {
        say(to_json(&outcome, Some(&args.output)));
        return Ok(());
    }
    let weight = outcome.wheel_weight;
    match after.zip(report) {
        Some((after, report)) => {
            let (before_m, after_m) =
                (outcome.before.run.end.lateral_offset_m, after.run.end.lateral_offset_m);
            say("");
            say_text(table(&outcome, after));
            say("");
            say(format_args!(
                "{} {}",
                paint(GOOD, format_args!("{}:", report.claim())),
                mm(before_m, after_m)
            ));
            say(format_args!("  W_T      {}", plus_minus(weight.value, weight.sigma)));
            next_steps::advise(&outcome);
            say(format_args!("  picture  {}", paint(BOLD, args.output.display())));
            next_steps::say_steps(common, args);
        }
        None if matches!(outcome.decision, Decision::NotARadius) => {
            say(format_args!(
                "{} a pull, or a caster that kicks on reversing, bends the path: W_T would only hide it. Nothing was changed.",
                paint(WARN, "Not a radius:")
            ));
            say("  check the caster, the floor's slope, and for a brake or tyre that drags");
            say(
                "  the firmware can steer against what remains: `beeline campaign record`, then `beeline apply`",
            );
        }
        None => {
            say(format_args!(
                "{} W_T {:.6} is inside the 95 % interval of the measured {}. Nothing was changed.",
                paint(GOOD, "Straight already:"),
                outcome.before.run.driven_with,
                plus_minus(weight.value, weight.sigma)
            ));
            next_steps::advise(&outcome);
        }
    }
    Ok(())
}

fn not_repeatable(outcome: &Outcome, after: &Measurement, control: &Measurement) -> Error {
    let off = |drive: &Measurement| LengthUnit::Mm.format(ended_m(drive), 1);
    Error::said_no(format_args!(
        "the drives differ by too much for so small a correction ({} off, {} with the new W_T, {} with the old one again); the old one is restored",
        off(&outcome.before),
        off(after),
        off(control)
    ))
    .hint("roll the robot forward onto its line, so that its caster trails, and calibrate again; --runs 4 takes a mean")
    .details(to_json(outcome, None))
}

fn cannot_tell(args: &CalibrateArgs, outcome: &Outcome) -> Error {
    let weight = outcome.wheel_weight;
    let off = LengthUnit::Mm.format(outcome.before.run.end.lateral_offset_m.abs(), 1);
    Error::said_no(format_args!(
        "cannot tell: {off} off the line, but this measurement says W_T = {} and so does not exclude the {} in use; nothing was changed",
        plus_minus(weight.value, weight.sigma),
        outcome.before.run.driven_with
    ))
    .hint(next_steps::after_cannot_tell(args, outcome))
    .details(to_json(outcome, None))
}

/// How far beside the line a drive ended; by the poses at rest, which no model of the path is fitted to \[m\].
fn ended_m(drive: &Measurement) -> f64 {
    drive.offset_m.unwrap_or(drive.run.end.lateral_offset_m)
}

/// The drawing alone for a file whose name ends in .svg, else the whole page.
fn draw(report: &CalibrationReport, output: &Path) -> String {
    let ending = output.extension().unwrap_or_default();
    if ending.eq_ignore_ascii_case("svg") { to_svg(report) } else { to_html(report) }
}

fn mm(before_m: f64, after_m: f64) -> String {
    format!("{:.1} mm off before, {:.1} mm after", before_m.abs() * 1e3, after_m.abs() * 1e3)
}

fn table(outcome: &Outcome, after: &Measurement) -> String {
    let row = |name: &str, before: String, after: String| {
        format!("{name:<22} {before:>12} {after:>12}\n")
    };
    let (before, after) = (&outcome.before.run, &after.run);
    let radius_m = outcome.geometry.wheel_radius_m;
    let mut table = paint(DIM, row("", "before".into(), "after".into()).trim_end()) + "\n";
    for (name, value) in [
        (
            "W_T in use",
            (|run| format!("{:.6}", run.driven_with))
                as fn(&crate::calibration_page::RunReport) -> String,
        ),
        ("lateral offset", |run| format!("{:+.1} mm", run.end.lateral_offset_m * 1e3)),
        ("heading at the end", |run| format!("{:+.2} mrad", run.end.heading_rad * 1e3)),
        ("W_T measured", |run| format!("{:.6}", run.wheel_weight.value)),
        ("  one sigma", |run| format!("{:.6}", run.wheel_weight.sigma)),
    ] {
        table += &row(name, value(before), value(after));
    }
    let radius = |w_t: f64| LengthUnit::Cm.format(radius_m * w_t, 4);
    table += &row("R_R in use", radius(before.driven_with), radius(after.driven_with));
    table.trim_end().into()
}

fn report(
    common: &Common,
    args: &CalibrateArgs,
    outcome: &Outcome,
    after: &Measurement,
) -> CalibrationReport {
    let radius_m = outcome.geometry.wheel_radius_m;
    CalibrationReport {
        robot_name: display_name(&outcome.checks.identity),
        port: common.port.to_string(),
        geometry: outcome.geometry,
        profile: ProfileNumbers {
            acceleration_rev_per_s2: args.profile.acceleration.rev_per_s2(radius_m),
            cruise_rev_per_s: args.profile.cruise.rev_per_s(radius_m),
            distance_m: args.distance.m(radius_m),
            duration_s: straight(args.distance, &args.profile, &outcome.checks.config).duration_s(),
        },
        before: outcome.before.run.clone(),
        after: after.run.clone(),
        out_and_back: outcome.out_and_back,
        wheel_weight: outcome.wheel_weight,
        basis: outcome.basis,
        drives: outcome.drives,
    }
}

/// The result as JSON, with the file of the picture if one was drawn.
fn to_json(outcome: &Outcome, picture: Option<&Path>) -> Value {
    let run = |measurement: &Measurement| {
        let end = measurement.run.end;
        let mut value = wheel_weight::to_json(&measurement.wheel_weight, &outcome.geometry);
        value["driven_with"] = json!(measurement.run.driven_with);
        value["lateral_offset_m"] = json!(end.lateral_offset_m);
        value["heading_rad"] = json!(end.heading_rad);
        value
    };
    let (decision, after) = match &outcome.decision {
        Decision::Corrected(after) => ("corrected", Some(after)),
        Decision::AlreadyStraight => ("already_straight", None),
        Decision::CannotTell => ("cannot_tell", None),
        Decision::NotARadius => ("not_a_radius", None),
        Decision::NotBetter(after) => ("not_better", Some(after)),
        Decision::NotRepeatable(after, _) => ("not_repeatable", Some(after)),
    };
    json!({
        "robot": outcome.checks.identity.name.as_str(),
        "decision": decision,
        "unsaved_changes_dropped": outcome.checks.identity.unsaved,
        "wheel_weight": {
            "value": outcome.wheel_weight.value,
            "sigma": outcome.wheel_weight.sigma,
            "from": outcome.basis.to_string(),
        },
        "drives": outcome.drives,
        "before": run(&outcome.before),
        "after": after.map(run),
        "out_and_back": outcome.out_and_back.map(|both| json!({
            "verdict": format!("{:?}", both.verdict).to_lowercase(),
            "wheel_weight": both.wheel_weight,
            "wheel_weight_sigma": both.wheel_weight_sigma,
            "pull_rad_per_m": both.pull_rad_per_m,
            "pull_sigma_rad_per_m": both.pull_sigma_rad_per_m,
        })),
        "picture": after.and(picture),
    })
}
