//! `beeline calibrate`

use std::path::Path;

use robot_model::Source;
use serde_json::{Value, json};
use sim_target::Lab;

use super::drive::straight;
use super::identify::display_name;
use super::wheel_weight;
use crate::calibrate::{
    Checks, Decision, Drive, Instrument, Measurement, Outcome, Settings, Step, Undo, calibrate,
    state_folder,
};
use crate::cli::{CalibrateArgs, Common, Measure, Method};
use crate::error::{Error, Result};
use crate::file::{check_writable, write_whole};
use crate::picture::{CalibrationReport, ProfileNumbers, to_html, to_svg};
use crate::port::with_robot;
use crate::quantity::{LengthUnit, plus_minus};
use crate::ui::{BOLD, DIM, GOOD, Progress, WARN, note, paint, say, warn};

pub(super) fn run(common: &Common, args: &CalibrateArgs) -> Result<()> {
    if args.undo {
        return undo(common);
    }
    if args.method == Method::Umbmark {
        return super::umbmark::run(common, args);
    }
    check_ending(&args.output)?;
    // Before the robot moves: a picture that cannot be written must not cost a calibration.
    check_writable(&args.output)
        .map_err(|error| cannot_draw(&args.output, error).hint("-o FILE puts it elsewhere"))?;
    let outcome = with_robot(&common.port, &common.sim(), async |session, lab| {
        let config = session.read_config().await?;
        let settings = Settings {
            motion: straight(args.distance, &args.profile, &config),
            tolerance: args.tolerance / 100.0,
            start_heading_sigma_rad: args.start_heading.rad,
            out_and_back: args.out_and_back,
            runs: args.runs.unwrap_or(1),
        };
        let remembers = !common.port.is_sim() || common.flash.is_some();
        let mut instrument = instrument(args, lab)?;
        let mut teller = Teller::new(common, &settings, args);
        let outcome =
            calibrate(session, &mut instrument, &settings, &mut |step| teller.tell(step)).await?;
        if let (Decision::Corrected(_), true) = (&outcome.decision, remembers) {
            remember(&outcome)?;
        }
        Ok(outcome)
    })?;
    finish(common, args, outcome)
}

fn check_ending(output: &Path) -> Result<()> {
    let ending = output.extension().unwrap_or_default();
    if ["html", "htm", "svg"].iter().any(|known| ending.eq_ignore_ascii_case(known)) {
        return Ok(());
    }
    Err(Error::new(format_args!("the picture {} must end in .html or .svg", output.display()))
        .hint("-o calibration.svg"))
}

fn cannot_draw(file: &Path, error: impl std::fmt::Display) -> Error {
    Error::new(format_args!("cannot write the picture {}: {error}", file.display()))
}

fn undo(common: &Common) -> Result<()> {
    if common.port.is_sim() && common.flash.is_none() {
        return Err(Error::new(
            "this simulated robot forgets when the command ends: nothing to undo",
        )
        .hint(
            "give it a memory with --flash FILE, or run `beeline sim --listen` and use that port",
        ));
    }
    let folder = state_folder()?;
    let undone = with_robot(&common.port, &common.sim(), async |session, _| {
        let identity = session.identify().await?;
        let undo = Undo::recall(&folder, &identity)?;
        undo.carry_out(session, &folder, &identity).await?;
        Ok(undo)
    })?;
    if common.json {
        say(json!({"undone": {"wheel_weight": undone.before, "was": undone.after}}));
    } else {
        say(format_args!("W_T is {} again, as before the last calibration; saved", undone.before));
    }
    Ok(())
}

fn remember(outcome: &Outcome) -> Result<()> {
    let Decision::Corrected(after) = &outcome.decision else { return Ok(()) };
    let undo = Undo {
        robot: display_name(&outcome.checks.identity),
        before: outcome.before.run.driven_with,
        after: after.run.driven_with,
    };
    let kept = state_folder().and_then(|folder| undo.remember(&folder, &outcome.checks.identity));
    if let Err(error) = kept {
        // The calibration itself is good and saved.
        warn(format_args!("--undo will not know of this calibration: {error}"));
    }
    Ok(())
}

