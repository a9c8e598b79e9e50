//! `beeline calibrate --method umbmark`: runs UMBmark and shows its result.
//!
//! The procedure itself is [`crate::calibrate::umbmark`].

use robot_model::explain::StepFound;
use serde_json::json;
use shared_proto::GeometryConfig;

use super::identify::display_name;
use super::pose_source;
use crate::calibrate::umbmark::{
    Decision, Systematic, UmbmarkOutcome, UmbmarkSettings, UmbmarkStep, umbmark,
};
use crate::campaign_recorder::piece::{self, Piece};
use crate::cli::{CalibrateArgs, Common};
use crate::compare::LINE;
use crate::error::{Error, Result};
use crate::explain::parameters;
use crate::limits;
use crate::port::with_robot;
use crate::quantity::LengthUnit;
use crate::table::wrapped;
use crate::ui::{BOLD, DIM, GOOD, Progress, note, paint, say, say_text};
use crate::undo::state_folder;
use crate::words;

pub(super) fn run(common: &Common, args: &CalibrateArgs) -> Result<()> {
    let forgets = common.port.is_sim() && common.flash.is_none();
    let undo_folder = if forgets { None } else { Some(state_folder()?) };
    let outcome = with_robot(&common.port, &common.sim(), async |session, testbed| {
        let config = session.read_config().await?;
        let radius_m = config.geometry.wheel_radius_m;
        let settings = UmbmarkSettings {
            side_m: args.side.m,
            runs: args.runs.unwrap_or(5),
            speed_mps: args.profile.cruise.mps(radius_m),
            acceleration_mps2: args.profile.acceleration.mps2(radius_m),
            undo_folder,
        };
        limits::check_square(settings.side_m, &config)?;
        let side = Piece::Straight { travel_m: settings.side_m, speed_mps: settings.speed_mps };
        if let Some(motion) =
            piece::motion(&side, config.geometry.track_width_m, settings.acceleration_mps2)
        {
            limits::check(&motion, &config, args.profile.long)?;
        }
        let mut source = pose_source::of_calibration(args, testbed)?;
        let mut progress = None;
        let quiet = common.json;
        umbmark(session, &mut *source, &settings, &mut |step| match step {
            UmbmarkStep::Checked(checks) if !quiet => {
                note(paint(BOLD, format_args!("UMBmark of {}", display_name(&checks.identity))));
                note(format_args!(
                    "  squares    {} each way, side {}",
                    settings.runs,
                    LengthUnit::Cm.format(settings.side_m, 0)
                ));
            }
            UmbmarkStep::Driving(again, number, of, share) => {
                let title = match again {
                    false => format!("square {number} of {of}"),
                    true => format!("again, square {number} of {of}"),
                };
                if share == 0.0 || progress.is_none() {
                    progress = Some(Progress::new(title, quiet));
                }
                if let Some(progress) = &progress {
                    progress.set(share);
                }
            }
            UmbmarkStep::Measured(again, systematic) => {
                progress = None;
                if !quiet {
                    let when = if again { "after" } else { "before" };
                    let error = LengthUnit::Mm.format(systematic.error_m, 1);
                    note(format_args!("  {when:<10} E_max,syst {error}"));
                }
            }
            UmbmarkStep::Written(_) if !quiet => note("  written    read back; driving again"),
            UmbmarkStep::Saved if !quiet => note("  saved"),
            _ => {}
        })
        .await
    })?;
    finish(common, &outcome)
}

/// The effects that `explain` finds in the first set of squares.
fn explained(outcome: &UmbmarkOutcome) -> Result<Vec<StepFound>> {
    let Some(campaign) = &outcome.campaign else { return Ok(Vec::new()) };
    let campaign = campaign.to_model(std::path::Path::new("squares"))?;
    let answer = robot_model::explain::explain(&campaign)?;
    Ok(answer.steps)
}

fn finish(common: &Common, outcome: &UmbmarkOutcome) -> Result<()> {
    let explained = explained(outcome)?;
    let before = &outcome.before;
    if common.json {
        say(to_json(outcome, &explained));
    } else {
        say_text(table(outcome));
        if outcome.campaign.is_some() {
            say("");
            say(paint(BOLD, "What `explain` finds in the tracks of the first squares"));
            if explained.is_empty() {
                say("  nothing beyond noise");
            }
            explained.iter().for_each(say_effect);
        }
    }
    let mm = |m: f64| format!("{:.1} mm", m * 1e3);
    match &outcome.decision {
        Decision::Saved(after) if !common.json => {
            say_apart(format_args!(
                "{} E_max,syst {} before, {} after",
                paint(GOOD, "Squares improved:"),
                mm(before.error_m),
                mm(after.error_m)
            ));
            if !common.robot_forgets() {
                say(format_args!(
                    "{} puts the old geometry back",
                    paint(BOLD, "beeline apply --undo")
                ));
            }
        }
        Decision::AlreadySquare if !common.json => say_apart(format_args!(
            "{} neither W_T nor the track width stands out from the scatter of the squares. Nothing was changed.",
            paint(GOOD, "Square already:"),
        )),
        Decision::Saved(_) | Decision::AlreadySquare => {}
        Decision::NotBetter(after) => {
            return Err(Error::said_no(format_args!(
                "the correction did not reduce the error ({} before, {} after); the old values are restored",
                mm(before.error_m),
                mm(after.error_m)
            ))
            .hint("more squares (--runs), larger ones (--side), or a better start"));
        }
        Decision::Contradicted => {
            return Err(Error::said_no(format_args!(
                "{} of the squares' errors come neither from the radii nor from the track width, as on a carpet or a slope that carries the robot aside; nothing was changed",
                mm(before.stray_m)
            ))
            .hint("`beeline campaign record`, then `beeline explain`, tells the causes apart"));
        }
    }
    Ok(())
}

