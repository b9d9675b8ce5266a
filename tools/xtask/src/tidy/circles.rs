//! No file of a crate needs itself through others: whoever reads one file needs no second one that needs the first.
//!
//! A file needs another one where a path in its code leads there (`crate::`, `super::`). A path to a re-export leads to what
//! is re-exported. A module may use its own children, which belong to it, while they may use its types; so that way down
//! does not count, and neither does code for tests.

use crate::{Outcome, files, workspace::Workspace};
use proc_macro2::{Ident, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;
use syn::UseTree;

/// Crates that are not checked yet, and why.
const LATER: &[(&str, &str)] = &[("calibrate", "its search is replaced as a whole")];
/// Folders with our crates.
const FOLDERS: [&str; 2] = ["fmu-src", "tools"];

/// Fails with every circle.
pub fn check(workspace: &Workspace) -> Outcome {
    let mut found = Vec::new();
    for package in workspace.packages.iter().filter(|p| LATER.iter().all(|(name, _)| *name != p.name)) {
        let sources = FOLDERS.iter().map(|f| workspace.root.join(f).join(&package.name).join("src"));
        for folder in sources.filter(|f| f.is_dir()) {
            let files = read(&folder)?;
            found.extend(circles(&files)?.into_iter().map(|circle| format!("{}: {circle}", package.name)));
        }
    }
    if found.is_empty() { Ok(()) } else { Err(format!("import circles: {}", found.join("; "))) }
}

/// Names of a module and those above it, from the crate's root; the root has none.
type Module = Vec<String>;

/// All modules below a folder, with their text.
fn read(folder: &Path) -> Outcome<BTreeMap<Module, String>> {
    let module = |file: &Path| {
        let path = file.strip_prefix(folder).unwrap_or(file).with_extension("");
        let mut module: Module = path.iter().map(|name| name.to_string_lossy().into_owned()).collect();
        module.pop_if(|last| ["lib", "main", "mod"].contains(&last.as_str()));
        module
    };
    files::rust(folder)?.iter().map(|file| Ok((module(file), files::read(file)?))).collect()
}

/// A path in the code, from the crate's root.
struct Reference {
    path: Module,
    /// The name under which a `pub use` hands it on.
    exported_as: Option<String>,
}

/// The circles among the modules of a crate, each as `a -> b -> a`.
fn circles(files: &BTreeMap<Module, String>) -> Outcome<Vec<String>> {
    let known: BTreeSet<&Module> = files.keys().collect();
    let references = files.iter().map(|(module, text)| Ok((module, references(module, text, &known)?)));
    let references: BTreeMap<&Module, Vec<Reference>> = references.collect::<Outcome<_>>()?;
    let mut needs: BTreeMap<&Module, BTreeSet<&Module>> = BTreeMap::new();
    for (module, list) in &references {
        for reference in list {
            let Some(target) = target(&reference.path, &references, 0) else { continue };
            if !target.starts_with(module) {
                needs.entry(module).or_default().insert(target);
            }
        }
    }
    let mut found = Vec::new();
    let mut done: BTreeSet<&Module> = BTreeSet::new();
    for module in needs.keys() {
        if done.contains(module) {
            continue;
        }
        if let Some(circle) = shortest_circle(module, &needs) {
            done.extend(&circle);
            let names: Vec<String> = circle.iter().map(|m| name(m)).collect();
            found.push(format!("{} -> {}", names.join(" -> "), names[0]));
        }
    }
    Ok(found)
}

fn name(module: &Module) -> String {
    if module.is_empty() { "crate".into() } else { module.join("::") }
}

/// The shortest way from a module back to itself.
fn shortest_circle<'a>(
    start: &'a Module,
    needs: &BTreeMap<&'a Module, BTreeSet<&'a Module>>,
) -> Option<Vec<&'a Module>> {
    let (mut open, mut seen) = (VecDeque::from([vec![start]]), BTreeSet::new());
    while let Some(way) = open.pop_front() {
        for next in needs.get(way[way.len() - 1]).into_iter().flatten() {
            if *next == start {
                return Some(way);
            }
            if seen.insert(*next) {
                open.push_back([&way[..], &[*next]].concat());
            }
        }
    }
    None
}

