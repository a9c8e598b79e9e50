//! Data logs of WPILib (`.wpilog`): entries of numbers, each value at a time of its own.
//!
//! ```text
//! file     "WPILOG", version u16 (1.x), length u32 and bytes of an extra header, records
//! record   header byte: lengths less one of entry (bits 0-1), size (2-3) and time (4-6); entry, size, time \[us\], payload
//! entry 0  control: 0 = start (entry u32, name, type, metadata), 1 = finish, 2 = metadata; strings with u32 length
//! ```
//!
//! Numbers are little endian
//! (<https://github.com/wpilibsuite/allwpilib/blob/main/wpiutil/doc/datalog.adoc>). A program logs a value when it changes: between
//! two records of a wheel it stood where it was, and columns that change in the same cycle of the program are one row.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use campaign::CampaignError;
use campaign::bounded_read::{TABLE_BYTES_MAX, open};

use crate::log::{Note, error};
use crate::text::{Mapping, Quantity, TextLogs, by_name, of_columns};

const MAGIC: &[u8] = b"WPILOG";
/// Of the version: 1.x.
const MAJOR: u8 = 1;
/// Values this close were logged in one cycle of a program \[us\]; cycles take 20 ms, or 5 ms at the fastest.
const CYCLE_US: i64 = 2_500;
/// Where nothing changes, a wheel gets a row this often \[us\], so many times: after that nobody knows whether the log went on. A
/// robot that stands for longer is as one whose log was interrupted.
const HELD_US: i64 = 500_000;
const HELD_MAX: i64 = 10;
/// And rows so long before it changes, so that it is not taken to have moved slowly all the time \[us\].
const BEFORE_US: [i64; 3] = [1_000_000, 500_000, 20_000];
/// Elements of an array that are columns.
const ARRAY_MAX: usize = 16;
/// Names that an error lists.
const NAMED_MAX: usize = 40;

/// What an entry holds.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Double,
    Float,
    Int64,
    Doubles,
    /// Doubles in this order, with what is added to the entry's name.
    Struct(&'static [&'static str]),
}

impl Kind {
    fn of(text: &str) -> Option<Self> {
        Some(match text {
            "double" => Self::Double,
            "float" => Self::Float,
            "int64" => Self::Int64,
            "double[]" => Self::Doubles,
            "struct:Rotation2d" => Self::Struct(&[""]),
            "struct:Translation2d" => Self::Struct(&[".x", ".y"]),
            "struct:Pose2d" => Self::Struct(&[".x", ".y", ".heading"]),
            "struct:Pose3d" => Self::Struct(&[".x", ".y", ".z", ".qw", ".qx", ".qy", ".qz"]),
            "struct:DifferentialDriveWheelPositions" => Self::Struct(&[".left", ".right"]),
            _ => return None,
        })
    }

    /// The numbers of a payload, each with what is added to the entry's name.
    fn numbers(self, payload: &[u8]) -> Vec<(String, f64)> {
        let doubles = || payload.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes));
        let one = |number: Option<f64>| number.map(|n| (String::new(), n)).into_iter().collect();
        match self {
            Self::Double => one(doubles().next()),
            Self::Float => {
                one(payload.first_chunk().map(|bytes| f64::from(f32::from_le_bytes(*bytes))))
            }
            Self::Int64 => {
                one(payload.first_chunk().map(|bytes| i64::from_le_bytes(*bytes) as f64))
            }
            Self::Doubles => {
                doubles().take(ARRAY_MAX).enumerate().map(|(k, n)| (format!("[{k}]"), n)).collect()
            }
            // A field is missing: the payload is not what its type says.
            Self::Struct(fields) if payload.len() < 8 * fields.len() => Vec::new(),
            Self::Struct(fields) => {
                fields.iter().zip(doubles()).map(|(field, n)| ((*field).to_owned(), n)).collect()
            }
        }
    }
}

/// A record.
struct Record<'a> {
    entry: u32,
    t_us: i64,
    payload: &'a [u8],
}

