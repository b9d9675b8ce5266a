//! XML elements of SSP 1.0 to be written.
use super::structure::End;
use crate::{BaseUnit, Kind};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};
use std::io;

/// Names of the XML prefixes.
pub(super) const NAMESPACES: [(&str, &str); 3] = [
    ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
    ("xmlns:ssd", "http://ssp-standard.org/SSP1/SystemStructureDescription"),
    ("xmlns:ssv", "http://ssp-standard.org/SSP1/SystemStructureParameterValues"),
];

/// An XML element to be written; without a list of children it is empty.
pub(super) struct Tag {
    pub(super) name: &'static str,
    pub(super) attributes: Vec<(&'static str, String)>,
    pub(super) children: Option<Vec<Tag>>,
}

pub(super) fn leaf(name: &'static str, attributes: &[(&'static str, &str)]) -> Tag {
    let attributes = attributes.iter().map(|(name, value)| (*name, (*value).to_owned())).collect();
    Tag { name, attributes, children: None }
}

pub(super) fn node(name: &'static str, attributes: &[(&'static str, &str)], children: Vec<Tag>) -> Tag {
    Tag { children: Some(children), ..leaf(name, attributes) }
}

/// An element in others without attributes, the outermost of them first.
pub(super) fn within(names: &[&'static str], inner: Tag) -> Tag {
    names.iter().rev().fold(inner, |inner, name| node(name, &[], vec![inner]))
}

/// An element around a list, if there is anything in it.
pub(super) fn list(name: &'static str, children: Vec<Tag>) -> Option<Tag> {
    (!children.is_empty()).then(|| node(name, &[], children))
}

impl Tag {
    fn write(&self, xml: &mut Writer<Vec<u8>>) -> io::Result<()> {
        let attributes = self.attributes.iter().map(|(name, value)| (*name, value.as_str()));
        let start = BytesStart::new(self.name).with_attributes(attributes);
        let Some(children) = &self.children else { return xml.write_event(Event::Empty(start)) };
        xml.write_event(Event::Start(start))?;
        children.iter().try_for_each(|child| child.write(xml))?;
        xml.write_event(Event::End(BytesEnd::new(self.name)))
    }
}

/// The text of a document with this root.
pub(super) fn document(root: &Tag) -> io::Result<String> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    root.write(&mut xml)?;
    let mut bytes = xml.into_inner();
    bytes.push(b'\n');
    String::from_utf8(bytes).map_err(io::Error::other)
}

/// The definition of a unit.
pub(super) fn unit_tag(name: &str, base: &BaseUnit) -> Tag {
    let used = BaseUnit::NAMES.into_iter().zip(base.exponents).filter(|(_, e)| *e != 0);
    let mut attributes: Vec<_> = used.map(|(name, exponent)| (name, exponent.to_string())).collect();
    attributes.extend((base.factor != 1.0).then(|| ("factor", base.factor.to_string())));
    attributes.extend((base.offset != 0.0).then(|| ("offset", base.offset.to_string())));
    node("ssc:Unit", &[("name", name)], vec![Tag { name: "ssc:BaseUnit", attributes, children: None }])
}

/// The type of a signal; the items of an enumeration are defined in the FMU and are not repeated in SSP.
pub(super) fn type_tag(kind: Kind, unit: Option<&str>) -> Option<Tag> {
    Some(match kind {
        Kind::Float64 | Kind::Float32 => {
            leaf("ssc:Real", &unit.map(|unit| ("unit", unit)).into_iter().collect::<Vec<_>>())
        }
        Kind::Boolean => leaf("ssc:Boolean", &[]),
        Kind::String => leaf("ssc:String", &[]),
        Kind::Binary | Kind::Clock => leaf("ssc:Binary", &[]),
        Kind::Enumeration => return None,
        _ => leaf("ssc:Integer", &[]),
    })
}

/// The attributes of a connection.
pub(super) fn between_ends<'e>(from: &'e End, to: &'e End) -> Vec<(&'static str, &'e str)> {
    let mut attributes: Vec<(&str, &str)> = Vec::new();
    attributes.extend(from.component.as_deref().map(|element| ("startElement", element)));
    attributes.push(("startConnector", &from.connector));
    attributes.extend(to.component.as_deref().map(|element| ("endElement", element)));
    attributes.push(("endConnector", &to.connector));
    attributes
}
