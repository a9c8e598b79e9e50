//! `beeline import`: makes a campaign of logs of other programs.
//!
//! Reading and understanding them is left to the crate `import`.

use std::path::Path;

use ::import::controller_file::{self, ControllerFile};
use ::import::geometry::Geometry;
use ::import::source::{Choice, Offer, Sources};
use ::import::understand::{Hints, Understood, understand};
use ::import::write::{Written, name_of, robot_of, write_with};
use serde_json::{Value, json};

use crate::cli::{Common, ImportArgs};
use crate::error::{Error, Result};
use crate::escape::{shell_option, shell_path};
use crate::import_page;
use crate::table::{Cell, Table};
use crate::ui::{BOLD, note, runs, say, warn};
use campaign::bounded_read::read_text;
use campaign::file::write_own;
use campaign::{CampaignError, RobotFile};

/// The page that shows what was understood, in the campaign folder.
const PAGE: &str = "import.html";
/// A page that is larger is none of ours.
const PAGE_BYTES_MAX: u64 = 1 << 26;

pub(super) fn run(common: &Common, args: &ImportArgs) -> Result<()> {
    let mappings: Vec<_> = args.mappings.iter().flat_map(|one| one.0.clone()).collect();
    let sources = Sources::open(&args.sources, &mappings)?;
    let controller = args.controller.as_deref().map(controller_file::read).transpose()?;
    let choice = Choice {
        wheels: args.wheels.clone(),
        odometry: odometry(args, controller.as_ref())?,
        pose: args.pose.clone(),
        imu: args.imu.clone(),
        mappings,
    };
    let Some(folder) = &args.output else {
        return list(common, args, &sources, &choice);
    };
    let there = robot_of(folder)?;
    let there = there.as_ref();
    let given = [args.wheel_radius.is_some(), args.track_width.is_some()];
    let of_folder = there.is_some() && controller.is_none() && given != [true; 2];
    let hints = hints(args, controller.as_ref(), there);
    // What is missing of a bag may be why something is not found.
    let warned = |_: &CampaignError| sources.notes().iter().for_each(warn);
    let chosen = sources.choose(&choice).inspect_err(warned)?;
    let (wheels, poses) = (chosen.wheels.what.clone(), chosen.poses.what.clone());
    let mut understood = understand(chosen.wheels, &chosen.poses, &hints, chosen.same_clock)?;
    understood.notes.splice(0..0, chosen.notes);
    let Written { names, were_there } =
        write_with(&understood, folder, args.add, |folder, written| {
            write_page(folder, &understood, written)
        })?;
    understood.notes.iter().for_each(warn);
    if common.json {
        let mut told = to_json(&understood, &names);
        told["runs_there_already"] = were_there.into();
        if of_folder {
            // What its first import estimated, or somebody wrote.
            told["robot"]["estimated"] = Value::Null;
        }
        say(told);
        return Ok(());
    }
    say(format_args!("wheels  {wheels}"));
    say(format_args!("poses   {poses}"));
    say(format_args!("clock   {}", import_page::clock(&understood)));
    let as_there = if of_folder { ", as its robot.toml says" } else { "" };
    say(format_args!("robot   {}{as_there}", robot(&understood)));
    say("");
    table(&understood, &names);
    say("");
    if were_there > 0 {
        note(format_args!("{were_there} of them were there already, and stay as they are"));
    }
    note(format_args!(
        "{}: {}, and {PAGE} shows what was understood. Next: `beeline compare {}`",
        folder.display(),
        runs(names.len()),
        shell_path(folder)
    ));
    Ok(())
}

/// What the user says, or the controller's file, or the robot of a folder that is there.
fn hints(
    args: &ImportArgs,
    controller: Option<&ControllerFile>,
    there: Option<&RobotFile>,
) -> Hints {
    Hints {
        name: args
            .name
            .clone()
            .or(there.map(|robot| robot.name.clone()))
            .or(args.output.as_deref().and_then(name_of)),
        wheel_radius_m: args
            .wheel_radius
            .map(|length| length.m)
            .or(controller.map(|controller| controller.geometry.wheel_radius_m))
            .or(there.map(|robot| robot.wheel_radius_m)),
        track_width_m: args
            .track_width
            .map(|length| length.m)
            .or(controller.map(|controller| controller.geometry.wheel_separation_m))
            .or(there.map(|robot| robot.track_width_m)),
        counts_per_rev: args.counts_per_rev.or(there.map(|robot| robot.counts_per_rev)),
        gear_reduction: args.gear_reduction.or(there.map(|robot| robot.gear_reduction)),
        cut: ::import::cut::CutOptions { rest_s: args.rest.s, ..Default::default() },
    }
}

