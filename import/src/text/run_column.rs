//! A column that names the run of each row.

/// The name of the column.
const NAME: &str = "run";

/// Which rows belong together.
pub(super) struct RunColumn {
    pub(super) index: usize,
    last: Option<String>,
    /// Of each row, the number of its run.
    of_row: Vec<usize>,
}

impl RunColumn {
    /// The column of this name, if there is one.
    pub(super) fn find(header: &[String]) -> Option<Self> {
        let index = header.iter().position(|name| name.eq_ignore_ascii_case(NAME))?;
        Some(Self { index, last: None, of_row: Vec::new() })
    }

    /// Takes the next row's cell.
    pub(super) fn push(&mut self, cell: &str) {
        let last = self.of_row.last().copied();
        let number = match (&self.last, last) {
            (Some(name), Some(number)) if name == cell => number,
            (_, last) => {
                self.last = Some(cell.to_owned());
                last.map_or(0, |number| number + 1)
            }
        };
        self.of_row.push(number);
    }

    /// The number of a row's run, counted from 0.
    pub(super) fn of(&self, row: usize) -> usize {
        self.of_row[row]
    }
}