/// The module that a path leads to, through re-exports.
fn target<'a>(
    path: &[String],
    all: &BTreeMap<&'a Module, Vec<Reference>>,
    depth: usize,
) -> Option<&'a Module> {
    let module = |length: usize| all.get_key_value(&path[..length].to_vec());
    let length = (0..=path.len()).rev().find(|length| module(*length).is_some())?;
    let (found, references) = module(length)?;
    if let (Some(item), true) = (path.get(length), depth < 8) {
        let exported = references.iter().find(|r| r.exported_as.as_ref() == Some(item));
        if let Some(exported) = exported {
            let whole: Module = exported.path.iter().chain(&path[length + 1..]).cloned().collect();
            return target(&whole, all, depth + 1);
        }
    }
    Some(found)
}

/// All paths of a file that lead into its own crate, but for those of tests.
fn references(module: &Module, text: &str, known: &BTreeSet<&Module>) -> Outcome<Vec<Reference>> {
    let wrong = |e| format!("the code of {} cannot be read: {e}", name(module));
    let mut reader = Reader { module, known, inline: Vec::new(), found: Vec::new() };
    reader.walk(text.parse().map_err(wrong)?);
    Ok(reader.found)
}

struct Reader<'a> {
    module: &'a Module,
    known: &'a BTreeSet<&'a Module>,
    /// Modules of the file itself that are open.
    inline: Vec<String>,
    found: Vec<Reference>,
}

impl Reader<'_> {
    /// Adds the paths of a code and of all macros and brackets in it.
    fn walk(&mut self, code: TokenStream) {
        let trees: Vec<TokenTree> = code.into_iter().collect();
        let is = |at: usize, text: &str| match trees.get(at) {
            Some(TokenTree::Ident(word)) => word == text,
            Some(TokenTree::Punct(mark)) => text.starts_with(mark.as_char()),
            _ => false,
        };
        let is_colons = |at: usize| is(at, ":") && is(at + 1, ":");
        let mut at = 0;
        while let Some(tree) = trees.get(at) {
            let is_behind = |text: &str, by: usize| at >= by && is(at - by, text);
            match tree {
                TokenTree::Group(group) if is_behind("#", 1) => {
                    let attribute = group.stream().to_string().replace(' ', "");
                    let is_end = |t: &TokenTree| t.to_string() == ";" || is_braces(t);
                    if attribute.starts_with("cfg(") && attribute.contains("test") {
                        at += trees[at..].iter().position(is_end).unwrap_or_default();
                    }
                }
                TokenTree::Group(group) => {
                    let is_module = is_braces(tree) && is_behind("mod", 2);
                    self.inline.extend(is_module.then(|| trees[at - 1].to_string()));
                    self.walk(group.stream());
                    self.inline.truncate(self.inline.len() - usize::from(is_module));
                }
                TokenTree::Ident(word) if word == "use" => {
                    let length = (at..trees.len()).take_while(|i| !is(*i, ";")).count();
                    let code = trees[at + 1..at + length].iter().cloned().collect();
                    if let Ok(tree) = syn::parse2::<UseTree>(code) {
                        let is_public = is_behind("pub", 1)
                            || is_behind("pub", 2) && matches!(trees[at - 1], TokenTree::Group(_));
                        self.tree(&tree, &[], is_public);
                        at += length;
                    }
                }
                // A method, the rest of a path, and `$crate::` in a macro, which another crate may expand.
                TokenTree::Ident(_) if is_behind(".", 1) || is_behind("$", 1) => {}
                TokenTree::Ident(_) if at >= 2 && is_colons(at - 2) => {}
                TokenTree::Ident(word) if is_colons(at + 1) => {
                    let mut path = vec![word.to_string()];
                    while let (true, Some(TokenTree::Ident(next))) = (is_colons(at + 1), trees.get(at + 3)) {
                        path.push(next.to_string());
                        at += 3;
                    }
                    self.add(&path, None);
                }
                _ => {}
            }
            at += 1;
        }
    }

    /// Adds what a `use` names.
    fn tree(&mut self, tree: &UseTree, before: &[String], is_public: bool) {
        // `use a::{self}` names `a`.
        let with = |name: &Ident| match before {
            [_, ..] if name == "self" => before.to_vec(),
            _ => [before, &[name.to_string()]].concat(),
        };
        match tree {
            UseTree::Path(path) => self.tree(&path.tree, &with(&path.ident), is_public),
            UseTree::Group(group) => group.items.iter().for_each(|t| self.tree(t, before, is_public)),
            UseTree::Glob(_) => self.add(before, None),
            UseTree::Rename(as_other) => {
                self.add(&with(&as_other.ident), is_public.then(|| as_other.rename.to_string()));
            }
            UseTree::Name(name) => {
                let path = with(&name.ident);
                self.add(&path, path.last().filter(|_| is_public).cloned());
            }
        }
    }

    /// Adds a path as it stands in the code, if it leads into the crate.
    fn add(&mut self, path: &[String], exported_as: Option<String>) {
        let (mut base, mut rest) = ([&self.module[..], &self.inline].concat(), path);
        while let [first, others @ ..] = rest {
            match first.as_str() {
                "crate" => base.clear(),
                "super" => drop(base.pop()),
                "self" => {}
                _ => break,
            }
            rest = others;
        }
        let whole = [&base[..], rest].concat();
        let is_child = || self.inline.is_empty() && self.known.contains(&whole[..base.len() + 1].to_vec());
        if rest.len() == path.len() && !is_child() {
            return;
        }
        // What stays within the modules of the file itself leads to the file.
        let is_own = !self.inline.is_empty() && whole.starts_with(self.module);
        self.found.push(Reference { path: if is_own { self.module.clone() } else { whole }, exported_as });
    }
}

