//! Rules of style: words, names, lengths of sentences, types of one name, cycles of imports.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use super::{
    import_graph, names,
    prose::{self, Line},
    rust_tokens::{Kind, code_outside_tests, tokens},
};
use crate::{error::TaskError, files, workspace::Workspace};

/// Files that contain the words that they search for.
const TABLES: [&str; 2] = ["tidy/banned_words.rs", "tidy/names.rs"];

/// Packages that are workspaces of their own.
const OTHER_PACKAGES: [&str; 2] = ["bindings/python", "fuzz"];

/// Pages that record the past, whose words are not checked.
const HISTORY: [&str; 2] = ["CHANGELOG.md", "docs/performance-log.md"];

/// Pages whose sentences are not counted: a log, and a page of doc comments, which are checked in their source.
const UNCOUNTED: [&str; 2] = ["docs/performance-log.md", "docs/SCENE-FORMAT.md"];

/// Breaches of all these rules, in all crates and in the pages.
pub(super) fn check(workspace: &Workspace) -> Result<Vec<String>, TaskError> {
    let mut found = Found { workspace, breaches: Vec::new() };
    let packages = workspace.packages.iter().filter_map(|package| Some(package.manifest_path.parent()?.to_owned()));
    for folder in packages.chain(OTHER_PACKAGES.map(|folder| workspace.root.join(folder))) {
        let mut sources = BTreeMap::new();
        for path in workspace.files(&workspace.relative(&folder).to_string(), ".rs")? {
            let source = files::read(&path)?;
            sources.insert(path, source);
        }
        found.words(&sources);
        found.types(&folder.join("src"), &sources);
        for root in ["src/lib.rs", "src/main.rs"].map(|root| folder.join(root)) {
            for cycle in import_graph::cycles(&root, &sources) {
                let names: Vec<String> = cycle.iter().map(|path| workspace.relative(path).to_string()).collect();
                found.add(&root, 1, format!("imports in a circle: {}", names.join(" ")));
            }
        }
    }
    for path in workspace.files("", ".md")? {
        let text = files::read(&path)?;
        let lines: Vec<_> = text.lines().enumerate().map(|(line, text)| (line + 1, text.to_owned())).collect();
        let is_among = |pages: &[&str]| pages.iter().any(|name| path.ends_with(name));
        if !is_among(&HISTORY) {
            found.add_all(&path, prose::banned(&lines));
        }
        if !is_among(&UNCOUNTED) {
            found.add_all(&path, prose::long_sentences(&lines));
        }
    }
    Ok(found.breaches)
}

/// Breaches found so far.
struct Found<'w> {
    workspace: &'w Workspace,
    breaches: Vec<String>,
}

impl Found<'_> {
    fn add(&mut self, path: &Path, line: usize, breach: String) {
        self.breaches.push(format!("{}:{line}: {breach}", self.workspace.relative(path)));
    }

    fn add_all(&mut self, path: &Path, lines: Vec<Line>) {
        lines.into_iter().for_each(|(line, breach)| self.add(path, line, breach));
    }

    fn words(&mut self, sources: &BTreeMap<PathBuf, String>) {
        let mut known = BTreeSet::new();
        for (path, source) in sources {
            if TABLES.iter().any(|table| path.ends_with(table)) {
                continue;
            }
            let tokens = tokens(source);
            for block in prose::comment_blocks(&tokens, Kind::Documentation) {
                self.add_all(path, prose::relative_openers(&block));
                self.add_all(path, prose::long_sentences(&block));
            }
            for kind in [Kind::Documentation, Kind::Comment] {
                for block in prose::comment_blocks(&tokens, kind) {
                    self.add_all(path, prose::banned(&block));
                }
            }
            for (name, (line, instead)) in names::banned(&tokens) {
                // Each name once, however many files have it.
                if known.insert(name) {
                    self.add(path, line, format!("`{name}`: rather {instead}"));
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
                    self.add(path, 1, breach);
                } else {
                    first.insert(name, path);
                }
            }
        }
    }
}