/// The records of a log; ends where one is not whole.
struct Records<'a>(&'a [u8]);

impl<'a> Iterator for Records<'a> {
    type Item = Record<'a>;

    fn next(&mut self) -> Option<Record<'a>> {
        let (head, mut rest) = self.0.split_first()?;
        let mut number = |length: u8| {
            let (bytes, after) = rest.split_at_checked(usize::from(length) + 1)?;
            rest = after;
            let mut whole = [0; 8];
            whole[..bytes.len()].copy_from_slice(bytes);
            Some(u64::from_le_bytes(whole))
        };
        let entry = number(head & 3)?;
        let size = number((head >> 2) & 3)?;
        let t_us = number((head >> 4) & 7)?;
        let (payload, after) = rest.split_at_checked(usize::try_from(size).ok()?)?;
        self.0 = after;
        Some(Record { entry: u32::try_from(entry).ok()?, t_us: i64::try_from(t_us).ok()?, payload })
    }
}

/// Whether a file is one, by its name.
pub(crate) fn is_wpilog(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("wpilog"))
}

/// Reads a log.
pub fn read(file: &Path, mappings: &[Mapping]) -> Result<TextLogs, CampaignError> {
    let mut bytes = Vec::new();
    open(file, TABLE_BYTES_MAX)
        .and_then(|mut content| content.read_to_end(&mut bytes))
        .map_err(|cause| CampaignError::io(file, "read it", cause))?;
    parse(file, &bytes, mappings)
}

/// The same from the log's content.
pub fn parse(file: &Path, content: &[u8], mappings: &[Mapping]) -> Result<TextLogs, CampaignError> {
    let records = records(file, content)?;
    let mut columns: BTreeMap<String, Vec<(i64, f64)>> = BTreeMap::new();
    let mut entries: BTreeMap<u32, (String, Kind)> = BTreeMap::new();
    let mut wanted: BTreeMap<String, Option<Mapping>> = BTreeMap::new();
    let (mut end_us, mut read) = (i64::MIN, 0);
    let mut all = Records(records);
    for record in &mut all {
        read += 1;
        if record.entry == 0 {
            if let Some((entry, name, kind)) = started(record.payload) {
                entries.insert(entry, (name, kind));
            }
            continue;
        }
        // Control records may have the time of another clock.
        end_us = end_us.max(record.t_us);
        let Some((name, kind)) = entries.get(&record.entry) else { continue };
        for (field, number) in kind.numbers(record.payload) {
            let name = format!("{name}{field}");
            let as_what = wanted.entry(name.clone()).or_insert_with(|| meant(&name, mappings));
            if as_what.is_some() {
                columns.entry(name).or_default().push((record.t_us, number));
            }
        }
    }
    let rest = all.0.len();
    let names: Vec<String> = wanted.keys().cloned().collect();
    if columns.is_empty() {
        return Err(nothing_known(file, &names, read));
    }
    let chosen: Vec<Mapping> = wanted.into_values().flatten().collect();
    let mut logs = of_columns(file, rows(columns, &chosen, end_us), &chosen)?;
    // All may be mapped.
    logs.columns = names;
    if rest > 0 {
        let text = format!("the log is cut off after {read} records; {rest} bytes were left out");
        logs.notes.push(Note::new(file, text));
    }
    Ok(logs)
}

/// What follows the header.
fn records<'a>(file: &Path, content: &'a [u8]) -> Result<&'a [u8], CampaignError> {
    let hint = "give a .wpilog file as WPILib's DataLogManager or AdvantageKit writes it";
    let (head, rest) = content
        .split_at_checked(12)
        .filter(|(head, _)| head.starts_with(MAGIC))
        .ok_or_else(|| error(file, "this is not a WPILib data log", hint))?;
    if head[7] != MAJOR {
        let problem = format!("version {}.{} of the format is unknown", head[7], head[6]);
        return Err(error(file, problem, "only versions 1.x are read"));
    }
    let extra = u32::from_le_bytes([head[8], head[9], head[10], head[11]]) as usize;
    rest.get(extra..)
        .ok_or_else(|| error(file, "the log ends within its header", "record it again"))
}

