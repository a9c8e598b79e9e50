//! The command line.

mod campaign;
mod check;
mod choice;
mod insight;

pub use self::campaign::{
    ApplyArgs, CampaignCommand, CampaignRecordArgs, FloorSize, Mass, PlanArgs, PlanCommandArgs,
};
pub use check::period_ms;
pub use choice::{Measure, Method};
pub use host_link::listen::Listen;
pub use insight::{
    AddArgs, CompareArgs, ExplainArgs, Format, ModelCommand, RemoveArgs, ReportArgs,
};

use std::path::PathBuf;

use clap::builder::styling::{AnsiColor, Styles};
use clap::{ArgGroup, Args, Parser, Subcommand};

use self::check::{
    above_zero, acceleration, angle, distance, length, not_negative, percent, rate, speed, time,
};
use crate::port::{Port, SimOptions};
use crate::quantity::{Acceleration, Angle, Distance, Length, Speed, Time};

const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

const EXAMPLES: &str = "\
Examples:
  beeline                                        calibrate a simulated robot and draw what happened
  beeline calibrate --port /dev/ttyACM0          calibrate a real one, with a ruler
  beeline drive straight 2m --port tcp:192.168.4.1:7700
  beeline wheel-weight --dx 2.525cm --dy 1mm     the paper's calculation on its own numbers
  beeline sim --listen tcp:127.0.0.1:7700        a robot in real time, for any serial program

Exit codes: 0 done, 1 the check said no, 2 could not run, 130 stopped by Ctrl-C.";

/// Makes a two-wheeled robot drive straight, and says why when it does not.
#[derive(Debug, Parser)]
#[command(name = "beeline", version, styles = STYLES, after_help = EXAMPLES, max_term_width = 100)]
pub struct Cli {
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
    /// What to do; nothing means `calibrate` on the simulator.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// Options of every command.
#[derive(Args, Clone, Debug)]
pub struct Common {
    /// The robot: a serial device (/dev/ttyACM0, COM3, @BAUD appended if not 921600, 19200 at least),
    /// tcp:HOST:PORT, or sim[:SCENARIO.toml].
    #[arg(
        long,
        short,
        global = true,
        value_name = "PORT",
        default_value = "sim",
        env = "BEELINE_PORT",
        help_heading = "Every command"
    )]
    pub port: Port,
    /// Print one JSON value instead of text (`watch`: one a line).
    #[arg(long, global = true, help_heading = "Every command")]
    pub json: bool,
    /// The seed that draws everything random, instead of the scenario's.
    #[arg(long, global = true, value_name = "N", help_heading = "Simulator")]
    pub seed: Option<u64>,
    /// A file that stands for the robot's flash; without it, the robot forgets.
    #[arg(long, global = true, value_name = "FILE", help_heading = "Simulator")]
    pub flash: Option<PathBuf>,
}

impl Common {
    /// What only the simulator needs to know.
    pub fn sim(&self) -> SimOptions {
        SimOptions { seed: self.seed, flash: self.flash.clone() }
    }
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// List the serial ports, and where else a robot may be.
    Ports,
    /// Show who the robot is and how it is: firmware, state, faults, supply, link.
    Identify,
    /// Read, change and save the robot's configuration.
    #[command(subcommand)]
    Config(ConfigCommand),
    /// Drive a motion: straight, spin or arc.
    #[command(subcommand)]
    Drive(DriveCommand),
    /// Brake along a ramp; --now cuts the motors and latches a fault.
    Stop {
        /// Zero duty at once, as the emergency stop does.
        #[arg(long)]
        now: bool,
    },
    /// Clear the latched fault. It is never cleared by itself.
    Clear,
    /// Show telemetry live.
    Watch(WatchArgs),
    /// Drive a motion and record it as a run of a campaign folder.
    Record(RecordArgs),
    /// Plan a whole campaign of runs, and record it.
    #[command(subcommand)]
    Campaign(CampaignCommand),
    /// Compare a campaign with a model: how far off, where, and what is noise.
    Compare(CompareArgs),
    /// Name the physical effects that a campaign shows and its model lacks.
    Explain(ExplainArgs),
    /// Show and change the model of a campaign: add an effect, and watch the error fall.
    #[command(subcommand)]
    Model(ModelCommand),
    /// Put everything that a campaign says on one page.
    Report(ReportArgs),
    /// The paper's experiment: drive, measure, compute W_T, write it, drive again.
    Calibrate(CalibrateArgs),
    /// Write what a campaign says, and the firmware can compensate, to the robot.
    Apply(ApplyArgs),
    /// The paper's calculation on numbers typed in.
    WheelWeight(WheelWeightArgs),
    /// Run a simulated robot in real time, behind TCP or a pseudo-terminal.
    Sim(SimArgs),
    /// Print a completion script for a shell.
    #[command(
        after_help = "Example:\n  beeline completions bash > ~/.local/share/bash-completion/completions/beeline"
    )]
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

