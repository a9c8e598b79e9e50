//! `beeline`: see `beeline --help`.

use std::process::ExitCode;

use clap::Parser;
use host_cli::cli::Cli;
use host_cli::error::Error;
use host_cli::{command, ui};

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        // Machines get their JSON here too; help is for people.
        Err(error) if error.use_stderr() && std::env::args_os().any(|arg| arg == "--json") => {
            return fail(&Error::from(error), true);
        }
        Err(error) => error.exit(),
    };
    match command::run(&cli).and_then(|()| ui::all_said()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(&error, cli.common.json),
    }
}

fn fail(error: &Error, json: bool) -> ExitCode {
    if !error.to_string().is_empty() {
        ui::print_error(error, json);
    }
    ExitCode::from(error.exit_code())
}
