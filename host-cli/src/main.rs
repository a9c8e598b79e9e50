//! `beeline`: see `beeline --help`.

use std::process::ExitCode;
#[cfg(unix)]
use std::sync::Arc;

use campaign::bounded_text::MESSAGE_MAX;
use clap::Parser;
use host_cli::cli::Cli;
use host_cli::error::Error;
use host_cli::{command, ui};

fn main() -> ExitCode {
    // A file that grows beyond `ulimit -f` is an error where it is written: by default the signal ends the process there.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        // With --json these errors are JSON too; help stays text.
        Err(error) if error.use_stderr() && std::env::args_os().any(|arg| arg == "--json") => {
            return fail(&Error::from(error), true);
        }
        // An argument that nobody would read.
        Err(error) if error.use_stderr() && error.to_string().len() > MESSAGE_MAX => {
            return fail(&Error::from(error), false);
        }
        Err(error) => error.exit(),
    };
    if let Err(error) = command::run(&cli) {
        return fail(&error, cli.common.json);
    }
    match ui::finish_output() {
        Ok(()) => ExitCode::SUCCESS,
        // As text even with --json: standard output, where JSON goes, cannot be written.
        Err(error) => fail(&error, false),
    }
}

fn fail(error: &Error, json: bool) -> ExitCode {
    if !error.to_string().is_empty() {
        ui::print_error(error, json);
    }
    ExitCode::from(error.exit_code())
}
