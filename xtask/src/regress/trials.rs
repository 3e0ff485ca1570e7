//! The table of what was tried and what failed.

use super::unit::Outcome;
use crate::table::Table;

/// A row per outcome that tried something, and one for all of them; `None` if nothing was tried.
pub(super) fn table(outcomes: &[Outcome]) -> Option<Table> {
    let mut table = Table::new(4, HEADER);
    let (mut tried, mut failed, mut seconds) = (0, 0, 0.0);
    for outcome in outcomes {
        let Some(trial) = &outcome.findings.trial else { continue };
        (tried, failed, seconds) = (tried + trial.tried, failed + trial.failed, seconds + outcome.seconds);
        let worst = |worst: f64| if worst == 0.0 { "0".to_owned() } else { format!("{worst:.1e}") };
        table.push([
            outcome.name.clone(),
            trial.title.to_owned(),
            trial.expected.to_owned(),
            trial.tolerance.to_owned(),
            trial.tried.to_string(),
            trial.failed.to_string(),
            trial.worst.map_or_else(String::new, worst),
            format!("{:.1}", outcome.seconds),
        ]);
    }
    if table.is_empty() {
        return None;
    }
    table.push(["all", "", "", "", &tried.to_string(), &failed.to_string(), "", &format!("{seconds:.1}")]);
    Some(table)
}

const HEADER: [&str; 8] = ["case", "what", "expected", "tolerance", "tried", "failed", "worst error", "s"];

#[cfg(test)]
mod tests {
    use super::{
        super::unit::{Findings, Trial},
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
        let table =
            table(&[outcome("numerics/S01", 5, 0), silent, outcome("numerics/S02", 1000, 2)]).unwrap().to_string();
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines.len(), 5, "{table}");
        assert!(
            lines[2]
                .starts_with("| numerics/S01 | title | 8        | 4u        |     5 |      0 |     2.0e-17 | 1.5 |"),
            "{table}"
        );
        assert!(lines[4].contains("|  1005 |      2 |") && lines[4].contains("| 3.0 |"), "{}", lines[4]);
        assert!(super::table(&[]).is_none());
    }
}
