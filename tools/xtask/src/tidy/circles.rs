//! No file of a crate needs itself through others: whoever reads one file needs no second one that needs the first.
//!
//! A file needs another one where a path in its code leads there (`crate::`, `super::`). A path to a re-export leads to what
//! is re-exported. A module may use its own children, which belong to it, while they may use its types; so that way down
//! does not count, and neither does code for tests.

use crate::{Outcome, workspace::Workspace};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;

/// Crates that are not checked yet, and why.
const LATER: &[(&str, &str)] = &[
    ("physics", "its models and effects get a new structure, in which these circles end"),
    ("calibrate", "its search is replaced as a whole"),
];
/// Folders with our crates.
const FOLDERS: [&str; 2] = ["fmu-src", "tools"];

/// Fails with every circle.
pub fn check(workspace: &Workspace) -> Outcome {
    let mut found = Vec::new();
    for package in workspace.packages.iter().filter(|p| LATER.iter().all(|(name, _)| *name != p.name)) {
        let sources = FOLDERS.iter().map(|f| workspace.root.join(f).join(&package.name).join("src"));
        for folder in sources.filter(|f| f.is_dir()) {
            let files = read(&folder, &[])?;
            found.extend(circles(&files).into_iter().map(|circle| format!("{}: {circle}", package.name)));
        }
    }
    if found.is_empty() { Ok(()) } else { Err(format!("import circles: {}", found.join("; "))) }
}

/// Names of a module and those above it, from the crate's root; the root has none.
type Module = Vec<String>;

/// All modules below a folder, with their text.
fn read(folder: &Path, above: &[String]) -> Outcome<BTreeMap<Module, String>> {
    let wrong = |e: std::io::Error| format!("{} cannot be read: {e}", folder.display());
    let mut files = BTreeMap::new();
    for path in folder.read_dir().map_err(wrong)?.flatten().map(|e| e.path()) {
        let Some(stem) = path.file_stem().and_then(|s| s.to_str()).map(String::from) else { continue };
        let mut module = above.to_vec();
        if path.is_dir() {
            module.push(stem);
            files.extend(read(&path, &module)?);
        } else if path.extension().is_some_and(|e| e == "rs") {
            if !["lib", "main", "mod"].contains(&stem.as_str()) {
                module.push(stem);
            }
            files.insert(module, std::fs::read_to_string(&path).map_err(wrong)?);
        }
    }
    Ok(files)
}

/// A path in the code, from the crate's root.
struct Reference {
    path: Module,
    /// The name under which a `pub use` hands it on.
    exported_as: Option<String>,
}

/// The circles among the modules of a crate, each as `a -> b -> a`.
fn circles(files: &BTreeMap<Module, String>) -> Vec<String> {
    let known: BTreeSet<&Module> = files.keys().collect();
    let references: BTreeMap<&Module, Vec<Reference>> =
        files.iter().map(|(module, text)| (module, references(module, text, &known))).collect();
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
    found
}

fn name(module: &Module) -> String {
    if module.is_empty() { "crate".into() } else { module.join("::") }
}

