//! The table of what was tried and what failed.

use super::Outcome;

pub(super) const HEAD: [&str; 8] = ["case", "what", "expected", "tolerance", "tried", "failed", "worst error", "s"];

/// One row for each outcome that tried something, and one for all of them.
pub(super) fn rows(outcomes: &[Outcome]) -> Vec<[String; 8]> {
    let mut rows = Vec::new();
    let (mut tried, mut failed, mut seconds) = (0, 0, 0.0);
    for outcome in outcomes {
        let Some(trial) = &outcome.findings.trial else { continue };
        (tried, failed, seconds) = (tried + trial.tried, failed + trial.failed, seconds + outcome.seconds);
        rows.push([
            outcome.name.clone(),
            trial.title.to_owned(),
            trial.expected.to_owned(),
            trial.tolerance.to_owned(),
            trial.tried.to_string(),
            trial.failed.to_string(),
            trial
                .worst
                .map_or_else(String::new, |worst| if worst == 0.0 { "0".to_owned() } else { format!("{worst:.1e}") }),
            format!("{:.1}", outcome.seconds),
        ]);
    }
    if !rows.is_empty() {
        let blank = String::new;
        let sums = [tried.to_string(), failed.to_string(), blank(), format!("{seconds:.1}")];
        let [tried, failed, worst, seconds] = sums;
        rows.push(["all".to_owned(), blank(), blank(), blank(), tried, failed, worst, seconds]);
    }
    rows
}

/// The table as Markdown with its columns aligned; `None` if nothing was tried.
pub(super) fn markdown(outcomes: &[Outcome]) -> Option<String> {
    let rows = rows(outcomes);
    if rows.is_empty() {
        return None;
    }
    let all: Vec<[String; 8]> = std::iter::once(HEAD.map(str::to_owned)).chain(rows).collect();
    let width = |column: usize| all.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; 8] = std::array::from_fn(width);
    let mut table = String::new();
    for (index, row) in all.iter().enumerate() {
        for (cell, width) in row.iter().zip(widths) {
            table.push_str(&format!("| {cell:width$} "));
        }
        table.push_str("|\n");
        if index == 0 {
            table.extend(widths.map(|width| format!("|{}", "-".repeat(width + 2))));
            table.push_str("|\n");
        }
    }
    Some(table)
}

#[cfg(test)]
mod tests {
    use super::{
        super::{Findings, Trial},
        *,
    };

    #[test]
    fn trials_are_listed_and_added_up() {
        let outcome = |name: &str, tried, failed| {
            let (title, expected, tolerance) = ("title", "8", "4u");
            let trial = Trial { title, expected, tolerance, tried, failed, worst: Some(2e-17) };
            Outcome {
                name: name.to_owned(),
                findings: Findings { trial: Some(trial), ..Findings::default() },
                seconds: 1.5,
            }
        };
        let silent = Outcome { name: "golden".to_owned(), findings: Findings::default(), seconds: 9.0 };
        let table = markdown(&[outcome("stiff/S01", 5, 0), silent, outcome("stiff/S02", 1000, 2)]).unwrap();
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines.len(), 5, "{table}");
        assert!(
            lines[2].starts_with("| stiff/S01 | title | 8        | 4u        | 5     | 0      | 2.0e-17     | 1.5")
        );
        assert!(lines[4].contains("| 1005  | 2      |") && lines[4].contains("| 3.0"), "{}", lines[4]);
        assert_eq!(markdown(&[]), None);
    }
}
