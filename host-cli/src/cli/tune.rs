//! The options of `beeline tune`.

use std::path::PathBuf;

use clap::Args;

use super::value_parsers::{above_zero, length, new_file, share};
use crate::quantity::Length;

/// `beeline tune`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Put the robot at the beginning of its floor, facing along it. The floor must be level. The robot
drives forwards and back by itself for about a minute, and turns on the spot; it stays on that
floor, and stops at Ctrl-C. Radius, track width and encoder counts must be right beforehand: see
`beeline config get geometry` and `beeline config get encoder`.

Examples:
  beeline tune --port /dev/ttyACM0 --floor 2m
  beeline tune --stiffness 0.5                   softer gains
  beeline tune --record my-motors                keeps the experiments: `beeline explain --drivetrain my-motors`
  beeline tune --undo --port /dev/ttyACM0        the gains from before the last tuning")]
pub struct TuneArgs {
    /// How much free floor there is ahead of the robot: 30cm to 100m.
    #[arg(long, value_name = "LENGTH", default_value = "1.5m", allow_hyphen_values = true, value_parser = above_zero(length))]
    pub floor: Length,
    /// 1 for the stiffest loop that keeps its margin, less for a softer one: 0.1 to 1.
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, value_parser = share)]
    pub stiffness: f64,
    /// Drive as many experiments again, and keep all of them as a campaign in this folder, for
    /// `beeline explain --drivetrain`.
    #[arg(long, value_name = "FOLDER", value_parser = new_file())]
    pub record: Option<PathBuf>,
    /// Restore the gains, feedforward and limits that the last tuning changed.
    #[arg(long, conflicts_with_all = ["floor", "stiffness", "record"])]
    pub undo: bool,
}
