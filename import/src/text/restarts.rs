//! Time that begins again within a table: a column `run` says where, as in what `beeline export --to csv` writes.
//!
//! Without that column, rows of two recordings would be put in order by their times, and so mixed.

use campaign::{CampaignError, Place};

use super::Quantity;
use super::read::Table;
use crate::log::Note;

/// Runs are put one after another, with so much between them \[s\]. From 2 s on, a pause ends a run.
const APART_S: f64 = 10.0;
/// Rows of one recording may be out of order by less than this \[s\]; more than half of it is another recording as well.
const DISORDER_S: f64 = 5.0;

impl Table<'_> {
    /// Puts runs one after another where time begins again in each; whether it does. It must not begin again elsewhere.
    pub(super) fn join_runs(&mut self, notes: &mut Vec<Note>) -> Result<bool, CampaignError> {
        let run_of = |row: usize| self.runs.as_ref().map_or(0, |runs| runs.of(row));
        let Some(times) = self.values(Quantity::Time) else { return Ok(false) };
        let mut times = times.to_vec();
        let (mut begin_s, mut latest_s, mut shift_s) = (f64::NAN, f64::NAN, 0.0);
        // The latest but one: a single row with a wrong time is no recording.
        let mut before_s = f64::NAN;
        let (mut run, mut joined) = (0, 0);
        for (row, t_s) in times.iter_mut().enumerate().filter(|(_, t_s)| t_s.is_finite()) {
            let is_next = run_of(row) != run;
            run = run_of(row);
            *t_s += shift_s;
            if begin_s.is_nan() {
                (begin_s, latest_s, before_s) = (*t_s, *t_s, *t_s);
            } else if is_next && *t_s <= latest_s {
                let later_s = latest_s + APART_S - *t_s;
                shift_s += later_s;
                *t_s += later_s;
                (begin_s, before_s) = (*t_s, *t_s);
                joined += 1;
            } else if *t_s < before_s - DISORDER_S && *t_s < f64::midpoint(begin_s, before_s) {
                let place = Place {
                    line: row as u64 + 1 + u64::from(self.has_header),
                    ..Place::whole(self.file)
                };
                let problem = format!(
                    "time begins again: {} s come after {} s",
                    *t_s - shift_s,
                    latest_s - shift_s
                );
                let hint = "give each recording a file of its own, or a column `run` that names it in each row";
                return Err(CampaignError::new(place, problem, hint));
            }
            before_s = before_s.max(latest_s.min(*t_s));
            latest_s = latest_s.max(*t_s);
        }
        if joined > 0 {
            let text = format!(
                "time begins again in each of {} runs: they were put one after another",
                joined + 1
            );
            notes.push(Note::new(self.file, text));
        }
        if let Some(time) = self.used.iter_mut().find(|used| used.quantity == Quantity::Time) {
            time.values = times;
        }
        Ok(joined > 0)
    }
}
