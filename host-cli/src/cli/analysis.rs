//! The commands that compare a campaign with a model, and explain it.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use robot_model::effect::custom::Per;

use super::value_parsers::{above_zero, new_file, new_file_named};
use crate::fit_cache::FitCache;
use crate::quantity::Length;

/// How a result is printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people.
    #[default]
    Text,
    /// One JSON value, as --json does.
    Json,
}

impl Format {
    /// Whether this is JSON.
    pub fn is_json(self) -> bool {
        self == Self::Json
    }
}

/// Whether what was found before is used again.
#[derive(Args, Clone, Copy, Debug)]
pub struct CacheArgs {
    /// Fit again even if nothing has changed since the last fit, and do not keep what is found.
    #[arg(long)]
    pub no_cache: bool,
}

impl CacheArgs {
    /// What was found before.
    pub fn cache(self, quiet: bool) -> FitCache {
        if self.no_cache { FitCache::none() } else { FitCache::of_user(quiet) }
    }
}

/// `beeline compare`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Compares with the campaign's model.toml, or with the nominal robot where there is none.

Examples:
  beeline compare my-robot
  beeline compare --drivetrain my-motors      its motors: voltages against counts
  beeline compare my-robot --format json")]
pub struct CompareArgs {
    /// The campaign folder.
    pub campaign: PathBuf,
    /// Use this model instead of the campaign's own.
    #[arg(long, value_name = "FILE", conflicts_with = "drivetrain")]
    pub model: Option<PathBuf>,
    /// Compare the model of the motors with what they did: needs voltages and counts, and no poses.
    #[arg(long)]
    pub drivetrain: bool,
    /// Text for people, or JSON.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Whether what was found before is used again.
    #[command(flatten)]
    pub reuse: CacheArgs,
}

/// `beeline explain`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Tests all effects of the catalogue, and those that the campaign's model.toml defines.

Examples:
  beeline explain my-robot
  beeline explain --drivetrain my-motors      what its motors lack: see `beeline tune --record`
  beeline explain my-robot --format json")]
pub struct ExplainArgs {
    /// The campaign folder.
    pub campaign: PathBuf,
    /// Text for people, or JSON.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Explain how the motors respond to voltages: needs voltages and counts, and no poses.
    #[arg(long, conflicts_with_all = ["tolerance", "save"])]
    pub drivetrain: bool,
    /// Report effects that move the robot by less than this as too small to matter, for example 0.2mm
    /// [default: a tenth of the noise of one pose].
    #[arg(long, value_parser = above_zero(|length: &Length| length.m))]
    pub tolerance: Option<Length>,
    /// Write the model found to this file, to predict other runs: `beeline compare OTHER --model FILE`.
    /// Of effects that these runs cannot tell apart it has all, each with its share.
    #[arg(long, value_name = "FILE", value_parser = new_file())]
    pub save: Option<PathBuf>,
    /// Exit with 1 if something that matters is missing, as `git diff` does.
    #[arg(long)]
    pub exit_code: bool,
    /// Whether what was found before is used again.
    #[command(flatten)]
    pub reuse: CacheArgs,
}

/// `beeline model ...`
#[derive(Clone, Debug, Subcommand)]
pub enum ModelCommand {
    /// Show the model: its effects and their values, and of the path its error.
    #[command(after_help = "Example:\n  beeline model show my-robot")]
    Show {
        /// The campaign folder, or a model.toml.
        campaign: PathBuf,
        /// Show the model of the motors, motors.toml.
        #[arg(long)]
        drivetrain: bool,
    },
    /// Add effects, fit the model again, and show whether it improved.
    Add(AddArgs),
    /// Remove effects, fit the model again, and show what that costs.
    Remove(RemoveArgs),
    /// Fit the model's effects to the campaign again.
    #[command(after_help = "Example:\n  beeline model fit my-robot")]
    Fit {
        /// The campaign folder.
        campaign: PathBuf,
        /// Fit the model of the motors: needs voltages and counts, and no poses.
        #[arg(long, conflicts_with = "model")]
        drivetrain: bool,
        /// Use this model instead of the campaign's own.
        #[arg(long, value_name = "FILE")]
        model: Option<PathBuf>,
    },
}

/// `beeline model add`
#[derive(Args, Clone, Debug)]
#[command(
    override_usage = "beeline model add [OPTIONS] [EFFECT]... <CAMPAIGN>",
    after_help = "\
An effect of your own is an equation. On its left: ds_left, ds_right, dtheta or dn (sideways),
followed by /dt, /ds or /dtheta for per second, metre or radian. On its right: v, v_left, v_right,
omega, a, a_left, a_right, theta, phi_left, phi_right, s, t, t_run, payload; sin, cos, tan, exp, ln,
sqrt, tanh, abs, sign, min, max; numbers, with a unit if need be: 0.3[m/s]. Every other name is a
parameter to be fitted; its unit is derived, or checked if you give it.

With --drivetrain the left side is dV (volts that the motor needs), dkS (friction), dkV or dkA, followed
by _left or _right for one motor. On its right: v, v_other, volts, volts_other, load, phi,
theta, t, side.

