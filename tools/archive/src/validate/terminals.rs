//! `terminalsAndIcons/terminalsAndIcons.xml`: schema, names, and the variables it refers to.

use std::collections::{HashMap, HashSet};

use roxmltree::Node;

use super::finding::{Findings, short};
use super::model::{Model, check_version_of, children, double};
use super::rules::{self, Breach};
use super::schema;
use super::xml::{Xml, decode};

/// Where the file must be.
pub(crate) const FILE: &str = "terminalsAndIcons/terminalsAndIcons.xml";

/// The file, what a terminal may refer to, and the findings.
struct Check<'a> {
    xml: &'a Xml<'a>,
    /// Causality by name, aliases included.
    variables: HashMap<&'a str, &'a str>,
    entries: &'a HashSet<String>,
    out: &'a mut Findings,
}

/// Checks the file against the model description and the entries of the archive.
pub(crate) fn check(bytes: &[u8], model: &Model, entries: &HashSet<String>, out: &mut Findings) {
    let Some(text) = decode(FILE, bytes, out) else { return };
    let Some(xml) = Xml::parse(FILE, &text, out) else { return };
    if !schema::check(&xml, &schema::FMI3, "fmiTerminalsAndIcons", out) {
        return;
    }
    check_version_of(model, &xml, out);
    let root = xml.root();
    let mut variables = HashMap::new();
    for v in &model.variables {
        let aliases = v.aliases.iter().filter_map(|a| a.attribute("name"));
        variables.extend(std::iter::once(v.name).chain(aliases).map(|name| (name, v.causality)));
    }
    for system in children(root, "GraphicalRepresentation").flat_map(|g| children(g, "CoordinateSystem")) {
        for (low, high) in [("x1", "x2"), ("y1", "y2")] {
            if let (Some(a), Some(b)) = (double(system, low), double(system, high))
                && a >= b
            {
                out.add(xml.place(system), rules::coordinate_system(low, a, high, b));
            }
        }
    }
    let mut check = Check { xml: &xml, variables, entries, out };
    children(root, "Terminals").for_each(|list| check.level(list));
}

impl Check<'_> {
    fn add(&mut self, node: Node, breach: Breach) {
        self.out.add(self.xml.place(node), breach);
    }

    /// The terminals side by side under one node.
    fn level(&mut self, parent: Node) {
        let mut names = HashSet::new();
        for terminal in children(parent, "Terminal") {
            let name = terminal.attribute("name").unwrap_or_default();
            if !names.insert(name) {
                self.add(terminal, rules::terminal_repeated(short(name)));
            }
            self.terminal(terminal, &short(name));
            self.level(terminal);
        }
    }

    fn terminal(&mut self, terminal: Node, name: &str) {
        let rule = terminal.attribute("matchingRule").unwrap_or_default();
        let predefined = ["plug", "bus", "sequence"].contains(&rule);
        if terminal.attribute("matchingRule").is_some() && !predefined && !rule.contains('.') {
            self.add(terminal, rules::matching_rule(short(rule), name));
        }
        let mut members = HashSet::new();
        let mut flows = 0;
        for member in children(terminal, "TerminalMemberVariable") {
            let kind = member.attribute("variableKind").unwrap_or_default();
            let is_flow = ["inflow", "outflow"].contains(&kind);
            flows += usize::from(is_flow);
            self.variable(member, "variableName", name, is_flow || kind == "signal");
            match member.attribute("memberName") {
                None if rule == "plug" || rule == "bus" => {
                    self.add(member, rules::member_name_missing(name, rule));
                }
                Some(m) if !members.insert(m) => {
                    self.add(member, rules::member_name_repeated(short(m), name))
                }
                _ => {}
            }
        }
        let streams = || children(terminal, "TerminalStreamMemberVariable");
        if streams().next().is_some() && flows > 1 {
            self.add(terminal, rules::stream_flow(name, flows));
        }
        for stream in streams() {
            self.variable(stream, "inStreamVariableName", name, true);
            self.variable(stream, "outStreamVariableName", name, true);
        }
        for graphic in children(terminal, "TerminalGraphicalRepresentation") {
            self.icon(graphic, name);
        }
    }

    fn variable(&mut self, node: Node, attribute: &str, terminal: &str, restricted: bool) {
        let Some(name) = node.attribute(attribute) else { return };
        match self.variables.get(name).copied() {
            None => self.add(node, rules::terminal_variable(terminal, short(name))),
            Some(causality @ ("local" | "independent" | "structuralParameter")) if restricted => {
                self.add(node, rules::terminal_causality(terminal, causality, short(name)));
            }
            Some(_) => {}
        }
    }

    fn icon(&mut self, graphic: Node, terminal: &str) {
        let Some(base) = graphic.attribute("iconBaseName") else { return };
        // An absolute URI is somebody else's file; its existence is not ours to check.
        if base.contains("://") {
            return;
        }
        let file = format!("terminalsAndIcons/{}.png", base.trim_start_matches("./"));
        if base.split('/').any(|part| part == "..") || !self.entries.contains(&file) {
            self.add(graphic, rules::icon_missing(short(base), terminal, short(&file)));
        }
    }
}
