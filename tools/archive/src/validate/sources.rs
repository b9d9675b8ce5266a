//! Source code: the files that the model description lists, and `sources/buildDescription.xml`.

use std::collections::HashSet;

use super::finding::{Findings, short};
use super::model::{FmiVersion, Model, check_version_of, children};
use super::rules;
use super::schema;
use super::xml::{Xml, decode};

/// Where the file must be.
pub(crate) const FILE: &str = "sources/buildDescription.xml";

/// The rules that need no build description.
pub(crate) fn check(model: &Model, entries: &HashSet<String>, out: &mut Findings) {
    let has_sources = entries.iter().any(|e| e.starts_with("sources/") && !e.ends_with('/'));
    if model.version == FmiVersion::V3 && has_sources && !entries.contains(FILE) {
        out.add("sources/", rules::build_description_missing(FILE));
    }
    if model.version == FmiVersion::V2 {
        let files = model
            .interfaces
            .iter()
            .flat_map(|i| children(*i, "SourceFiles"))
            .flat_map(|s| children(s, "File"));
        for file in files {
            if let Some(name) = file.attribute("name") {
                require_source(name, &model.place(file), entries, out);
            }
        }
    }
}

fn require_source(name: &str, place: &str, entries: &HashSet<String>, out: &mut Findings) {
    let file = format!("sources/{}", name.trim_start_matches("./"));
    if !entries.contains(&file) {
        out.add(place, rules::source_file_missing(short(name)));
    }
}

/// Checks the build description against the model description and the entries of the archive.
pub(crate) fn check_build(bytes: &[u8], model: &Model, entries: &HashSet<String>, out: &mut Findings) {
    let Some(text) = decode(FILE, bytes, out) else { return };
    let Some(xml) = Xml::parse(FILE, &text, out) else { return };
    if !schema::check(&xml, &schema::FMI3, "fmiBuildDescription", out) {
        return;
    }
    check_version_of(model, &xml, out);
    let root = xml.root();
    let mut seen = HashSet::new();
    for configuration in root.children().filter(|c| c.has_tag_name("BuildConfiguration")) {
        let place = xml.place(configuration);
        let Some(identifier) = configuration.attribute("modelIdentifier") else { continue };
        let is_ours = |i: &roxmltree::Node| i.attribute("modelIdentifier") == Some(identifier);
        if !model.interfaces.is_empty() && !model.interfaces.iter().any(is_ours) {
            out.add(&place, rules::build_identifier(short(identifier)));
        }
        if configuration.attribute("platform").is_none() && !seen.insert(identifier) {
            out.add(&place, rules::build_fallback(short(identifier)));
        }
        let sets = configuration.children().filter(|c| c.has_tag_name("SourceFileSet"));
        for file in sets.flat_map(|s| s.children()).filter(|c| c.has_tag_name("SourceFile")) {
            if let Some(name) = file.attribute("name") {
                require_source(name, &xml.place(file), entries, out);
            }
        }
    }
}
