//! `terminalsAndIcons/terminalsAndIcons.xml`: schema, names, and the variables it refers to.

use std::collections::{HashMap, HashSet};

use roxmltree::Node;

use super::finding::{Findings, short};
use super::model::{Model, check_version_of, children, double};
use super::rules;
use super::schema;
use super::xml::Xml;

/// Where the file must be.
pub(crate) const FILE: &str = "terminalsAndIcons/terminalsAndIcons.xml";

/// What a terminal may refer to.
struct Context<'a> {
    /// Causality by name, aliases included.
    variables: HashMap<&'a str, &'a str>,
    entries: &'a HashSet<String>,
}

/// Checks the file against the model description and the entries of the archive.
pub(crate) fn check(bytes: &[u8], model: &Model, entries: &HashSet<String>, out: &mut Findings) {
    let Some(xml) = Xml::parse(FILE, bytes, out) else { return };
    if !schema::check(&xml, &schema::FMI3, "fmiTerminalsAndIcons", out) {
        return;
    }
    check_version_of(model, &xml, out);
    let root = xml.root();
    let mut variables = HashMap::new();
    for v in &model.variables {
        let aliases = v.aliases.iter().filter_map(|a| a.attribute("name"));
        std::iter::once(v.name).chain(aliases).for_each(|name| {
            variables.insert(name, v.causality);
        });
    }
    let context = Context { variables, entries };
    for system in children(root, "GraphicalRepresentation").flat_map(|g| children(g, "CoordinateSystem")) {
        let corner = |name| double(system, name);
        for (low, high) in [("x1", "x2"), ("y1", "y2")] {
            if let (Some(a), Some(b)) = (corner(low), corner(high))
                && a >= b
            {
                out.add(xml.place(system), rules::coordinate_system(low, a, high, b));
            }
        }
    }
    for list in children(root, "Terminals") {
        check_level(&xml, list, &context, out);
    }
}

/// The terminals side by side under one node.
fn check_level(xml: &Xml, parent: Node, context: &Context, out: &mut Findings) {
    let mut names = HashSet::new();
    for terminal in parent.children().filter(|c| c.has_tag_name("Terminal")) {
        let name = terminal.attribute("name").unwrap_or_default();
        if !names.insert(name) {
            out.add(xml.place(terminal), rules::terminal_repeated(short(name)));
        }
        check_terminal(xml, terminal, name, context, out);
        check_level(xml, terminal, context, out);
    }
}

fn check_terminal(xml: &Xml, terminal: Node, name: &str, context: &Context, out: &mut Findings) {
    let rule = terminal.attribute("matchingRule").unwrap_or_default();
    let predefined = ["plug", "bus", "sequence"].contains(&rule);
    if terminal.attribute("matchingRule").is_some() && !predefined && !rule.contains('.') {
        out.add(xml.place(terminal), rules::matching_rule(short(rule), short(name)));
    }
    let mut members = HashSet::new();
    let mut flows = 0;
    let streams = terminal.children().any(|c| c.has_tag_name("TerminalStreamMemberVariable"));
    for member in terminal.children().filter(|c| c.has_tag_name("TerminalMemberVariable")) {
        let kind = member.attribute("variableKind").unwrap_or_default();
        let is_flow = ["inflow", "outflow"].contains(&kind);
        flows += usize::from(is_flow);
        check_variable(xml, member, "variableName", name, is_flow || kind == "signal", context, out);
        match member.attribute("memberName") {
            None if rule == "plug" || rule == "bus" => {
                out.add(xml.place(member), rules::member_name_missing(short(name), rule))
            }
            Some(m) if !members.insert(m) => {
                out.add(xml.place(member), rules::member_name_repeated(short(m), short(name)))
            }
            _ => {}
        }
    }
    if streams && flows > 1 {
        out.add(xml.place(terminal), rules::stream_flow(short(name), flows));
    }
    for stream in terminal.children().filter(|c| c.has_tag_name("TerminalStreamMemberVariable")) {
        for attribute in ["inStreamVariableName", "outStreamVariableName"] {
            check_variable(xml, stream, attribute, name, true, context, out);
        }
    }
    for graphic in terminal.children().filter(|c| c.has_tag_name("TerminalGraphicalRepresentation")) {
        check_icon(xml, graphic, name, context, out);
    }
}

fn check_variable(
    xml: &Xml,
    node: Node,
    attribute: &str,
    terminal: &str,
    restricted: bool,
    context: &Context,
    out: &mut Findings,
) {
    let Some(name) = node.attribute(attribute) else { return };
    match context.variables.get(name) {
        None => out.add(xml.place(node), rules::terminal_variable(short(terminal), short(name))),
        Some(causality)
            if restricted && ["local", "independent", "structuralParameter"].contains(causality) =>
        {
            out.add(xml.place(node), rules::terminal_causality(short(terminal), causality, short(name)));
        }
        Some(_) => {}
    }
}

fn check_icon(xml: &Xml, graphic: Node, terminal: &str, context: &Context, out: &mut Findings) {
    let Some(base) = graphic.attribute("iconBaseName") else { return };
    // An absolute URI is somebody else's file; its existence is not ours to check.
    if base.contains("://") {
        return;
    }
    let file = format!("terminalsAndIcons/{}.png", base.trim_start_matches("./"));
    if base.split('/').any(|part| part == "..") || !context.entries.contains(&file) {
        out.add(xml.place(graphic), rules::icon_missing(short(base), short(terminal), short(&file)));
    }
}
