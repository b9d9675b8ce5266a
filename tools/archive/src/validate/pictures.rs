//! Pictures that the standards name: files of the format that their names say.

use std::collections::HashSet;

use super::finding::Findings;
use super::rules;
use super::zip::{self, Archive};

/// Largest picture that is read.
const LARGEST: u64 = 64 << 20;

/// Reads the icon of the model, those of terminals, and the diagram.
pub(crate) fn check(archive: &mut Archive, entries: &HashSet<String>, out: &mut Findings) {
    let named = |entry: &&String| {
        ["model.png", "documentation/diagram.png", "documentation/diagram.svg"].contains(&entry.as_str())
            || entry.starts_with("terminalsAndIcons/") && (entry.ends_with(".png") || entry.ends_with(".svg"))
    };
    let mut pictures: Vec<&String> = entries.iter().filter(named).collect();
    pictures.sort_unstable();
    for entry in pictures {
        // What cannot be read from the archive has been reported.
        let Some(bytes) = zip::read(archive, entry, LARGEST) else { continue };
        let fault = if entry.ends_with(".png") { png_fault(&bytes) } else { svg_fault(&bytes) };
        if let Some(reason) = fault {
            out.add(entry, rules::picture_unreadable(reason.trim_end_matches('.')));
        }
    }
}

fn png_fault(bytes: &[u8]) -> Option<String> {
    let mut reader = match png::Decoder::new(std::io::Cursor::new(bytes)).read_info() {
        Ok(reader) => reader,
        Err(error) => return Some(format!("it is no PNG ({error})")),
    };
    while let Some(row) = reader.next_row().transpose() {
        if let Err(error) = row {
            return Some(format!("the PNG is damaged ({error})"));
        }
    }
    None
}

fn svg_fault(bytes: &[u8]) -> Option<String> {
    let Ok(text) = std::str::from_utf8(bytes) else { return Some("it is no SVG (not UTF-8)".to_owned()) };
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    match roxmltree::Document::parse_with_options(text, options) {
        Ok(svg) if svg.root_element().has_tag_name(("http://www.w3.org/2000/svg", "svg")) => None,
        Ok(_) => Some("the XML has no element <svg> as its root".to_owned()),
        Err(error) => Some(format!("it is no SVG ({error})")),
    }
}