/// The shortest way from a module back to itself.
fn shortest_circle<'a>(
    start: &'a Module,
    needs: &BTreeMap<&'a Module, BTreeSet<&'a Module>>,
) -> Option<Vec<&'a Module>> {
    let mut from: BTreeMap<&Module, &'a Module> = BTreeMap::new();
    let mut open = VecDeque::from([start]);
    while let Some(at) = open.pop_front() {
        for next in needs.get(at).into_iter().flatten() {
            if *next == start {
                let mut circle = vec![at];
                while let Some(before) = from.get(circle[0]).filter(|_| circle[0] != start) {
                    circle.insert(0, before);
                }
                return Some(circle);
            }
            if !from.contains_key(*next) {
                from.insert(next, at);
                open.push_back(next);
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
fn references(module: &Module, text: &str, known: &BTreeSet<&Module>) -> Vec<Reference> {
    let tokens = tokens(text);
    let mut reader = Reader { module, known, inline: Vec::new(), found: Vec::new() };
    let (mut at, mut depth, mut is_public) = (0, 0_usize, false);
    let mut ends: Vec<usize> = Vec::new();
    while at < tokens.len() {
        let token = tokens[at].as_str();
        match token {
            "#" => {
                let end = closing(&tokens, at + 1);
                let attribute = tokens[at..end].concat();
                at = end;
                if attribute.starts_with("#[cfg(") && attribute.contains("test") {
                    at = item_end(&tokens, at);
                }
                continue;
            }
            "{" => depth += 1,
            "}" => {
                depth = depth.saturating_sub(1);
                if ends.last() == Some(&depth) {
                    ends.pop();
                    reader.inline.pop();
                }
            }
            "mod" if tokens.get(at + 2).is_some_and(|t| t == "{") => {
                reader.inline.push(tokens[at + 1].clone());
                ends.push(depth);
                depth += 1;
                at += 3;
                continue;
            }
            "use" => {
                let end = (at..tokens.len()).find(|i| tokens[*i] == ";").unwrap_or(tokens.len());
                reader.tree(&tokens[at + 1..end], &[], is_public);
                (at, is_public) = (end, false);
                continue;
            }
            // A method, the rest of a path, and `$crate::` in a macro, which another crate may expand.
            _ if at > 0 && [".", "::", "$"].contains(&tokens[at - 1].as_str()) => {}
            _ if tokens.get(at + 1).is_some_and(|t| t == "::") => {
                let mut path = vec![tokens[at].clone()];
                while tokens.get(at + 1).is_some_and(|t| t == "::") && tokens.get(at + 2).is_some_and(is_word)
                {
                    path.push(tokens[at + 2].clone());
                    at += 2;
                }
                reader.add(&path, None);
            }
            _ => {}
        }
        // `pub`, or the end of `pub(crate)`.
        is_public = token == "pub" || is_public && ["(", ")", "crate", "super", "in", "::"].contains(&token);
        at += 1;
    }
    reader.found
}

struct Reader<'a> {
    module: &'a Module,
    known: &'a BTreeSet<&'a Module>,
    /// Modules of the file itself that are open.
    inline: Vec<String>,
    found: Vec<Reference>,
}

impl Reader<'_> {
    /// Adds a path as it stands in the code, if it leads into the crate.
    fn add(&mut self, path: &[String], exported_as: Option<String>) {
        let mut base: Module = self.module.iter().chain(&self.inline).cloned().collect();
        let mut rest = path;
        match path[0].as_str() {
            "crate" => {
                base.clear();
                rest = &path[1..];
            }
            "self" => rest = &path[1..],
            "super" => {
                while rest.first().is_some_and(|s| s == "super") {
                    base.pop();
                    rest = &rest[1..];
                }
            }
            child => {
                base.push(child.into());
                if !self.inline.is_empty() || !self.known.contains(&base) {
                    return;
                }
                rest = &path[1..];
            }
        }
        base.extend(rest.iter().cloned());
        // What stays within the modules of the file itself leads to the file.
        if !self.inline.is_empty() && base.starts_with(self.module) {
            base.clone_from(self.module);
        }
        self.found.push(Reference { path: base, exported_as });
    }

    /// Adds what a `use` names: `a::{b, c::d as e, *}`.
    fn tree(&mut self, tokens: &[String], before: &[String], is_public: bool) {
        let mut path = before.to_vec();
        let mut at = 0;
        while at < tokens.len() {
            match tokens[at].as_str() {
                "::" => {}
                "{" => {
                    let inner = &tokens[at + 1..closing(tokens, at) - 1];
                    let (mut start, mut depth) = (0, 0);
                    for (i, token) in inner.iter().map(String::as_str).chain([","]).enumerate() {
                        match token {
                            "{" => depth += 1,
                            "}" => depth -= 1,
                            "," if depth == 0 => {
                                if start < i {
                                    self.tree(&inner[start..i], &path, is_public);
                                }
                                start = i + 1;
                            }
                            _ => {}
                        }
                    }
                    return;
                }
                "as" | "*" => break,
                // `use a::{self}` names `a`.
                "self" if !path.is_empty() => {}
                word => path.push(word.into()),
            }
            at += 1;
        }
        let alias = tokens.iter().position(|t| t == "as").and_then(|i| tokens.get(i + 1));
        let name = alias.or(path.last()).filter(|_| is_public && tokens.last().is_some_and(|t| t != "*"));
        let name = name.cloned();
        if !path.is_empty() {
            self.add(&path, name);
        }
    }
}

/// The token after the bracket that closes the one at `open` (or the first one behind it).
fn closing(tokens: &[String], open: usize) -> usize {
    let mut depth = 0;
    for (i, token) in tokens.iter().enumerate().skip(open) {
        match token.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => {
                depth -= 1;
                if depth == 0 {
                    return i + 1;
                }
            }
            _ => {}
        }
    }
    tokens.len()
}

/// The token behind the item that begins at `at`: after its `;` or its braces.
fn item_end(tokens: &[String], mut at: usize) -> usize {
    while let Some(token) = tokens.get(at) {
        match token.as_str() {
            ";" => return at + 1,
            "{" => return closing(tokens, at),
            "(" | "[" => at = closing(tokens, at),
            _ => at += 1,
        }
    }
    at
}

fn is_word(token: &String) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Words, `::`, and single characters; without comments, texts and lifetimes.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |i| i + 2)
        } else if let Some(length) = literal(rest) {
            length
        } else if c.is_alphanumeric() || c == '_' {
            let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            tokens.push(rest[..length].into());
            length
        } else if rest.starts_with("::") {
            tokens.push("::".into());
            2
        } else {
            if !c.is_whitespace() {
                tokens.push(c.into());
            }
            c.len_utf8()
        };
        rest = &rest[length..];
    }
    tokens
}

/// The length of the text, character or lifetime that begins here.
fn literal(rest: &str) -> Option<usize> {
    let prefix = ["br", "cr", "b", "c", "r"].into_iter().find(|p| {
        rest.strip_prefix(p).is_some_and(|r| {
            r.trim_start_matches('#').starts_with('"') && (!r.starts_with('#') || p.ends_with('r'))
        })
    });
    let start = prefix.map_or(0, str::len);
    let body = &rest[start..];
    let hashes = body.len() - body.trim_start_matches('#').len();
    if prefix.is_some_and(|p| p.ends_with('r')) {
        let end = format!("\"{}", "#".repeat(hashes));
        return Some(start + hashes + 1 + body[hashes + 1..].find(&end).map_or(0, |i| i + end.len()));
    }
    let quoted = |quote: char| {
        let mut escaped = false;
        let end = body.char_indices().skip(1).find(|(_, c)| {
            let is_end = *c == quote && !escaped;
            escaped = *c == '\\' && !escaped;
            is_end
        });
        start + end.map_or(body.len(), |(i, _)| i + 1)
    };
    if body.starts_with('"') {
        return Some(quoted('"'));
    }
    let second = body.strip_prefix('\'')?.chars().next()?;
    let is_character = second == '\\' || body[1 + second.len_utf8()..].starts_with('\'');
    if is_character {
        return Some(quoted('\''));
    }
    Some(1 + body[1..].find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(body.len() - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let module = |path: &str| path.split("::").filter(|s| !s.is_empty()).map(String::from).collect();
        circles(&files.iter().map(|(path, text)| (module(path), (*text).to_owned())).collect())
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
