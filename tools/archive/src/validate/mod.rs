//! Checks an FMU: the archive, the XML files against the schemas of the standards, the rules that only the text of
//! the standards states, and how the FMU behaves when it is run.
//!
//! Any FMU of FMI 2.0 or 3.0 is judged alike. [`rules::ALL`] lists every rule; a breach of the standard or of the
//! FMU's own declarations is an error, doubtful practice a warning.

mod binaries;
mod directory;
pub mod dynamic;
mod finding;
mod layout;
mod model;
mod pictures;
pub mod rules;
mod schema;
mod semantics;
mod sources;
mod symbols;
mod terminals;
mod xml;
mod zip;

use std::collections::HashSet;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

pub use self::finding::Finding;
use self::finding::{Findings, short};
use self::model::{FmiVersion, Model};
pub use self::rules::{Basis, Phase, Severity};
use self::xml::Xml;
use self::zip::Archive;

/// The file is not an archive that could be checked at all.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct Unreadable {
    path: String,
    reason: String,
}

/// Larger model descriptions are not read.
const LARGEST_XML: u64 = 512 << 20;
/// How long a call may take before the FMU counts as hung.
pub const PATIENCE: Duration = Duration::from_secs(60);
const MODEL_DESCRIPTION: &str = "modelDescription.xml";

/// Runs every check. The FMU runs through `program` (see [`dynamic::run`]) wherever an importer could run it; otherwise the finding
/// `not-run` says why not.
///
/// # Errors
/// As [`validate_static`].
pub fn validate(path: &Path, program: &Path) -> Result<Vec<Finding>, Unreadable> {
    validate_within(path, program, PATIENCE)
}

/// As [`validate`], with another patience than [`PATIENCE`] for each call, and for the static checks.
///
/// # Errors
/// As [`validate_static`].
pub fn validate_within(path: &Path, program: &Path, patience: Duration) -> Result<Vec<Finding>, Unreadable> {
    let (sender, receiver) = channel();
    let file = path.to_owned();
    // A thread that is late is left alone; this process ends soon.
    thread::spawn(move || sender.send(check_static(&file)));
    let Ok(checked) = receiver.recv_timeout(patience) else {
        let mut out = Findings::new();
        out.add("archive", rules::time_limit(patience.as_secs_f64()));
        out.add("archive", rules::cannot_run("its files take too long to read"));
        return Ok(out.into_list());
    };
    let (mut findings, version) = checked?;
    let danger = findings.iter().find(|f| f.severity == Severity::Error && f.phase == Phase::Archive);
    if let Some(danger) = danger {
        let mut out = Findings::new();
        out.version = version;
        out.add("archive", rules::cannot_run(format!("the archive breaks the rule {}", danger.code)));
        findings.extend(out.into_list());
    } else {
        findings.extend(dynamic::run(program, path, version, patience));
    }
    Ok(findings)
}

/// Runs every check that needs no loading of the FMU.
///
/// # Errors
/// [`Unreadable`] when the file cannot be opened or is no zip archive.
pub fn validate_static(path: &Path) -> Result<Vec<Finding>, Unreadable> {
    check_static(path).map(|(findings, _)| findings)
}

