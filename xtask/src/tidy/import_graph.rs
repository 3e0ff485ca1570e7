//! Imports between the files of a crate, and the cycles among them.
//!
//! A path counts as an import of the file that declares the item: re-exports on the way are followed. Tests are left out.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use super::rust_tokens::{Kind, Token, code_outside_tests, tokens};

/// A file of a crate as a module.
#[derive(Debug, Default)]
struct Module<'s> {
    path: PathBuf,
    parent: usize,
    children: BTreeMap<&'s str, usize>,
    items: BTreeSet<&'s str>,
    imports: Vec<Import<'s>>,
    code: Vec<Token<'s>>,
}

/// One name that a `use` brings into a module; `None` for all names of the target.
#[derive(Debug, Clone)]
struct Import<'s> {
    name: Option<&'s str>,
    path: Vec<&'s str>,
    is_public: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Target {
    Module(usize),
    Item(usize),
}

/// Modules of a crate; the first is the root.
#[derive(Debug)]
struct Crate<'s> {
    modules: Vec<Module<'s>>,
}

/// Groups of files that import each other, directly or through others. `sources` are all files of the crate by path.
pub(super) fn cycles(root: &Path, sources: &BTreeMap<PathBuf, String>) -> Vec<Vec<PathBuf>> {
    let graph = Crate::read(root, sources);
    let edges: Vec<BTreeSet<usize>> = (0..graph.modules.len()).map(|module| graph.imports_of(module)).collect();
    let reached: Vec<BTreeSet<usize>> = (0..edges.len()).map(|start| reachable(&edges, start)).collect();
    let mut cycles = Vec::new();
    let mut seen = BTreeSet::new();
    for start in 0..edges.len() {
        if reached[start].contains(&start) && !seen.contains(&start) {
            let group: Vec<usize> =
                reached[start].iter().copied().filter(|end| reached[*end].contains(&start)).collect();
            cycles.push(group.iter().map(|module| graph.modules[*module].path.clone()).collect());
            seen.extend(group);
        }
    }
    cycles
}

/// Nodes that paths of at least one edge lead to.
fn reachable(edges: &[BTreeSet<usize>], start: usize) -> BTreeSet<usize> {
    let mut reached = BTreeSet::new();
    let mut waiting = vec![start];
    while let Some(node) = waiting.pop() {
        waiting.extend(edges[node].iter().filter(|next| reached.insert(**next)));
    }
    reached
}

impl<'s> Crate<'s> {
    fn read(root: &Path, sources: &'s BTreeMap<PathBuf, String>) -> Self {
        let mut graph = Self { modules: Vec::new() };
        graph.add(root, 0, sources);
        graph
    }

    /// Adds the module of a file and all below it; returns its index.
    fn add(&mut self, path: &Path, parent: usize, sources: &'s BTreeMap<PathBuf, String>) -> usize {
        let index = self.modules.len();
        let source = sources.get(path).map_or("", String::as_str);
        let module = Module { path: path.to_owned(), parent, ..read_module(source) };
        let children: Vec<&str> = module.children.keys().copied().collect();
        self.modules.push(module);
        let folder = path.parent().unwrap_or(Path::new(""));
        let stem = path.file_stem().unwrap_or_default();
        let is_folder = ["mod", "lib", "main"].iter().any(|name| stem == *name);
        let folder = if is_folder { folder.to_owned() } else { folder.join(stem) };
        for name in children {
            let file = [folder.join(format!("{name}.rs")), folder.join(name).join("mod.rs")];
            // Modules that another build replaces, and those within a file, belong to this file.
            let child = file.iter().find(|file| sources.contains_key(*file));
            let child = child.map_or(index, |file| self.add(file, index, sources));
            self.modules[index].children.insert(name, child);
        }
        index
    }

