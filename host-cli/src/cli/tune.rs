//! The options of `beeline tune`.

use std::path::PathBuf;

use clap::Args;

use super::value_parsers::{above_zero, length, new_file, new_file_named, share};
use crate::quantity::Length;

/// `beeline tune`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Put the robot at the beginning of a level stretch of floor, facing along it. For about a minute it
drives forwards and back by itself, and turns on the spot. It stays on that stretch, and stops at
Ctrl-C. Radius, track width and encoder counts must be right beforehand: see
`beeline config get geometry` and `beeline config get encoder`.

Examples:
  beeline tune --port /dev/ttyACM0 --floor 2m
  beeline tune --wheels-up                       motors and wiring, before the robot stands on its floor
  beeline tune --stiffness 0.5                   softer gains
  beeline tune -o tuning.html                    also a page with pictures
  beeline tune --record my-motors                keep the experiments for `beeline explain --drivetrain my-motors`
  beeline tune --undo --port /dev/ttyACM0        the gains from before the last tuning")]
pub struct TuneArgs {
    /// Length of free floor ahead of the robot: 30cm to 100m.
    #[arg(long, value_name = "LENGTH", default_value = "1.5m", allow_hyphen_values = true, value_parser = above_zero(length))]
    pub floor: Length,
    /// The wheels turn in the air and need no floor. kS and kV are those of the motors, kA that of the wheels alone: on its floor
    /// the robot has to be tuned as well.
    #[arg(long, conflicts_with = "floor")]
    pub wheels_up: bool,
    /// Stiffness of the loop, 0.1 to 1: 1 is the stiffest that keeps its stability margin.
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, value_parser = share)]
    pub stiffness: f64,
    /// Drive as many experiments again, and keep all of them as a campaign in this folder, for
    /// `beeline explain --drivetrain`.
    #[arg(long, value_name = "FOLDER", value_parser = new_file())]
    pub record: Option<PathBuf>,
    /// Also write what was found as a page with pictures, one self-contained file.
    #[arg(long, short, value_name = "FILE.html", value_parser = new_file_named("html"))]
    pub output: Option<PathBuf>,
    /// Restore the gains, feedforward and limits that the last tuning changed.
    #[arg(long, conflicts_with_all = ["floor", "wheels_up", "stiffness", "record", "output"])]
    pub undo: bool,
}
