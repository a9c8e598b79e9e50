//! A file that another program is still writing: a tracker's track, a logger's readings.
//!
//! The format of a track is left to [`crate::track`].

use std::io::{ErrorKind, Read};
use std::path::Path;

use robot_model::calibration::TrackSample;

use crate::bounded_read::{TABLE_BYTES_MAX, open};
use crate::error::{CampaignError, Place, Warning};
use crate::track::{parse_track, unknown_columns};

/// Refuses, before the robot moves, a file that is not a track; a file that is still empty is
/// accepted. Returns the warnings about its header.
pub fn check_header(path: &Path) -> Result<Vec<Warning>, CampaignError> {
    let text = whole_lines(path).map_err(|error| {
        let hint = "start the tracking system first, so that the file is there";
        let refused = CampaignError::new(Place::whole(path), "cannot read the track", hint);
        CampaignError { cause: Some(error), ..refused }
    })?;
    let Some(header) = text.lines().next() else { return Ok(Vec::new()) };
    for column in ["t_s", "x_m", "y_m"] {
        if !header.split(',').any(|name| name.trim() == column) {
            let place = Place { line: 1, ..Place::whole(path) };
            let hint = "a track has a header line: t_s,x_m,y_m or t_s,x_m,y_m,heading_rad";
            return Err(CampaignError::new(place, format!("there is no column {column}"), hint));
        }
    }
    unknown_columns(path, header)
}

/// A track file as far as it has come: a tracking system may create it, or begin it, only when the
/// robot first moves.
pub fn track_so_far(path: &Path) -> Result<Vec<TrackSample>, CampaignError> {
    const HEADER_AND_TWO_ROWS: usize = 3;
    match whole_lines(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(CampaignError::io(path, "read it", error)),
        Ok(text) if text.lines().count() < HEADER_AND_TWO_ROWS => Ok(Vec::new()),
        Ok(text) => Ok(parse_track(path, &text)?.0),
    }
}

/// A file that is being written, up to its last line feed: the line after it is not complete yet.
pub fn whole_lines(path: &Path) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    open(path, TABLE_BYTES_MAX)?.read_to_end(&mut bytes)?;
    bytes.truncate(bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1));
    String::from_utf8(bytes).map_err(|error| std::io::Error::new(ErrorKind::InvalidData, error))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        file
    }

    #[test]
    fn a_row_that_is_still_being_written_is_not_read_however_far_it_has_come() {
        let rows = "t_s,x_m,y_m\n0,0,0\n1,0.1,0\n";
        for torn in ["", "2", "2,", "2,0.", "2,0.2,0", "2,0.2,-", "\u{b0}"] {
            // The last bytes of a torn row need not be whole characters.
            let mut bytes = [rows, torn].concat().into_bytes();
            if torn == "\u{b0}" {
                bytes.pop();
            }
            let file = file(&bytes);
            assert_eq!(track_so_far(file.path()).unwrap().len(), 2, "{torn:?}");
            assert!(check_header(file.path()).unwrap().is_empty());
        }
        let whole = file([rows, "2,0.2,0\n"].concat().as_bytes());
        assert_eq!(track_so_far(whole.path()).unwrap().len(), 3);
        assert!(track_so_far(file(b"t_s,x_m,y_m\n0,0,0\n1,x,0\n").path()).is_err());
        assert!(check_header(file(b"t_s,x").path()).unwrap().is_empty(), "a torn header");
    }

    #[test]
    fn a_column_that_no_track_has_is_named() {
        let file = file(b"t_s,x_m,y_m,colour\n");
        let warnings = check_header(file.path()).unwrap();
        assert_eq!(warnings.len(), 1);
        assert!(warnings[0].to_string().contains("column 4: the column `colour`"));
    }
}