Examples:
  beeline model add wheel_radius_ratio my-robot
  beeline model add --custom \"dtheta = k * v^2 * omega\" my-robot
  beeline model add backlash --drivetrain my-motors      its motors: see `beeline explain --drivetrain`
  beeline model add --custom \"dkS_right = k * max(0, cos(phi))\" --drivetrain my-motors"
)]
pub struct AddArgs {
    /// Effects of the catalogue, then the campaign folder.
    #[arg(required = true, value_name = "EFFECT... CAMPAIGN")]
    pub what: Vec<PathBuf>,
    /// Add effects of motors: needs voltages and counts, and no poses.
    #[arg(long, conflicts_with_all = ["model", "per"])]
    pub drivetrain: bool,
    /// An effect of your own, as an equation (see below).
    #[arg(long, value_name = "EQUATION")]
    pub custom: Vec<String>,
    /// Its name in model.toml, or in motors.toml.
    #[arg(long, value_name = "ID", requires = "custom")]
    pub name: Vec<String>,
    /// What the left side is divided by, if the equation does not say: second, metre or radian.
    #[arg(long, requires = "custom", value_parser = per)]
    pub per: Option<Per>,
    /// Unit of a parameter, to be checked against the equation: k=s^2/m^2.
    #[arg(long, value_name = "NAME=UNIT", requires = "custom", value_parser = unit)]
    pub unit: Vec<(String, String)>,
    /// Plausible range of a parameter: k=-0.1..0.1.
    #[arg(long, value_name = "NAME=LOW..HIGH", requires = "custom", value_parser = range)]
    pub range: Vec<(String, [f64; 2])>,
    /// Use this model instead of the campaign's own.
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
}

/// `beeline model remove`
#[derive(Args, Clone, Debug)]
#[command(
    override_usage = "beeline model remove [OPTIONS] <EFFECT>... <CAMPAIGN>",
    after_help = "Example:\n  beeline model remove wheel_radius_ratio my-robot"
)]
pub struct RemoveArgs {
    /// Effects, then the campaign folder.
    #[arg(required = true, value_name = "EFFECT... CAMPAIGN")]
    pub what: Vec<PathBuf>,
    /// Remove effects of motors.
    #[arg(long, conflicts_with = "model")]
    pub drivetrain: bool,
    /// Use this model instead of the campaign's own.
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
}

/// `beeline fleet`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
A robot is identified by its number or its name. The date of a campaign is started_s (if it counts from 1970), a date in the
folder's name, or the time of its newest run. Robots with the same nominal geometry are one kind, fitted with the same effects.

Examples:
  beeline fleet robots/ -o fleet.html
  beeline fleet robots/*/2025-* --table values.csv
  beeline fleet robots/ --json")]
pub struct FleetArgs {
    /// Campaign folders, or folders that contain some.
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Where to write the page, one self-contained file.
    #[arg(long, short, value_name = "FILE.html", value_parser = new_file_named("html"))]
    pub output: Option<PathBuf>,
    /// Where to write a table with one value in each row.
    #[arg(long, value_name = "FILE.csv", value_parser = new_file_named("csv"))]
    pub table: Option<PathBuf>,
}

/// `beeline report`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  beeline report my-robot -o report.html
  beeline report --drivetrain my-motors -o motors.html  its motors: see `beeline tune --record`
  beeline report my-robot --interactive -o try.html     the page of `beeline serve`, to send to somebody")]
pub struct ReportArgs {
    /// The campaign folder.
    pub campaign: PathBuf,
    /// Where to write the page, one self-contained file. FILE.svg: only its main picture.
    #[arg(long, short, value_name = "FILE", default_value = "report.html", value_parser = new_file())]
    pub output: PathBuf,
    /// The motors of the campaign: voltages against counts, as in `explain --drivetrain`.
    #[arg(long, conflicts_with = "interactive")]
    pub drivetrain: bool,
    /// Write the page of `beeline serve` with its answers in it: effects can be switched without a server.
    #[arg(long)]
    pub interactive: bool,
    /// Whether what was found before is used again.
    #[command(flatten)]
    pub reuse: CacheArgs,
}

/// `beeline serve`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
With a campaign: switch effects of the catalogue on and off, and see at once the cross-validated and the held-out
error, paths and residuals. Only model.toml changes, and only if you save.

Without one: watch the robot at --port live, drive it while you hold a button, and be guided through a calibration,
a tuning or a campaign. This program then has the serial port open; other beeline commands with the same --port go
through it. With both, the page shows what the campaign's model predicts.

Examples:
  beeline serve my-robot
  beeline serve --port /dev/ttyACM0
  beeline serve my-robot --port /dev/ttyACM0
  beeline serve                          a simulated robot")]
pub struct ServeArgs {
    /// The campaign folder; without it, or with --port, the page is that of the robot.
    pub campaign: Option<PathBuf>,
    /// Where the page is served. Beyond this machine only someone with the printed link can open it
    /// [default: 127.0.0.1:7780, or another port if that is taken].
    #[arg(long, value_name = "IP:PORT")]
    pub listen: Option<SocketAddr>,
    /// Do not open a browser.
    #[arg(long)]
    pub no_open: bool,
    /// Whether what was found before is used again.
    #[command(flatten)]
    pub reuse: CacheArgs,
}

fn per(text: &str) -> Result<Per, String> {
    let known = Per::ALL.into_iter().find(|per| per.name() == text);
    known.ok_or_else(|| format!("must be {}", Per::ALL.map(Per::name).join(", ")))
}

fn unit(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, unit)) => Ok((name.trim().to_owned(), unit.trim().to_owned())),
        None => Err("must be NAME=UNIT, for example k=s/m".to_owned()),
    }
}

fn range(text: &str) -> Result<(String, [f64; 2]), String> {
    let parse = || {
        let (name, range) = text.split_once('=')?;
        let (low, high) = range.split_once("..")?;
        Some((name.trim().to_owned(), [low.trim().parse().ok()?, high.trim().parse().ok()?]))
    };
    parse().ok_or_else(|| "must be NAME=LOW..HIGH, for example k=-0.1..0.1".to_owned())
}
