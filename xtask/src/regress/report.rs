//! One page that shows every picture, failures first. It needs no other file.

use std::fs;

use base64::{Engine, prelude::BASE64_STANDARD};

use super::{
    trials,
    unit::{Outcome, Verdict, count, summary},
};
use crate::error::TaskError;

const HEAD: &str = "<!DOCTYPE html>
<html lang=\"en\">
<meta charset=\"utf-8\">
<title>regress</title>
<style>
  body { font: 15px sans-serif; margin: 2em; }
  section { border-left: 6px solid #3a3; padding-left: 1em; margin: 1.5em 0; }
  section.failed { border-color: #c22; }
  section.skipped { border-color: #ca2; }
  h2 { font-size: 1.1em; margin: 0; }
  pre { white-space: pre-wrap; margin: .3em 0; }
  img { image-rendering: pixelated; min-width: 300px; background: repeating-conic-gradient(#ddd 0 25%, #fff 0 50%) 0 / 16px 16px; }
</style>
";

/// The page for these outcomes.
pub(super) fn html(outcomes: &[Outcome]) -> Result<String, TaskError> {
    let failed = count(outcomes, Verdict::Failed);
    let summary = summary(outcomes);
    let mut page = format!("{HEAD}<h1>{failed} failed, {summary}</h1>\n<p>expected | difference | actual</p>\n");
    let mut in_order: Vec<&Outcome> = outcomes.iter().collect();
    in_order.sort_by_key(|outcome| outcome.verdict());
    for outcome in in_order {
        page.push_str(&section(outcome)?);
    }
    if let Some(table) = trials::table(outcomes) {
        page.push_str(&format!("<pre>{}</pre>\n", escape(&table.to_string())));
    }
    Ok(page)
}

fn section(outcome: &Outcome) -> Result<String, TaskError> {
    let class = outcome.verdict().name();
    let lines: Vec<&str> = outcome.findings.lines().collect();
    let picture = match &outcome.findings.picture {
        Some(path) => {
            let bytes = fs::read(path).map_err(TaskError::file(path))?;
            format!("<img alt=\"\" src=\"data:image/png;base64,{}\">\n", BASE64_STANDARD.encode(bytes))
        }
        None => String::new(),
    };
    Ok(format!(
        "<section class=\"{class}\">\n<h2>{} ({class}, {:.1} s)</h2>\n<pre>{}</pre>\n{picture}</section>\n",
        escape(&outcome.name),
        outcome.seconds,
        escape(&lines.join("\n")),
    ))
}

/// Text as HTML shows it literally.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::{super::unit::Findings, *};

    fn outcome(name: &str, problems: &[&str]) -> Outcome {
        let problems = problems.iter().map(ToString::to_string).collect();
        Outcome { name: name.to_owned(), findings: Findings { problems, ..Findings::default() }, seconds: 0.0 }
    }

    #[test]
    fn failures_come_first_and_text_is_escaped() {
        let page = html(&[outcome("good", &[]), outcome("bad", &["1 < 2"])]).unwrap();
        assert!(page.contains("1 failed, 1 of 2 passed") && page.contains("1 &lt; 2"));
        assert!(page.find("bad (failed").unwrap() < page.find("good (passed").unwrap());
    }

    #[test]
    fn what_was_skipped_is_told_apart_from_what_passed() {
        let mut skipped = outcome("absent", &[]);
        skipped.findings.skip("no reference");
        let page = html(&[outcome("good", &[]), skipped]).unwrap();
        assert!(page.contains("0 failed, 1 of 2 passed, 1 skipped"), "{page}");
        assert!(page.contains("<section class=\"skipped\">\n<h2>absent (skipped, 0.0 s)</h2>\n<pre>no reference<"));
    }

    #[test]
    fn pictures_are_embedded() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, b"abc").unwrap();
        let mut outcome = outcome("a", &[]);
        outcome.findings.picture = Some(path);
        assert!(html(&[outcome]).unwrap().contains("data:image/png;base64,YWJj"));
    }
}
