//! Track files: where a camera, a laser or a total station measured the robot.
//!
//! Comma-separated with a header: `t_s,x_m,y_m` and, optionally, `heading_rad`; time on the clock
//! of the run, strictly increasing. A row without x or y is skipped: the robot was not seen then.

use std::path::Path;

use robot_model::calibration::TrackSample;

use crate::bounded_read::{TABLE_BYTES_MAX, read_text};
use crate::table::Table;
use crate::{CampaignError, Column, Place, Warning};

/// The column of a track that has this name.
fn column(name: &str) -> Option<Column> {
    Column::from_name(name)
        .filter(|column| matches!(column, Column::Time | Column::X | Column::Y | Column::Heading))
}

/// Warns about columns that a track does not have.
pub fn unknown_columns(file: &Path, header: &str) -> Result<Vec<Warning>, CampaignError> {
    Ok(Table::parse_header(file, header, column)?.warnings)
}

/// Reads a track file; at least two samples.
pub fn read_track(file: &Path) -> Result<(Vec<TrackSample>, Vec<Warning>), CampaignError> {
    let text = read_text(file, TABLE_BYTES_MAX)
        .map_err(|error| CampaignError::io(file, "read it", error))?;
    parse_track(file, &text)
}

/// Reads the text of a track file; at least two samples.
pub fn parse_track(
    file: &Path,
    text: &str,
) -> Result<(Vec<TrackSample>, Vec<Warning>), CampaignError> {
    let required = [Column::Time, Column::X, Column::Y];
    let table = Table::parse(file, text.as_bytes(), column, &required)?;
    let samples: Vec<_> = table
        .rows
        .iter()
        .filter_map(|(_, cells)| {
            let cell = |wanted| {
                cells.iter().find(|(column, _)| *column == wanted).and_then(|(_, value)| *value)
            };
            Some(TrackSample {
                t_s: cell(Column::Time)?,
                x_m: cell(Column::X)?,
                y_m: cell(Column::Y)?,
                heading_rad: cell(Column::Heading),
            })
        })
        .collect();
    if samples.len() < 2 {
        let problem = format!("only {} rows have both x_m and y_m", samples.len());
        let hint = "a track needs at least two positions, better hundreds";
        return Err(CampaignError::new(Place::whole(file), problem, hint));
    }
    Ok((samples, table.warnings))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<(Vec<TrackSample>, Vec<Warning>), CampaignError> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        read_track(file.path())
    }

    #[test]
    fn headings_and_unseen_rows_are_optional() {
        let (samples, warnings) =
            read("t_s,heading_rad,x_m,y_m\n0,0.1,1,2\n1,,,\n2,,3,4\n").unwrap();
        assert!(warnings.is_empty());
        assert_eq!(samples.len(), 2);
        assert_eq!(samples[0].heading_rad, Some(0.1));
        assert_eq!(samples[1], TrackSample { t_s: 2.0, x_m: 3.0, y_m: 4.0, heading_rad: None });
    }

    #[test]
    fn a_track_without_y_or_with_one_place_is_refused() {
        let error = read("t_s,x_m\n0,1\n1,2\n").unwrap_err().to_string();
        assert!(error.contains("line 1: the required column `y_m` is missing"), "{error}");
        let error = read("t_s,x_m,y_m\n0,1,1\n1,,\n").unwrap_err().to_string();
        assert!(error.contains("only 1 rows have both"), "{error}");
    }
}
