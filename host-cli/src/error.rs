//! The error that a person reads: what failed, on what, and what to try.
//!
//! The advice for errors of the link and of plans is in [`crate::advice`].

use std::fmt;

use campaign::CampaignError;
use campaign::bounded_text::bounded;
use campaign::os_error::without_os_numbers;
use campaign::plan::PlanError;
use campaign::words::recording_error;
use robot_model::recording::RecordingError;
use sim_link::ServeError;
use sim_target::scenario::ScenarioError;

use crate::advice;
use crate::interrupt;

/// An error for a person to read.
#[derive(Debug)]
pub struct Error {
    what: String,
    hint: Option<String>,
    kind: Kind,
    details: Option<serde_json::Value>,
}

/// How the command ended; decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The command could not run: exit code 2.
    CouldNotRun,
    /// The same, because the connection broke: another one may do.
    CutOff,
    /// The command ran, and its answer is no: exit code 1.
    SaidNo,
    /// The user stopped it: exit code 130, as shells do.
    Interrupted,
}

/// A result for a person to read.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// The command could not run. Errors of the system that the text names lose their numbers, and quotations their length.
    pub fn new(what: impl fmt::Display) -> Self {
        let what = without_os_numbers(&what.to_string());
        let what = bounded(&what, &[]).into_owned();
        Self { what, hint: None, kind: Kind::CouldNotRun, details: None }
    }

    /// The command ran, and its answer is no.
    pub fn said_no(what: impl fmt::Display) -> Self {
        Self { kind: Kind::SaidNo, ..Self::new(what) }
    }

    /// The answer was printed already, and it is no: exit code 1 without a message.
    pub fn answered_no() -> Self {
        Self::said_no("")
    }

    /// The user stopped it.
    pub fn interrupted(what: impl fmt::Display) -> Self {
        Self { kind: Kind::Interrupted, ..Self::new(what) }
    }

    /// Adds what to try.
    pub fn hint(mut self, hint: impl fmt::Display) -> Self {
        self.hint = Some(bounded(&hint.to_string(), &[]).into_owned());
        self
    }

    /// Adds what was found in spite of the error, as a JSON object.
    pub fn details(mut self, details: serde_json::Value) -> Self {
        self.details = Some(details);
        self
    }

    /// The error as JSON: what was found, what failed, what to try, and the exit code.
    pub fn to_json(&self) -> serde_json::Value {
        let mut value = self.details.clone().unwrap_or_else(|| serde_json::json!({}));
        value["error"] = self.what.as_str().into();
        value["hint"] = self.hint.as_deref().into();
        value["exit_code"] = self.exit_code().into();
        value
    }

    /// Whether the connection broke.
    pub fn is_cut_off(&self) -> bool {
        self.kind == Kind::CutOff
    }

    /// Whether the user stopped it.
    pub fn is_interrupted(&self) -> bool {
        self.kind == Kind::Interrupted
    }

    /// The process's exit code.
    pub fn exit_code(&self) -> u8 {
        match self.kind {
            Kind::CouldNotRun | Kind::CutOff => 2,
            Kind::SaidNo => 1,
            Kind::Interrupted => 130,
        }
    }

    /// What to try, if there is advice.
    pub fn hint_text(&self) -> Option<&str> {
        self.hint.as_deref()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

impl std::error::Error for Error {}

impl From<clap::Error> for Error {
    fn from(error: clap::Error) -> Self {
        let text = error.render().to_string();
        // Blocks separated by blank lines: the problem, tips, the usage. The names of arguments are
        // in the indented lines of the first block.
        let mut blocks = text.split("\n\n").map(|block| {
            block
                .lines()
                .map(str::trim)
                .filter(|line| !line.is_empty())
                .collect::<Vec<_>>()
                .join(" ")
        });
        let what = blocks.next().unwrap_or_default();
        // Clap quotes by them, and has no apostrophes.
        let what = bounded(&what, &['\'']);
        let tip = blocks.find_map(|block| block.strip_prefix("tip: ").map(str::to_owned));
        Error::new(what.strip_prefix("error: ").unwrap_or(&what))
            .hint(tip.as_deref().unwrap_or("`beeline --help`"))
    }
}

impl From<CampaignError> for Error {
    fn from(error: CampaignError) -> Self {
        let cause = error.cause.map(|cause| format!(" ({cause})")).unwrap_or_default();
        Error::new(format_args!("{}: {}{cause}", error.place, error.problem)).hint(error.hint)
    }
}

impl From<RecordingError> for Error {
    fn from(error: RecordingError) -> Self {
        Error::new(recording_error(&error))
    }
}

impl From<ScenarioError> for Error {
    fn from(error: ScenarioError) -> Self {
        let place = error.place.map(|(line, column)| format!(", line {line}, column {column}"));
        let place = place.unwrap_or_default();
        Error::new(format_args!("{}{place}: {}", error.origin, error.problem)).hint(error.hint)
    }
}

impl From<host_link::Error> for Error {
    fn from(error: host_link::Error) -> Self {
        let converted = match &error {
            host_link::Error::Cancelled(left) => {
                Error::interrupted(format_args!("{}{left}", interrupt::words()))
            }
            host_link::Error::ConnectionLost { .. } => {
                Error { kind: Kind::CutOff, ..Error::new(&error) }
            }
            _ => Error::new(&error),
        };
        match advice::on_link(&error) {
            Some(advice) => converted.hint(advice),
            None => converted,
        }
    }
}

impl From<PlanError> for Error {
    fn from(error: PlanError) -> Self {
        Error::new(&error).hint(advice::on_plan(&error))
    }
}

impl From<ServeError> for Error {
    fn from(error: ServeError) -> Self {
        let (converted, hint) = match error {
            ServeError::Link(error) => return error.into(),
            ServeError::ResetOnPty => (Error::new(&error), "--listen tcp:127.0.0.1:0"),
            ServeError::CameraExists(_) => (
                Error::new(&error),
                "--camera FILE makes a new track: name another one, or move this one away",
            ),
            ServeError::CameraNew(..) => {
                (Error::new(&error), "--camera FILE names the track file to write")
            }
            ServeError::CameraWrite(..) => {
                (Error::new(&error), "the camera's track is written there: is the disk full?")
            }
        };
        converted.hint(hint)
    }
}

/// Adds to an error on what the operation failed.
pub trait Context<T> {
    /// `"{what}: {the error}"`.
    fn context(self, what: impl fmt::Display) -> Result<T>;
}

impl<T, E: fmt::Display> Context<T> for std::result::Result<T, E> {
    fn context(self, what: impl fmt::Display) -> Result<T> {
        self.map_err(|error| Error::new(format_args!("{what}: {error}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_of_the_system_is_said_without_its_number() {
        let missing = || std::io::Error::from_raw_os_error(2);
        let words = missing().to_string();
        let words = words.strip_suffix(" (os error 2)").unwrap();
        let of_a_file: Result<()> = Err(missing()).context("cannot read a.toml");
        let of_a_file = of_a_file.unwrap_err();
        assert_eq!(of_a_file.to_string(), format!("cannot read a.toml: {words}"));
        assert_eq!(of_a_file.to_json()["error"], format!("cannot read a.toml: {words}"));
        let file = std::path::Path::new("robot.toml");
        let of_a_campaign = Error::from(CampaignError::io(file, "read this file", missing()));
        assert_eq!(
            of_a_campaign.to_string(),
            format!("robot.toml: cannot read this file ({words})")
        );
    }
}