    /// Files that the code of a module names, without itself.
    fn imports_of(&self, module: usize) -> BTreeSet<usize> {
        let this = &self.modules[module];
        let mut files = BTreeSet::new();
        let is_named = |name: &str| this.code.iter().filter(|token| token.text == name).count() > 1;
        for import in &this.imports {
            // A re-export by itself is no import.
            if import.name.map_or(import.is_public, |name| import.is_public && !is_named(name)) {
                continue;
            }
            match self.resolve(module, &import.path, 0) {
                Some(Target::Item(file)) => files.extend([file]),
                // Names of a module are imported where a path mentions them.
                Some(Target::Module(file)) if import.name.is_none() => files.extend([file]),
                _ => {}
            }
        }
        for path in paths(&this.code).into_iter().collect::<BTreeSet<_>>() {
            if let Some(Target::Item(file)) = self.resolve(module, &path, 0) {
                files.insert(file);
            }
        }
        files.remove(&module);
        files
    }

    /// Follows a path as seen from a module; `None` if it leaves the crate or names something local.
    fn resolve(&self, from: usize, path: &[&'s str], depth: usize) -> Option<Target> {
        let (first, rest) = path.split_first()?;
        let mut target = match *first {
            "crate" => Target::Module(0),
            "self" => Target::Module(from),
            "super" => Target::Module(self.modules[from].parent),
            name => self.member(from, name, depth)?,
        };
        for name in rest {
            let Target::Module(module) = target else { break };
            target = match *name {
                "super" => Target::Module(self.modules[module].parent),
                "self" => target,
                // Items that a macro declares have no declaration to be found.
                name => self.member(module, name, depth).unwrap_or(Target::Item(module)),
            };
        }
        Some(target)
    }

    /// A name within a module: a child, an import, or an item.
    fn member(&self, module: usize, name: &str, depth: usize) -> Option<Target> {
        // Deep chains of imports end; so do imports in a circle.
        if depth > 12 {
            return None;
        }
        let this = &self.modules[module];
        if let Some(child) = this.children.get(name) {
            return Some(Target::Module(*child));
        }
        if this.items.contains(name) {
            return Some(Target::Item(module));
        }
        let import = this.imports.iter().find(|import| import.name == Some(name) && import.path != [name]);
        if let Some(import) = import {
            return self.resolve(module, &import.path, depth + 1);
        }
        this.imports.iter().filter(|import| import.name.is_none()).find_map(|import| {
            match self.resolve(module, &import.path, depth + 1)? {
                Target::Module(other) if other != module => self.member(other, name, depth + 1),
                _ => None,
            }
        })
    }
}

/// Children, items and imports of a module.
fn read_module(source: &str) -> Module<'_> {
    let code = code_outside_tests(&tokens(source));
    let mut module = Module::default();
    let text = |at: usize| code.get(at).map_or("", |token| token.text);
    for at in 0..code.len() {
        match text(at) {
            "mod" if text(at + 2) == ";" || text(at + 2) == "{" => {
                module.children.insert(text(at + 1), 0);
            }
            "struct" | "enum" | "union" | "trait" | "type" | "fn" | "const" | "static" => {
                module.items.insert(text(at + 1));
            }
            "macro_rules" => {
                module.items.insert(text(at + 2));
            }
            "use" if !["<", "+", ","].contains(&text(at + 1)) => {
                let is_public = at > 0 && (text(at - 1) == "pub" || text(at - 1) == ")");
                let end = code[at..].iter().position(|token| token.text == ";").map_or(code.len(), |end| at + end);
                read_use(&code[at + 1..end], &mut Vec::new(), is_public, &mut module.imports);
            }
            _ => {}
        }
    }
    Module { code, ..module }
}