/// Whether a tree of tokens stands in braces.
fn is_braces(tree: &TokenTree) -> bool {
    matches!(tree, TokenTree::Group(group) if group.delimiter() == proc_macro2::Delimiter::Brace)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let module = |path: &str| path.split("::").filter(|s| !s.is_empty()).map(String::from).collect();
        circles(&files.iter().map(|(path, text)| (module(path), (*text).to_owned())).collect()).unwrap()
    }

    #[test]
    fn a_circle_is_found_and_shown() {
        let files = [
            ("", "mod a; mod b; mod c;"),
            ("a", "use crate::b::{X, y::Z as W}; fn f() {}"),
            ("b", "pub struct X; fn f() { super::c::g() }"),
            ("c", "use std::fmt; use super::a as other; pub fn g() {}"),
        ];
        assert_eq!(found(&files), ["a -> b -> c -> a"]);
    }

    #[test]
    fn a_type_of_the_parent_is_an_edge_and_a_re_export_leads_on() {
        let parent = "mod child; mod leaf; pub use leaf::Leaf; pub(crate) struct P;";
        let inner = |text| {
            found(&[("", "mod p;"), ("p", parent), ("p::child", text), ("p::leaf", "pub struct Leaf;")])
        };
        assert!(inner("use super::P;").is_empty(), "the parent only declares the child");
        assert!(inner("use super::Leaf;").is_empty());
        let back = |child| {
            let leaf = "use super::child::X; pub struct Leaf;";
            found(&[("", "mod p;"), ("p", parent), ("p::child", child), ("p::leaf", leaf)])
        };
        assert_eq!(back("use super::Leaf; pub struct X;"), ["p::child -> p::leaf -> p::child"]);
        assert!(back("use super::P; pub struct X;").is_empty());
    }

    #[test]
    fn tests_comments_texts_and_lifetimes_do_not_count() {
        let a = r##"
            // use crate::b::X;
            /* crate::b */
            const T: &str = "crate::b::X"; const R: &str = r#"use crate::b::X;"#; const C: char = '"';
            fn f<'a>(x: &'a str) -> char { '\'' }
            #[cfg(test)]
            mod tests { use super::*; use crate::b::X; }
            #[cfg(all(test, unix))]
            use crate::b::X;
            mod inline { use super::g; }
        "##;
        assert!(found(&[("", "mod a; mod b;"), ("a", a), ("b", "use crate::a::f;")]).is_empty());
        assert_eq!(found(&[("", ""), ("a", "crate::b::f()"), ("b", "use crate::a::f;")]).len(), 1);
    }

    #[test]
    fn every_exception_is_a_crate_of_ours() {
        let workspace = Workspace::find().unwrap();
        for (name, reason) in LATER {
            assert!(workspace.packages.iter().any(|p| p.name == *name) && !reason.is_empty(), "{name}");
        }
    }
}
