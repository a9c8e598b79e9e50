//! What can be wrong with a campaign, where, and what to do about it.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::bounded_text::{QUOTED_MAX, bounded, shortened};
use crate::os_error::without_os_numbers;
use crate::simulated::Simulated;

/// A place in a file, lines and columns from 1; zero where there is none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file or folder.
    pub file: PathBuf,
    /// Line, 0 for the file as a whole.
    pub line: u64,
    /// Column: the character in a TOML file, the cell in a CSV file; 0 for the line as a whole.
    pub column: u64,
}

impl Place {
    /// The place of a byte in a text.
    pub fn of_byte(file: &Path, text: &str, byte: usize) -> Self {
        let before = &text[..text.floor_char_boundary(byte)];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        Self {
            file: file.into(),
            line: before.matches('\n').count() as u64 + 1,
            column: before[line_start..].chars().count() as u64 + 1,
        }
    }

    /// A file or folder as a whole.
    pub fn whole(file: &Path) -> Self {
        Self { file: file.into(), line: 0, column: 0 }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if self.line > 0 {
            write!(f, ", line {}", self.line)?;
        }
        if self.column > 0 {
            write!(f, ", column {}", self.column)?;
        }
        Ok(())
    }
}

/// Why a campaign could not be read or written.
#[derive(Debug)]
pub struct CampaignError {
    /// Where.
    pub place: Place,
    /// What is wrong.
    pub problem: String,
    /// What to try.
    pub hint: String,
    /// The system's own error, if it was the cause.
    pub cause: Option<io::Error>,
}

impl CampaignError {
    /// A problem, and what to try.
    pub fn new(place: Place, problem: impl Into<String>, hint: impl Into<String>) -> Self {
        let (problem, hint): (String, String) = (problem.into(), hint.into());
        let problem = bounded(&problem, &[]).into_owned();
        Self { place, problem, hint: bounded(&hint, &[]).into_owned(), cause: None }
    }

    /// What the system refused to do with a file.
    pub fn io(path: &Path, doing: &str, cause: io::Error) -> Self {
        let hint = match cause.kind() {
            io::ErrorKind::NotFound => "check the path",
            io::ErrorKind::InvalidData => "it must be UTF-8 text",
            kind => crate::file::hint(kind).unwrap_or("check the path and the disk"),
        };
        Self {
            place: Place::whole(path),
            problem: format!("cannot {doing}"),
            hint: hint.into(),
            cause: Some(cause),
        }
    }
}

impl fmt::Display for CampaignError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.problem)?;
        if let Some(cause) = &self.cause {
            write!(f, " ({})", without_os_numbers(&cause.to_string()))?;
        }
        write!(f, "; {}", self.hint)
    }
}

impl std::error::Error for CampaignError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.cause.as_ref().map(|cause| cause as _)
    }
}

/// A run that is left out, as another has the same rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CopiedRun {
    /// Its name.
    pub name: String,
    /// The run that counts in its place.
    pub of: String,
}

/// Something that does not stop a command, but that the user should know.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// A column that no campaign has.
    UnknownColumn {
        /// Where.
        place: Place,
        /// Its name.
        name: String,
    },
    /// A clock that can hardly be in seconds.
    Clock {
        /// Where.
        place: Place,
        /// The fastest that a wheel turns by it \[rad/s\].
        rate_rad_s: f64,
        /// How many of its units make a second, as likely as not.
        per_s: f64,
    },
    /// The last pose of a run lies far from dead reckoning that began at the first one.
    EndPoseOff {
        /// Where.
        place: Place,
        /// How far, if its position does \[m\].
        position_m: Option<f64>,
        /// How far, if its heading does \[rad\].
        heading_rad: Option<f64>,
    },
    /// Most poses of many runs lie far from where the wheels led, and nothing known explains it.
    ManyRunsOff {
        /// The campaign's `robot.toml`.
        place: Place,
    },
    /// Most poses of a single run lie far from where the wheels led, and nothing known explains it.
    MostPosesOff {
        /// Where.
        place: Place,
        /// How far (rms) \[m\].
        off_m: f64,
    },
    /// A count jumps as no wheel rolls.
    CountsJump {
        /// Where.
        place: Place,
        /// How far the wheel would have rolled \[m\].
        rolled_m: f64,
    },
    /// A single position that is elsewhere.
    Spike {
        /// Where.
        place: Place,
        /// How far off it is \[m\].
        off_m: f64,
    },
    /// Values that are repeated until there are new ones.
    Held {
        /// Where.
        place: Place,
        /// Of which columns.
        columns: &'static str,
        /// Between two new ones \[s\].
        every_s: f64,
    },
    /// The same angle between headings and direction of travel in all runs.
    HeadingOffset {
        /// Where.
        place: Place,
        /// By how much, counter-clockwise positive \[rad\].
        turned_rad: f64,
    },
    /// Runs were measured with another noise than `robot.toml` says.
    OtherNoise {
        /// The campaign's `robot.toml`.
        place: Place,
        /// The key.
        name: &'static str,
        /// What it says.
        there: f64,
        /// The noise of this measurement.
        here: f64,
    },
    /// A campaign of one simulated robot is continued with another.
    OtherRobot {
        /// The campaign's `robot.toml`.
        place: Place,
        /// Which it was.
        before: Simulated,
        /// Which it is.
        now: Simulated,
    },
    /// Runs that are copies of others.
    Copies {
        /// The folder of the runs.
        place: Place,
        /// Which, and of which.
        copies: Vec<CopiedRun>,
    },
    /// A file that looks like a run, but whose name keeps it from being read.
    NotARun {
        /// Where.
        place: Place,
    },
    /// Runs without a start time.
    NoStart {
        /// The campaign's `robot.toml`.
        place: Place,
        /// How many runs.
        runs: usize,
        /// Of how many.
        of: usize,
    },
}

