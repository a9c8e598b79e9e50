//! `beeline export`: what a campaign says, for other programs.

use std::fs;
use std::path::Path;

use ::import::export::{Controller, Target, Trajectory, bag, table};
use serde_json::{Value, json};

use super::compare::{effects_of, read};
use crate::cli::{Common, ExportArgs, ExportFormat};
use crate::error::{Context, Error, Result};
use crate::ui::{note, runs, say_text, tell, warn};
use campaign::file::write_whole;
use campaign::model::ModelFile;
use campaign::new_folders::NewFolders;

pub(super) fn run(common: &Common, args: &ExportArgs) -> Result<()> {
    let output = output(common, args)?;
    let (read, campaign) = read(&args.campaign)?;
    let place = ModelFile::place(&args.campaign);
    let model = ModelFile::read_or_empty(&place)?;
    let target = match args.to {
        ExportFormat::Turtlebot3 => Target::TurtleBot3,
        ExportFormat::Linorobot2 => Target::Linorobot2,
        ExportFormat::Wpilib => Target::Wpilib,
        _ => Target::DiffDrive,
    };
    let controller = Controller::of(&args.campaign, &read.robot, &campaign, &model, target)?;
    if let Some(cost) = &controller.cost {
        let [own, whole] = cost.position_m.map(|m| m * 1e3);
        warn(format_args!(
            "{} cannot be told: {}; this costs {:.1} mm ({own:.1} mm instead of {whole:.1} mm)",
            target.name(),
            cost.effects.join(", "),
            own - whole
        ));
    }
    let trajectories = || -> Result<_> {
        let geometry = &controller.geometry;
        let mut all = Trajectory::all(&campaign, geometry.radii_m(), geometry.track_width_m());
        let effects = effects_of(&model, &place, &args.campaign)?;
        let comparer = args.reuse.cache(common.json).comparer(&campaign, &model)?;
        Trajectory::add_predictions(&mut all, &comparer.predicted(&effects));
        Ok(all)
    };
    match args.to {
        ExportFormat::Ros2
        | ExportFormat::Turtlebot3
        | ExportFormat::Linorobot2
        | ExportFormat::Wpilib => text(common, (output, args.force), &controller.file(&read.robot)),
        ExportFormat::Json => {
            text(common, (output, args.force), &format!("{:#}\n", to_json(&controller)))
        }
        ExportFormat::Csv => text(common, (output, args.force), &table(&trajectories()?)),
        ExportFormat::Mcap => {
            let mut all = trajectories()?;
            Trajectory::add_telemetry(&mut all, &read.runs);
            let bytes = bag(&all).context("cannot make the bag")?;
            let Some(file) = output else { return Ok(()) };
            write_new(file, &bytes, args.force)?;
            told(common, file, &format!("a ROS 2 bag of {}", runs(campaign.runs.len())));
            Ok(())
        }
        ExportFormat::Tum => {
            let Some(folder) = output else { return Ok(()) };
            write_tum(folder, &trajectories()?, args.force)?;
            told(
                common,
                folder,
                &format!("three trajectories of each of {}", runs(campaign.runs.len())),
            );
            Ok(())
        }
    }
}

/// The file or folder to write; none if the text goes to standard output.
fn output<'a>(common: &Common, args: &'a ExportArgs) -> Result<Option<&'a Path>> {
    let needs = match args.to {
        ExportFormat::Tum => Some("a folder: three files a run go into it"),
        ExportFormat::Mcap => Some("a file: a bag is not text"),
        _ => None,
    };
    let output = args.output.as_deref().filter(|file| file.as_os_str() != "-");
    if let (None, Some(what)) = (output, needs) {
        return Err(Error::new("no place to write to").hint(format_args!("give -o {what}")));
    }
    if common.json && output.is_none() && args.to != ExportFormat::Json {
        return Err(Error::new("what this format prints is not JSON")
            .hint("--to json prints the numbers as JSON; -o FILE writes the file"));
    }
    Ok(output)
}

/// Writes three files a run.
fn write_tum(folder: &Path, trajectories: &[Trajectory], force: bool) -> Result<()> {
    let _made =
        NewFolders::make(folder).context(format_args!("cannot make {}", folder.display()))?;
    for one in trajectories {
        for (what, text) in [
            ("measured", one.measured_tum()),
            ("odometry", one.odometry_tum()),
            ("predicted", one.predicted_tum()),
        ] {
            let file = folder.join(format!("{}_{what}.tum", one.run));
            // Of an export that was interrupted.
            if fs::read(&file).is_ok_and(|there| there == text.as_bytes()) {
                continue;
            }
            write_new(&file, text.as_bytes(), force)?;
        }
    }
    Ok(())
}

fn text(common: &Common, (file, force): (Option<&Path>, bool), text: &str) -> Result<()> {
    match file {
        Some(file) => {
            write_new(file, text.as_bytes(), force)?;
            told(common, file, "written");
        }
        None => say_text(text.trim_end()),
    }
    Ok(())
}

fn told(common: &Common, file: &Path, what: &str) {
    let file = file.display().to_string();
    if common.json {
        tell(true, json!({ "file": file }), "");
    } else {
        note(format_args!("{file}: {what}"));
    }
}

/// Writes a file that does not exist, unless it may be replaced.
fn write_new(file: &Path, bytes: &[u8], force: bool) -> Result<()> {
    if !force && file.exists() && file.is_file() {
        return Err(Error::new(format_args!("{} exists", file.display()))
            .hint("choose another name, or --force to replace it"));
    }
    write_whole(file, bytes).map_err(|error| {
        Error::new(format_args!("cannot write {}: {error}", file.display()))
            .hint(error.hint("choose another place with -o"))
    })
}

fn to_json(controller: &Controller) -> Value {
    let [left, right] = controller.geometry.radius_multipliers;
    let [left_m, right_m] = controller.geometry.radii_m();
    let [nominal, errors] = controller.errors;
    let cost = controller.cost.as_ref().map(|cost| {
        json!({ "effects": cost.effects, "position_m": cost.position_m[0], "model_position_m": cost.position_m[1] })
    });
    json!({
        "schema": 1,
        "wheel_radius_m": controller.geometry.wheel_radius_m,
        "left_wheel_radius_multiplier": left,
        "right_wheel_radius_multiplier": right,
        "left_wheel_radius_m": left_m,
        "right_wheel_radius_m": right_m,
        "wheel_separation_m": controller.geometry.wheel_separation_m,
        "wheel_separation_multiplier": controller.geometry.separation_multiplier,
        "effective_wheel_separation_m": controller.geometry.track_width_m(),
        "pose_variances": controller.pose_variances,
        "twist_variances": controller.twist_variances,
        "nominal_error_m": nominal.fitted.position_rms_m,
        "error_m": errors.fitted.position_rms_m,
        "not_expressible": cost,
    })
}
