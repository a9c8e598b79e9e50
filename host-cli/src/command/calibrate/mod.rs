//! `beeline calibrate`: checks the options, runs the calibration and shows its result.
//!
//! The procedure itself is [`crate::calibrate`].

mod next_steps;
mod outcome;
mod progress_printer;

use std::path::Path;

use serde_json::json;

use self::outcome::{cannot_draw, finish};
use self::progress_printer::ProgressPrinter;
use super::drive::straight;
use super::pose_source;
use crate::calibrate::{Settings, calibrate};
use crate::cli::{CalibrateArgs, Common, Method};
use crate::error::{Error, Result};
use crate::limits;
use crate::port::with_robot;
use crate::ui::say;
use crate::undo::{WheelWeight, state_folder};

use super::undo::last_change;
use campaign::file::check_writable;

pub(super) fn run(common: &Common, args: &CalibrateArgs) -> Result<()> {
    let umbmark = args.method == Method::Umbmark;
    match (args.undo, umbmark) {
        (true, true) => return super::apply::undo(common),
        (true, false) => return undo(common),
        _ => check_combination(args)?,
    }
    if umbmark {
        return super::umbmark::run(common, args);
    }
    check_ending(&args.output)?;
    // Before the robot moves: a picture that cannot be written must not cost a calibration.
    check_writable(&args.output)
        .map_err(|error| cannot_draw(&args.output, error).hint("-o FILE puts it elsewhere"))?;
    // Connecting takes the robot from the host that drives it: wrong options are refused before.
    if !common.port.has_testbed() {
        pose_source::of_calibration(args, None)?;
    }
    let forgets = common.port.is_sim() && common.flash.is_none();
    let undo_folder = if forgets { None } else { Some(state_folder()?) };
    let outcome = with_robot(&common.port, &common.sim(), async |session, testbed| {
        let config = session.read_config().await?;
        let motion = straight(args.distance, &args.profile, &config);
        limits::check_distance(&motion, &config)?;
        limits::check(&motion, &config, args.profile.long)?;
        let settings = Settings {
            motion,
            tolerance_share: args.tolerance_percent / 100.0,
            start_heading_sigma_rad: args.start_heading.rad,
            out_and_back: args.out_and_back,
            runs: args.runs.unwrap_or(1),
            undo_folder,
        };
        let mut source = pose_source::of_calibration(args, testbed)?;
        let mut printer = ProgressPrinter::new(common, &settings, args);
        calibrate(session, &mut *source, &settings, &mut |step| printer.print(step)).await
    })?;
    finish(common, args, outcome)
}

/// Refuses options that contradict each other.
fn check_combination(args: &CalibrateArgs) -> Result<()> {
    if !args.out_and_back {
        return Ok(());
    }
    if args.method == Method::Umbmark {
        return Err(Error::new(
            "--out-and-back belongs to --method straight: UMBmark drives its squares in both directions instead",
        )
        .hint("leave out one of the two"));
    }
    if args.runs.is_some_and(|runs| runs > 1) {
        return Err(Error::new(
            "--out-and-back and --runs exclude each other: the way back begins where the way out ended, but each of several runs begins at the start line",
        )
        .hint("use them one after the other: --out-and-back tells a pull from unequal radii, --runs reduces the uncertainty of W_T"));
    }
    Ok(())
}

fn check_ending(output: &Path) -> Result<()> {
    let ending = output.extension().unwrap_or_default();
    if ["html", "htm", "svg"].iter().any(|known| ending.eq_ignore_ascii_case(known)) {
        return Ok(());
    }
    Err(Error::new(format_args!("the picture {} must end in .html or .svg", output.display()))
        .hint("-o calibration.svg"))
}

fn undo(common: &Common) -> Result<()> {
    let undone = last_change::<WheelWeight>(common)?;
    if common.json {
        say(json!({"undone": {"wheel_weight": undone.before.0, "was": undone.after.0}}));
    } else {
        say(format_args!(
            "W_T is {} again, as before the last calibration, and saved",
            undone.before.0
        ));
    }
    Ok(())
}
