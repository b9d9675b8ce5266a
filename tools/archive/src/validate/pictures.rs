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

/// The format of a file that is called PNG.
fn format_of(bytes: &[u8]) -> &'static str {
    let starts: [(&[u8], &str); 5] = [
        (b"\x89PNG", "a damaged PNG"),
        (b"\xff\xd8\xff", "a JPEG and no PNG"),
        (b"GIF8", "a GIF and no PNG"),
        (b"BM", "a BMP and no PNG"),
        (b"version https://git-lfs", "a pointer of Git LFS and no PNG"),
    ];
    starts.iter().find(|(start, _)| bytes.starts_with(start)).map_or("no PNG", |(_, name)| name)
}

/// An error of the decoder without the dump of its types.
fn words(error: &png::DecodingError) -> String {
    let text = error.to_string();
    text.split(" while decoding").next().unwrap_or(&text).to_owned()
}

fn png_fault(bytes: &[u8]) -> Option<String> {
    let mut reader = match png::Decoder::new(std::io::Cursor::new(bytes)).read_info() {
        Ok(reader) => reader,
        Err(error) => return Some(format!("it is {} ({})", format_of(bytes), words(&error))),
    };
    while let Some(row) = reader.next_row().transpose() {
        if let Err(error) = row {
            return Some(format!("the PNG is damaged ({})", words(&error)));
        }
    }
    None
}

/// The encoding of an XML file by its byte order mark or its declaration; UTF-8 without them.
fn encoding_of(bytes: &[u8]) -> &'static encoding_rs::Encoding {
    let declared = || {
        let head = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).into_owned();
        let name = head.split_once("encoding=")?.1.get(1..)?.split(['"', '\'']).next()?.to_owned();
        encoding_rs::Encoding::for_label(name.as_bytes())
    };
    let marked = encoding_rs::Encoding::for_bom(bytes).map(|(encoding, _)| encoding);
    marked.or_else(declared).unwrap_or(encoding_rs::UTF_8)
}

fn svg_fault(bytes: &[u8]) -> Option<String> {
    let (text, _, _) = encoding_of(bytes).decode(bytes);
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    match roxmltree::Document::parse_with_options(&text, options) {
        Ok(svg) if svg.root_element().has_tag_name(("http://www.w3.org/2000/svg", "svg")) => None,
        Ok(svg) if svg.root_element().tag_name().name() == "svg" => {
            Some("the element <svg> lacks the namespace http://www.w3.org/2000/svg".to_owned())
        }
        Ok(_) => Some("the XML has no element <svg> as its root".to_owned()),
        Err(error) => Some(format!("it is no SVG ({error})")),
    }
}
