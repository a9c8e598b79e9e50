//! Which campaigns there are, and when each was driven.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use campaign::Campaign;

/// Folders are searched so deep: fleet, robot, date, campaign.
const DEPTH_MAX: usize = 4;
/// `started_s` above this counts from 1970; recorders that count from their own beginning stay below it \[s\].
const SINCE_1970_S: f64 = 1e9;
const DAY_S: f64 = 86_400.0;

/// When a campaign was driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dated {
    /// Days since 1970, in UTC; `None` if nothing says it.
    pub days: Option<f64>,
    /// What says it: `started_s`, `name` of the folder, or `file` for the time of its newest run.
    pub by: &'static str,
}

/// The campaigns in these folders: each is one, or has some in it. By name. The error names the folder that cannot be
/// listed.
pub fn campaigns(folders: &[PathBuf]) -> Result<Vec<PathBuf>, (PathBuf, std::io::Error)> {
    let mut found = Vec::new();
    for folder in folders {
        search(folder, DEPTH_MAX, &mut found)?;
    }
    found.sort();
    found.dedup();
    Ok(found)
}

fn search(
    folder: &Path,
    deeper: usize,
    found: &mut Vec<PathBuf>,
) -> Result<(), (PathBuf, std::io::Error)> {
    let unread = |error| (folder.to_owned(), error);
    if folder.join("robot.toml").exists() {
        found.push(folder.to_owned());
        return Ok(());
    }
    for entry in fs::read_dir(folder).map_err(unread)? {
        let entry = entry.map_err(unread)?;
        let hidden = entry.file_name().to_string_lossy().starts_with('.');
        // Not through links: they may lead in a circle.
        if deeper > 0 && !hidden && entry.file_type().map_err(unread)?.is_dir() {
            search(&entry.path(), deeper - 1, found)?;
        }
    }
    Ok(())
}

/// When the campaign of a folder was driven.
pub(super) fn dated(folder: &Path, campaign: &Campaign) -> Dated {
    let started =
        campaign.runs.iter().filter_map(|run| run.facts.started_s).fold(f64::NAN, f64::min);
    if started > SINCE_1970_S {
        return Dated { days: Some(started / DAY_S), by: "started_s" };
    }
    let names = folder.iter().rev().filter_map(|part| part.to_str());
    if let Some(days) = names.take(2).find_map(date_in) {
        return Dated { days: Some(days), by: "name" };
    }
    let written = campaign.runs.iter().filter_map(|run| {
        let file = folder.join("runs").join(format!("{}.csv", run.name));
        let written = fs::metadata(file).ok()?.modified().ok()?;
        written.duration_since(UNIX_EPOCH).ok()
    });
    let days = written.max().map(|since| since.as_secs_f64() / DAY_S);
    Dated { days, by: "file" }
}

/// The day of a date `2025-03-31` or `20250331` in a name, as days since 1970.
fn date_in(name: &str) -> Option<f64> {
    let bytes = name.as_bytes();
    (0..bytes.len()).find_map(|start| {
        let is_digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
        if start > 0 && is_digit(start - 1) {
            return None;
        }
        let dashed = bytes.get(start + 4) == Some(&b'-') && bytes.get(start + 7) == Some(&b'-');
        let (places, end) = if dashed {
            ([start, start + 5, start + 8], start + 10)
        } else {
            ([start, start + 4, start + 6], start + 8)
        };
        let number = |from: usize, digits: usize| {
            let all = (from..from + digits).all(is_digit);
            name.get(from..from + digits).filter(|_| all)?.parse::<i64>().ok()
        };
        let (year, month, day) =
            (number(places[0], 4)?, number(places[1], 2)?, number(places[2], 2)?);
        let sound =
            (1970..2200).contains(&year) && (1..=12).contains(&month) && (1..=31).contains(&day);
        (sound && !is_digit(end)).then(|| days_since_1970(year, month, day) as f64)
    })
}

/// Days from 1970-01-01 to a day of the Gregorian calendar (Howard Hinnant, `days_from_civil`).
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let of_era = year - era * 400;
    let of_year = (153 * (if month > 2 { month - 3 } else { month + 9 }) + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
}

/// `2025-03-31` (the inverse of `days_since_1970`, `civil_from_days`).
pub(super) fn date(days: f64) -> String {
    let z = days.floor() as i64 + 719_468;
    let era = z.div_euclid(146_097);
    let of_era = z - era * 146_097;
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let shifted = (5 * of_year + 2) / 153;
    let day = of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    let year = year + era * 400 + i64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_and_dates_are_those_of_the_calendar() {
        for (text, days) in [
            ("1970-01-01", 0.0),
            ("2000-02-29", 11_016.0),
            ("2025-03-31", 20_178.0),
            ("2100-03-01", 47_541.0),
        ] {
            assert_eq!(date_in(text), Some(days), "{text}");
            assert_eq!(date(days + 0.99), text);
        }
    }

    #[test]
    fn a_date_is_found_in_a_name_and_other_numbers_are_none() {
        for name in ["2025-03-31", "20250331", "robot7_2025-03-31_hall", "r-20250331-2"] {
            assert_eq!(date_in(name), Some(20_178.0), "{name}");
        }
        for name in [
            "robot-17",
            "12025-03-31",
            "2025-13-31",
            "2025033",
            "202503311",
            "1234567890",
            "",
            "\u{e4}20",
        ] {
            assert_eq!(date_in(name), None, "{name}");
        }
    }
}
