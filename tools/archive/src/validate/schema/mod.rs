//! The FMI schema files as tables, and the function that checks a document against them.
//!
//! The tables contain the rules of the XSD files of the standards: attributes and their types, child elements, their
//! order and multiplicity. Every content model of the FMI schemas is a sequence of slots; a slot is one element or a
//! choice of elements, repeated within limits.

mod table;
pub(crate) mod types;

use roxmltree::Node;

use self::table::{Content, Element, UNBOUNDED};
pub(crate) use self::table::{FMI2, FMI3, Schema};
use super::finding::{Findings, short};
use super::rules;
use super::xml::Xml;

const INSTANCE_NAMESPACE: &str = "http://www.w3.org/2001/XMLSchema-instance";

/// Checks a whole document whose root must be the element `root`; false when the root is something else.
pub(crate) fn check(xml: &Xml, schema: &Schema, root: &str, out: &mut Findings) -> bool {
    let root = schema.element(root);
    let node = xml.root();
    if node.tag_name().name() != root.name || node.tag_name().namespace().is_some() {
        let space = node
            .tag_name()
            .namespace()
            .map(|n| format!(" in the namespace \"{}\"", short(n)))
            .unwrap_or_default();
        out.add(xml.place(node), rules::xsd_root(short(node.tag_name().name()), space, root.name));
        return false;
    }
    walk(xml, schema, node, root, out);
    true
}

/// No text other than white space between elements.
fn check_text(xml: &Xml, child: Node, element: &Element, out: &mut Findings) {
    let text = child.text().filter(|_| child.is_text()).unwrap_or_default();
    if !text.trim_matches([' ', '\t', '\n', '\r']).is_empty() {
        out.add(xml.place(child), rules::xsd_text(element.name, short(text.trim())));
    }
}

fn walk(xml: &Xml, schema: &Schema, node: Node, element: &Element, out: &mut Findings) {
    check_attributes(xml, node, element, out);
    let slots = match &element.content {
        &Content::Any(most) => {
            let count = node.children().filter(Node::is_element).count();
            if count > most {
                out.add(xml.place(node), rules::xsd_too_many_children(element.name, count, most));
            }
            // A limited number of elements without text in between.
            if most != UNBOUNDED {
                node.children().for_each(|child| check_text(xml, child, element, out));
            }
            return;
        }
        Content::Slots(slots) => slots,
    };
    let mut counts = vec![0_usize; slots.len()];
    let mut cursor = 0;
    for child in node.children() {
        check_text(xml, child, element, out);
        if !child.is_element() {
            continue;
        }
        let name = child.tag_name().name();
        let found = slots.iter().enumerate().find_map(|(i, slot)| {
            let known =
                schema.choices(slot).find(|e| e.name == name && child.tag_name().namespace().is_none());
            known.map(|e| (i, e))
        });
        let Some((index, known)) = found else {
            out.add(xml.place(child), rules::xsd_element_unknown(short(name), element.name));
            continue;
        };
        counts[index] += 1;
        if index < cursor {
            let after: Vec<_> = schema.choices(&slots[cursor]).map(|e| e.name).collect();
            out.add(xml.place(child), rules::xsd_element_order(name, after.join("|"), element.name));
        }
        cursor = cursor.max(index);
        if counts[index] == slots[index].most.saturating_add(1) {
            out.add(xml.place(child), rules::xsd_element_repeated(name, element.name, slots[index].most));
        }
        walk(xml, schema, child, known, out);
    }
    for (slot, count) in slots.iter().zip(&counts) {
        if *count < slot.least {
            let names: Vec<_> = schema.choices(slot).map(|e| format!("<{}>", e.name)).collect();
            out.add(xml.place(node), rules::xsd_element_missing(element.name, names.join(" or ")));
        }
    }
}

fn check_attributes(xml: &Xml, node: Node, element: &Element, out: &mut Findings) {
    let known = || element.attributes.iter();
    for attribute in node.attributes() {
        let name = attribute.name();
        match attribute.namespace() {
            Some(INSTANCE_NAMESPACE) => continue,
            Some(_) if element.any_attribute || matches!(element.content, Content::Any(_)) => continue,
            Some(space) => {
                out.add(
                    xml.place(node),
                    rules::xsd_foreign_attribute(short(name), short(space), element.name),
                );
                continue;
            }
            None => {}
        }
        match known().find(|a| a.name == name) {
            Some(a) if !a.kind.accepts(attribute.value()) => {
                let label = node
                    .attribute("name")
                    .filter(|_| name != "name")
                    .map(|n| format!(" of \"{}\"", short(n)))
                    .unwrap_or_default();
                out.add(
                    xml.place(node),
                    rules::xsd_attribute_value(
                        short(attribute.value()),
                        name,
                        element.name,
                        label,
                        a.kind.describe(),
                    ),
                );
            }
            Some(_) => {}
            // The schema gives no type: no check.
            None if element.any_attribute && matches!(element.content, Content::Any(_)) => {}
            None if element.any_attribute => {
                out.add(xml.place(node), rules::capability_unknown(element.name, short(name)))
            }
            None => out.add(xml.place(node), rules::xsd_attribute_unknown(short(name), element.name)),
        }
    }
    for a in known().filter(|a| a.required && node.attribute(a.name).is_none()) {
        let label = node.attribute("name").map(|n| format!(" \"{}\"", short(n))).unwrap_or_default();
        out.add(xml.place(node), rules::xsd_attribute_missing(element.name, label, a.name));
    }
}
