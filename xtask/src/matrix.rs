//! A table of scenes by structures.

use comfy_table::{Table, presets};
use rt_accel::AcceleratorKind;

/// One quantity: a row for each scene, a column for each structure.
#[derive(Debug)]
pub(crate) struct Matrix {
    pub title: String,
    rows: Vec<(String, Vec<String>)>,
}

/// A cell that nothing was measured for.
const NOTHING: &str = "–";

impl Matrix {
    /// Fills each cell with what `cell` says of its row and its structure.
    pub(crate) fn new<R>(
        title: &str,
        rows: impl IntoIterator<Item = (String, R)>,
        cell: impl Fn(&R, &str) -> Option<String>,
    ) -> Self {
        let cells = |row: &R| {
            let cell = |kind: &AcceleratorKind| cell(row, kind.name()).unwrap_or_else(|| NOTHING.to_owned());
            AcceleratorKind::ALL.iter().map(cell).collect()
        };
        Self { title: title.to_owned(), rows: rows.into_iter().map(|(name, row)| (name, cells(&row))).collect() }
    }

    fn header() -> impl Iterator<Item = &'static str> {
        std::iter::once("").chain(AcceleratorKind::ALL.iter().map(|kind| kind.name()))
    }

    pub(crate) fn markdown(&self) -> String {
        let line = |cells: Vec<&str>| format!("| {} |\n", cells.join(" | "));
        let mut text = line(Self::header().collect());
        text.push_str(&format!("|:--|{}\n", "--:|".repeat(AcceleratorKind::ALL.len())));
        for (name, cells) in &self.rows {
            text.push_str(&line(std::iter::once(name).chain(cells).map(String::as_str).collect()));
        }
        text
    }

    pub(crate) fn terminal(&self) -> String {
        let mut table = Table::new();
        table.load_style(presets::NOTHING).set_header(Self::header());
        for (name, cells) in &self.rows {
            table.add_row(std::iter::once(name).chain(cells));
        }
        table.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_are_in_their_places() {
        let matrix = Matrix::new("t", [("a".to_owned(), 7)], |row, kind| (kind == "grid").then(|| format!("{row}")));
        let text = matrix.markdown();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("|  | linear | grid | bvh"), "{text}");
        assert!(lines[2].starts_with("| a | – | 7 | –"), "{text}");
        assert!(lines.iter().all(|line| line.matches('|').count() == AcceleratorKind::ALL.len() + 2), "{text}");
        assert!(matrix.terminal().contains("grid"));
    }
}