/// The entry that a control record starts, if it is one of numbers.
fn started(payload: &[u8]) -> Option<(u32, String, Kind)> {
    let (kind, mut rest) = payload.split_first()?;
    if *kind != 0 {
        return None;
    }
    let number = |rest: &mut &[u8]| {
        let (bytes, after) = rest.split_first_chunk()?;
        *rest = after;
        Some(u32::from_le_bytes(*bytes))
    };
    let entry = number(&mut rest)?;
    let mut string = || {
        let length = usize::try_from(number(&mut rest)?).ok()?;
        let (bytes, after) = rest.split_at_checked(length)?;
        rest = after;
        Some(String::from_utf8_lossy(bytes).into_owned())
    };
    let (name, of) = (string()?, string()?);
    // NetworkTables' own mark is no part of a name, and a colon would be taken for a unit.
    let name = name.strip_prefix("NT:").unwrap_or(&name).to_owned();
    Some((entry, name, Kind::of(&of)?))
}

/// What a column is: as the user says, or by a usual name behind its last slash.
fn meant(name: &str, mappings: &[Mapping]) -> Option<Mapping> {
    let by_user = mappings.iter().find(|mapping| mapping.column == name).cloned();
    by_user.or_else(|| {
        let (quantity, factor) = by_name(name.rsplit('/').next().unwrap_or(name))?;
        let is_given = mappings.iter().any(|mapping| mapping.quantity == quantity);
        // Times are those of the records.
        let serves = quantity != Quantity::Time && !is_given;
        serves.then(|| Mapping { quantity, column: name.to_owned(), factor })
    })
}

fn nothing_known(file: &Path, names: &[String], read: usize) -> CampaignError {
    if names.is_empty() {
        let problem = format!("none of its {read} records is of numbers");
        return error(
            file,
            problem,
            "log the angles or distances of both wheels, and measured poses",
        );
    }
    let shown = names.iter().take(NAMED_MAX).cloned().collect::<Vec<_>>().join(", ");
    let more = names.len().saturating_sub(NAMED_MAX);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    error(
        file,
        "no entries are known to be wheels or positions",
        format!(
            "name them: --map left_m=ENTRY,right_m=ENTRY,x_m=ENTRY.x,y_m=ENTRY.y; there is {shown}{more}"
        ),
    )
}

/// One row for each cycle in which something changed, with the time first. Poses keep no value: one that was not measured is none.
/// Wheels keep theirs while they stand; of wheels that turn, nothing is known between two records.
fn rows(
    columns: BTreeMap<String, Vec<(i64, f64)>>,
    chosen: &[Mapping],
    end_us: i64,
) -> Vec<(String, Vec<f64>)> {
    let names: Vec<String> = columns.keys().cloned().collect();
    let is_wheel: Vec<bool> = names
        .iter()
        .map(|name| {
            let own = chosen.iter().find(|mapping| mapping.column == *name);
            own.is_some_and(|mapping| mapping.quantity.is_wheel())
        })
        .collect();
    let each = columns.into_values().enumerate();
    let mut values: Vec<(i64, usize, f64)> = each
        .flat_map(|(k, own)| own.into_iter().map(move |(t_us, value)| (t_us, k, value)))
        .collect();
    values.sort_by_key(|(t_us, k, _)| (*t_us, *k));
    let wheels_us: Vec<i64> =
        values.iter().filter(|(_, k, _)| is_wheel[*k]).map(|(t_us, ..)| *t_us).collect();
    let mut table = vec![Vec::new(); names.len() + 1];
    let mut held = vec![f64::NAN; names.len()];
    let mut push = |t_us: i64, row: &[f64]| {
        table[0].push(t_us as f64 * 1e-6);
        table[1..].iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
    };
    let wheels_alone = |held: &[f64]| -> Vec<f64> {
        held.iter().zip(&is_wheel).map(|(v, wheel)| if *wheel { *v } else { f64::NAN }).collect()
    };
    let mut next = 0;
    let mut before_us = values.first().map_or(end_us, |first| first.0);
    while next < values.len() {
        let at_us = values[next].0;
        let still = wheels_alone(&held);
        held_times(before_us, at_us).for_each(|t_us| push(t_us, &still));
        let mut row = still;
        let mut set = vec![false; names.len()];
        while let Some((t_us, k, value)) = values.get(next)
            && *t_us - at_us <= CYCLE_US
            && !set[*k]
        {
            (row[*k], set[*k], held[*k]) = (*value, true, *value);
            next += 1;
        }
        let is_of_wheels = set.iter().zip(&is_wheel).any(|(set, wheel)| *set && *wheel);
        if !is_of_wheels && !stand_at(&wheels_us, at_us) {
            row.iter_mut().zip(&is_wheel).filter(|(_, w)| **w).for_each(|(v, _)| *v = f64::NAN);
        }
        push(at_us, &row);
        before_us = at_us;
    }
    let still = wheels_alone(&held);
    held_times(before_us, end_us).for_each(|t_us| push(t_us, &still));
    std::iter::once("t_s".to_owned()).chain(names).zip(table).collect()
}

