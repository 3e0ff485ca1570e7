//! Breaches that remain of rules that came late: a count per crate and rule, which may only fall.

use std::{collections::BTreeMap, fmt::Write as _, fs};

use super::report::Report;
use crate::{error::TaskError, workspace::Workspace};

const FILE: &str = "xtask/tidy-allowance.toml";

const TITLE: &str = "\
# Breaches of rules of `cargo xtask tidy` that remain, by crate. No count may rise; the goal is an empty file.
# `cargo xtask tidy CRATE` lists them, `cargo xtask tidy --lower` writes the counts that have fallen.
";

/// Breaches by crate and rule.
pub(super) type Breaches = BTreeMap<String, BTreeMap<&'static str, Vec<String>>>;

/// Allowed numbers by crate and rule.
type Allowance = BTreeMap<String, BTreeMap<String, usize>>;

/// Compares with the allowance. With `lower`, writes the file anew if no count has risen.
pub(super) fn check(workspace: &Workspace, breaches: &Breaches, lower: bool) -> Result<Report, TaskError> {
    let path = workspace.root.join(FILE);
    let text = if path.exists() { fs::read_to_string(&path).map_err(TaskError::file(&path))? } else { String::new() };
    let allowed = toml::from_str(&text).map_err(|source| TaskError::Toml { path: path.clone(), source })?;
    let report = compare(breaches, &allowed);
    if lower && report.breaches.is_empty() {
        fs::write(&path, page(breaches)).map_err(TaskError::file(&path))?;
    }
    Ok(report)
}

fn compare(breaches: &Breaches, allowed: &Allowance) -> Report {
    let mut report = Report::default();
    let limit =
        |package: &str, rule: &str| allowed.get(package).and_then(|rules| rules.get(rule)).copied().unwrap_or(0);
    for (package, rules) in breaches {
        for (rule, lines) in rules {
            let (count, limit) = (lines.len(), limit(package, rule));
            if count > limit {
                report.breaches.push(format!(
                    "{package}: {count} breaches of \"{rule}\", {limit} are allowed: `cargo xtask tidy {package}` lists them"
                ));
            } else if count < limit {
                report
                    .warnings
                    .push(format!("{package}: \"{rule}\" can be lowered from {limit} to {count} with --lower"));
            }
        }
    }
    for (package, rules) in allowed {
        for (rule, limit) in rules {
            if breaches.get(package).is_none_or(|rules| !rules.contains_key(rule.as_str())) {
                report.warnings.push(format!("{package}: \"{rule}\" can be lowered from {limit} to 0 with --lower"));
            }
        }
    }
    report
}

fn page(breaches: &Breaches) -> String {
    let mut page = TITLE.to_owned();
    for (package, rules) in breaches {
        let _ = writeln!(page, "\n[{package}]");
        for (rule, lines) in rules {
            let _ = writeln!(page, "\"{rule}\" = {}", lines.len());
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_may_fall_and_not_rise() {
        let breaches = |count: usize| -> Breaches {
            BTreeMap::from([("a".to_owned(), BTreeMap::from([("rule", vec!["line".to_owned(); count])]))])
        };
        let allowed: Allowance = toml::from_str(&page(&breaches(2))).expect("a page that can be read");
        let counts = |breaches: &Breaches| {
            let report = compare(breaches, &allowed);
            (report.breaches.len(), report.warnings.len())
        };
        assert_eq!(counts(&breaches(3)), (1, 0));
        assert_eq!(counts(&breaches(2)), (0, 0));
        assert_eq!(counts(&breaches(1)), (0, 1));
        assert_eq!(counts(&Breaches::new()), (0, 1));
        assert_eq!(compare(&breaches(1), &Allowance::new()).breaches.len(), 1);
    }
}