pub(super) fn instrument(args: &CalibrateArgs, lab: Option<Lab>) -> Result<Instrument> {
    let measure = args.measure.clone().unwrap_or(match lab {
        Some(_) => Measure::Camera,
        None => Measure::Ask,
    });
    let confirm = !args.yes;
    match (measure, lab) {
        (Measure::Camera, Some(lab)) => Ok(Instrument::Camera(lab, 0)),
        (Measure::Ruler, Some(lab)) => Ok(Instrument::Ruler(lab)),
        (Measure::Camera | Measure::Ruler, None) => {
            Err(Error::new("camera and ruler belong to the simulator in this process (--port sim)")
                .hint("--measure ask, or --measure track:FILE"))
        }
        (Measure::Nobody, _) => Err(Error::new("a calibration needs a measurement")
            .hint("--measure ask, or --measure track:FILE")),
        (Measure::Ask, _) => Ok(Instrument::Person { resolution_m: args.ruler.m, confirm }),
        (Measure::Track(path), _) => Ok(Instrument::TrackFile {
            path,
            position_sigma_m: args.position_sigma.m,
            heading_sigma_rad: args.heading_sigma.rad,
            confirm,
            seen: 0,
        }),
    }
}

/// Tells the user what is going on.
struct Teller {
    quiet: bool,
    forgets: bool,
    distance: String,
    /// Drives with the W_T that was there.
    drives: u32,
    progress: Option<Progress>,
}

impl Teller {
    fn new(common: &Common, settings: &Settings, args: &CalibrateArgs) -> Self {
        let radius_free = match args.distance {
            crate::quantity::Distance::Wheel(rad) => format!("{} rev", rad / std::f64::consts::TAU),
            crate::quantity::Distance::Ground(m) => format!("{m} m"),
        };
        let distance = format!("{radius_free}, {:.1} s", settings.motion.duration_s());
        let forgets = common.port.is_sim() && common.flash.is_none();
        Self { quiet: common.json, forgets, distance, drives: 0, progress: None }
    }

    fn tell(&mut self, step: Step<'_>) {
        if self.quiet {
            return;
        }
        match step {
            Step::Checked(checks) => self.checked(checks),
            Step::Driving(which, share) => {
                let title = match which {
                    Drive::Before => "driving",
                    Drive::Back => "driving back",
                    Drive::After => "driving with the new W_T",
                };
                self.progress.get_or_insert_with(|| Progress::new(title, false)).set(share);
            }
            Step::Measured(which, measurement) => {
                self.progress = None;
                self.drives += u32::from(which == Drive::Before);
                self.measured(which, measurement);
            }
            Step::OutAndBack(both, back) => {
                note(format_args!("  way back   turned by {:+.1} mrad", -back.alpha_rad * 1e3));
                note(format_args!("  verdict    {}", both.verdict.sentence()));
                note(format_args!(
                    "  W_T        {}",
                    plus_minus(both.wheel_weight, both.wheel_weight_sigma)
                ));
            }
            Step::Written(value) => {
                note(format_args!("  written    W_T {value:.6}, read back"));
                note(paint(BOLD, "Driving again"));
            }
            Step::Saved if self.forgets => {
                note(
                    "  saved      (a simulated robot without --flash FILE forgets when this ends)",
                );
            }
            Step::Saved => note("  saved      survives power-off"),
        }
    }

