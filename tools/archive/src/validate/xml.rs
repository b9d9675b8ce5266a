//! An XML file of the archive with its name; errors of encoding and form are findings.

use cosim::xml::{decode as decoded, encoding_label};
use roxmltree::Node;
use std::borrow::Cow;

use super::finding::Findings;
use super::rules;

/// Deeper than any FMI file is; the walkers recurse, so a hostile depth must end before them.
const DEEPEST: usize = 256;

pub(crate) struct Xml<'a> {
    file: &'a str,
    xml: cosim::xml::Xml<'a>,
}

impl<'a> Xml<'a> {
    /// Parses `text`; what is wrong with the form goes to `out`, `None` ends the checks of the file.
    pub(crate) fn parse(file: &'a str, text: &'a str, out: &mut Findings) -> Option<Xml<'a>> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        check_declaration(file, text, out);
        let xml = match cosim::xml::Xml::parse(text) {
            Ok(xml) => xml,
            Err(roxmltree::Error::DtdDetected) => {
                let line = 1 + text[..text.find("<!DOCTYPE").unwrap_or(0)].matches('\n').count();
                out.add(format!("{file}:{line}"), rules::xml_doctype());
                return None;
            }
            Err(e) => {
                out.add(format!("{file}:{}", e.pos().row), rules::xml_malformed(e));
                return None;
            }
        };
        if is_too_deep(xml.document()) {
            out.add(file, rules::xml_depth(DEEPEST));
            return None;
        }
        check_lengths(file, &xml, out);
        Some(Xml { file, xml })
    }

    pub(crate) fn root(&self) -> Node<'_, 'a> {
        self.xml.root()
    }

    /// The file without its name.
    pub(crate) fn file(&self) -> &cosim::xml::Xml<'a> {
        &self.xml
    }

    /// `file:line` of a node.
    pub(crate) fn place(&self, node: Node) -> String {
        format!("{}:{}", self.file, self.xml.line(node))
    }
}

/// No text of one attribute is longer ...
const LONGEST: usize = 1 << 16;
/// ... but those that list something.
const LISTS: [&str; 5] = ["start", "dependencies", "dependenciesKind", "clocks", "value"];

fn check_lengths(file: &str, xml: &cosim::xml::Xml, out: &mut Findings) {
    for node in xml.document().descendants() {
        let long = node.attributes().filter(|a| a.value().len() > LONGEST && !LISTS.contains(&a.name()));
        for attribute in long {
            let (name, length) = (attribute.name(), attribute.value().chars().count());
            let breach = rules::attribute_huge(name, node.tag_name().name(), length, LONGEST);
            out.add(format!("{file}:{}", xml.line(node)), breach);
        }
    }
}

/// The text of `bytes` in the encoding that the file declares; one that is not UTF-8 goes to `out`.
pub(crate) fn decode<'a>(file: &str, bytes: &'a [u8], out: &mut Findings) -> Option<Cow<'a, str>> {
    match decoded(bytes) {
        Ok((text, _)) => Some(text),
        Err(line) => {
            out.add(format!("{file}:{line}"), rules::xml_not_utf8());
            None
        }
    }
}

fn check_declaration(file: &str, text: &str, out: &mut Findings) {
    let declaration = text.strip_prefix("<?xml").and_then(|t| t.split_once("?>")).map_or("", |(d, _)| d);
    match encoding_label(declaration) {
        Some(e) if e.eq_ignore_ascii_case("utf-8") => {}
        Some(e) => out.add(format!("{file}:1"), rules::xml_encoding(super::finding::short(e))),
        None => out.add(format!("{file}:1"), rules::xml_encoding_missing()),
    }
}

fn is_too_deep(root: Node) -> bool {
    let mut depth = 0_usize;
    let mut node = root;
    loop {
        if let Some(child) = node.first_child() {
            depth += 1;
            if depth > DEEPEST {
                return true;
            }
            node = child;
            continue;
        }
        loop {
            if let Some(next) = node.next_sibling() {
                node = next;
                break;
            }
            match node.parent() {
                Some(parent) => node = parent,
                None => return false,
            }
            depth = depth.saturating_sub(1);
        }
    }
}
