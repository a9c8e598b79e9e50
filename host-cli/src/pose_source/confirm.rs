//! Asks a person to put the robot at a mark.

use campaign::plan::PlannedRun;
use host_link::Clock;

use super::mark::{DriveOrSkip, Mark};
use crate::error::{Error, Result};
use crate::question::{Choice, Picture, Question};
use crate::ui;

/// Before a drive along a line.
const AT_LINE: &[Choice] = &[Choice { label: "It stands there: drive", answer: "" }];
/// Before a run.
pub(super) const AT_MARK: &[Choice] = &[
    Choice { label: "It stands there: drive", answer: "" },
    Choice { label: "Skip this run", answer: "s" },
];

/// Asks a person to put the robot at a mark, and waits for the answer.
pub(super) async fn confirm(clock: &Clock, mark: Mark<'_>) -> Result<DriveOrSkip> {
    match mark {
        Mark::Line(place) => {
            let question = Question::new(format!("Put the robot {place}, with room ahead"))
                .picture(Picture::Line)
                .choices(AT_LINE, ", and press Enter:")
                .not_typed();
            match ui::ask(&question, clock).await?.to_lowercase().as_str() {
                "" | "y" | "yes" => Ok(DriveOrSkip::Drive),
                _ => Err(Error::interrupted("not driven")),
            }
        }
        Mark::Run(run) => loop {
            let question = Question::new(ask_for(run))
                .picture(Picture::Mark)
                .choices(AT_MARK, " Enter to drive, s to skip it, q to stop here:")
                .not_typed();
            match ui::ask(&question, clock).await?.to_lowercase().as_str() {
                "" | "y" | "yes" => return Ok(DriveOrSkip::Drive),
                "s" | "skip" => return Ok(DriveOrSkip::Skip),
                "q" | "quit" => return Err(stopped()),
                _ => {}
            }
        },
    }
}

/// Asks a person to put the robot at the start of a run.
pub(super) fn ask_for(run: &PlannedRun) -> String {
    let deg = run.heading_rad.to_degrees().rem_euclid(360.0);
    let facing = match deg.round() as u32 {
        0 | 360 => "facing along the campaign's x axis".to_owned(),
        deg => format!("facing {deg} degrees to the left of the campaign's x axis"),
    };
    let load = if run.payload_kg > 0.0 {
        format!(", with {} kg on board", run.payload_kg)
    } else {
        String::new()
    };
    format!("{}: put the robot at its mark, {facing}{load}.", run.name)
}

/// The error of a user who stops here.
pub(super) fn stopped() -> Error {
    Error::interrupted("stopped; the same command continues from here")
}
