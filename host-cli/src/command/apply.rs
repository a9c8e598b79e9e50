//! `beeline apply`

use host_link::Session;
use robot_model::effect::{Effect, KnownEffect};
use robot_model::explain::Answer;
use robot_model::explain::model::fit;
use robot_model::recording::RecordingError;
use serde_json::json;
use shared_proto::{Config, ConfigOrigin, GeometryConfig, Identity};

use super::compare::warn_of_runs_without_poses;
use super::identify::display_name;
use crate::apply::{Change, Estimate, Remedy, chosen, estimates, unconfirmed};
use crate::cli::{ApplyArgs, Common};
use crate::error::{Error, Result};
use crate::explain::{explained, flash_option, wrong_in_robot_toml};
use crate::fit_cache::{FitCache, Question};
use crate::hex::hex;
use crate::port::with_robot;
use crate::quantity::LengthUnit;
use crate::question;
use crate::ui::{self, BOLD, DIM, GOOD, note, note_text, paint, say, warn};
use crate::undo::{Undo, state_folder};

use super::undo::last_change;
use crate::words;
use campaign::model::{EffectEntry, ModelFile};
use campaign::words::recording_error;
use campaign::{Campaign, Recordings};

pub(super) fn run(common: &Common, args: &ApplyArgs) -> Result<()> {
    if args.undo {
        return undo(common);
    }
    let Some(folder) = &args.campaign else {
        return Err(Error::new("which campaign?").hint("beeline apply FOLDER --port PORT"));
    };
    let (campaign, recordings) = Campaign::read_both(folder)?;
    for warning in &campaign.warnings {
        warn(warning);
    }
    warn_of_runs_without_poses(&campaign);
    let cache = args.reuse.cache(common.json);
    let (effects, unsettled) = effects_of(folder, (&campaign, recordings), &cache, common.json)?;
    let (change, written) = with_robot(&common.port, &common.sim(), async |session, _| {
        let identity = session.identify().await?;
        if identity.unsaved {
            warn("unsaved changes on the robot are discarded");
            session.restore_config(ConfigOrigin::Saved).await?;
        }
        let config = session.read_config().await?;
        // As in recording: a simulated robot is another one with each seed.
        let uid = (!common.port.is_sim()).then(|| hex(&identity.uid));
        let change = Change::new(&effects, &campaign.robot, &config, uid.as_deref())?;
        if let Some((problem, hint)) = &unsettled {
            return Err(Error::new(problem).hint(hint));
        }
        if !common.json {
            note(paint(BOLD, format_args!("Robot: {}", display_name(&identity))));
            note_text(table(&change));
        }
        if let Some(stays_m) = change.other_radius_m(&campaign.robot) {
            warn(format_args!(
                "the mean radius stays at {}: robot.toml says {}, and the runs do not contradict it; if that is right, \
                 scale the robot's radius to it with `beeline config set geometry.wheel_radius_m`",
                LengthUnit::Mm.format(stays_m, 3),
                LengthUnit::Mm.format(campaign.robot.wheel_radius_m, 3)
            ));
        }
        if !change.changes() {
            return Ok((change, false));
        }
        if !args.yes {
            let question = question::Question::new("Write and save this? y or n:");
            let answer = ui::ask(&question, &session.clock()).await?.to_lowercase();
            if !matches!(answer.as_str(), "y" | "yes") {
                return Err(Error::interrupted("nothing was written; the robot is as it was"));
            }
        }
        let mut new = config.clone();
        new.geometry = change.after;
        [_, new.odometry] = change.odometry;
        new.validate().map_err(|error| {
            Error::new(format_args!("the values that the campaign gives are out of range: {error}"))
                .hint("check robot.toml, and the values that `explain` finds")
        })?;
        write(common, session, &identity, &config, &new).await?;
        Ok((change, true))
    })?;
    finish(common, &change, written);
    Ok(())
}

/// Writes and saves a configuration. First the undo: a robot that was changed can then always be changed back.
async fn write(
    common: &Common,
    session: &mut Session,
    identity: &Identity,
    config: &Config,
    new: &Config,
) -> Result<()> {
    let remembered = if !common.port.is_sim() || common.flash.is_some() {
        let undo = Undo {
            robot: display_name(identity),
            before: config.geometry,
            after: new.geometry,
            odometry: Some(config.odometry),
        };
        Some(undo.remember(&state_folder()?, identity)?)
    } else {
        None
    };
    session.write_config(new).await?;
    if let Err(error) = session.save_config().await {
        if let Some(remembered) = remembered {
            remembered.take_back()?;
        }
        return Err(error.into());
    }
    Ok(())
}

