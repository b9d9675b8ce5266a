//! An XML file with the line of every node, and the attributes of its elements as values.
//!
//! All XML of FMI and SSP archives is read through here. Errors are [`Fault`]s; the caller adds the name of the file.
use crate::{BaseUnit, Unit};
use roxmltree::{Document, Node};
use std::borrow::Cow;
use std::str::FromStr;

/// The text of an XML file, and the name of its encoding if that is not UTF-8. The byte order mark decides, then the declaration.
///
/// # Errors
/// The number of the first line that is no text of the encoding; UTF-8 is assumed where an unknown one is declared.
pub fn decode(bytes: &[u8]) -> Result<(Cow<'_, str>, Option<&'static str>), u32> {
    let marked = encoding_rs::Encoding::for_bom(bytes).map(|(encoding, _)| encoding);
    let encoding = marked.or_else(|| declared(bytes)).unwrap_or(encoding_rs::UTF_8);
    if encoding == encoding_rs::UTF_8 {
        let line = |at: usize| 1 + bytes[..at].iter().filter(|b| **b == b'\n').count() as u32;
        return match std::str::from_utf8(bytes) {
            Ok(text) => Ok((Cow::Borrowed(text), None)),
            Err(e) => Err(line(e.valid_up_to())),
        };
    }
    let (text, _, bad) = encoding.decode(bytes);
    match text.find('\u{fffd}').filter(|_| bad) {
        Some(at) => Err(1 + text[..at].matches('\n').count() as u32),
        None => Ok((text, Some(encoding.name()))),
    }
}

/// The encoding that an XML declaration names. Text of two bytes a character shows by the zeros of its first letters.
fn declared(bytes: &[u8]) -> Option<&'static encoding_rs::Encoding> {
    match bytes {
        [b'<', 0, ..] => return Some(encoding_rs::UTF_16LE),
        [0, b'<', ..] => return Some(encoding_rs::UTF_16BE),
        _ => {}
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]);
    let (declaration, _) = head.strip_prefix("<?xml")?.split_once("?>")?;
    encoding_rs::Encoding::for_label(encoding_label(declaration)?.as_bytes())
}

/// The value of `encoding` in an XML declaration.
pub fn encoding_label(declaration: &str) -> Option<&str> {
    let rest = declaration.split_once("encoding")?.1.trim_start().strip_prefix('=')?.trim_start();
    let quote = rest.chars().next().filter(|c| *c == '"' || *c == '\'')?;
    rest[1..].split(quote).next()
}

/// A parsed XML file.
pub struct Xml<'a> {
    document: Document<'a>,
    /// Offset of the first byte of each line: the line of a node is found by bisection.
    line_starts: Vec<usize>,
}

/// What is wrong at one place of an XML file.
pub(crate) struct Fault {
    /// Line, from 1.
    pub(crate) line: u32,
    pub(crate) message: String,
}

impl<'a> Xml<'a> {
    /// Parses `text`, which may begin with a byte order mark.
    ///
    /// # Errors
    /// Text that is not well-formed XML, or has a document type declaration.
    pub fn parse(text: &'a str) -> Result<Self, roxmltree::Error> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let document = Document::parse(text)?;
        let line_starts = std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect();
        Ok(Self { document, line_starts })
    }

    /// As [`Self::parse`], with the error as a fault.
    pub(crate) fn read(text: &'a str) -> Result<Self, Fault> {
        Self::parse(text)
            .map_err(|e| Fault { line: e.pos().row, message: format!("not well-formed XML: {e}") })
    }

    /// The node above the root element.
    pub fn document(&self) -> Node<'_, 'a> {
        self.document.root()
    }

    /// The root element.
    pub fn root(&self) -> Node<'_, 'a> {
        self.document.root_element()
    }

    /// Line of a node of this document, from 1.
    pub fn line(&self, node: Node) -> u32 {
        self.line_starts.partition_point(|start| *start <= node.range().start) as u32
    }

    pub(crate) fn fault(&self, node: Node, message: impl Into<String>) -> Fault {
        Fault { line: self.line(node), message: message.into() }
    }

    /// An attribute that must be there.
    pub(crate) fn required<'n>(&self, node: Node<'n, '_>, name: &str) -> Result<&'n str, Fault> {
        let absent = || self.fault(node, format!("<{}> has no attribute {name}", node.tag_name().name()));
        node.attribute(name).ok_or_else(absent)
    }

    /// An attribute that is a number.
    pub(crate) fn number<T: FromStr>(&self, node: Node, name: &str) -> Result<Option<T>, Fault> {
        let Some(text) = node.attribute(name) else { return Ok(None) };
        let wrong = |_| self.fault(node, format!("{name} = {text:?} is not a number of the right kind"));
        text.trim().parse().map(Some).map_err(wrong)
    }

    /// An attribute that must be there and is a number.
    pub(crate) fn required_number<T: FromStr>(&self, node: Node, name: &str) -> Result<T, Fault> {
        self.required(node, name)?;
        self.number(node, name)?.ok_or_else(|| self.fault(node, format!("{name} is missing")))
    }

    /// An attribute that is a Boolean.
    pub(crate) fn flag(&self, node: Node, name: &str) -> Result<Option<bool>, Fault> {
        match node.attribute(name).map(str::trim) {
            None => Ok(None),
            Some("true" | "1") => Ok(Some(true)),
            Some("false" | "0") => Ok(Some(false)),
            Some(other) => Err(self.fault(node, format!("{name} = {other:?} is neither true nor false"))),
        }
    }

