//! A table of samples in a CSV file: named columns, numbers, times that increase.
//!
//! The caller says which of the [`Column`]s a file may have.

use std::io::Read;
use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};

use super::{CampaignError, Column, Place, Warning};
use crate::bounded_read::{TABLE_BYTES_MAX, open};

/// The cells of one row in the known columns.
pub type Cells = Vec<(Column, Option<f64>)>;

/// The cells of a file.
pub struct Table {
    columns: Vec<Option<Column>>,
    /// One row: its line in the file, and the cells of the known columns.
    pub rows: Vec<(u64, Cells)>,
    /// Columns that were ignored.
    pub warnings: Vec<Warning>,
}

impl Table {
    /// Reads a file. `known` finds a column by its name; each row must have its time, and times
    /// must increase; `required` columns must be in the header.
    pub fn read(
        file: &Path,
        known: impl Fn(&str) -> Option<Column>,
        required: &[Column],
    ) -> Result<Self, CampaignError> {
        let open = open(file, TABLE_BYTES_MAX)
            .map_err(|error| CampaignError::io(file, "read it", error))?;
        Self::parse(file, open, known, required)
    }

    /// As [`read`](Self::read), from the file's content.
    pub fn parse(
        file: &Path,
        content: impl Read,
        known: impl Fn(&str) -> Option<Column>,
        required: &[Column],
    ) -> Result<Self, CampaignError> {
        let mut reader = ReaderBuilder::new()
            .has_headers(false)
            .trim(Trim::All)
            .flexible(true)
            .from_reader(content);
        let mut records = reader.records();
        let Some(header) = records.next() else {
            let problem = "the file is empty";
            return Err(CampaignError::new(Place::whole(file), problem, header_hint(required)));
        };
        let header = header.map_err(|error| damaged(file, &error))?;
        check_separator(file, &header)?;
        let mut table = Self::with_header(file, &header, known)?;
        for column in required {
            let name = column.name();
            if !table.columns.contains(&Some(*column)) {
                let place = Place { line: 1, ..Place::whole(file) };
                let problem = format!("the required column `{name}` is missing");
                return Err(CampaignError::new(place, problem, header_hint(required)));
            }
        }
        for record in records {
            table.add(file, &record.map_err(|error| damaged(file, &error))?)?;
        }
        if table.rows.len() < 2 {
            let problem =
                format!("a run needs at least two rows, this one has {}", table.rows.len());
            let hint = "record it again, or remove the file";
            return Err(CampaignError::new(Place::whole(file), problem, hint));
        }
        table.check_time(file)?;
        Ok(table)
    }

    /// The columns that a header line names, without rows.
    pub fn parse_header(
        file: &Path,
        header: &str,
        known: impl Fn(&str) -> Option<Column>,
    ) -> Result<Self, CampaignError> {
        let header = header.split(',').map(str::trim).collect();
        check_separator(file, &header)?;
        Self::with_header(file, &header, known)
    }

    fn with_header(
        file: &Path,
        header: &StringRecord,
        known: impl Fn(&str) -> Option<Column>,
    ) -> Result<Self, CampaignError> {
        let mut table = Self { columns: Vec::new(), rows: Vec::new(), warnings: Vec::new() };
        for (index, name) in header.iter().enumerate() {
            // Spreadsheets put a byte order mark before the first name.
            let name = name.trim_start_matches('\u{feff}');
            let place = Place { file: file.into(), line: 1, column: index as u64 + 1 };
            let column = known(name);
            if column.is_none() {
                table.warnings.push(Warning::UnknownColumn { place, name: name.into() });
            } else if table.columns.contains(&column) {
                let problem = format!("the column `{name}` appears twice");
                return Err(CampaignError::new(place, problem, "keep one of them"));
            }
            table.columns.push(column);
        }
        Ok(table)
    }

    /// The number of a column in the header, from 1.
    pub fn column(&self, column: Column) -> Option<u64> {
        self.columns.iter().position(|known| *known == Some(column)).map(|index| index as u64 + 1)
    }

    fn add(&mut self, file: &Path, record: &StringRecord) -> Result<(), CampaignError> {
        let line = record.position().map_or(0, |position| position.line());
        if record.len() != self.columns.len() {
            let place = Place { line, ..Place::whole(file) };
            let problem =
                format!("{} cells, but the header has {}", record.len(), self.columns.len());
            let hint = "an empty cell still takes its comma; numbers take a point, not a comma";
            return Err(CampaignError::new(place, problem, hint));
        }
        let mut cells = Vec::new();
        for (index, (column, text)) in self.columns.iter().zip(record).enumerate() {
            let Some(column) = *column else { continue };
            if text.is_empty() {
                cells.push((column, None));
                continue;
            }
            let place = Place { file: file.into(), line, column: index as u64 + 1 };
            let value = text.parse::<f64>().map_err(|_| {
                let problem = format!("`{text}` is not a number");
                CampaignError::new(
                    place.clone(),
                    problem,
                    "leave the cell empty if it was not measured",
                )
            })?;
            if !value.is_finite() {
                let problem = format!("`{text}` is not a finite number");
                let hint = "leave the cell empty if it was not measured";
                return Err(CampaignError::new(place, problem, hint));
            }
            if !column.range().contains(value) {
                let problem = format!("{} = {text} is out of range", column.name());
                let hint = format!("it must be {}", column.range());
                return Err(CampaignError::new(place, problem, hint));
            }
            cells.push((column, Some(value)));
        }
        self.rows.push((line, cells));
        Ok(())
    }

    fn check_time(&self, file: &Path) -> Result<(), CampaignError> {
        let time = Column::Time;
        let column = self.column(time).unwrap_or(1);
        let mut before = f64::NEG_INFINITY;
        for (line, cells) in &self.rows {
            let place = Place { file: file.into(), line: *line, column };
            let Some(t_s) =
                cells.iter().find(|(column, _)| *column == time).and_then(|(_, value)| *value)
            else {
                let problem = "the time is missing";
                return Err(CampaignError::new(place, problem, "every row needs its time"));
            };
            if t_s <= before {
                let problem =
                    format!("the time {t_s} s is not later than the {before} s before it");
                let hint = "sort the rows by time and remove duplicates";
                return Err(CampaignError::new(place, problem, hint));
            }
            before = t_s;
        }
        Ok(())
    }
}

/// Refuses the separators that a spreadsheet writes where numbers have a decimal comma: the header
/// would be read as one column with a strange name.
fn check_separator(file: &Path, header: &StringRecord) -> Result<(), CampaignError> {
    let [only] = header.iter().collect::<Vec<_>>()[..] else { return Ok(()) };
    let what = match only {
        _ if only.contains(';') => "semicolons",
        _ if only.contains('\t') => "tabs",
        _ => return Ok(()),
    };
    let place = Place { line: 1, ..Place::whole(file) };
    let problem = format!("its columns are separated by {what}");
    let hint = "put commas in their place, and a point into each number that has a comma";
    Err(CampaignError::new(place, problem, hint))
}

fn header_hint(required: &[Column]) -> String {
    let names: Vec<_> = required.iter().map(|column| column.name()).collect();
    format!("the first line must name the columns, with at least {}", names.join(","))
}

fn damaged(file: &Path, error: &csv::Error) -> CampaignError {
    let line = error.position().map_or(0, |position| position.line());
    let place = Place { line, ..Place::whole(file) };
    CampaignError::new(
        place,
        format!("not a CSV file: {error}"),
        "it must be UTF-8 text with commas",
    )
}
