//! `beeline`: see `beeline --help`.

use std::process::ExitCode;

use clap::Parser;
use host_cli::cli::Cli;
use host_cli::{command, ui};

fn main() -> ExitCode {
    let cli = Cli::parse();
    match command::run(&cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            ui::print_error(&error, cli.common.json);
            ExitCode::from(error.exit_code())
        }
    }
}
