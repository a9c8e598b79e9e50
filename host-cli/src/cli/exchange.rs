//! `beeline import` and `beeline export`: logs of other programs in, what a campaign says out.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use import::text::{Mapping, parse_mappings};

use super::CacheArgs;
use super::value_parsers::{above_zero, length, new_file, time};
use crate::quantity::{Length, Time};

/// `beeline import`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Sources: a ROS 2 bag (MCAP, sqlite3) or its folder, a CSV file with a header line, a TUM or EuRoC trajectory.
Wheels and poses may come from different files with different clocks.

Names in --map: t_s, left_counts, right_counts, left_rad, right_rad, left_m, right_m, x_m, y_m, z_m,
heading_rad, qx, qy, qz, qw. Units: s ms us ns, m cm mm in ft, rad deg rev.

Examples:
  beeline import drive.mcap                      list what is in it, and propose a command
  beeline import drive.mcap -o my-logs --wheel-radius 36mm --track-width 37.2cm
  beeline import drive.mcap -o my-logs --wheels wheel_left,wheel_right --pose /tf:map.base_link
  beeline import drive.mcap -o by-odometry --odometry /odom --wheel-radius 36mm --track-width 37.2cm
  beeline import encoders.csv track.tum -o my-logs --counts-per-rev 1920 \\
      --map left_counts=enc_l,right_counts=enc_r,t_s=stamp:ns")]
pub struct ImportArgs {
    /// The files, or folders of bags.
    #[arg(required = true, value_name = "SOURCE")]
    pub sources: Vec<PathBuf>,
    /// The campaign folder to write. Without it, the contents of the sources are only listed.
    #[arg(long, short, value_name = "FOLDER", value_parser = new_file())]
    pub output: Option<PathBuf>,
    /// The joints of the left and the right wheel.
    #[arg(long, value_name = "LEFT,RIGHT", value_parser = wheels)]
    pub wheels: Option<[String; 2]>,
    /// Wheel odometry, from which the wheels' motion is computed back: give --controller, or the --wheel-radius and
    /// --track-width that the odometry used.
    #[arg(long, value_name = "TOPIC", conflicts_with = "wheels")]
    pub odometry: Option<String>,
    /// Parameters of the controller that computed the odometry, for radius and track width: ROS 2's diff_drive_controller,
    /// TurtleBot3.
    #[arg(long, value_name = "FILE.yaml")]
    pub controller: Option<PathBuf>,
    /// The measured poses: a topic, or /tf:PARENT.CHILD.
    #[arg(long, value_name = "TOPIC")]
    pub pose: Option<String>,
    /// The gyro, if the bag has several: a topic of sensor_msgs/msg/Imu.
    #[arg(long, value_name = "TOPIC")]
    pub imu: Option<String>,
    /// Which column of a table is which quantity: NAME=COLUMN, or NAME=COLUMN:UNIT.
    #[arg(long = "map", value_name = "NAME=COLUMN,...", value_parser = Mappings::parse)]
    pub mappings: Vec<Mappings>,
    /// Nominal wheel radius [default: estimated from how far the robot went].
    #[arg(long, value_name = "LENGTH", value_parser = above_zero(length))]
    pub wheel_radius: Option<Length>,
    /// Nominal track width [default: estimated from how far the robot turned].
    #[arg(long, value_name = "LENGTH", value_parser = above_zero(length))]
    pub track_width: Option<Length>,
    /// Counts per turn of the encoder, four per line; for wheels in counts.
    #[arg(long, value_name = "N", value_parser = positive)]
    pub counts_per_rev: Option<f64>,
    /// Turns of the encoder per turn of the wheel.
    #[arg(long, value_name = "N", value_parser = positive)]
    pub gear_reduction: Option<f64>,
    /// Name of the robot.
    #[arg(long)]
    pub name: Option<String>,
    /// A stop that is longer than this ends a run.
    #[arg(long, value_name = "TIME", default_value = "2s", value_parser = above_zero(time))]
    pub rest: Time,
    /// Add the runs to those in the folder.
    #[arg(long)]
    pub add: bool,
}

/// Columns of one `--map`.
#[derive(Clone, Debug)]
pub struct Mappings(pub Vec<Mapping>);

impl Mappings {
    fn parse(text: &str) -> Result<Self, String> {
        parse_mappings(text).map(Self)
    }
}

/// `beeline export`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  beeline export my-robot --to ros2 -o diff_drive.yaml    parameters of ROS 2's diff_drive_controller
  beeline export my-robot --to turtlebot3                 parameters of TurtleBot3; also linorobot2, wpilib
  beeline export my-robot --to json                       the same numbers for other programs
  beeline export my-robot --to tum -o tracks              trajectories, for example for evo
  beeline export my-robot --to mcap -o my-robot.mcap      for Foxglove, PlotJuggler, Rerun")]
pub struct ExportArgs {
    /// The campaign folder.
    pub campaign: PathBuf,
    /// The program that will read it.
    #[arg(long)]
    pub to: ExportFormat,
    /// The file to write, for tum the folder; `-` is standard output [default: standard output, for text].
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Replace files that exist.
    #[arg(long)]
    pub force: bool,
    /// Whether what was found before is used again.
    #[command(flatten)]
    pub reuse: CacheArgs,
}

/// What is exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExportFormat {
    /// Parameters of diff_drive_controller, as YAML.
    Ros2,
    /// Parameters of TurtleBot3's turtlebot3_node, as YAML.
    Turtlebot3,
    /// Lines of linorobot2's configuration header.
    Linorobot2,
    /// Constants for WPILib, in Java.
    Wpilib,
    /// The numbers of diff_drive_controller as JSON.
    Json,
    /// Three trajectories a run: as measured, by odometry with these numbers, and as the campaign's model predicts.
    Tum,
    /// All runs in one table.
    Csv,
    /// All runs in one ROS 2 bag.
    Mcap,
}

fn wheels(text: &str) -> Result<[String; 2], String> {
    match text.split(',').map(str::trim).collect::<Vec<_>>()[..] {
        [left, right] if !left.is_empty() && !right.is_empty() && left != right => {
            Ok([left.to_owned(), right.to_owned()])
        }
        _ => Err("must be two joints, LEFT,RIGHT".to_owned()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok();
    number
        .filter(|number| *number > 0.0 && number.is_finite())
        .ok_or("must be a number above zero".to_owned())
}
