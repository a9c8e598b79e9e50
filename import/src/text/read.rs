//! A text file as wheels and poses.
//!
//! Longer than 400 lines because all of it is one table: which columns are used, their cells, what they come to.

use std::path::Path;

use campaign::bounded_read::{TABLE_BYTES_MAX, open};
use campaign::{CampaignError, Place};
use csv::{ReaderBuilder, StringRecord, Trim};

use super::cell::number;
use super::mapping::by_name;
use super::run_column::RunColumn;
use super::{Mapping, Quantity, held_poses};
use crate::log::{Note, Pose3, PoseLog, WheelLog, WheelUnit, error, ordered};

/// What a text file holds: wheels, poses, or both on one clock.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextLogs {
    /// Wheels, if it has them.
    pub wheels: Option<WheelLog>,
    /// Poses, if it has them.
    pub poses: Option<PoseLog>,
    /// What a user should know.
    pub notes: Vec<Note>,
    /// The names of its columns.
    pub columns: Vec<String>,
    /// Its time began again in each run, and tells nothing about another file's.
    pub has_own_time: bool,
}

/// The columns of a TUM trajectory.
const TUM: [Quantity; 8] = [
    Quantity::Time,
    Quantity::X,
    Quantity::Y,
    Quantity::Z,
    Quantity::QuaternionX,
    Quantity::QuaternionY,
    Quantity::QuaternionZ,
    Quantity::QuaternionW,
];

/// Reads a file.
pub fn read(file: &Path, mappings: &[Mapping]) -> Result<TextLogs, CampaignError> {
    let mut bytes = Vec::new();
    let read = open(file, TABLE_BYTES_MAX);
    read.and_then(|mut content| std::io::Read::read_to_end(&mut content, &mut bytes))
        .map_err(|cause| CampaignError::io(file, "read it", cause))?;
    parse(file, &bytes, mappings)
}

/// The same from the file's content.
pub fn parse(file: &Path, content: &[u8], mappings: &[Mapping]) -> Result<TextLogs, CampaignError> {
    let text = std::str::from_utf8(content).map_err(|_| {
        error(file, "it is not UTF-8 text", "give a bag (.mcap), a CSV file or a TUM trajectory")
    })?;
    let first = text.lines().find(|line| !line.trim().is_empty());
    let Some(first) = first else {
        return Err(error(file, "the file is empty", "record it again"));
    };
    let mut table = Table::of(file, text, first, mappings)?;
    let notes = table.read_rows(text)?;
    table.logs(notes)
}

/// One column that is used.
pub(super) struct Used {
    pub(super) quantity: Quantity,
    pub(super) index: usize,
    pub(super) name: String,
    pub(super) factor: Option<f64>,
    pub(super) values: Vec<f64>,
}

pub(super) struct Table<'a> {
    pub(super) file: &'a Path,
    delimiter: u8,
    pub(super) has_header: bool,
    cells: usize,
    pub(super) used: Vec<Used>,
    header: Vec<String>,
    pub(super) runs: Option<RunColumn>,
}

/// The separator of a line.
fn delimiter(line: &str) -> u8 {
    let count = |separator: char| line.matches(separator).count();
    [',', ';', '\t']
        .into_iter()
        .max_by_key(|separator| count(*separator))
        .filter(|best| count(*best) > 0)
        .map_or(b' ', |best| best as u8)
}

impl<'a> Table<'a> {
    /// A table with these columns, none of which is used yet.
    pub(super) fn with_header(file: &'a Path, header: Vec<String>) -> Self {
        let (cells, used) = (header.len(), Vec::new());
        Self { file, delimiter: b',', has_header: true, cells, used, header, runs: None }
    }

    /// What its columns are, once they have values.
    pub(super) fn logs(mut self, mut notes: Vec<Note>) -> Result<TextLogs, CampaignError> {
        notes.extend(self.scale_times()?);
        notes.extend(self.scale_headings()?);
        let has_own_time = self.join_runs(&mut notes)?;
        let (wheels, poses) = (self.wheels(&mut notes), self.poses(&mut notes));
        let columns = if self.has_header { self.header } else { Vec::new() };
        Ok(TextLogs { wheels, poses, notes, columns, has_own_time })
    }