/// `beeline config ...`
#[derive(Debug, Subcommand)]
pub enum ConfigCommand {
    /// Show the configuration in use, or a part of it.
    #[command(
        after_help = "Examples:\n  beeline config get\n  beeline config get geometry.wheel_weight\n  beeline config get limits"
    )]
    Get {
        /// A field or a group, `geometry.wheel_weight` or `geometry`.
        field: Option<String>,
    },
    /// Change a field, in SI units. Not saved until `config save`.
    #[command(
        after_help = "Example:\n  beeline config set geometry.wheel_weight 0.9919 --save --port /dev/ttyACM0"
    )]
    Set {
        /// The field, `geometry.wheel_weight`.
        field: String,
        /// Its new value.
        #[arg(allow_negative_numbers = true)]
        value: String,
        /// Save it at once.
        #[arg(long)]
        save: bool,
    },
    /// Make the configuration in use survive power-off.
    Save,
    /// Go back to the saved configuration, or the factory's.
    Restore {
        /// The one that is built into the firmware.
        #[arg(long)]
        factory: bool,
    },
    /// Write the configuration in use to a TOML file.
    #[command(
        after_help = "Examples:\n  beeline config export my-robot.toml\n  beeline config export -"
    )]
    Export {
        /// The file; `-` for standard output.
        file: PathBuf,
        /// Overwrite it if it exists.
        #[arg(long)]
        force: bool,
    },
    /// Use the configuration of a TOML file.
    #[command(
        after_help = "Example:\n  beeline config import my-robot.toml --save --port /dev/ttyACM0"
    )]
    Import {
        /// The file.
        file: PathBuf,
        /// Save it at once.
        #[arg(long)]
        save: bool,
    },
}

/// Shape of a motion, shared by all of them.
#[derive(Args, Clone, Copy, Debug)]
pub struct ProfileArgs {
    /// Speed between the ramps, of the farther wheel: 0.2m/s, 0.523rev/s.
    #[arg(long, value_name = "SPEED", default_value = "0.523rev/s", allow_hyphen_values = true, value_parser = above_zero(speed))]
    pub cruise: Speed,
    /// Steepness of the ramps: 0.05m/s^2, 0.101rev/s^2.
    #[arg(long, value_name = "ACCELERATION", default_value = "0.101rev/s^2", allow_hyphen_values = true, value_parser = above_zero(acceleration))]
    pub acceleration: Acceleration,
    /// Drive it even if it takes longer than ten minutes.
    #[arg(long)]
    pub long: bool,
}

/// `beeline drive ...`
#[derive(Clone, Debug, Subcommand)]
pub enum DriveCommand {
    /// Drive straight; a negative distance goes backwards.
    #[command(
        allow_negative_numbers = true,
        after_help = "Examples:\n  beeline drive straight 8rev\n  beeline drive straight -50cm --cruise 0.3m/s"
    )]
    Straight {
        /// How far: 1.8m, 8rev (turns of a wheel).
        #[arg(allow_hyphen_values = true)]
        distance: Distance,
        /// Shape of the motion.
        #[command(flatten)]
        profile: ProfileArgs,
    },
    /// Turn on the spot; positive is counter-clockwise.
    #[command(after_help = "Example:\n  beeline drive spin -360deg --cruise 0.2m/s")]
    Spin {
        /// How far: 90deg, -1rev (turns of the robot).
        #[arg(allow_hyphen_values = true)]
        angle: Angle,
        /// Shape of the motion.
        #[command(flatten)]
        profile: ProfileArgs,
    },
    /// Drive an arc; positive angles turn left, a negative radius drives the same circle backwards,
    /// so that the robot turns the other way.
    #[command(after_help = "Example:\n  beeline drive arc 1m 90deg")]
    Arc {
        /// Radius of the circle that the robot's centre drives.
        #[arg(allow_hyphen_values = true)]
        radius: Length,
        /// How far the robot turns.
        #[arg(allow_hyphen_values = true)]
        angle: Angle,
        /// Shape of the motion.
        #[command(flatten)]
        profile: ProfileArgs,
    },
}

