//! Tables of the results.

use comfy_table::{CellAlignment, Table, presets};

use super::statistics::{ConfidenceInterval, TimeToError};
use super::summary::{MethodSummary, PointSummary, Summary};

#[derive(Debug)]
pub(super) struct TextTable {
    pub(super) header: Vec<&'static str>,
    pub(super) rows: Vec<Vec<String>>,
}

const NO_VALUE: &str = "-";

/// One row per method and sample count, with a column for FLIP if `flip` is set.
pub(super) fn points(summary: &Summary, flip: bool) -> TextTable {
    let mut header = vec!["method", "spp", "seconds", "RMSE", "95 %", "relMSE", "bias", "efficiency"];
    if flip {
        header.insert(7, "FLIP");
    }
    let rows = summary.methods.iter().flat_map(|method| {
        method.points.iter().map(move |point| {
            let mut row = point_row(method, point);
            if flip {
                row.insert(7, point.flip.map_or(NO_VALUE.to_owned(), number));
            }
            row
        })
    });
    TextTable { header, rows: rows.collect() }
}

fn point_row(method: &MethodSummary, point: &PointSummary) -> Vec<String> {
    // Errors near that of the reference are unreliable.
    let mark = if point.is_trusted { "" } else { "*" };
    vec![
        method.name.label.clone(),
        point.spp.to_string(),
        number(point.seconds),
        point.rmse.map_or(NO_VALUE.to_owned(), number) + mark,
        point
            .rmse_interval
            .filter(|_| point.is_trusted)
            .map_or(NO_VALUE.to_owned(), |interval| range(interval, number)),
        number(point.relative_mse),
        format!("{} ± {}", signed(point.bias), number(point.bias_standard_error)),
        point.efficiency.filter(|_| point.is_trusted).map_or(NO_VALUE.to_owned(), number),
    ]
}

/// One row per method.
pub(super) fn methods(summary: &Summary) -> TextTable {
    let header = vec!["method", "slope by N", "95 %", "slope by seconds", "95 %", "seconds to target"];
    let rows = summary.methods.iter().map(|method| {
        let mut row = vec![method.name.label.clone()];
        for slope in [method.slope_of_samples, method.slope_of_seconds] {
            row.push(slope.map_or(NO_VALUE.to_owned(), |slope| fixed(slope.mean)));
            row.push(slope.map_or(NO_VALUE.to_owned(), |slope| range(slope, fixed)));
        }
        row.push(match method.time_to_error {
            None => NO_VALUE.to_owned(),
            Some(TimeToError::At(seconds)) => number(seconds),
            Some(TimeToError::Before(seconds)) => format!("< {}", number(seconds)),
            Some(TimeToError::NotWithin(seconds)) => format!("> {}", number(seconds)),
        });
        row
    });
    TextTable { header, rows: rows.collect() }
}

impl TextTable {
    /// Table for a terminal.
    pub(super) fn text(&self) -> String {
        let mut table = Table::new();
        table.load_style(presets::NOTHING);
        // Broken lines would be unreadable; the terminal may wrap or cut them.
        table.set_header(self.header.iter()).set_content_arrangement(comfy_table::ContentArrangement::Disabled);
        table.add_rows(&self.rows);
        for column in table.column_iter_mut().skip(1) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        table.lines().map(|line| line.trim_end().to_owned()).collect::<Vec<_>>().join("\n")
    }
}

/// Number with three significant digits.
pub(super) fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        1e-3..1e0 => {
            let decimals = 3 + usize::from(value.abs() < 0.1) + usize::from(value.abs() < 0.01);
            format!("{value:.decimals$}")
        }
        1e0..1e1 => format!("{value:.2}"),
        1e1..1e2 => format!("{value:.1}"),
        1e2..1e6 => format!("{value:.0}"),
        _ => format!("{value:.2e}"),
    }
}

/// Number with sign and three significant digits.
fn signed(value: f64) -> String {
    if value > 0.0 { format!("+{}", number(value)) } else { number(value) }
}

fn fixed(value: f64) -> String {
    format!("{value:.2}")
}

fn range(interval: ConfidenceInterval, show: fn(f64) -> String) -> String {
    format!("{} .. {}", show(interval.low), show(interval.high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.000_123_4, "1.23e-4"),
            (0.001_234, "0.00123"),
            (0.012_34, "0.0123"),
            (0.123_4, "0.123"),
            (-1.234, "-1.23"),
            (12.34, "12.3"),
            (123_456.0, "123456"),
            (1.234e6, "1.23e6"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(value), text);
        }
        assert_eq!(
            (signed(0.5), signed(-0.5), signed(0.0)),
            ("+0.500".to_owned(), "-0.500".to_owned(), "0".to_owned())
        );
    }
}