fn to_json(outcome: &UmbmarkOutcome, explained: &[StepFound]) -> serde_json::Value {
    let set = |systematic: &Systematic, geometry: &GeometryConfig| {
        json!({
            "e_max_syst_m": systematic.error_m,
            "stray_m": systematic.stray_m,
            "e_d": systematic.wheel_ratio,
            "e_b": systematic.track_ratio,
            "left_m": systematic.left_m,
            "right_m": systematic.right_m,
            "geometry": geometry,
        })
    };
    let explained: Vec<_> = explained
        .iter()
        .map(|step| {
            let parameters = crate::json::parameters(&step.parameters);
            json!({"class": step.class, "parameters": parameters, "why": words::evidence(step)})
        })
        .collect();
    let (decision, after) = match &outcome.decision {
        Decision::Saved(after) => ("saved", Some(after)),
        Decision::NotBetter(after) => ("not_better", Some(after)),
        Decision::AlreadySquare => ("already_square", None),
        Decision::Contradicted => ("contradicted", None),
    };
    json!({
        "decision": decision,
        "saved": decision == "saved",
        "before": set(&outcome.before, &outcome.geometry[0]),
        "after": after.map(|after| set(after, &outcome.geometry[1])),
        "explained": explained,
    })
}

/// Prints one effect with its values and the reason to accept it, as `explain` does.
fn say_effect(step: &StepFound) {
    let put = |indent: usize, words: &str| {
        for line in wrapped(words, LINE - indent) {
            say(format_args!("{:indent$}{line}", ""));
        }
    };
    put(2, &step.class.join(" or "));
    parameters(&step.parameters, 4);
    put(4, &format!("Evidence: {}.", words::evidence(step).trim_end_matches('.')));
    if step.class.len() > 1 {
        put(4, &format!("The values apply if it is {}.", step.effect));
    }
}

fn table(outcome: &UmbmarkOutcome) -> String {
    let before = &outcome.before;
    let after = match &outcome.decision {
        Decision::Saved(after) | Decision::NotBetter(after) => Some(after),
        Decision::AlreadySquare | Decision::Contradicted => None,
    };
    let mean = |errors: &[[f64; 2]]| {
        let n = errors.len().max(1) as f64;
        let sum = |k: usize| errors.iter().map(|error| error[k]).sum::<f64>() / n * 1e3;
        format!("{:+.1}, {:+.1} mm", sum(0), sum(1))
    };
    let row =
        |name: &str, before: String, after: String| format!("{name:<28} {before:>18} {after:>18}");
    let both =
        |read: &dyn Fn(&Systematic) -> String| (read(before), after.map(read).unwrap_or_default());
    let in_use = |read: &dyn Fn(&GeometryConfig) -> String| {
        let [then, now] = &outcome.geometry;
        (read(then), after.map(|_| read(now)).unwrap_or_default())
    };
    let head = after.map_or("", |_| "after");
    let mut lines = vec![paint(DIM, row("", "before".into(), head.into()).trim_end())];
    for (name, (a, b)) in [
        ("E_max,syst", both(&|set| format!("{:.1} mm", set.error_m * 1e3))),
        ("neither radii nor track", both(&|set| format!("{:.1} mm", set.stray_m * 1e3))),
        ("mean error, left squares", both(&|set| mean(&set.left_m))),
        ("mean error, right squares", both(&|set| mean(&set.right_m))),
        ("E_d, with the values in use", both(&|set| format!("{:.6}", set.wheel_ratio))),
        ("E_b, with the values in use", both(&|set| format!("{:.6}", set.track_ratio))),
        ("W_T in use", in_use(&|g| format!("{:.6}", g.wheel_weight))),
        ("R_L in use", in_use(&|g| LengthUnit::Cm.format(g.wheel_radius_m, 4))),
        ("track width in use", in_use(&|g| LengthUnit::Cm.format(g.track_width_m, 3))),
    ] {
        lines.push(row(name, a, b).trim_end().to_string());
    }
    lines.join("\n")
}

/// Says a line after an empty one.
fn say_apart(line: std::fmt::Arguments<'_>) {
    say("");
    say(line);
}
