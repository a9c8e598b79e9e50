//! The command line: its options, and which of their values are valid.
//!
//! What a command does is left to [`crate::command`].

mod analysis;
mod calibrate;
mod campaign;
mod drive;
mod exchange;
mod tune;
mod value_enums;
mod value_parsers;

pub use self::campaign::{
    ApplyArgs, CampaignCommand, CampaignRecordArgs, FloorSize, Mass, PlanArgs, PlanCommandArgs,
};
pub use analysis::{
    AddArgs, CacheArgs, CompareArgs, ExplainArgs, FleetArgs, Format, ModelCommand, RemoveArgs,
    ReportArgs, ServeArgs,
};
pub use calibrate::{CalibrateArgs, WheelWeightArgs};
pub use drive::{DriveArgs, DriveCommand, ProfileArgs, VelocitySource};
pub use exchange::{ExportArgs, ExportFormat, ImportArgs, Mappings};
pub use host_link::listen::Listen;
pub use tune::TuneArgs;
pub use value_enums::{Measure, Method};
pub use value_parsers::period_ms;

use std::path::PathBuf;

use clap::builder::styling::{AnsiColor, Styles};
use clap::{Args, Parser, Subcommand};

use self::value_parsers::{above_zero, key_file, new_file, rate, time, whole};
use crate::port::{Port, SimOptions};
use crate::quantity::Time;
use crate::watch::Column;

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

Exit codes: 0 done, 1 the answer is no, 2 could not run, 130 stopped by Ctrl-C.";

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
    /// The robot: a serial device such as /dev/ttyACM0 or COM3, tcp:HOST:PORT, or the simulator:
    /// sim or sim:SCENARIO.toml. A serial device runs at 921600 baud; append @BAUD, 38400 at least,
    /// for another rate.
    #[arg(
        long,
        short,
        global = true,
        value_name = "PORT",
        default_value = "sim",
        env = "BEELINE_PORT",
        help_heading = "Most commands"
    )]
    pub port: Port,
    /// The file of the robot's key: `beeline key new` makes one.
    #[arg(
        long,
        global = true,
        value_name = "FILE",
        env = "BEELINE_KEY_FILE",
        value_parser = key_file(),
        help_heading = "Most commands"
    )]
    pub key_file: Option<PathBuf>,
    /// Print one JSON value instead of text (`watch`: one per line).
    #[arg(long, global = true, help_heading = "Every command")]
    pub json: bool,
    /// Seed of all random numbers, instead of the scenario's.
    #[arg(long, global = true, value_name = "N", value_parser = whole, help_heading = "Simulator")]
    pub seed: Option<u64>,
    /// The file that holds the robot's flash; without it, the robot forgets when the command ends.
    #[arg(long, global = true, value_name = "FILE", value_parser = new_file(), help_heading = "Simulator")]
    pub flash: Option<PathBuf>,
}

impl Common {
    /// Whether the robot forgets what it saves: a simulated one without a file for its flash.
    pub fn robot_forgets(&self) -> bool {
        matches!(self.port, Port::Sim(_) | Port::Served(..)) && self.flash.is_none()
    }

    /// The options of the simulator, and the key.
    pub fn sim(&self) -> SimOptions {
        SimOptions {
            seed: self.seed,
            flash: self.flash.clone(),
            key_file: self.key_file.clone(),
            key_optional: false,
        }
    }
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// List the serial ports, and other ways to reach a robot.
    Ports,
    /// Show the robot's identity and condition: firmware, state, faults, supply, link.
    Identify,
    /// Read, change and save the robot's configuration.
    #[command(subcommand)]
    Config(ConfigCommand),
    /// Make, set and clear the robot's key. A robot with a key obeys only hosts that have the same key.
    #[command(subcommand)]
    Key(KeyCommand),
    /// Drive a motion: straight, spin, arc, or a velocity for a time.
    #[command(subcommand)]
    Drive(DriveArgs),
    /// Turn one wheel after the other and ask which one turned: finds a front that is the back, and mends it.
    #[command(after_help = "Example:\n  beeline wiring --port /dev/ttyACM0")]
    Wiring,
    /// Brake along a ramp and switch the motors off; --now cuts them at once and latches a fault.
    Stop {
        /// Zero duty at once, as the emergency stop does.
        #[arg(long)]
        now: bool,
    },
    /// Clear the latched fault. No fault clears itself.
    Clear,
    /// Show telemetry live.
    Watch(WatchArgs),
    /// Drive a motion and record it as a run of a campaign folder.
    Record(RecordArgs),
    /// Plan a whole campaign of runs, and record it.
    #[command(subcommand)]
    Campaign(CampaignCommand),
    /// Make a campaign from the logs of other programs: ROS 2 bags, trajectories, tables.
    Import(ImportArgs),
    /// Write the results of a campaign for other programs: parameters, trajectories, bags.
    Export(ExportArgs),
    /// Compare a campaign with a model: how large the error is, where it arises, and what is noise.
    Compare(CompareArgs),
    /// Name the physical effects that a campaign shows and its model lacks.
    Explain(ExplainArgs),
    /// Show and change the model of a campaign: add an effect, and watch the error fall.
    #[command(subcommand)]
    Model(ModelCommand),
    /// Compare many robots and dates: which change with time, which differ from the others, what all have in common.
    Fleet(FleetArgs),
    /// Write everything that a campaign shows to one page.
    Report(ReportArgs),
    /// Open a page: of a campaign, to switch effects on and watch the error fall; or of a robot, to watch and drive it.
    Serve(ServeArgs),
    /// Calibrate W_T by the paper's experiment: drive, measure, compute, write, drive again.
    Calibrate(CalibrateArgs),
    /// Identify the motors, compute feedforward and gains, and keep them if the robot follows better.
    Tune(TuneArgs),
    /// Write radii, track width and pull found in a campaign to the robot.
    Apply(ApplyArgs),
    /// Compute W_T from numbers typed in, as the paper does.
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
        /// A field or a group, such as `geometry.wheel_weight` or `geometry`.
        field: Option<String>,
    },
    /// Change a field, in SI units. Not saved until `config save`.
    #[command(
        after_help = "Example:\n  beeline config set geometry.wheel_weight 0.9919 --save --port /dev/ttyACM0"
    )]
    Set {
        /// The field, such as `geometry.wheel_weight`.
        field: String,
        /// Its new value.
        #[arg(allow_negative_numbers = true)]
        value: String,
        /// Save it at once.
        #[arg(long)]
        save: bool,
    },
    /// Save the configuration in use, so that it survives power-off.
    Save,
    /// Return to the saved configuration, or the factory's.
    Restore {
        /// Return to the factory configuration.
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

/// `beeline key ...`
#[derive(Debug, Subcommand)]
pub enum KeyCommand {
    /// Make a new key, in a file that only you may read.
    #[command(after_help = "Example:\n  beeline key new robot.key")]
    New {
        /// The new file.
        #[arg(value_parser = new_file())]
        file: PathBuf,
    },
    /// Store a key in a robot on a serial line; the robot keeps it without power. To replace a key, give the old one with --key-file.
    #[command(after_help = "Examples:
  beeline key set robot.key --port /dev/ttyACM0
  beeline key set new.key --key-file robot.key --port /dev/ttyACM0")]
    Set {
        /// The file of the key.
        file: PathBuf,
    },
    /// Remove the robot's key: the robot then obeys any host that can reach it. Give the key with --key-file.
    #[command(
        after_help = "Example:\n  beeline key clear --key-file robot.key --port /dev/ttyACM0"
    )]
    Clear,
}

