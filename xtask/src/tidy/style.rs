//! Rules of style that are counted per crate: words, names, lengths of sentences, types of one name, cycles of imports.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use super::{
    allowance::Breaches,
    import_graph, names, prose,
    rust_tokens::{Kind, code_outside_tests, tokens},
};
use crate::{error::TaskError, workspace::Workspace};

/// Files that must spell out what they look for.
const TABLES: [&str; 2] = ["tidy/banned_words.rs", "tidy/names.rs"];

/// Pages that record the past.
const HISTORY: [&str; 2] = ["CHANGELOG.md", "docs/performance-log.md"];

/// Breaches of all these rules, by crate; pages in Markdown count as a crate `docs`.
pub(super) fn breaches(workspace: &Workspace) -> Result<Breaches, TaskError> {
    let mut breaches = Breaches::new();
    for package in &workspace.packages {
        let Some(folder) = package.manifest_path.parent() else { continue };
        let mut sources = BTreeMap::new();
        for path in workspace.files(&workspace.relative(folder).to_string(), ".rs")? {
            let source = fs::read_to_string(&path).map_err(TaskError::file(&path))?;
            sources.insert(path, source);
        }
        let mut found = Found { workspace, rules: BTreeMap::new() };
        found.words(&sources);
        found.types(&folder.join("src"), &sources);
        for root in ["src/lib.rs", "src/main.rs"].map(|root| folder.join(root)) {
            for cycle in import_graph::cycles(&root, &sources) {
                let names: Vec<String> = cycle.iter().map(|path| workspace.relative(path).to_string()).collect();
                for path in &cycle {
                    found.add("import cycles", path, 1, format!("imports in a circle: {}", names.join(" ")));
                }
            }
        }
        breaches.insert(package.name.clone(), found.rules);
    }
    let mut pages = Found { workspace, rules: BTreeMap::new() };
    for path in workspace.files("", ".md")? {
        if HISTORY.iter().any(|name| path.ends_with(name)) {
            continue;
        }
        let text = fs::read_to_string(&path).map_err(TaskError::file(&path))?;
        let lines: Vec<_> = text.lines().enumerate().map(|(line, text)| (line + 1, text.to_owned())).collect();
        for (line, breach) in prose::banned(&lines) {
            pages.add("words", &path, line, breach);
        }
    }
    breaches.insert("docs".to_owned(), pages.rules);
    breaches.retain(|_, rules| !rules.is_empty());
    Ok(breaches)
}

/// Breaches of one crate by rule.
struct Found<'w> {
    workspace: &'w Workspace,
    rules: BTreeMap<&'static str, Vec<String>>,
}

impl Found<'_> {
    fn add(&mut self, rule: &'static str, path: &Path, line: usize, breach: String) {
        let line = format!("{}:{line}: {breach}", self.workspace.relative(path));
        self.rules.entry(rule).or_default().push(line);
    }

    fn words(&mut self, sources: &BTreeMap<PathBuf, String>) {
        let mut known = BTreeSet::new();
        for (path, source) in sources {
            if TABLES.iter().any(|table| path.ends_with(table)) {
                continue;
            }
            let tokens = tokens(source);
            for block in prose::comment_blocks(&tokens, Kind::Documentation) {
                for (line, breach) in prose::relative_openers(&block) {
                    self.add("doc openers", path, line, breach);
                }
                for (line, breach) in prose::long_sentences(&block) {
                    self.add("long sentences", path, line, breach);
                }
            }
            for kind in [Kind::Documentation, Kind::Comment] {
                for (line, breach) in prose::comment_blocks(&tokens, kind).iter().flat_map(|block| prose::banned(block))
                {
                    self.add("words", path, line, breach);
                }
            }
            for (name, (line, instead)) in names::banned(&tokens) {
                // Each name once, however many files have it.
                if known.insert(name) {
                    self.add("names", path, line, format!("`{name}`: rather {instead}"));
                }
            }
        }
    }

    fn types(&mut self, folder: &Path, sources: &BTreeMap<PathBuf, String>) {
        let mut first: BTreeMap<&str, &Path> = BTreeMap::new();
        for (path, source) in sources.iter().filter(|(path, _)| path.starts_with(folder)) {
            for name in names::types(&code_outside_tests(&tokens(source))) {
                if let Some(other) = first.get(name) {
                    let breach = format!("a type `{name}` is in {}, too", self.workspace.relative(other));
                    self.add("types of one name", path, 1, breach);
                } else {
                    first.insert(name, path);
                }
            }
        }
    }
}
