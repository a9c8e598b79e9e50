//! `beeline calibrate`

use std::io::Write;
use std::path::Path;

use serde_json::{Value, json};
use sim_target::Lab;
use tempfile::NamedTempFile;

use super::drive::straight;
use super::identify::display_name;
use super::wheel_weight;
use crate::calibrate::{
    Checks, Decision, Drive, Instrument, Measurement, Outcome, Settings, Step, Undo, calibrate,
    state_folder,
};
use crate::cli::{CalibrateArgs, Common, Measure};
use crate::error::{Error, Result};
use crate::picture::{CalibrationReport, ProfileNumbers, to_html};
use crate::port::with_robot;
use crate::quantity::LengthUnit;
use crate::ui::{BOLD, DIM, GOOD, Progress, WARN, note, paint, say, warn};

pub(super) fn run(common: &Common, args: &CalibrateArgs) -> Result<()> {
    if args.undo {
        return undo(common);
    }
    // Before the robot moves: a picture that cannot be written must not cost a calibration.
    let picture = Picture::reserve(&args.output)?;
    let outcome = with_robot(&common.port, &common.sim(), async |session, lab| {
        let config = session.read_config().await?;
        let settings = Settings {
            motion: straight(args.distance, &args.profile, &config),
            tolerance: args.tolerance / 100.0,
            start_heading_sigma_rad: args.start_heading.rad,
            out_and_back: args.out_and_back,
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
    finish(common, args, outcome, picture)
}

fn undo(common: &Common) -> Result<()> {
    if common.port.is_sim() && common.flash.is_none() {
        return Err(Error::new("this simulated robot forgets when the command ends: nothing to undo")
            .hint("give it a memory with --flash FILE, or run `beeline sim --listen` and use that port"));
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

fn instrument(args: &CalibrateArgs, lab: Option<Lab>) -> Result<Instrument> {
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

/// A place for the picture, taken before the robot moves.
struct Picture {
    file: NamedTempFile,
}

impl Picture {
    fn reserve(path: &Path) -> Result<Self> {
        let failed = |error: &dyn std::fmt::Display| {
            Error::new(format_args!("cannot write the picture {}: {error}", path.display()))
                .hint("-o FILE puts it elsewhere")
        };
        if path.is_dir() {
            return Err(failed(&"it is a folder"));
        }
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let file = tempfile::Builder::new()
            .prefix(".beeline-")
            .tempfile_in(folder)
            .map_err(|error| failed(&error))?;
        Ok(Self { file })
    }

    fn write(mut self, path: &Path, html: &str) -> Result<()> {
        let failed = |error: &dyn std::fmt::Display| {
            Error::new(format_args!("cannot write the picture {}: {error}", path.display()))
                .hint("the calibration itself is done and saved")
        };
        self.file.write_all(html.as_bytes()).map_err(|error| failed(&error))?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::Permissions::from_mode(0o644);
            self.file.as_file().set_permissions(mode).map_err(|error| failed(&error))?;
        }
        self.file.persist(path).map_err(|error| failed(&error.error))?;
        Ok(())
    }
}

/// Tells the user what is going on.
struct Teller {
    quiet: bool,
    distance: String,
    progress: Option<Progress>,
}

impl Teller {
    fn new(common: &Common, settings: &Settings, args: &CalibrateArgs) -> Self {
        let radius_free = match args.distance {
            crate::quantity::Distance::Wheel(rad) => format!("{} rev", rad / std::f64::consts::TAU),
            crate::quantity::Distance::Ground(m) => format!("{m} m"),
        };
        let distance = format!("{radius_free}, {:.1} s", settings.motion.duration_s());
        Self { quiet: common.json, distance, progress: None }
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
                self.measured(which, measurement);
            }
            Step::OutAndBack(both) => note(format_args!("  {}", both.verdict.sentence())),
            Step::Written(value) => note(format_args!("  W_T = {value:.6} written and read back")),
            Step::Saved => note("  W_T saved"),
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
        note(format_args!(
            "  geometry   wheels {}, track {}, W_T {}",
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
                note("  encoders   run with their motors");
                note(format_args!("  before     {off} to the {side}, heading {heading_mrad:+.1} mrad"));
                let weight = &measurement.wheel_weight;
                note(format_args!("  W_T        {:.6} +- {:.6}", weight.value, weight.sigma));
            }
            Drive::Back => note(format_args!("  way back   turned by {:+.1} mrad", -measurement.wheel_weight.alpha_rad * 1e3)),
            Drive::After => {
                note(format_args!("  after      {off} to the {side}, heading {heading_mrad:+.1} mrad"));
            }
        }
    }
}

fn finish(common: &Common, args: &CalibrateArgs, outcome: Outcome, picture: Picture) -> Result<()> {
    let after = match &outcome.decision {
        Decision::Corrected(after) => Some(after),
        Decision::NotBetter(after) => {
            let change = mm(outcome.before.run.end.lateral_offset_m, after.run.end.lateral_offset_m);
            return Err(Error::said_no(format_args!("the new W_T made it no better ({change}); the old one is back"))
                .hint("is the start line-up good enough? --out-and-back tells a pull from a radius"));
        }
        Decision::AlreadyStraight | Decision::NotARadius => None,
    };
    if let Some(after) = after {
        let report = report(common, args, &outcome, after);
        picture.write(&args.output, &to_html(&report))?;
    }
    if common.json {
        say(to_json(&outcome, after, &args.output));
        return Ok(());
    }
    let weight = &outcome.before.wheel_weight;
    match after {
        Some(after) => {
            let (before_m, after_m) = (outcome.before.run.end.lateral_offset_m, after.run.end.lateral_offset_m);
            say("");
            say(table(&outcome, after));
            say("");
            say(format_args!("{} {}", paint(GOOD, "Drives straight:"), mm(before_m, after_m)));
            say(format_args!("  W_T is sure to +- {:.6}; {}", weight.sigma, weight.what_would_reduce_it_most()));
            say(format_args!("  picture: {}", paint(BOLD, args.output.display())));
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
                "{} W_T {} is within one sigma ({:.6}) of the measured {:.6}. Nothing was changed.",
                paint(GOOD, "Straight already:"),
                outcome.before.run.driven_with,
                weight.sigma,
                weight.value
            ));
            say(format_args!("  {}", weight.what_would_reduce_it_most()));
        }
    }
    Ok(())
}

fn mm(before_m: f64, after_m: f64) -> String {
    format!("{:.1} mm off before, {:.1} mm after", before_m.abs() * 1e3, after_m.abs() * 1e3)
}

fn table(outcome: &Outcome, after: &Measurement) -> String {
    let row = |name: &str, before: String, after: String| format!("{name:<22} {before:>12} {after:>12}\n");
    let (before, after) = (&outcome.before.run, &after.run);
    let radius_m = outcome.geometry.wheel_radius_m;
    let mut table = paint(DIM, row("", "before".into(), "after".into()).trim_end()) + "\n";
    for (name, value) in [
        ("W_T in use", (|run| format!("{:.6}", run.driven_with)) as fn(&crate::picture::RunReport) -> String),
        ("lateral offset", |run| format!("{:+.1} mm", run.end.lateral_offset_m * 1e3)),
        ("heading at the end", |run| format!("{:+.2} mrad", run.end.heading_rad * 1e3)),
        ("W_T measured", |run| format!("{:.6}", run.wheel_weight.value)),
        ("  standard deviation", |run| format!("{:.6}", run.wheel_weight.sigma)),
    ] {
        table += &row(name, value(before), value(after));
    }
    let radius = |w_t: f64| LengthUnit::Cm.format(radius_m * w_t, 4);
    table += &row("R_R in use", radius(before.driven_with), radius(after.driven_with));
    table.trim_end().into()
}

fn next_steps(common: &Common) {
    let port = if common.port.is_sim() { String::new() } else { format!(" --port {}", common.port) };
    say("  next:");
    if common.port.is_sim() {
        say("    beeline calibrate --seed 7 --measure ruler     another robot, measured with a ruler");
        say("    beeline calibrate --out-and-back               is it the radius at all?");
        say("    beeline calibrate --port /dev/ttyACM0          a real one");
    } else {
        say(format_args!("    beeline drive straight 8rev{port}"));
        say(format_args!("    beeline calibrate --undo{port}"));
    }
}

fn report(common: &Common, args: &CalibrateArgs, outcome: &Outcome, after: &Measurement) -> CalibrationReport {
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
        Decision::NotARadius => "not_a_radius",
        Decision::NotBetter(_) => "not_better",
    };
    json!({
        "robot": outcome.checks.identity.name.as_str(),
        "decision": decision,
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

