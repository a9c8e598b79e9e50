//! `beeline campaign ...`

use std::path::PathBuf;
use std::str::FromStr;

use campaign::range::PAYLOAD_KG;
use clap::{Args, Subcommand};

use super::value_parsers::{above_zero, acceleration, angle, count, length, speed};
use super::{CacheArgs, Measure};
use crate::quantity::{Acceleration, Angle, Length, Speed};

/// `beeline campaign ...`
#[derive(Clone, Debug, Subcommand)]
pub enum CampaignCommand {
    /// Show the runs of a campaign, or write them to a file for editing. Needs no robot.
    #[command(after_help = "\
Examples:
  beeline campaign plan
  beeline campaign plan --floor 2mx4m --payload 3kg -o plan.toml
  beeline campaign plan --plan plan.toml        floor and time of an edited plan")]
    Plan(PlanCommandArgs),
    /// Drive a whole campaign and record it; the same command continues after an interruption.
    #[command(after_help = "\
How the robot is measured (--measure):
  camera      the simulator's overhead camera (default on the simulator)
  ask         you type the pose that a tape reads (1.795m -12mm 3deg) after each run, or a
              track file's name, `repeat`, `skip`, or Enter for none; before a run you confirm
              that the robot stands at its mark, or type where else (default elsewhere)
  track:FILE  a CSV (t_s,x_m,y_m[,heading_rad]) that a tracking system appends to
  none        nothing measures it: add poses to the files later

Kinds of single runs (--run), as `explain` suggests them:
  rest, straight, out-and-back, \"six short out-and-backs\", spin, \"spins both ways\", arc,
  \"arcs both ways\", \"straights at three speeds\", \"arcs of two radii\", \"arcs at two speeds\",
  square, \"square both ways\", \"out-and-back in four headings\",
  \"out-and-back with and without a load\", \"out-and-back, an hour later\"
The name of a run of the campaign's plan drives that run once more.

Examples:
  beeline campaign record my-robot
  beeline campaign record my-robot --plan plan.toml --port /dev/ttyACM0 --measure track:track.csv
  beeline campaign record my-robot --run spin")]
    Record(CampaignRecordArgs),
}

/// `beeline campaign plan`
#[derive(Args, Clone, Debug)]
pub struct PlanCommandArgs {
    /// What to plan for.
    #[command(flatten)]
    pub plan: PlanArgs,
    /// Distance between the wheels.
    #[arg(long, value_name = "LENGTH", default_value = "37.2cm", allow_hyphen_values = true, value_parser = above_zero(length))]
    pub track_width: Length,
    /// Write the plan as TOML; `-` for standard output.
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Replace a file that exists.
    #[arg(long)]
    pub force: bool,
}

/// What a campaign is planned for.
#[derive(Args, Clone, Debug, Default)]
pub struct PlanArgs {
    /// Use the plan in this file instead of the usual one.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["floor", "slow", "fast", "acceleration", "repeats", "payload"])]
    pub plan: Option<PathBuf>,
    /// Free floor [default: 3mx3m].
    #[arg(long, value_name = "LENGTHxLENGTH")]
    pub floor: Option<FloorSize>,
    /// The slow speed, of the faster wheel [default: 0.12 m/s].
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true, value_parser = above_zero(speed))]
    pub slow: Option<Speed>,
    /// The fast speed, of the faster wheel [default: 0.35 m/s, or what the robot may drive].
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true, value_parser = above_zero(speed))]
    pub fast: Option<Speed>,
    /// Acceleration of the ramps [default: 0.3 m/s^2].
    #[arg(long, value_name = "ACCELERATION", allow_hyphen_values = true, value_parser = above_zero(acceleration))]
    pub acceleration: Option<Acceleration>,
    /// Drive every run this many times [default: 1].
    #[arg(long, value_name = "N", value_parser = count(20))]
    pub repeats: Option<u16>,
    /// Add an out-and-back run with this load on board.
    #[arg(long, value_name = "MASS")]
    pub payload: Option<Mass>,
}

impl PlanArgs {
    /// Whether any of them was given.
    pub fn any(&self) -> bool {
        self.plan.is_some()
            || self.floor.is_some()
            || self.slow.is_some()
            || self.fast.is_some()
            || self.acceleration.is_some()
            || self.repeats.is_some()
            || self.payload.is_some()
    }
}