    /// A `Unit` without its display units, the same in both standards and in system structures.
    pub(crate) fn unit(&self, node: Node) -> Result<Unit, Fault> {
        let base = child(node, "BaseUnit").map(|base| {
            let mut exponents = [0; 8];
            for (exponent, name) in exponents.iter_mut().zip(BaseUnit::NAMES) {
                *exponent = self.number(base, name)?.unwrap_or(0);
            }
            Ok(BaseUnit {
                exponents,
                factor: self.number(base, "factor")?.unwrap_or(1.0),
                offset: self.number(base, "offset")?.unwrap_or(0.0),
            })
        });
        let base = base.transpose()?;
        Ok(Unit { name: self.required(node, "name")?.to_owned(), base, display_units: Vec::new() })
    }
}

/// The first child element of a name.
pub fn child<'a, 'd>(node: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
    node.children().find(|n| n.tag_name().name() == name)
}

/// All child elements; none without a node.
pub fn elements<'a, 'd: 'a>(node: Option<Node<'a, 'd>>) -> impl Iterator<Item = Node<'a, 'd>> {
    node.into_iter().flat_map(|n| n.children()).filter(Node::is_element)
}

/// Child elements of a name.
pub fn children<'a, 'd: 'a>(node: Node<'a, 'd>, name: &'static str) -> impl Iterator<Item = Node<'a, 'd>> {
    node.children().filter(move |c| c.has_tag_name(name))
}

/// An attribute of type xs:unsignedInt; `None` if it is absent or unreadable.
pub fn unsigned(node: Node, name: &str) -> Option<u32> {
    node.attribute(name).and_then(parse_integer).and_then(|v| u32::try_from(v).ok())
}

/// An attribute of type xs:double; `None` if it is absent or unreadable.
pub fn double(node: Node, name: &str) -> Option<f64> {
    node.attribute(name).and_then(parse_double)
}

/// Whether an attribute of type xs:boolean is there and true.
pub fn is_true(node: Node, name: &str) -> bool {
    node.attribute(name).and_then(parse_boolean) == Some(true)
}

/// A list of xs:unsignedInt; unreadable items are left out.
pub fn unsigned_list(text: &str) -> Vec<u32> {
    text.split_ascii_whitespace()
        .filter_map(|t| parse_integer(t).and_then(|v| u32::try_from(v).ok()))
        .collect()
}

/// A text of the file for a message, shortened so that the message stays one readable line.
pub fn short(text: &str) -> String {
    shortened(text, 80)
}

/// A text for a message, with at most so many characters.
pub fn shortened(text: &str, most: usize) -> String {
    let mut out: String = text.chars().take(most).flat_map(char::escape_debug).collect();
    if text.chars().nth(most).is_some() {
        out.push_str("...");
    }
    out
}

/// White space of XML Schema.
const SPACE: [char; 4] = [' ', '\t', '\n', '\r'];

/// Reads an xs:double; unlike Rust it accepts `INF` but not `inf`, `infinity` or `nan`.
pub fn parse_double(text: &str) -> Option<f64> {
    match text.trim_matches(SPACE) {
        "INF" => Some(f64::INFINITY),
        "-INF" => Some(f64::NEG_INFINITY),
        "NaN" => Some(f64::NAN),
        text if text.bytes().all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b)) => text.parse().ok(),
        _ => None,
    }
}

/// Reads an integer of any XML Schema type.
pub fn parse_integer(text: &str) -> Option<i128> {
    let text = text.trim_matches(SPACE);
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    // Leading zeros are allowed in any number.
    let significant = digits.trim_start_matches('0');
    let value: i128 = if significant.is_empty() { 0 } else { significant.parse().ok()? };
    Some(if text.starts_with('-') { -value } else { value })
}

/// Reads an xs:boolean.
pub fn parse_boolean(text: &str) -> Option<bool> {
    match text.trim_matches(SPACE) {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn declared_encodings_are_read() {
        let text = |label: &str| format!("<?xml version='1.0' encoding='{label}'?>\n<a>Maß</a>");
        let latin: Vec<u8> = text("ISO-8859-1").chars().map(|c| c as u8).collect();
        assert_eq!(decode(&latin).unwrap().0, text("ISO-8859-1"));
        let wide = text("UTF-16");
        for bytes in [
            wide.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>(),
            [0xfe, 0xff].into_iter().chain(wide.encode_utf16().flat_map(u16::to_be_bytes)).collect(),
        ] {
            assert_eq!(decode(&bytes).unwrap().0, wide);
        }
        assert_eq!(decode(text("UTF-8").as_bytes()), Ok((text("UTF-8").into(), None)));
        assert_eq!(decode(b"<a>\n\xff</a>"), Err(2));
        // Shift JIS has no character 0xff.
        assert_eq!(decode(b"<?xml encoding='Shift_JIS'?>\n\n\xff"), Err(3));
    }

    #[test]
    fn lines_are_those_of_the_parser() {
        let xml = Xml::parse("\u{feff}<a>\n\n<b/><c\n x='1'/>text\r\n<d/></a>").unwrap();
        for node in xml.document().descendants() {
            let row = node.document().text_pos_at(node.range().start).row;
            assert_eq!(xml.line(node), row, "{node:?}");
        }
        assert_eq!(child(xml.root(), "d").map(|d| xml.line(d)), Some(5));
    }
}