/// `beeline watch`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
On a terminal: state and faults with what to do, who drives, supply, both wheels with speed, setpoint, following error
and duty, the path, and how much telemetry was lost. Keys: s or space is the emergency stop, p pauses, q quits.

Examples:
  beeline watch --port /dev/ttyACM0
  beeline watch --plain --for 5s
  beeline watch --columns time,left-counts,right-counts,left-duty,right-duty")]
pub struct WatchArgs {
    /// Frames per second, 1 to 1000: a divisor of 1000 [default: 50 on the whole screen, 10 as lines].
    #[arg(long, value_parser = rate)]
    pub rate: Option<u16>,
    /// Print lines even on a terminal.
    #[arg(long)]
    pub plain: bool,
    /// Print lines with these columns.
    #[arg(
        long,
        value_name = "COLUMN,...",
        value_delimiter = ',',
        value_enum,
        conflicts_with = "json"
    )]
    pub columns: Vec<Column>,
    /// Stop after this time [default: at Ctrl-C; simulator: after 2 s of its own time].
    #[arg(long = "for", value_name = "TIME", allow_hyphen_values = true, value_parser = above_zero(time))]
    pub duration: Option<Time>,
}

/// `beeline record`
#[derive(Args, Clone, Debug)]
#[command(
    after_help = "Examples:\n  beeline record my-robot straight 8rev\n  beeline record my-robot spin 360deg --name spin_left --port /dev/ttyACM0\n  beeline record my-robot straight 2m --mcap straight.mcap"
)]
pub struct RecordArgs {
    /// The campaign folder; made if it does not exist.
    pub campaign: PathBuf,
    /// Name of the run, by default its kind. A number is put before it.
    #[arg(long, global = true)]
    pub name: Option<String>,
    /// Samples per second, 1 to 1000: a divisor of 1000.
    #[arg(long, global = true, default_value_t = 100, value_parser = rate)]
    pub rate: u16,
    /// Write the run as a ROS 2 bag as well, in this new file: wheel angles, measured poses, and odometry computed with the
    /// robot's configuration.
    #[arg(long, global = true, value_name = "FILE.mcap", value_parser = new_file())]
    pub mcap: Option<PathBuf>,
    /// The motion.
    #[command(subcommand)]
    pub motion: DriveCommand,
}

/// `beeline sim`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  beeline sim --listen tcp:127.0.0.1:7700 --camera track.csv
  beeline sim --listen tcp:0.0.0.0:7700 --key-file robot.key
  beeline sim --listen pty --port sim:sim-target/scenarios/lossy_link.toml
  beeline sim --scenario > my-robot.toml         a scenario to start from")]
pub struct SimArgs {
    /// Where to listen: tcp:HOST:PORT (port 0 takes any free one), or pty.
    #[arg(long, value_name = "WHERE", required_unless_present = "scenario")]
    pub listen: Option<Listen>,
    /// Let other machines connect without a key: anyone who connects can drive the robot.
    #[arg(long)]
    pub insecure: bool,
    /// Write what the overhead camera sees to this new file, as a track that `calibrate` can read.
    #[arg(long, value_name = "FILE", value_parser = new_file())]
    pub camera: Option<PathBuf>,
    /// Put the robot back at its start line whenever a client connects and it stands still
    /// (TCP only: a pseudo-terminal does not report connections).
    #[arg(long)]
    pub reset_on_connect: bool,
    /// Stop after this time [default: at Ctrl-C].
    #[arg(long = "for", value_name = "TIME", allow_hyphen_values = true, value_parser = above_zero(time))]
    pub duration: Option<Time>,
    /// Print the scenario as TOML and do nothing else.
    #[arg(long)]
    pub scenario: bool,
}