/// Writes the page into a campaign. One of these very runs stays: it says what was understood when they came.
fn write_page(
    folder: &Path,
    understood: &Understood,
    written: &Written,
) -> std::result::Result<(), CampaignError> {
    let page = folder.join(PAGE);
    let of_runs = import_page::of_runs(&written.names);
    if read_text(&page, PAGE_BYTES_MAX).is_ok_and(|there| there.contains(&of_runs)) {
        return Ok(());
    }
    let html = import_page::page(understood, &written.names);
    write_own(&page, html.as_bytes())
        .map_err(|error| CampaignError::io(&page, "write it", error.into()))
}

/// The topic of odometry that is to be turned back into wheels, and the numbers that it used.
fn odometry(
    args: &ImportArgs,
    controller: Option<&ControllerFile>,
) -> Result<Option<(String, Geometry)>> {
    let Some(topic) = &args.odometry else { return Ok(None) };
    let by_hand = args.wheel_radius.zip(args.track_width);
    let by_hand = by_hand.map(|(radius, width)| Geometry::nominal(radius.m, width.m));
    let Some(geometry) = controller.map(|controller| controller.geometry).or(by_hand) else {
        return Err(Error::new(format_args!(
            "the radius and the track width that {topic} was computed with are unknown"
        ))
        .hint("add --controller FILE.yaml with the controller's parameters, or its --wheel-radius and --track-width"));
    };
    if let (Some(controller), Some(file)) = (controller, &args.controller) {
        let file = file.display();
        if controller.is_open_loop {
            return Err(Error::new(format_args!(
                "{file}: by open_loop, {topic} is what was commanded, and not what the wheels did"
            ))
            .hint("choose the joints with --wheels, or record a bag with open_loop: false"));
        }
        if controller.uses_gyro {
            warn(format_args!(
                "{file}: by odometry.use_imu, {topic} turns by the gyro: what both wheels did together is in it, but not which of them; choose the joints with --wheels if the bag has any"
            ));
        }
    }
    Ok(Some((topic.clone(), geometry)))
}

/// The nominal numbers, and what was assumed of them.
fn robot(understood: &Understood) -> String {
    let robot = &understood.robot;
    let text = format!(
        "{}: wheel radius {} m, track width {} m",
        robot.name, robot.wheel_radius_m, robot.track_width_m
    );
    let (what, options) = match understood.is_estimated {
        [false, false] => return text,
        [true, true] => ("both are", "--wheel-radius and --track-width"),
        [true, false] => ("the radius is", "--wheel-radius"),
        [false, true] => ("the track width is", "--track-width"),
    };
    format!(
        "{text}; {what} estimated from this log, so that what `explain` says of it corrects the estimate: give {options} of the data sheet to judge the robot"
    )
}

/// The runs, and what was left out.
fn table(understood: &Understood, names: &[String]) {
    let mut table = Table::new("lrrrl");
    let head = ["run", "began", "took", "poses", "begins"];
    table.row(head.map(|text| Cell::styled(BOLD, text)));
    let first_s = understood.begin_s();
    for (run, name) in understood.runs.iter().zip(names) {
        table.row([
            name.as_str().into(),
            format!("{:.1} s", run.started_s - first_s).into(),
            format!("{:.1} s", run.recording.duration_s()).into(),
            run.recording.measured_poses.len().into(),
            run.begins.words().into(),
        ]);
    }
    for left in &understood.left_out {
        table.row([
            "left out".into(),
            format!("{:.1} s", left.from_s - first_s).into(),
            format!("{:.1} s", left.to_s - left.from_s).into(),
            "".into(),
            left.why.as_str().into(),
        ]);
    }
    table.say(0);
}