    fn of(
        file: &'a Path,
        text: &str,
        first: &str,
        mappings: &[Mapping],
    ) -> Result<Self, CampaignError> {
        // A comment before a table without a header, as TUM files have one; EuRoC's header is a comment.
        let is_comment = first.trim_start().starts_with('#');
        let data = text
            .lines()
            .find(|line| !line.trim().is_empty() && !line.trim_start().starts_with('#'));
        let probe = data.unwrap_or(first);
        let delimiter = delimiter(if is_comment { probe } else { first });
        let split = |line: &str| -> Vec<String> {
            let line = line.trim().trim_start_matches('\u{feff}').trim_start_matches('#');
            let cells = line
                .split(char::from(delimiter))
                .map(|cell| cell.trim().trim_matches('"').to_owned());
            cells.filter(|cell| delimiter != b' ' || !cell.is_empty()).collect()
        };
        let (header, values) = (split(first), split(probe));
        let is_number = |cell: &String| cell.parse::<f64>().is_ok();
        let has_header = !header.iter().all(is_number)
            && (!is_comment || header.len() == values.len() && delimiter != b' ');
        let mut table = Self {
            file,
            delimiter,
            has_header,
            cells: values.len(),
            used: Vec::new(),
            header,
            runs: None,
        };
        if has_header {
            table.runs = RunColumn::find(&table.header);
            table.cells = table.header.len();
            table.use_columns(mappings)?;
        } else if values.len() == TUM.len() && values.iter().all(is_number) {
            for (index, quantity) in TUM.into_iter().enumerate() {
                let name = quantity.name().to_owned();
                table.used.push(Used {
                    quantity,
                    index,
                    name,
                    factor: Some(1.0),
                    values: Vec::new(),
                });
            }
            // The epoch may be in nanoseconds all the same.
            table.used[0].factor = None;
        } else {
            let problem = format!("it has no header line that names its {} columns", values.len());
            let hint = "a CSV file needs one; a TUM trajectory has eight numbers a line: t x y z qx qy qz qw";
            return Err(error(file, problem, hint));
        }
        Ok(table)
    }

    /// Which column is what: those that the user named, then those with usual names.
    pub(super) fn use_columns(&mut self, mappings: &[Mapping]) -> Result<(), CampaignError> {
        let named = mappings.iter().filter_map(|mapping| {
            let index = self.header.iter().position(|name| *name == mapping.column)?;
            Some((mapping.quantity, index, mapping.factor))
        });
        let usual = self.header.iter().enumerate().filter_map(|(index, name)| {
            let (quantity, factor) = by_name(name)?;
            Some((quantity, index, factor))
        });
        let is_named = |quantity| mappings.iter().any(|mapping| mapping.quantity == quantity);
        for (quantity, index, factor) in named.chain(usual).collect::<Vec<_>>() {
            if let Some(used) = self.used.iter().find(|used| used.quantity == quantity)
                && used.index != index
                && !is_named(quantity)
            {
                return Err(self.two_for(quantity, [used.index, index]));
            }
            if self.used.iter().any(|used| used.quantity == quantity || used.index == index) {
                continue;
            }
            let name = self.header[index].clone();
            let by_unit = factor.or_else(|| by_name(&name).and_then(|(_, factor)| factor));
            self.used.push(Used { quantity, index, name, factor: by_unit, values: Vec::new() });
        }
        let place = Place { line: 1, ..Place::whole(self.file) };
        let columns = format!("its columns are {}", self.header.join(", "));
        if !self.has(&[Quantity::Time]) {
            let hint = format!("name the column of the time: --map t_s=COLUMN:UNIT; {columns}");
            return Err(CampaignError::new(place, "no column is known to be the time", hint));
        }
        if !self.has_wheels() && !self.has(&[Quantity::X, Quantity::Y]) {
            let hint = format!(
                "name them: --map left_counts=COLUMN,right_counts=COLUMN or --map x_m=COLUMN,y_m=COLUMN; {columns}"
            );
            return Err(CampaignError::new(
                place,
                "no columns are known to be wheels or positions",
                hint,
            ));
        }
        Ok(())
    }