    fn checked(&self, checks: &Checks) {
        let config = &checks.config;
        note(paint(BOLD, format_args!("Calibrating {}", display_name(&checks.identity))));
        note(format_args!(
            "  link       {} of {} answered, {} asked again",
            checks.asked, checks.asked, checks.repeated
        ));
        note(format_args!("  supply     {:.2} V", checks.supply_v));
        if checks.identity.unsaved {
            warn(
                "what was changed and not saved is dropped: a calibration starts from the saved configuration",
            );
        }
        note(format_args!(
            "  geometry   wheels {}, track {}, W_T {:.6}",
            LengthUnit::Cm.format(config.geometry.wheel_radius_m, 2),
            LengthUnit::Cm.format(config.geometry.track_width_m, 2),
            config.geometry.wheel_weight
        ));
        note(paint(BOLD, format_args!("Driving {}", self.distance)));
    }

    fn measured(&self, which: Drive, measurement: &Measurement) {
        let end = measurement.run.end;
        let side = if end.lateral_offset_m < 0.0 { "right" } else { "left" };
        let off = LengthUnit::Mm.format(end.lateral_offset_m.abs(), 1);
        let heading_mrad = end.heading_rad * 1e3;
        match which {
            Drive::Before => {
                if self.drives == 1 {
                    note("  encoders   run with their motors");
                }
                note(format_args!(
                    "  before     {off} to the {side}, heading {heading_mrad:+.1} mrad"
                ));
                let weight = &measurement.wheel_weight;
                note(format_args!("  W_T        {}", plus_minus(weight.value, weight.sigma)));
                if (weight.value - 1.0).abs() > 0.03 {
                    warn(
                        "wheels that differ by more than 3 % are rare: are counts_per_rev, gear_reduction and the signs right?",
                    );
                }
            }
            // What it says takes both ways: see the verdict.
            Drive::Back => {}
            Drive::After => {
                note(format_args!(
                    "  after      {off} to the {side}, heading {heading_mrad:+.1} mrad"
                ));
            }
        }
    }
}

fn finish(common: &Common, args: &CalibrateArgs, outcome: Outcome) -> Result<()> {
    let after = match &outcome.decision {
        Decision::Corrected(after) => Some(after),
        Decision::NotBetter(after) => {
            let change =
                mm(outcome.before.run.end.lateral_offset_m, after.run.end.lateral_offset_m);
            return Err(Error::said_no(format_args!(
                "the new W_T made it no better ({change}); the old one is back"
            ))
            .hint("is the start line-up good enough? --out-and-back tells a pull from a radius"));
        }
        Decision::CannotTell => return Err(cannot_tell(&outcome)),
        Decision::AlreadyStraight | Decision::NotARadius => None,
    };
    if let Some(after) = after {
        let report = report(common, args, &outcome, after);
        write_whole(&args.output, draw(&report, &args.output).as_bytes()).map_err(|error| {
            cannot_draw(&args.output, error).hint("the calibration itself is done and saved")
        })?;
    }
    if common.json {
        say(to_json(&outcome, after, &args.output));
        return Ok(());
    }
    let weight = outcome.wheel_weight;
    match after {
        Some(after) => {
            let (before_m, after_m) =
                (outcome.before.run.end.lateral_offset_m, after.run.end.lateral_offset_m);
            say("");
            say(table(&outcome, after));
            say("");
            say(format_args!("{} {}", paint(GOOD, "Drives straight:"), mm(before_m, after_m)));
            say(format_args!("  W_T      {}", plus_minus(weight.value, weight.sigma)));
            advise(&outcome);
            say(format_args!("  picture  {}", paint(BOLD, args.output.display())));
            next_steps(common);
        }
        None if matches!(outcome.decision, Decision::NotARadius) => {
            say(format_args!(
                "{} the path bends, but by a pull, not by the wheels: W_T would only hide it. Nothing was changed.",
                paint(WARN, "Not a radius:")
            ));
            say("  look at the caster, the floor's slope, and a brake or tyre that drags");
        }
        None => {
            say(format_args!(
                "{} W_T {:.6} is inside the 95 % interval of the measured {}. Nothing was changed.",
                paint(GOOD, "Straight already:"),
                outcome.before.run.driven_with,
                plus_minus(weight.value, weight.sigma)
            ));
            advise(&outcome);
        }
    }
    Ok(())
}

