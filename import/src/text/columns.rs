//! Columns of numbers as wheels and poses, wherever they come from.

use std::path::Path;

use campaign::CampaignError;

use super::Mapping;
use super::read::{Table, TextLogs};

/// What columns of the same length are: as these mappings say, or by their names. NaN is an empty cell.
pub(crate) fn of_columns(
    file: &Path,
    columns: Vec<(String, Vec<f64>)>,
    mappings: &[Mapping],
) -> Result<TextLogs, CampaignError> {
    let (names, mut values): (Vec<String>, Vec<Vec<f64>>) = columns.into_iter().unzip();
    let mut table = Table::with_header(file, names);
    table.use_columns(mappings)?;
    for used in &mut table.used {
        used.values = std::mem::take(&mut values[used.index]);
        let factor = used.factor.unwrap_or(1.0);
        used.values.iter_mut().for_each(|value| *value *= factor);
    }
    table.logs(Vec::new())
}
