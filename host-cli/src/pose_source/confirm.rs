//! Asks a person to put the robot at a mark.

use host_link::Clock;

use super::{DriveOrSkip, Mark, ask_for, stopped};
use crate::error::{Error, Result};
use crate::ui;

/// Asks a person to put the robot at a mark, and waits for the answer.
pub(super) async fn confirm(clock: &Clock, mark: Mark<'_>) -> Result<DriveOrSkip> {
    match mark {
        Mark::Line(place) => {
            let question = format!("Put the robot {place}, with room ahead, and press Enter:");
            match ui::ask(&question, clock).await?.to_lowercase().as_str() {
                "" | "y" | "yes" => Ok(DriveOrSkip::Drive),
                _ => Err(Error::interrupted("not driven")),
            }
        }
        Mark::Run(run) => loop {
            let question =
                format!("{} Enter to drive, s to skip it, q to stop here:", ask_for(run));
            match ui::ask(&question, clock).await?.to_lowercase().as_str() {
                "" | "y" | "yes" => return Ok(DriveOrSkip::Drive),
                "s" | "skip" => return Ok(DriveOrSkip::Skip),
                "q" | "quit" => return Err(stopped()),
                _ => {}
            }
        },
    }
}