/// The effects to apply: those of the campaign's model, or without one those that the explanation names.
fn effects_of(
    folder: &std::path::Path,
    (campaign, recordings): (&Campaign, Recordings),
    cache: &FitCache,
    quiet: bool,
) -> Result<(Vec<Estimate>, Option<Unsettled>)> {
    let place = ModelFile::place(folder);
    let model = ModelFile::read_or_empty(&place)?;
    if let Some(entry) = model.effects.iter().find(|entry| entry.parameters.is_empty()) {
        let id = entry.id();
        return Err(Error::new(format_args!("{}: {id} has no value yet", place.display()))
            .hint(format_args!("beeline model fit {}", folder.display())));
    }
    let in_use: Vec<&str> = model.in_use().iter().map(|entry| entry.id()).collect();
    // Somebody has chosen a model.
    if model.effects.len() > in_use.len() {
        return Ok((chosen(&model), None));
    }
    let failed = |error: RecordingError| {
        let why = recording_error(&error);
        Error::new(format_args!("{}: {why}", folder.display())).hint("record that run again")
    };
    let nominal_m = [campaign.robot.wheel_radius_m, campaign.robot.track_width_m];
    let campaign = recordings.into_model(campaign, folder)?;
    let catalogue = model.catalogue();
    let question = Question { campaign: &campaign, catalogue: &catalogue, in_model: &in_use };
    let answer = explained(&question, cache, quiet).map_err(failed)?;
    let unsettled = unsettled(&answer, &catalogue, nominal_m);
    let mut effects = estimates(&answer);
    // What is compensated and not there: only a value shows whether that is sure.
    let gone = |entry: &&&EffectEntry| !effects.iter().any(|other| other.is(entry.id()));
    let gone: Vec<EffectEntry> = model.in_use().iter().filter(gone).copied().cloned().collect();
    if !gone.is_empty() {
        let mut all: Vec<KnownEffect> =
            effects.iter().filter_map(|effect| model.find(&effect.effect)).collect();
        all.extend(gone.iter().map(|entry| entry.effect.clone()));
        let all: Vec<&dyn Effect> = all.iter().map(|effect| &**effect).collect();
        let fitted = fit(&campaign, &all).map_err(failed)?;
        effects.extend(gone.iter().filter_map(|entry| unconfirmed(entry, &fitted)));
    }
    Ok((effects, unsettled))
}

