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
        let message = format!(
            "The root element is <{}>{space} instead of <{}>",
            short(node.tag_name().name()),
            root.name
        );
        out.add(&rules::XSD_ROOT, xml.place(node), message);
        return false;
    }
    walk(xml, schema, node, root, out);
    true
}

/// No text other than white space between elements.
fn check_text(xml: &Xml, child: Node, element: &Element, out: &mut Findings) {
    let text = child.text().filter(|_| child.is_text()).unwrap_or_default();
    if !text.trim_matches([' ', '\t', '\n', '\r']).is_empty() {
        let message = format!(
            "<{}> contains the text \"{}\", but only elements are allowed",
            element.name,
            short(text.trim())
        );
        out.add(&rules::XSD_TEXT, xml.place(child), message);
    }
}

fn walk(xml: &Xml, schema: &Schema, node: Node, element: &Element, out: &mut Findings) {
    check_attributes(xml, node, element, out);
    let slots = match &element.content {
        &Content::Any(most) => {
            let count = node.children().filter(Node::is_element).count();
            if count > most {
                let message =
                    format!("<{}> has {count} child elements, at most {most} is allowed", element.name);
                out.add(&rules::XSD_ELEMENT_REPEATED, xml.place(node), message);
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
            let message = format!("The element <{}> is not allowed in <{}>", short(name), element.name);
            out.add(&rules::XSD_ELEMENT_UNKNOWN, xml.place(child), message);
            continue;
        };
        counts[index] += 1;
        if index < cursor {
            let after: Vec<_> = schema.choices(&slots[cursor]).map(|e| e.name).collect();
            let message =
                format!("The element <{name}> must stand before <{}> in <{}>", after.join("|"), element.name);
            out.add(&rules::XSD_ELEMENT_ORDER, xml.place(child), message);
        }
        cursor = cursor.max(index);
        if counts[index] == slots[index].most.saturating_add(1) {
            let message = format!(
                "The element <{name}> occurs too often in <{}>: at most {} allowed",
                element.name, slots[index].most
            );
            out.add(&rules::XSD_ELEMENT_REPEATED, xml.place(child), message);
        }
        walk(xml, schema, child, known, out);
    }
    for (slot, count) in slots.iter().zip(&counts) {
        if *count < slot.least {
            let names: Vec<_> = schema.choices(slot).map(|e| format!("<{}>", e.name)).collect();
            let message = format!("<{}> must contain {}", element.name, names.join(" or "));
            out.add(&rules::XSD_ELEMENT_MISSING, xml.place(node), message);
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
                let message = format!(
                    "The attribute \"{}\" of the namespace \"{}\" is not allowed in <{}>",
                    short(name),
                    short(space),
                    element.name
                );
                out.add(&rules::XSD_ATTRIBUTE_UNKNOWN, xml.place(node), message);
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
                let message = format!(
                    "The value \"{}\" of the attribute \"{name}\" in <{}>{label} is not {}",
                    short(attribute.value()),
                    element.name,
                    a.kind.describe()
                );
                out.add(&rules::XSD_ATTRIBUTE_VALUE, xml.place(node), message);
            }
            Some(_) => {}
            // The schema gives no type: no check.
            None if element.any_attribute && matches!(element.content, Content::Any(_)) => {}
            None if element.any_attribute => {
                let message = format!(
                    "<{}> has the attribute \"{}\", which is not a capability flag of the standard and has no namespace",
                    element.name,
                    short(name)
                );
                out.add(&rules::CAPABILITY_UNKNOWN, xml.place(node), message);
            }
            None => {
                let message =
                    format!("The attribute \"{}\" is not allowed in <{}>", short(name), element.name);
                out.add(&rules::XSD_ATTRIBUTE_UNKNOWN, xml.place(node), message);
            }
        }
    }
    for a in known().filter(|a| a.required && node.attribute(a.name).is_none()) {
        let label = node.attribute("name").map(|n| format!(" \"{}\"", short(n))).unwrap_or_default();
        let message =
            format!("The element <{}>{label} lacks the required attribute \"{}\"", element.name, a.name);
        out.add(&rules::XSD_ATTRIBUTE_MISSING, xml.place(node), message);
    }
}