/// What would make W_T more certain, one thought a line.
fn advise(outcome: &Outcome) {
    if outcome.wheel_weight.sigma != outcome.before.wheel_weight.sigma {
        // The advice is about one run by itself; this came of several, or of both ways.
        return;
    }
    for thought in outcome.before.wheel_weight.what_would_reduce_it_most().to_string().split("; ") {
        say(format_args!("           {thought}"));
    }
    if outcome.before.wheel_weight.what_would_reduce_it_most().dominating == Source::Wander {
        say("           beeline calibrate --runs 4 does that");
    }
}

fn cannot_tell(outcome: &Outcome) -> Error {
    let weight = outcome.wheel_weight;
    let off = LengthUnit::Mm.format(outcome.before.run.end.lateral_offset_m.abs(), 1);
    Error::said_no(format_args!(
        "cannot tell: {off} off the line, but this measurement says W_T = {} and so does not exclude the {} in use; nothing was changed",
        plus_minus(weight.value, weight.sigma),
        outcome.before.run.driven_with
    ))
    .hint(outcome.before.wheel_weight.what_would_reduce_it_most())
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
            (|run| format!("{:.6}", run.driven_with)) as fn(&crate::picture::RunReport) -> String,
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

fn next_steps(common: &Common) {
    let port =
        if common.port.is_sim() { String::new() } else { format!(" --port {}", common.port) };
    let suggestions = if common.port.is_sim() {
        [
            ("calibrate --seed 7 --measure ruler", "another robot, measured with a ruler"),
            ("calibrate --out-and-back", "is it the radius at all?"),
            ("calibrate --port /dev/ttyACM0", "a real one"),
        ]
        .to_vec()
    } else {
        vec![
            ("drive straight 8rev", "look along the line"),
            ("calibrate --undo", "put the old W_T back"),
        ]
    };
    let width =
        suggestions.iter().map(|(command, _)| command.len() + port.len()).max().unwrap_or(0);
    say("\nWhat to try next:");
    for (command, why) in suggestions {
        let command = format!("{command}{port}");
        say(format_args!("  beeline {command:<width$}   {}", paint(DIM, why)));
    }
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
        date: None,
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
    }
}

fn to_json(outcome: &Outcome, after: Option<&Measurement>, picture: &Path) -> Value {
    let run = |measurement: &Measurement| {
        let end = measurement.run.end;
        let mut value = wheel_weight::to_json(&measurement.wheel_weight, &outcome.geometry);
        value["driven_with"] = json!(measurement.run.driven_with);
        value["lateral_offset_m"] = json!(end.lateral_offset_m);
        value["heading_rad"] = json!(end.heading_rad);
        value
    };
    let decision = match &outcome.decision {
        Decision::Corrected(_) => "corrected",
        Decision::AlreadyStraight => "already_straight",
        Decision::CannotTell => "cannot_tell",
        Decision::NotARadius => "not_a_radius",
        Decision::NotBetter(_) => "not_better",
    };
    json!({
        "robot": outcome.checks.identity.name.as_str(),
        "decision": decision,
        "wheel_weight": {
            "value": outcome.wheel_weight.value,
            "sigma": outcome.wheel_weight.sigma,
        },
        "before": run(&outcome.before),
        "after": after.map(run),
        "out_and_back": outcome.out_and_back.map(|both| json!({
            "verdict": format!("{:?}", both.verdict).to_lowercase(),
            "wheel_weight": both.wheel_weight,
            "wheel_weight_sigma": both.wheel_weight_sigma,
            "pull_rad_per_m": both.pull_rad_per_m,
            "pull_sigma_rad_per_m": both.pull_sigma_rad_per_m,
        })),
        "picture": after.map(|_| picture),
    })
}
