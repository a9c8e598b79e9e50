//! Whether sources can be used as they are, and together.

use campaign::CampaignError;

use super::{Source, Sources};
use crate::log::error;
use crate::text::Mapping;

impl Sources {
    /// Where time begins again in each run of a table, no other file can be matched with it.
    pub(super) fn check_times(&self) -> Result<(), CampaignError> {
        let own = self.each.iter().find_map(|source| match source {
            Source::Text(file, logs) if logs.has_own_time => Some(file),
            _ => None,
        });
        match own {
            Some(file) if self.each.len() > 1 => Err(error(
                file,
                "its time begins again in each run, so no other file can be matched with it",
                "put wheels and poses into one table, or let one clock count on from run to run",
            )),
            _ => Ok(()),
        }
    }

    /// A column that was mapped must be in some file.
    pub(super) fn check_mappings(&self, mappings: &[Mapping]) -> Result<(), CampaignError> {
        let texts = || {
            self.each.iter().filter_map(|source| match source {
                Source::Text(file, logs) => Some((file, logs)),
                Source::Bag(..) => None,
            })
        };
        for mapping in mappings {
            let is_there = texts().any(|(_, logs)| logs.columns.contains(&mapping.column));
            if is_there {
                continue;
            }
            let Some((file, _)) = texts().next() else { continue };
            let columns: Vec<String> = texts()
                .map(|(file, logs)| format!("{}: {}", file.display(), logs.columns.join(", ")))
                .collect();
            let problem = format!("no file has a column `{}`", mapping.column);
            return Err(error(file, problem, format!("the columns are: {}", columns.join("; "))));
        }
        Ok(())
    }
}