/// Imports of the tree of a `use`; returns the number of its tokens.
fn read_use<'s>(
    tree: &[Token<'s>],
    prefix: &mut Vec<&'s str>,
    is_public: bool,
    imports: &mut Vec<Import<'s>>,
) -> usize {
    let depth = prefix.len();
    let mut at = 0;
    let mut name = None;
    while let Some(token) = tree.get(at) {
        match token.text {
            "::" => {}
            "," | "}" => break,
            "{" => {
                at += 1;
                while tree.get(at).is_some_and(|token| token.text != "}") {
                    at += read_use(&tree[at..], prefix, is_public, imports);
                    at += usize::from(tree.get(at).is_some_and(|token| token.text == ","));
                }
                prefix.truncate(depth);
                return at + 1;
            }
            "*" => {
                imports.push(Import { name: None, path: prefix.clone(), is_public });
                prefix.truncate(depth);
                return at + 1;
            }
            "as" => {
                name = tree.get(at + 1).map(|token| token.text);
                at += 1;
            }
            // `self` within braces is the module itself.
            "self" if !prefix.is_empty() => {}
            segment => prefix.push(segment),
        }
        at += 1;
    }
    if let Some(last) = name.or(prefix.last().copied()) {
        imports.push(Import { name: Some(last), path: prefix.clone(), is_public });
    }
    prefix.truncate(depth);
    at
}

/// Paths of two segments and more outside of `use`.
fn paths<'s>(code: &[Token<'s>]) -> Vec<Vec<&'s str>> {
    let mut paths = Vec::new();
    let mut at = 0;
    while at < code.len() {
        if code[at].text == "use" {
            at += code[at..].iter().position(|token| token.text == ";").unwrap_or(0);
        }
        let mut path = Vec::new();
        while code.get(at).is_some_and(|token| token.kind == Kind::Word) {
            path.push(code[at].text);
            if code.get(at + 1).is_none_or(|token| token.text != "::") {
                break;
            }
            at += 2;
        }
        if path.len() > 1 {
            paths.push(path);
        }
        at += 1;
    }
    paths
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cycles of a crate with these files in `src`.
    fn cycles_of(files: &[(&str, &str)]) -> Vec<Vec<String>> {
        let sources = files.iter().map(|(path, source)| (Path::new("src").join(path), (*source).to_owned())).collect();
        let name = |path: &PathBuf| path.strip_prefix("src").expect("below src").to_string_lossy().replace('\\', "/");
        cycles(Path::new("src/lib.rs"), &sources).iter().map(|group| group.iter().map(name).collect()).collect()
    }

    #[test]
    fn files_that_import_each_other_are_a_cycle() {
        let root = ("lib.rs", "mod a; mod b; mod c; pub use a::A;");
        let a = ("a.rs", "use crate::b::B; pub struct A;");
        assert_eq!(cycles_of(&[root, a, ("b.rs", "pub struct B;")]), [[""; 0]; 0]);
        assert_eq!(
            cycles_of(&[root, a, ("b.rs", "use super::{c::{self}, a as x}; fn f(a: x::A) {}")]),
            [["a.rs", "b.rs"]]
        );
        let through = [("b.rs", "pub struct B(crate::c::C);"), ("c.rs", "use crate::{A, b::B as _}; pub struct C(A);")];
        assert_eq!(cycles_of(&[root, a, through[0], through[1]]), [["a.rs", "b.rs", "c.rs"]]);
    }

    #[test]
    fn a_module_and_its_child_can_be_a_cycle() {
        let child = ("a/b.rs", "use super::S; pub fn f(s: S) {}");
        assert_eq!(
            cycles_of(&[("lib.rs", "mod a;"), ("a/mod.rs", "mod b; pub use b::f; pub struct S;"), child]),
            [[""; 0]; 0]
        );
        let uses = ("a/mod.rs", "mod b; struct S; fn g() { b::f(S); }");
        assert_eq!(cycles_of(&[("lib.rs", "mod a;"), uses, child]), [["a/mod.rs", "a/b.rs"]]);
    }

    #[test]
    fn tests_and_re_exports_are_no_imports() {
        let files = [
            ("lib.rs", "mod a; mod b; pub use b::*;"),
            ("a.rs", "use crate::B; #[cfg(test)] mod tests { use crate::b; }"),
            ("b.rs", "pub struct B; #[cfg(test)] mod tests { use crate::a::f; }"),
        ];
        assert_eq!(cycles_of(&files), [[""; 0]; 0]);
        let mut with_cycle = files;
        with_cycle[2].1 = "pub struct B; fn f() { super::a::g(); }";
        assert_eq!(cycles_of(&with_cycle), [["a.rs", "b.rs"]]);
    }
}
