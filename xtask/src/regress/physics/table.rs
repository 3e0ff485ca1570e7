//! The table of all pairs, for the terminal and for the guide.

use std::path::Path;

use super::{
    comparison::Comparison,
    pair::{Effort, OWN},
};
use crate::{error::TaskError, files, table::Table, workspace::Workspace};

const PAGE: &str = "docs/PHYSICS.md";
const MARKER: &str = "physics";

#[derive(Debug)]
pub(in super::super) struct PairRow {
    pub(super) name: String,
    /// True if the pair is part of the project.
    pub(super) is_own: bool,
    pub(super) kind: String,
    pub(super) note: String,
    pub(super) comparison: Comparison,
    pub(super) verdict: &'static str,
}

impl PairRow {
    /// One line for the terminal.
    pub(super) fn line(&self) -> String {
        let Comparison { rms, worst, far, blocks, .. } = &self.comparison;
        format!(
            "{}; ratio {}; z {}; blocks: RMS {rms:.2}, worst {worst:.1}, {far} of {blocks} beyond 3; notices {}",
            self.verdict,
            self.ratios(),
            self.scores(),
            self.notices(),
        )
    }

    fn cells(&self) -> [String; 10] {
        let Comparison { rms, worst, far, blocks, .. } = &self.comparison;
        [
            format!("{}{}", if self.is_own { "" } else { "° " }, self.name),
            self.kind.clone(),
            self.note.replace('|', "\\|"),
            self.verdict.to_owned(),
            self.ratios(),
            self.scores(),
            format!("{rms:.2}"),
            format!("{worst:.1}"),
            format!("{far} of {blocks}"),
            self.notices(),
        ]
    }

    /// Ratios of the image means with the maximum of their standard errors; one if all are the same.
    fn ratios(&self) -> String {
        let Comparison { ratio, ratio_error, .. } = &self.comparison;
        let error = ratio_error.iter().copied().filter(|error| error.is_finite()).fold(0.0, f64::max);
        let one = |ratio: &f64| if ratio.is_finite() { format!("{ratio:.4}") } else { "black".to_owned() };
        format!("{} ± {error:.4}", merged(ratio.iter().map(one)))
    }

    fn scores(&self) -> String {
        merged(self.comparison.mean_scores.iter().map(|z| format!("{z:+.1}")))
    }

    fn notices(&self) -> String {
        let percent = 100.0 * self.comparison.notices;
        if percent.is_finite() { format!("{percent:.2} %") } else { "blocks".to_owned() }
    }
}

/// Numbers of the three channels; one number if all read the same.
fn merged(channels: impl Iterator<Item = String>) -> String {
    let mut texts: Vec<String> = channels.collect();
    texts.dedup();
    texts.join(" / ")
}

/// Writes the table of the pairs into the folder of the report, and with `write` into the guide.
pub(super) fn finish(
    workspace: &Workspace,
    mut rows: Vec<&PairRow>,
    folder: &Path,
    effort: Effort,
    write: bool,
) -> Result<(), TaskError> {
    rows.sort_by(|a, b| a.name.cmp(&b.name));
    if rows.is_empty() {
        return Ok(());
    }
    let table = markdown(&rows).to_string();
    let path = folder.join("physics.md");
    files::write(&path, &table)?;
    println!("{} (see {})", summary(&rows, effort), workspace.relative(&path));
    if write {
        let origin = format!(
            "\nWritten by `cargo xtask regress physics --full --write` on one {}, at commit {}. {}\n\n",
            crate::processor::processor(),
            workspace.commit(),
            summary(&rows, effort),
        );
        let path = workspace.root.join(PAGE);
        files::replace_block(&path, MARKER, &format!("{origin}{table}\n"))?;
    }
    Ok(())
}

fn markdown(rows: &[&PairRow]) -> Table {
    let header =
        ["pair", "reference", "idea", "verdict", "ratio of image means", "z", "RMS", "worst", "beyond 3", "notices"];
    let mut table = Table::new(4, header);
    rows.iter().for_each(|row| table.push(row.cells()));
    table
}

fn summary(rows: &[&PairRow], effort: Effort) -> String {
    let count = |verdict: &str| rows.iter().filter(|row| row.verdict == verdict).count();
    let own = rows.iter().filter(|row| row.is_own).count();
    let mut text = format!("{} pairs, {own} of them in {OWN}, with {effort}: {} agree", rows.len(), count("agrees"));
    for (verdict, words) in [
        ("differs by convention", "differ by convention"),
        ("differs, known", "are known to differ"),
        ("FAILS", "fail"),
    ] {
        text.push_str(&match count(verdict) {
            0 => String::new(),
            n => format!(", {n} {words}"),
        });
    }
    text.push('.');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &str, is_own: bool, ratio: [f64; 3]) -> PairRow {
        let comparison = Comparison {
            ratio,
            ratio_error: [0.001, 0.002, f64::NAN],
            mean_scores: [0.5, 0.5, 0.5],
            rms: 1.0,
            worst: 2.5,
            far: 0,
            blocks: 192,
            notices: 0.0123,
            problems: Vec::new(),
            notes: Vec::new(),
        };
        let (name, kind, note) = (name.to_owned(), "numeric".to_owned(), "a | b".to_owned());
        PairRow { name, is_own, kind, note, comparison, verdict: "agrees" }
    }

    #[test]
    fn rows_show_ratios_scores_and_verdict() {
        let rows = [row("a", true, [1.0, 1.0, f64::NAN]), row("b", false, [1.0; 3])];
        let cells = rows.map(|row| row.cells().join("; "));
        let ratio = "1.0000 / black ± 0.0020; +0.5; 1.00; 2.5; 0 of 192; 1.23 %";
        assert_eq!(cells[0], format!("a; numeric; a \\| b; agrees; {ratio}"));
        assert!(cells[1].starts_with("° b; numeric; a \\| b; agrees; 1.0000 ± 0.0020; +0.5;"), "{}", cells[1]);
    }

    #[test]
    fn the_summary_counts_verdicts() {
        let mut failing = row("c", false, [1.0; 3]);
        failing.verdict = "FAILS";
        let rows = [row("a", true, [1.0; 3]), failing];
        let text = summary(&rows.iter().collect::<Vec<_>>(), Effort::FULL);
        assert_eq!(text, "2 pairs, 1 of them in tests/physics/pairs, with all seeds and samples: 1 agree, 1 fail.");
    }
}