/// The findings of the static checks, and the standard.
fn check_static(path: &Path) -> Result<(Vec<Finding>, FmiVersion), Unreadable> {
    let unreadable = |reason: String| Unreadable { path: path.display().to_string(), reason };
    let open = |e: std::io::Error| unreadable(format!("cannot be read: {e}"));
    if path.is_dir() {
        return Err(unreadable("is a folder, not an FMU archive".into()));
    }
    let mut file = File::open(path).map_err(open)?;
    let directory = directory::read(&mut file).map_err(open)?;
    let Some(directory) = directory else { return Err(unreadable("is not a zip archive".into())) };
    if directory.spanned {
        let mut out = Findings::new();
        zip::check(&directory, &mut out);
        return Ok((out.into_list(), FmiVersion::V3));
    }
    let mut archive = Archive::new(BufReader::new(file))
        .map_err(|e| unreadable(format!("is not a readable zip archive: {e}")))?;

    let mut out = Findings::new();
    let description = zip::read(&mut archive, MODEL_DESCRIPTION, LARGEST_XML);
    if let Some(bytes) = &description {
        // The archive's rules, too, cite the section of the right standard.
        out.version = guess_version(bytes);
    }
    if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("fmu")) {
        out.add("archive", rules::extension());
    }
    zip::check(&directory, &mut out);
    zip::check_content(&mut archive, &directory, &mut out);
    let entries: HashSet<String> = directory.entries.iter().map(|e| e.text()).collect();
    match description {
        Some(bytes) => {
            if let Some(text) = xml::decode(MODEL_DESCRIPTION, &bytes, &mut out) {
                check_description(&text, &mut archive, &entries, &mut out);
            }
        }
        None if entries.contains(MODEL_DESCRIPTION) => {
            if !out.any_error() {
                out.add(MODEL_DESCRIPTION, rules::description_unreadable(MODEL_DESCRIPTION));
            }
        }
        None => {
            let suffix = format!("/{MODEL_DESCRIPTION}");
            let elsewhere =
                directory.entries.iter().map(|e| e.text()).find(|e| e.replace('\\', "/").ends_with(&suffix));
            let hint = elsewhere.map(|e| format!("; it is at \"{}\"", short(&e))).unwrap_or_default();
            out.add("archive", rules::description_missing(MODEL_DESCRIPTION, hint));
        }
    }
    let version = out.version;
    Ok((out.into_list(), version))
}

/// The version as it appears in the text, before the file is parsed.
fn guess_version(bytes: &[u8]) -> FmiVersion {
    // Text of two bytes a character has zeros between the letters.
    let head: Vec<u8> = bytes.iter().take(8192).copied().filter(|b| *b != 0).collect();
    let head = String::from_utf8_lossy(&head);
    let version =
        head.split_once("fmiVersion").map_or("", |(_, rest)| rest).trim_start_matches([' ', '=', '"', '\'']);
    if version.starts_with('2') { FmiVersion::V2 } else { FmiVersion::V3 }
}

fn check_description(text: &str, archive: &mut Archive, entries: &HashSet<String>, out: &mut Findings) {
    let Some(xml) = Xml::parse(MODEL_DESCRIPTION, text, out) else { return };
    let root = xml.root();
    let version = match root.attribute("fmiVersion") {
        Some("2.0") => FmiVersion::V2,
        Some(v) if v.starts_with("3.") => {
            if v != "3.0" {
                out.add(xml.place(root), rules::version_newer(short(v)));
            }
            FmiVersion::V3
        }
        Some(v) => {
            out.add(xml.place(root), rules::version(short(v)));
            return;
        }
        // The schema rules report the missing attribute; its neighbours show which schema applies.
        None if root.attribute("guid").is_some() => FmiVersion::V2,
        None => FmiVersion::V3,
    };
    out.version = version;
    let table: &schema::Schema = match version {
        FmiVersion::V2 => &schema::FMI2,
        FmiVersion::V3 => &schema::FMI3,
    };
    if !schema::check(&xml, table, "fmiModelDescription", out) {
        return;
    }
    let model = Model::read(xml.file(), version);
    semantics::check(&model, out);
    layout::check(&model, entries, out);
    pictures::check(archive, entries, out);
    sources::check(&model, entries, out);
    if let Some(bytes) = zip::read(archive, sources::FILE, LARGEST_XML) {
        sources::check_build(&bytes, &model, entries, out);
    }
    if let Some(bytes) = zip::read(archive, terminals::FILE, LARGEST_XML) {
        terminals::check(&bytes, &model, entries, out);
    }
    binaries::check(archive, &model, entries, out);
}