/// `beeline campaign record`
#[derive(Args, Clone, Debug)]
pub struct CampaignRecordArgs {
    /// The campaign folder; made if it does not exist.
    pub campaign: PathBuf,
    /// What to plan for.
    #[command(flatten)]
    pub plan: PlanArgs,
    /// Record only runs of this kind, or a run of the plan once more, and add them to the campaign.
    #[arg(long, value_name = "KIND", conflicts_with = "plan")]
    pub run: Option<String>,
    /// camera, ask, track:FILE or none.
    #[arg(long, value_name = "HOW")]
    pub measure: Option<Measure>,
    /// A CSV file (t_s,gyro_z_rad_s) that a gyro's logger appends to, on any clock.
    #[arg(long, value_name = "FILE")]
    pub gyro: Option<PathBuf>,
    /// Noise of the measured positions, one sigma [default: 2 mm for a tape, else estimated from the data].
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = above_zero(length))]
    pub position_sigma: Option<Length>,
    /// Noise of the measured headings, one sigma [default: 10 mrad for a tape, else estimated from the data].
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, value_parser = above_zero(angle))]
    pub heading_sigma: Option<Angle>,
    /// Samples per second.
    #[arg(long, default_value_t = 50, value_parser = count(1000))]
    pub rate: u16,
    /// Do not ask; assume that the robot stands at its mark before each run.
    #[arg(long, short)]
    pub yes: bool,
}

/// `beeline apply`
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Writes the effects of the campaign's model.toml, or without one those that
`explain` finds. The firmware can compensate both wheel radii (R_L and W_T),
the track width and a pull to one side. Other effects are listed with remedies.

Examples:
  beeline apply my-robot --port /dev/ttyACM0
  beeline apply --undo --port /dev/ttyACM0")]
pub struct ApplyArgs {
    /// The campaign folder.
    #[arg(required_unless_present = "undo")]
    pub campaign: Option<PathBuf>,
    /// Write without asking.
    #[arg(long, short)]
    pub yes: bool,
    /// Restore the configuration that was in use before the last `apply`.
    #[arg(long, conflicts_with = "campaign")]
    pub undo: bool,
    /// Whether what was found before is used again.
    #[command(flatten)]
    pub reuse: CacheArgs,
}

/// Free floor, `3mx2.5m` or `3m` \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloorSize(pub [f64; 2]);

impl FromStr for FloorSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |text: &str| -> Result<f64, String> {
            let length: Length = text.trim().parse().map_err(|error| format!("{error}"))?;
            if length.m > 0.0 { Ok(length.m) } else { Err("must be above zero".into()) }
        };
        match text.split_once('x') {
            Some((a, b)) => Ok(Self([side(a)?, side(b)?])),
            None => side(text).map(|side| Self([side; 2])),
        }
    }
}

/// A mass \[kg\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mass(pub f64);

impl FromStr for Mass {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, kg) = match (text.strip_suffix("kg"), text.strip_suffix('g')) {
            (Some(number), _) => (number, 1.0),
            (None, Some(number)) => (number, 1e-3),
            (None, None) => return Err("no unit: 3kg or 500g".into()),
        };
        match number.trim().parse::<f64>().map(|number| number * kg) {
            Ok(kg) if kg > 0.0 && PAYLOAD_KG.contains(kg) => Ok(Self(kg)),
            _ => Err(format!("must be a number above zero, and kg or g; {PAYLOAD_KG}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floors_and_masses_take_units_and_refuse_nonsense() {
        assert_eq!("3mx250cm".parse(), Ok(FloorSize([3.0, 2.5])));
        assert_eq!("2m".parse(), Ok(FloorSize([2.0, 2.0])));
        assert_eq!("500g".parse(), Ok(Mass(0.5)));
        for bad in ["", "3", "x", "3mx", "-1m", "3m x -2m"] {
            assert!(bad.parse::<FloorSize>().is_err(), "{bad}");
        }
        for bad in ["", "3", "kg", "-1kg", "nankg", "infkg", "200000kg", "1e300g"] {
            assert!(bad.parse::<Mass>().is_err(), "{bad}");
        }
    }
}
