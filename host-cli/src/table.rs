//! Tables on a terminal: columns as wide as their cells, numbers aligned to the right.

use anstyle::Style;

use crate::ui::{paint, say};

/// One cell: its text and its style.
#[derive(Clone, Debug)]
pub struct Cell {
    text: String,
    style: Style,
}

impl Cell {
    /// A cell in a style.
    pub fn styled(style: Style, text: impl ToString) -> Self {
        Self { text: text.to_string(), style }
    }
}

impl<T: ToString> From<T> for Cell {
    fn from(text: T) -> Self {
        Self::styled(Style::new(), text)
    }
}

/// How the cells of a column are aligned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// To the left, for words.
    Left,
    /// To the right, for numbers.
    Right,
}

/// A table, built row by row.
#[derive(Clone, Debug)]
pub struct Table {
    aligns: Vec<Align>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table with this alignment: `l` or `r` for each column.
    pub fn new(aligns: &str) -> Self {
        let align = |c| if c == 'r' { Align::Right } else { Align::Left };
        Self { aligns: aligns.chars().map(align).collect(), rows: Vec::new() }
    }

    /// Adds a row; missing cells at its end stay empty.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// The lines of the table, each with `indent` spaces before it.
    pub fn lines(&self, indent: usize) -> Vec<String> {
        let width = |text: &str| text.chars().count();
        let mut widths = vec![0; self.aligns.len()];
        // A row of one cell is a heading over all columns.
        for row in self.rows.iter().filter(|row| row.len() > 1) {
            for (column, cell) in row.iter().enumerate() {
                widths[column] = widths[column].max(width(&cell.text));
            }
        }
        let line = |row: &Vec<Cell>| {
            let mut line = " ".repeat(indent);
            for (column, cell) in row.iter().enumerate() {
                let space = " ".repeat(widths[column].saturating_sub(width(&cell.text)));
                let text = if cell.style == Style::new() {
                    cell.text.clone()
                } else {
                    paint(cell.style, &cell.text)
                };
                let last = column + 1 == row.len();
                match self.aligns[column] {
                    Align::Right => line += &format!("{space}{text}"),
                    Align::Left if last => line += &text,
                    Align::Left => line += &format!("{text}{space}"),
                }
                if !last {
                    line += "  ";
                }
            }
            line.trim_end().to_owned()
        };
        self.rows.iter().map(line).collect()
    }

    /// Prints the table.
    pub fn say(&self, indent: usize) {
        self.lines(indent).iter().for_each(say);
    }
}

/// Words in lines of at most `width` characters.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell_and_headings_do_not_count() {
        let mut table = Table::new("lr");
        table.row(["a heading longer than anything".into()]);
        table.row(["straight".into(), "1.5".into()]);
        table.row(["übung".into(), Cell::from(-12.25)]);
        let expected =
            ["  a heading longer than anything", "  straight     1.5", "  übung     -12.25"];
        assert_eq!(table.lines(2), expected);
    }

    #[test]
    fn words_are_wrapped_between_them() {
        assert_eq!(wrapped("one two  three", 8), ["one two", "three"]);
        assert!(wrapped(" ", 8).is_empty());
    }
}