/// `0.31 m and 90 degrees`.
pub fn how_far(position_m: Option<f64>, heading_rad: Option<f64>) -> String {
    let position = position_m.map(|m| format!("{m:.2} m"));
    let heading = heading_rad.map(|rad| format!("{:.0} degrees", rad.to_degrees().abs()));
    [position, heading].into_iter().flatten().collect::<Vec<_>>().join(" and ")
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownColumn { place, name } => {
                let name = shortened(name, QUOTED_MAX);
                write!(f, "{place}: the column `{name}` is unknown and was ignored")
            }
            Self::Clock { place, rate_rad_s, per_s } => clock(f, place, *rate_rad_s, *per_s),
            Self::EndPoseOff { place, position_m, heading_rad } => {
                let off = how_far(*position_m, *heading_rad);
                write!(
                    f,
                    "{place}: the run ends {off} off dead reckoning: the pose was misread, the robot was moved, \
                     or counts were lost; correct the pose, or remove the run if the robot was not the cause"
                )
            }
            Self::ManyRunsOff { place } => write!(
                f,
                "{place}: in most runs the measured poses lie far from where the wheels led, and nothing known explains \
                 it; check wheel_radius_m, counts_per_rev, gear_reduction and track_width_m, and that no wheel lost counts"
            ),
            Self::MostPosesOff { place, off_m } => write!(
                f,
                "{place}: only in this run, most poses lie far from where the wheels led ({off_m:.2} m), and nothing known \
                 explains it: compare its columns with those of the other runs, check the clock of its poses, or remove the run \
                 if somebody pushed the robot"
            ),
            Self::CountsJump { place, rolled_m } => write!(
                f,
                "{place}: in the step to this row the wheel would have rolled {rolled_m:.2} m, many times as fast as in \
                 the rest of the run: a row is corrupt, or counts were lost; correct the row, or remove the run"
            ),
            Self::Spike { place, off_m } => write!(
                f,
                "{place}: this position lies {off_m:.2} m off those before and after it: clear x_m, y_m and \
                 heading_rad in this row"
            ),
            Self::Held { place, columns, every_s } => write!(
                f,
                "{place}: {columns} are new only every {every_s:.2} s and repeated in between: leave their cells empty in \
                 rows without a new value"
            ),
            Self::HeadingOffset { place, turned_rad } => write!(
                f,
                "{place}: in nearly all runs heading_rad differs by {:+.1} degrees from the direction of travel: the heading marker is \
                 mounted at an angle; {turned_rad:.4} was taken out: subtract it from heading_rad, or turn the marker",
                turned_rad.to_degrees()
            ),
            Self::OtherNoise { place, name, there, here } => {
                write!(
                    f,
                    "{place}: {name} = {there}, but this run was measured with {here}; a campaign \
                     has one noise: use one folder for each way of measuring"
                )
            }
            Self::OtherRobot { place, before, now } => write!(
                f,
                "{place}: the simulated robot of this campaign was {before}, and now it is {now}: no model explains the \
                 runs of two robots; use one folder for each robot"
            ),
            Self::Copies { place, copies } => copied(f, place, copies),
            Self::NotARun { place } => write!(
                f,
                "{place}: this file was not read: a run's file ends in .csv, in small letters, and its name is UTF-8; rename it"
            ),
            Self::NoStart { place, runs, of } => no_start(f, place, *runs, *of),
        }
    }
}

fn clock(f: &mut fmt::Formatter<'_>, place: &Place, rate_rad_s: f64, per_s: f64) -> fmt::Result {
    let unit = match per_s {
        per_s if per_s < 1e4 => "milliseconds",
        per_s if per_s < 1e7 => "microseconds",
        _ => "nanoseconds",
    };
    let deg = rate_rad_s.to_degrees();
    // Degrees per second that are not all zeros.
    let digits = (1.0 - deg.log10().floor()).clamp(2.0, 12.0) as usize;
    write!(
        f,
        "{place}: t_s looks like {unit}: no wheel would turn faster than {deg:.digits$} degrees per second; give seconds"
    )
}

fn copied(f: &mut fmt::Formatter<'_>, place: &Place, copies: &[CopiedRun]) -> fmt::Result {
    /// More would not be read.
    const NAMED: usize = 4;
    let named = copies.iter().take(NAMED).map(|copy| format!("{} of {}", copy.name, copy.of));
    let mut named: Vec<String> = named.collect();
    if copies.len() > NAMED {
        named.push(format!("{} more", copies.len() - NAMED));
    }
    let (runs, count) = match copies.len() {
        1 => ("run is a copy", "counts"),
        _ => ("runs are copies", "count"),
    };
    write!(
        f,
        "{place}: {} {runs} of another and {count} only once ({}); remove the copies, and drive again for more evidence",
        copies.len(),
        named.join(", ")
    )
}

fn no_start(f: &mut fmt::Formatter<'_>, place: &Place, runs: usize, of: usize) -> fmt::Result {
    let which = if runs == of { format!("all {of}") } else { format!("{runs} of {of}") };
    write!(
        f,
        "{place}: started_s is missing for {which} runs, so nothing can show whether the \
         robot changes with time (thermal_drift); add started_s to each [[run]] there, in seconds on one clock"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_of_the_system_is_said_without_its_number() {
        let cause = io::Error::from_raw_os_error(2);
        assert!(cause.to_string().ends_with(" (os error 2)"), "{cause}");
        let said = CampaignError::io(Path::new("robot.toml"), "read this file", cause).to_string();
        assert!(said.starts_with("robot.toml: cannot read this file ("), "{said}");
        assert!(said.ends_with("); check the path") && !said.contains("os error"), "{said}");
    }
}
