//! Carries out the commands of the command line: one file a command.
//!
//! A command reads its options, calls the library, and prints the result.

mod apply;
mod calibrate;
mod campaign;
mod compare;
mod config;
mod drive;
mod explain;
mod export;
mod fleet;
mod identify;
mod import;
mod key;
mod model;
mod model_arguments;
mod motor_model;
mod motors;
mod ports;
mod pose_source;
mod record;
mod report;
mod serve;
mod sim;
mod tune;
mod umbmark;
mod undo;
mod velocity;
mod watch;
mod wheel_weight;
mod wiring;

use clap::{CommandFactory, Parser};

use crate::cli::{CampaignCommand, Cli, Command, DriveArgs};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::ui::say_text;

/// Carries out the command line.
pub fn run(cli: &Cli) -> Result<()> {
    let common = &cli.common;
    let Some(command) = &cli.command else {
        let calibrate = Cli::parse_from(["beeline", "calibrate"]);
        return run(&Cli { common: common.clone(), ..calibrate });
    };
    if ends_in_good_order(command) {
        interrupt::listen();
    }
    match command {
        Command::Ports => ports::run(common),
        Command::Identify => identify::run(common),
        Command::Config(args) => config::run(common, args),
        Command::Key(args) => key::run(common, args),
        Command::Drive(DriveArgs::Motion(motion)) => drive::run(common, motion),
        Command::Drive(DriveArgs::Velocity { forward, turn, duration, acceleration }) => {
            velocity::run(common, *forward, *turn, *duration, *acceleration)
        }
        Command::Wiring => wiring::run(common),
        Command::Stop { now } => drive::stop(common, *now),
        Command::Clear => drive::clear(common),
        Command::Watch(args) => watch::run(common, args),
        Command::Record(args) => record::run(common, args),
        Command::Campaign(args) => campaign::run(common, args),
        Command::Calibrate(args) => calibrate::run(common, args),
        Command::Tune(args) => tune::run(common, args),
        Command::Apply(args) => apply::run(common, args),
        Command::Compare(args) => compare::run(common, args),
        Command::Explain(args) => explain::run(common, args),
        Command::Fleet(args) => fleet::run(common, args),
        Command::Import(args) => import::run(common, args),
        Command::Export(args) => export::run(common, args),
        Command::Model(args) => model::run(common, args),
        Command::Report(args) => report::run(common, args),
        Command::Serve(args) => serve::run(common, args, run),
        Command::WheelWeight(args) => wheel_weight::run(common, args),
        Command::Sim(args) => sim::run(common, args),
        Command::Completions { .. } if common.json => {
            Err(Error::new("a script for a shell is no JSON").hint("leave --json out"))
        }
        Command::Completions { shell } => {
            say_completions(*shell);
            Ok(())
        }
    }
}

/// Whether Ctrl-C asks a command to end in good order, as one does that moves a robot. The others it ends at once.
fn ends_in_good_order(command: &Command) -> bool {
    match command {
        Command::Campaign(args) => !matches!(args, CampaignCommand::Plan(_)),
        Command::Drive(_)
        | Command::Wiring
        | Command::Watch(_)
        | Command::Record(_)
        | Command::Calibrate(_)
        | Command::Tune(_)
        | Command::Apply(_)
        | Command::Sim(_) => true,
        _ => false,
    }
}

fn say_completions(shell: clap_complete::Shell) {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "beeline", &mut script);
    say_text(String::from_utf8_lossy(&script).trim_end());
}
