//! Columns whose unit nobody gave: times of an epoch, headings in degrees.

use campaign::CampaignError;

use super::read::{Table, Used};
use super::{Quantity, heading};
use crate::log::{Note, error};

impl Table<'_> {
    /// A time whose unit nobody gave is in that of an epoch, if it is one, else in seconds.
    pub(super) fn scale_times(&mut self) -> Result<Vec<Note>, CampaignError> {
        let file = self.file;
        let Some(time) = self.used.iter_mut().find(|used| used.quantity == Quantity::Time) else {
            return Ok(Vec::new());
        };
        let finite: Vec<f64> = time.values.iter().copied().filter(|t| t.is_finite()).collect();
        if finite.len() < 2 {
            return Err(error(
                file,
                "fewer than two rows have a time",
                "record it again, or map another column to t_s",
            ));
        }
        if time.factor.is_some() {
            return Ok(Vec::new());
        }
        let middle = finite[finite.len() / 2];
        // From 2001 to 2286.
        let unit = [("milliseconds", 1e-3), ("microseconds", 1e-6), ("nanoseconds", 1e-9)]
            .into_iter()
            .find(|(_, factor)| (1e9..1e10).contains(&(middle * factor)));
        if let Some((name, factor)) = unit {
            time.values.iter_mut().for_each(|value| *value *= factor);
            let text = format!("the times in `{}` are {name} of an epoch", time.name);
            return Ok(vec![Note::new(file, text)]);
        }
        let mut steps: Vec<f64> = finite.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
        steps.sort_by(f64::total_cmp);
        let step = steps[steps.len() / 2];
        /// No log with so few samples shows a robot's motion \[s\].
        const STEP_MAX_S: f64 = 4.0;
        if step > STEP_MAX_S {
            let problem =
                format!("in seconds, the times in `{}` would be {step} s apart", time.name);
            return Err(error(
                file,
                problem,
                format!("give their unit: --map t_s={}:ms, or us, or ns", time.name),
            ));
        }
        Ok(Vec::new())
    }

    /// A heading whose unit nobody gave is in that which agrees with the path.
    pub(super) fn scale_headings(&mut self) -> Result<Option<Note>, CampaignError> {
        let (file, is_open) = (self.file, |used: &&Used| used.factor.is_none());
        let heading = self.column(Quantity::Heading).filter(is_open);
        let path = self.values(Quantity::X).zip(self.values(Quantity::Y));
        let Some((heading, (x, y))) = heading.zip(path) else { return Ok(None) };
        let (name, unit) = (heading.name.clone(), heading::unit(x, y, &heading.values));
        match unit {
            Some(1.0) => Ok(None),
            Some(unit) => {
                let open = self.used.iter_mut().filter(|used| used.quantity == Quantity::Heading);
                open.flat_map(|used| &mut used.values).for_each(|value| *value *= unit);
                let text = format!("the headings in `{name}` are degrees: converted");
                Ok(Some(Note::new(file, text)))
            }
            None => {
                let problem = format!("the headings in `{name}` may be in degrees or in radians");
                let hint = format!("give their unit: --map heading_rad={name}:deg, or rad");
                Err(error(file, problem, hint))
            }
        }
    }
}
