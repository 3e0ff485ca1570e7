//! Table of one quantity: a row for each scene, a column for each accelerator.

use std::fmt;

use rt_accel::AcceleratorKind;

use crate::table::Table;

/// A table under a title; displayed as a section of a page.
#[derive(Debug)]
pub(crate) struct Matrix {
    title: String,
    table: Table,
}

/// Cell without a measurement.
const NO_VALUE: &str = "–";

impl Matrix {
    /// Fills the cells of each row with `cell(row, accelerator)`.
    pub(crate) fn new<R>(
        title: &str,
        rows: impl IntoIterator<Item = (String, R)>,
        cell: impl Fn(&R, &str) -> Option<String>,
    ) -> Self {
        let names = || AcceleratorKind::ALL.iter().map(|kind| kind.name());
        let mut table = Table::new(1, std::iter::once("").chain(names()));
        for (name, row) in rows {
            let cells = names().map(|kind| cell(&row, kind).unwrap_or_else(|| NO_VALUE.to_owned()));
            table.push(std::iter::once(name).chain(cells));
        }
        Self { title: title.to_owned(), table }
    }
}

impl fmt::Display for Matrix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "## {}\n\n{}", self.title, self.table)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_are_in_their_places() {
        let matrix = Matrix::new("t", [("a".to_owned(), 7)], |row, kind| (kind == "grid").then(|| format!("{row}")));
        let text = matrix.to_string();
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split('|').map(str::trim).collect()).collect();
        assert_eq!((lines[0][0], &lines[2][1..5]), ("## t", &["", "linear", "grid", "bvh"][..]), "{text}");
        assert_eq!(lines[4][1..5], ["a", "–", "7", "–"], "{text}");
    }
}