/// Why nothing is written, and what to do.
type Unsettled = (String, &'static str);

/// Left over this many times the reachable error, values may stand in for something else.
const LEFT_OVER_MAX: f64 = 2.0;

/// Nothing is written by a file with wrong numbers, nor beside a large error that nothing explains.
fn unsettled(answer: &Answer, catalogue: &[&dyn Effect], nominal_m: [f64; 2]) -> Option<Unsettled> {
    if let Some(numbers) = wrong_in_robot_toml(answer, catalogue, nominal_m) {
        let problem = format!("nothing was written: robot.toml is far off. {numbers}");
        return Some((problem, "then look at `beeline explain`, and apply again"));
    }
    let after =
        answer.steps.last().map_or(answer.baseline.cross_validated, |step| step.cross_validated);
    let is_large = after.position_rms_m > LEFT_OVER_MAX * answer.reachable.position_rms_m;
    (answer.unexplained.structure && is_large).then(|| {
        let problem = format!(
            "nothing was written: {:.1} mm of the error are unexplained, and depend on {}",
            1e3 * answer.unexplained.size_m,
            words::depends_on(&answer.unexplained)
        );
        let hint =
            "`beeline report` draws it; to apply chosen effects all the same: beeline model add";
        (problem, hint)
    })
}

pub(super) fn undo(common: &Common) -> Result<()> {
    let undone = last_change::<GeometryConfig>(common)?;
    if common.json {
        say(json!({"undone": undone.before, "was": undone.after}));
    } else {
        say("the old geometry is restored and saved");
    }
    Ok(())
}

fn table(change: &Change) -> String {
    let (before, after) = (&change.before, &change.after);
    let mut lines = vec![paint(DIM, format_args!("  {:<22} {:>14} {:>14}", "", "now", "new"))];
    let cm = |value: f64| LengthUnit::Cm.format(value, 4);
    let mm = |value: f64| LengthUnit::Mm.format(value, 3);
    let [sure, surer] = &change.odometry;
    let ratio = |value: f64| format!("{value:.6}");
    let pull = |g: &GeometryConfig| format!("{:.3} mrad/m", g.heading_pull_rad_per_m * 1e3);
    let right_m = |g: &GeometryConfig| g.wheel_radius_m * g.wheel_weight;
    for (name, now, then) in [
        ("R_L", cm(before.wheel_radius_m), cm(after.wheel_radius_m)),
        ("R_R", cm(right_m(before)), cm(right_m(after))),
        ("W_T", ratio(before.wheel_weight), ratio(after.wheel_weight)),
        ("track width", cm(before.track_width_m), cm(after.track_width_m)),
        ("heading pull", pull(before), pull(after)),
        ("W_T, one sigma", ratio(sure.wheel_weight_sd), ratio(surer.wheel_weight_sd)),
        ("track width, one sigma", mm(sure.track_width_sd_m), mm(surer.track_width_sd_m)),
    ] {
        lines.push(format!("  {name:<22} {now:>14} {then:>14}"));
    }
    for (effect, remedy) in &change.remedies {
        let text = match remedy {
            Remedy::Compensated => "compensated by the above".to_owned(),
            Remedy::Unsure => {
                "not written: its 95 % interval includes zero; more runs that excite it would narrow it"
                    .to_owned()
            }
            Remedy::Stays => {
                "the value in use stays: these runs confirm neither it nor another value".to_owned()
            }
            Remedy::Small => {
                "not written: it explains less than is left unexplained, so it may be something else".to_owned()
            }
            Remedy::Ambiguous(others) => format!(
                "not written: these runs cannot tell it from {}; `explain` suggests a run that can, if there is one",
                others.join(", ")
            ),
            Remedy::Measurement => "concerns the measurement, not the robot: nothing to compensate".to_owned(),
            Remedy::Uncompensated(what) => {
                format!("not compensated, as the firmware has no term for it; remedy: {what}")
            }
        };
        lines.push(format!("  {effect:<22} {text}"));
    }
    lines.join("\n")
}

/// Whether there are effects, and the firmware has a term for none of them.
fn has_no_term(change: &Change) -> bool {
    let none = |remedy: &Remedy| matches!(remedy, Remedy::Uncompensated(_) | Remedy::Measurement);
    !change.remedies.is_empty() && change.remedies.iter().all(|(_, remedy)| none(remedy))
}

fn finish(common: &Common, change: &Change, written: bool) {
    if common.json {
        let remedies = change.remedies.iter().map(|(effect, remedy)| {
            let (what, more) = match remedy {
                Remedy::Compensated => ("compensated", json!(null)),
                Remedy::Unsure => ("unsure", json!(null)),
                Remedy::Stays => ("stays", json!(null)),
                Remedy::Small => ("small", json!(null)),
                Remedy::Ambiguous(others) => ("ambiguous", json!(others)),
                Remedy::Measurement => ("measurement", json!(null)),
                Remedy::Uncompensated(what) => ("uncompensated", json!(what)),
            };
            json!({"effect": effect, "remedy": what, "detail": more})
        });
        say(json!({
            "written": written,
            "before": change.before,
            "after": change.after,
            "odometry": {"before": change.odometry[0], "after": change.odometry[1]},
            "effects": remedies.collect::<Vec<_>>(),
        }));
    } else if written {
        say(paint(GOOD, "written, read back and saved"));
        if !common.port.is_sim() || common.flash.is_some() {
            say(format_args!(
                "  beeline apply --undo --port {}{} restores the old values",
                common.port,
                flash_option(common)
            ));
        }
    } else if has_no_term(change) {
        say(
            "nothing to write: the firmware has no term for any of these effects; radii and track width are fitted by \
             `beeline model add wheel_radius_ratio wheel_radius_scale track_width`",
        );
    } else {
        say(
            "nothing to write: the values in use agree with the campaign, or the firmware cannot compensate the difference",
        );
    }
}