fn to_json(understood: &Understood, names: &[String]) -> Value {
    let first_s = understood.begin_s();
    let robot = &understood.robot;
    let runs = understood.runs.iter().zip(names).map(|(run, name)| {
        json!({
            "name": name,
            "kind": run.kind.name(),
            "started_s": run.started_s,
            "duration_s": run.recording.duration_s(),
            "poses": run.recording.measured_poses.len(),
        })
    });
    let left_out = understood.left_out.iter().map(|left| {
        json!({ "from_s": left.from_s - first_s, "to_s": left.to_s - first_s, "why": left.why })
    });
    json!({
        "schema": 1,
        "clock": {
            "late_s": understood.clock.late_s,
            "drift": understood.clock.rate(),
            "sigma_s": understood.clock.sigma_s,
        },
        "robot": {
            "wheel_radius_m": robot.wheel_radius_m,
            "track_width_m": robot.track_width_m,
            "counts_per_rev": robot.counts_per_rev,
            "estimated": understood.is_estimated.contains(&true),
        },
        "runs": runs.collect::<Vec<_>>(),
        "left_out": left_out.collect::<Vec<_>>(),
        "notes": understood.notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}

/// Lists what is in the sources, and proposes the command.
fn list(common: &Common, args: &ImportArgs, sources: &Sources, choice: &Choice) -> Result<()> {
    let offers = sources.offers();
    sources.notes().iter().for_each(warn);
    let chosen = sources.choose(choice);
    let command = chosen.as_ref().ok().map(|chosen| proposed(args, &offers, chosen.wheels.unit));
    if common.json {
        let each = offers.iter().map(|offer| {
            json!({
                "file": offer.file.to_string_lossy(),
                "name": offer.name,
                "type": offer.schema,
                "count": offer.count,
                "option": offer.option,
                "remark": offer.remark,
            })
        });
        say(json!({ "schema": 1, "offers": each.collect::<Vec<_>>(), "command": command }));
        return Ok(());
    }
    let mut table = Table::new("llrl");
    table.row(["in", "type", "count", "option"].map(|text| Cell::styled(BOLD, text)));
    for offer in &offers {
        let what = match (&offer.option, offer.remark.as_str()) {
            (Some(option), "") => option.clone(),
            (Some(option), remark) => format!("{option}  ({remark})"),
            (None, remark) => remark.to_owned(),
        };
        table.row([
            offer.name.as_str().into(),
            offer.schema.as_str().into(),
            offer.count.into(),
            what.into(),
        ]);
    }
    table.say(0);
    say("");
    match (command, chosen) {
        (Some(command), _) => {
            say(command);
            Ok(())
        }
        (None, Err(error)) => Err(error.into()),
        (None, Ok(_)) => Ok(()),
    }
}

/// The command that imports these sources.
fn proposed(args: &ImportArgs, offers: &[Offer], unit: ::import::log::WheelUnit) -> String {
    let mut words = vec!["beeline import".to_owned()];
    words.extend(args.sources.iter().map(|source| shell_path(source)));
    words.push("-o my-robot".into());
    let wheels = args
        .wheels
        .as_ref()
        .map(|[left, right]| shell_option("--wheels", &format!("{left},{right}")));
    let odometry = args.odometry.as_ref().map(|topic| shell_option("--odometry", topic));
    let controller =
        args.controller.as_ref().map(|file| format!("--controller {}", shell_path(file)));
    let pose = args.pose.as_ref().map(|pose| shell_option("--pose", pose));
    let only = |option: &str| {
        let fits = |offer: &&Offer| {
            offer.option.as_ref().is_some_and(|own| own.starts_with(option))
                && offer.remark.is_empty()
        };
        let found = offers.iter().find(fits)?.option.as_ref()?;
        let (name, value) = found.split_once(' ')?;
        Some(shell_option(name, value))
    };
    words.extend(odometry.or(wheels).or_else(|| only("--wheels ")));
    words.extend(pose.or_else(|| only("--pose ")));
    words.push(controller.unwrap_or("--wheel-radius RADIUS --track-width WIDTH".into()));
    if unit == ::import::log::WheelUnit::Counts && args.counts_per_rev.is_none() {
        words.push("--counts-per-rev N".into());
    }
    words.join(" ")
}