    fn two_for(&self, quantity: Quantity, [a, b]: [usize; 2]) -> CampaignError {
        let place = Place { line: 1, column: b as u64 + 1, file: self.file.into() };
        let [a, b] = [a, b].map(|index| &self.header[index]);
        let name = quantity.name();
        let problem = format!("both columns `{a}` and `{b}` may be {name}");
        let hint = match a == b {
            true => "give them different names in the header".to_owned(),
            false => format!("name the one that is: --map {name}={a}"),
        };
        CampaignError::new(place, problem, hint)
    }

    fn has(&self, quantities: &[Quantity]) -> bool {
        quantities.iter().all(|wanted| self.column(*wanted).is_some())
    }

    pub(super) fn column(&self, quantity: Quantity) -> Option<&Used> {
        self.used.iter().find(|used| used.quantity == quantity)
    }

    fn has_wheels(&self) -> bool {
        WHEELS.iter().any(|(pair, _)| self.has(pair))
    }

    /// Reads the numbers of the columns that are used.
    fn read_rows(&mut self, text: &str) -> Result<Vec<Note>, CampaignError> {
        let mut reader = ReaderBuilder::new()
            .has_headers(false)
            .delimiter(self.delimiter)
            .trim(Trim::All)
            .flexible(true)
            .comment(Some(b'#'))
            .from_reader(text.as_bytes());
        let ends_in_full = text.ends_with('\n');
        let mut notes = Vec::new();
        let mut record = StringRecord::new();
        let mut skip =
            self.has_header && !text.trim_start_matches('\u{feff}').trim_start().starts_with('#');
        let mut pending: Option<CampaignError> = None;
        loop {
            let more = reader.read_record(&mut record).map_err(|cause| {
                let line = cause.position().map_or(0, csv::Position::line);
                let place = Place { line, ..Place::whole(self.file) };
                CampaignError::new(
                    place,
                    format!("not a table: {cause}"),
                    "it must be UTF-8 text with one separator",
                )
            })?;
            if !more {
                break;
            }
            if let Some(error) = pending.take() {
                return Err(error);
            }
            if std::mem::take(&mut skip) {
                continue;
            }
            // The last line of a file that a crash cut off is left out.
            pending = self.read_row(&record).err();
        }
        match pending {
            Some(error) if ends_in_full => Err(error),
            Some(_) => {
                notes.push(Note::new(
                    self.file,
                    "the last line is cut off, as by a crash; it was left out",
                ));
                Ok(notes)
            }
            None => Ok(notes),
        }
    }

    fn read_row(&mut self, record: &StringRecord) -> Result<(), CampaignError> {
        let line = record.position().map_or(0, csv::Position::line);
        let cells: Vec<&str> =
            record.iter().filter(|cell| self.delimiter != b' ' || !cell.is_empty()).collect();
        if cells.len() != self.cells {
            let place = Place { line, ..Place::whole(self.file) };
            let problem = format!("{} cells, but there are {} columns", cells.len(), self.cells);
            return Err(CampaignError::new(
                place,
                problem,
                "an empty cell still takes its separator; numbers take a point",
            ));
        }
        let mut values = Vec::with_capacity(self.used.len());
        for used in &self.used {
            let text = cells[used.index];
            values.push(number(text, self.delimiter).ok_or_else(|| {
                let place = Place { line, column: used.index as u64 + 1, file: self.file.into() };
                let problem = format!("`{text}` in the column `{}` is not a number", used.name);
                CampaignError::new(
                    place,
                    problem,
                    "leave the cell empty if it was not measured, or map another column with --map",
                )
            })?);
        }
        if let Some(runs) = &mut self.runs {
            runs.push(cells[runs.index]);
        }
        for (used, value) in self.used.iter_mut().zip(values) {
            used.values.push(value * used.factor.unwrap_or(1.0));
        }
        Ok(())
    }

