//! Tables of measurements, as Markdown with aligned columns: it reads well on a terminal, too.

use std::fmt;

/// A table. All rows have as many cells as the header.
#[derive(Debug)]
pub(crate) struct Table {
    n_left: usize,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows. Names stand in the first `n_left` columns, numbers in the others.
    pub(crate) fn new<S: Into<String>>(n_left: usize, header: impl IntoIterator<Item = S>) -> Self {
        Self { n_left, rows: vec![header.into_iter().map(Into::into).collect()] }
    }

    pub(crate) fn push<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        let cells: Vec<String> = cells.into_iter().map(Into::into).collect();
        debug_assert_eq!(cells.len(), self.rows[0].len());
        self.rows.push(cells);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.rows.len() == 1
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = |column: usize| self.rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0).max(3);
        let widths: Vec<usize> = (0..self.rows[0].len()).map(width).collect();
        for (index, row) in self.rows.iter().enumerate() {
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                if column < self.n_left { write!(f, "| {cell:<width$} ")? } else { write!(f, "| {cell:>width$} ")? }
            }
            writeln!(f, "|")?;
            if index == 0 {
                for (column, width) in widths.iter().enumerate() {
                    let dashes = "-".repeat(width - 1);
                    if column < self.n_left { write!(f, "| :{dashes} ")? } else { write!(f, "| {dashes}: ")? }
                }
                writeln!(f, "|")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_aligned_to_the_left_and_numbers_to_the_right() {
        let mut table = Table::new(1, ["", "time in s"]);
        assert!(table.is_empty());
        table.push(["kd", "1.5"]);
        table.push(["∛n cells", "10"]);
        let text =
            "|          | time in s |\n| :------- | --------: |\n| kd       |       1.5 |\n| ∛n cells |        10 |\n";
        assert_eq!((table.is_empty(), table.to_string()), (false, text.to_owned()));
    }
}