/// `beeline watch`
#[derive(Args, Clone, Debug)]
pub struct WatchArgs {
    /// Frames per second, 1 to 1000: a divisor of 1000.
    #[arg(long, default_value_t = 10, value_parser = rate)]
    pub rate: u16,
    /// Stop after this long; without it, at Ctrl-C (simulator: after 2 s of its time).
    #[arg(long = "for", value_name = "TIME", allow_hyphen_values = true, value_parser = above_zero(time))]
    pub duration: Option<Time>,
}

/// `beeline record`
#[derive(Args, Clone, Debug)]
#[command(
    after_help = "Examples:\n  beeline record my-robot straight 8rev\n  beeline record my-robot spin 360deg --name spin_left --port /dev/ttyACM0"
)]
pub struct RecordArgs {
    /// The campaign folder; made if it does not exist.
    pub campaign: PathBuf,
    /// Name of the run; its kind if not given. A number is put before it.
    #[arg(long, global = true)]
    pub name: Option<String>,
    /// Samples per second, 1 to 1000: a divisor of 1000.
    #[arg(long, global = true, default_value_t = 100, value_parser = rate)]
    pub rate: u16,
    /// The motion.
    #[command(subcommand)]
    pub motion: DriveCommand,
}

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
    /// straight: the paper's, W_T from a straight line; umbmark: squares both ways, W_T and track width.
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
    /// Also drive back once, so that a pull is not taken for a radius. Not with --runs: the way back
    /// begins where the way out ended, each of several runs at the start line.
    #[arg(long)]
    pub out_and_back: bool,
    /// Drive this many runs before deciding, each from the start line, and take their mean; not with
    /// --out-and-back [default: 1; umbmark: 5 each way].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=100))]
    pub runs: Option<u16>,
    /// Where the picture goes: a page with everything, or the drawing alone if FILE ends in .svg.
    #[arg(long, short, value_name = "FILE", default_value = "beeline-calibration.html")]
    pub output: PathBuf,
    /// No questions: start without asking whether the robot stands at its line.
    #[arg(long, short)]
    pub yes: bool,
    /// Put back the W_T that was there before the last calibration.
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
    #[arg(long, value_name = "N", allow_hyphen_values = true, default_value_t = 900.0)]
    pub counts_per_rev: f64,
    /// Wheel revolutions driven (both wheels).
    #[arg(long, value_name = "N", allow_hyphen_values = true, default_value_t = 8.0)]
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

/// `beeline sim`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  beeline sim --listen tcp:127.0.0.1:7700 --camera track.csv
  beeline sim --listen pty --port sim:sim-target/scenarios/lossy_link.toml
  beeline sim --scenario > my-robot.toml         a scenario to start from")]
pub struct SimArgs {
    /// tcp:HOST:PORT (port 0: any that is free), or pty.
    #[arg(long, value_name = "WHERE", required_unless_present = "scenario")]
    pub listen: Option<Listen>,
    /// Write what the overhead camera sees to this new file, as a track that `calibrate` can read.
    #[arg(long, value_name = "FILE")]
    pub camera: Option<PathBuf>,
    /// Put the robot back at its start line whenever a client connects and it stands still
    /// (TCP only: on a pseudo-terminal nobody sees a client come).
    #[arg(long)]
    pub reset_on_connect: bool,
    /// Stop after this long.
    #[arg(long = "for", value_name = "TIME", allow_hyphen_values = true, value_parser = above_zero(time))]
    pub duration: Option<Time>,
    /// Print the scenario as TOML and do nothing else.
    #[arg(long)]
    pub scenario: bool,
}
