//! The options of `beeline calibrate` and `beeline wheel-weight`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};

use super::drive::ProfileArgs;
use super::value_enums::{Measure, Method};
use super::value_parsers::{
    above_zero, angle, count, distance, length, new_file, not_negative, number, percent,
};
use crate::quantity::{Angle, Distance, Length};

/// `beeline calibrate`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
How the deviation is measured (--measure):
  camera      the simulator's overhead camera (default on the simulator)
  ruler       the simulator's ruler: lateral offset at the end
  ask         you are asked for the lateral offset, or dx and dy (default elsewhere)
  track:FILE  a CSV (t_s,x_m,y_m[,heading_rad]) that a tracking system appends to

Examples:
  beeline calibrate
  beeline calibrate --measure ruler --out-and-back
  beeline calibrate --port /dev/ttyACM0 --ruler 1mm
  beeline calibrate --method umbmark --side 2m --port /dev/ttyACM0
  beeline calibrate --undo --port /dev/ttyACM0")]
pub struct CalibrateArgs {
    /// straight: the paper's method, W_T from a straight line; umbmark: squares in both directions, W_T and track width.
    #[arg(long, value_name = "METHOD", default_value = "straight")]
    pub method: Method,
    /// Side of the squares of UMBmark.
    #[arg(long, value_name = "LENGTH", default_value = "1m", allow_hyphen_values = true, value_parser = above_zero(length))]
    pub side: Length,
    /// How far to drive: 8rev, 2m.
    #[arg(long, value_name = "DISTANCE", default_value = "8rev", allow_hyphen_values = true, value_parser = above_zero(distance))]
    pub distance: Distance,
    /// Shape of the motion.
    #[command(flatten)]
    pub profile: ProfileArgs,
    /// camera, ruler, ask or track:FILE.
    #[arg(long, value_name = "HOW")]
    pub measure: Option<Measure>,
    /// Resolution of the ruler: a reading is good to half of it.
    #[arg(long, value_name = "LENGTH", default_value = "1mm", allow_hyphen_values = true, value_parser = above_zero(length))]
    pub ruler: Length,
    /// How well the robot is lined up with its start line, one sigma.
    #[arg(long, value_name = "ANGLE", default_value = "2mrad", allow_hyphen_values = true, value_parser = not_negative(angle))]
    pub start_heading: Angle,
    /// How well wheel radius and track width are known, one sigma, in percent.
    #[arg(long = "tolerance", value_name = "PERCENT", default_value_t = 0.5, allow_hyphen_values = true, value_parser = percent)]
    pub tolerance_percent: f64,
    /// Noise of the measured track's positions, one sigma.
    #[arg(long, value_name = "LENGTH", default_value = "1mm", allow_hyphen_values = true, value_parser = above_zero(length))]
    pub position_sigma: Length,
    /// Noise of the measured track's headings, one sigma.
    #[arg(long, value_name = "ANGLE", default_value = "2mrad", allow_hyphen_values = true, value_parser = above_zero(angle))]
    pub heading_sigma: Angle,
    /// Also drive back once, to tell a pull from unequal radii. Not with --runs, whose runs each begin at
    /// the start line.
    #[arg(long)]
    pub out_and_back: bool,
    /// Drive this many runs before deciding, each from the start line, and take their mean; not with
    /// --out-and-back [default: 1; umbmark: 5 each way].
    #[arg(long, value_name = "N", value_parser = count(100))]
    pub runs: Option<u16>,
    /// Where to write the picture: the full page, or only the drawing if FILE ends in .svg.
    #[arg(long, short, value_name = "FILE", default_value = "beeline-calibration.html", value_parser = new_file())]
    pub output: PathBuf,
    /// Start without asking whether the robot stands at its line.
    #[arg(long, short)]
    pub yes: bool,
    /// Restore the W_T that was in use before the last calibration.
    #[arg(long)]
    pub undo: bool,
}

/// `beeline wheel-weight`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Give either the tangent of the trace at its end (--dx and --dy, dy to the RIGHT positive, as in the
paper) or the lateral offset of the end from the start line (--lateral, to the LEFT positive).

Examples:
  beeline wheel-weight --dx 2.525cm --dy 1mm
  beeline wheel-weight --lateral -36mm --start-heading 2mrad")]
#[command(group(ArgGroup::new("deviation").required(true)))]
pub struct WheelWeightArgs {
    /// Base of the tangent, along the line.
    #[arg(
        long,
        value_name = "LENGTH",
        allow_hyphen_values = true,
        requires = "dy",
        group = "deviation"
    )]
    pub dx: Option<Length>,
    /// Rise of the tangent over that base, to the right positive.
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, requires = "dx")]
    pub dy: Option<Length>,
    /// Offset of the end from the start line, to the left positive.
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, group = "deviation")]
    pub lateral: Option<Length>,
    /// Uncertainty of a reading, one sigma.
    #[arg(long, value_name = "LENGTH", default_value = "0.5mm", allow_hyphen_values = true, value_parser = not_negative(length))]
    pub sigma: Length,
    /// Wheel radius, R_L.
    #[arg(long, value_name = "LENGTH", default_value = "3.6cm", allow_hyphen_values = true, value_parser = above_zero(length))]
    pub radius: Length,
    /// Track width, b.
    #[arg(long, value_name = "LENGTH", default_value = "37.2cm", allow_hyphen_values = true, value_parser = above_zero(length))]
    pub track_width: Length,
    /// Encoder counts per wheel revolution, N / g.
    #[arg(long, value_name = "N", allow_hyphen_values = true, default_value_t = 900.0, value_parser = number)]
    pub counts_per_rev: f64,
    /// Wheel revolutions driven (both wheels).
    #[arg(long, value_name = "N", allow_hyphen_values = true, default_value_t = 8.0, value_parser = number)]
    pub revolutions: f64,
    /// Counts of the left wheel, if the wheels turned differently.
    #[arg(long, value_name = "N", allow_hyphen_values = true, requires = "right_counts")]
    pub left_counts: Option<f64>,
    /// Counts of the right wheel.
    #[arg(long, value_name = "N", allow_hyphen_values = true, requires = "left_counts")]
    pub right_counts: Option<f64>,
    /// How well the robot was lined up with its start line, one sigma.
    #[arg(long, value_name = "ANGLE", default_value = "0rad", allow_hyphen_values = true, value_parser = not_negative(angle))]
    pub start_heading: Angle,
}