    pub(super) fn values(&self, quantity: Quantity) -> Option<&[f64]> {
        self.column(quantity).map(|used| used.values.as_slice())
    }

    fn wheels(&self, notes: &mut Vec<Note>) -> Option<WheelLog> {
        let (pair, unit) = WHEELS.iter().find(|(pair, _)| self.has(pair))?;
        let (left, right) = (self.column(pair[0])?, self.column(pair[1])?);
        let times = self.values(Quantity::Time)?;
        let mut samples: Vec<(f64, [f64; 2])> = times
            .iter()
            .zip(left.values.iter().zip(&right.values))
            // An empty cell: not measured then.
            .filter(|(_, (left, right))| !left.is_nan() && !right.is_nan())
            .map(|(t_s, (left, right))| (*t_s, [*left, *right]))
            .collect();
        let said = ordered(
            &mut samples,
            |sample| sample.0,
            |sample| sample.1.iter().all(|phi| phi.is_finite()),
        );
        notes.extend(said.into_iter().map(|said| Note::new(self.file, said)));
        let what = format!("{}, {}", left.name, right.name);
        let (t_s, turned) = samples.into_iter().unzip();
        Some(WheelLog {
            file: self.file.into(),
            what,
            t_s,
            turned,
            unit: *unit,
            ..WheelLog::default()
        })
    }

    fn poses(&self, notes: &mut Vec<Note>) -> Option<PoseLog> {
        let (times, x, y) =
            (self.values(Quantity::Time)?, self.values(Quantity::X)?, self.values(Quantity::Y)?);
        let z = self.values(Quantity::Z);
        let heading = self.values(Quantity::Heading);
        let quaternion = [
            Quantity::QuaternionX,
            Quantity::QuaternionY,
            Quantity::QuaternionZ,
            Quantity::QuaternionW,
        ]
        .map(|part| self.values(part));
        let mut poses: Vec<Pose3> = (0..times.len())
            .filter(|row| !x[*row].is_nan() && !y[*row].is_nan())
            .map(|row| {
                let about_z = heading.map(|rad| (rad[row] / 2.0).sin_cos());
                let of_heading = about_z.map(|(sin, cos)| [0.0, 0.0, sin, cos]);
                let of_quaternion = match quaternion {
                    [Some(x), Some(y), Some(z), Some(w)] => Some([x[row], y[row], z[row], w[row]]),
                    _ => None,
                };
                let orientation =
                    of_quaternion.or(of_heading).filter(|q| q.iter().all(|part| part.is_finite()));
                let height_m = z.map_or(0.0, |z| z[row]);
                let height_m = if height_m.is_nan() { 0.0 } else { height_m };
                Pose3 { t_s: times[row], position_m: [x[row], y[row], height_m], orientation }
            })
            .collect();
        if self.has_wheels() && held_poses::are_held(&poses) {
            held_poses::keep_first(&mut poses);
            let text =
                "poses stand in each row until the next is measured: the first of each is taken";
            notes.push(Note::new(self.file, text));
        }
        let said = ordered(
            &mut poses,
            |pose| pose.t_s,
            |pose| pose.position_m.iter().all(|part| part.is_finite()),
        );
        notes.extend(said.into_iter().map(|said| Note::new(self.file, said)));
        let what = if self.has_header { "positions" } else { "TUM trajectory" };
        Some(PoseLog { file: self.file.into(), what: what.into(), poses })
    }
}

/// Pairs of columns that are wheels, the surest first.
const WHEELS: [([Quantity; 2], WheelUnit); 3] = [
    ([Quantity::LeftCounts, Quantity::RightCounts], WheelUnit::Counts),
    ([Quantity::LeftAngle, Quantity::RightAngle], WheelUnit::Radians),
    ([Quantity::LeftTravel, Quantity::RightTravel], WheelUnit::Metres),
];

#[cfg(test)]
mod tests;