/// Whether wheels with records at these times stand at this one, between two of them: in a pause, and not just before it ends.
fn stand_at(records_us: &[i64], at_us: i64) -> bool {
    let last_us = BEFORE_US[BEFORE_US.len() - 1];
    let next = records_us.partition_point(|t_us| *t_us <= at_us);
    match (next.checked_sub(1).map(|before| records_us[before]), records_us.get(next)) {
        (Some(before_us), Some(next_us)) => {
            next_us.saturating_sub(before_us) > 4 * last_us && at_us <= next_us - last_us
        }
        // Before the first one, nothing is known; after the last one, they stand.
        (before, _) => before.is_some(),
    }
}

/// The times of rows between two records in which nothing changes.
fn held_times(from_us: i64, to_us: i64) -> impl Iterator<Item = i64> {
    let after = (1..=HELD_MAX).map(move |k| from_us.saturating_add(k * HELD_US));
    let after_end_us = from_us.saturating_add(HELD_MAX * HELD_US);
    let last_us = BEFORE_US[BEFORE_US.len() - 1];
    let before = BEFORE_US.into_iter().map(move |us| to_us.saturating_sub(us));
    // A step of a moving wheel is no pause.
    let is_pause = to_us.saturating_sub(from_us) > 4 * last_us;
    let after = after.filter(move |t_us| *t_us < to_us - last_us);
    let before = before
        .filter(move |t_us| *t_us > from_us && (*t_us > after_end_us || *t_us == to_us - last_us));
    after.chain(before).filter(move |_| is_pause)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_wheels_that_turn_nothing_is_known_between_two_records() {
        // At 50 Hz, a pause of half a second, and on.
        let records: Vec<i64> = [0, 20, 40, 60, 560, 580].map(|ms| 1000 * ms).into();
        for (at_ms, stands) in [
            (-5, false),
            (10, false),
            (55, false),
            (65, true),
            (300, true),
            (539, true),
            (550, false),
            (570, false),
            (900, true),
        ] {
            assert_eq!(stand_at(&records, 1000 * at_ms), stands, "{at_ms}");
        }
        assert!(!stand_at(&[], 0));
    }

    #[test]
    fn a_pause_has_rows_that_increase_and_are_few_however_long_it_is() {
        let times = |to_us| held_times(1_000, to_us).collect::<Vec<_>>();
        assert!(times(21_000).is_empty());
        assert_eq!(times(151_000), [131_000]);
        for to_us in [700_000, 4_000_000, 5_900_000, 6_300_000, 60_000_000, i64::MAX] {
            let times = times(to_us);
            assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{to_us}: {times:?}");
            assert!(
                times.len() <= 13 && times.last() == Some(&(to_us - 20_000)),
                "{to_us}: {times:?}"
            );
        }
    }
}
