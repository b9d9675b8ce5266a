//! The folder `binaries`: platform names, file names, machine code of the right machine, exported functions.

use std::collections::{BTreeMap, HashSet};

use object::Architecture;

use super::finding::{Findings, short};
use super::model::{FmiVersion, Model};
use super::rules;
use super::symbols::{self, Part, System};
use super::zip::{self, Archive};

/// No library of an FMU is larger; a larger one is not read.
const LARGEST_BINARY: u64 = 1 << 30;

/// Properties of a platform folder.
struct Platform {
    system: System,
    architecture: Architecture,
}

const ARCHITECTURES: [(&str, Architecture); 4] = [
    ("aarch32", Architecture::Arm),
    ("aarch64", Architecture::Aarch64),
    ("x86_64", Architecture::X86_64),
    ("x86", Architecture::I386),
];
const SYSTEMS: [(&str, System); 3] =
    [("darwin", System::Darwin), ("linux", System::Linux), ("windows", System::Windows)];

/// A folder name of FMI 2.
fn fmi2_platform(folder: &str) -> Option<Platform> {
    let (system, architecture) = match folder {
        "win32" => (System::Windows, Architecture::I386),
        "win64" => (System::Windows, Architecture::X86_64),
        "linux32" => (System::Linux, Architecture::I386),
        "linux64" => (System::Linux, Architecture::X86_64),
        "darwin32" => (System::Darwin, Architecture::I386),
        "darwin64" => (System::Darwin, Architecture::X86_64),
        _ => return None,
    };
    Some(Platform { system, architecture })
}

/// A platform tuple `<arch>-<sys>` of FMI 3; those with an ABI hold static libraries and are not checked.
fn tuple(folder: &str) -> Option<Platform> {
    let (architecture, system) = folder.split_once('-')?;
    Some(Platform {
        system: SYSTEMS.iter().find(|(name, _)| *name == system)?.1,
        architecture: ARCHITECTURES.iter().find(|(name, _)| *name == architecture)?.1,
    })
}

fn has_abi(folder: &str) -> bool {
    let mut parts = folder.splitn(3, '-');
    let base = [parts.next(), parts.next()].map(Option::unwrap_or_default).join("-");
    parts.next().is_some() && tuple(&base).is_some()
}

fn suffix(system: System) -> &'static str {
    match system {
        System::Linux => "so",
        System::Windows => "dll",
        System::Darwin => "dylib",
    }
}

pub(crate) fn check(archive: &mut Archive, model: &Model, entries: &HashSet<String>, out: &mut Findings) {
    let mut folders: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for entry in entries.iter().filter(|e| !e.ends_with('/')) {
        if let Some((folder, file)) = entry.strip_prefix("binaries/").and_then(|e| e.split_once('/')) {
            folders.entry(folder).or_default().push(file);
        }
    }
    for (folder, files) in folders {
        let place = format!("binaries/{folder}");
        let platform = match (fmi2_platform(folder), tuple(folder)) {
            (Some(p), _) => {
                if model.version == FmiVersion::V3 {
                    out.add(&place, rules::platform_of_fmi2(folder));
                }
                p
            }
            (None, Some(p)) => {
                let old = p.architecture == Architecture::X86_64 || p.architecture == Architecture::I386;
                if model.version == FmiVersion::V2 && old {
                    out.add(&place, rules::platform_of_fmi3(folder));
                }
                p
            }
            (None, None) => {
                if !(model.version == FmiVersion::V3 && has_abi(folder)) {
                    out.add(&place, rules::platform_unknown(short(folder)));
                }
                continue;
            }
        };
        check_folder(archive, model, folder, &platform, &files, entries, out);
    }
}

fn check_folder(
    archive: &mut Archive,
    model: &Model,
    folder: &str,
    platform: &Platform,
    files: &[&str],
    entries: &HashSet<String>,
    out: &mut Findings,
) {
    let mut identifiers: Vec<&str> =
        model.interfaces.iter().filter_map(|i| i.attribute("modelIdentifier")).collect();
    identifiers.dedup();
    let wanted: Vec<(&str, String)> =
        identifiers.iter().map(|i| (*i, format!("{i}.{}", suffix(platform.system)))).collect();
    let found = wanted.iter().filter(|(_, file)| files.contains(&file.as_str())).count();
    let is_static = |f: &&str| f.ends_with(".lib") || f.ends_with(".a");
    let sources = entries.iter().any(|e| e.starts_with("sources/") && !e.ends_with('/'));
    for (identifier, file) in &wanted {
        let path = format!("binaries/{folder}/{file}");
        if files.contains(&file.as_str()) {
            check_binary(archive, model, identifier, &path, folder, platform, out);
        // A folder may hold a static library only, or one interface type as binary and the other as source.
        } else if !(files.iter().any(is_static) && found == 0 || found > 0 && sources) {
            let mut have = files.to_vec();
            have.sort_unstable();
            have.truncate(5);
            out.add(
                format!("binaries/{folder}"),
                rules::binary_missing(folder, short(file), short(identifier), short(&have.join(", "))),
            );
        }
    }
}

fn check_binary(
    archive: &mut Archive,
    model: &Model,
    identifier: &str,
    path: &str,
    folder: &str,
    platform: &Platform,
    out: &mut Findings,
) {
    // What cannot be unpacked has been reported with the archive.
    let Some(bytes) = zip::read(archive, path, LARGEST_BINARY) else { return };
    let parts = symbols::read(&bytes);
    if parts.is_empty() {
        out.add(path, rules::binary_format(path));
        return;
    }
    let fits = |p: &&Part| p.system == platform.system && p.architecture == platform.architecture;
    let Some(part) = parts.iter().find(fits) else {
        let have: Vec<_> = parts.iter().map(|p| format!("{:?} for {:?}", p.architecture, p.system)).collect();
        out.add(
            path,
            rules::binary_architecture(
                path,
                have.join(", "),
                folder,
                format!("{:?}", platform.architecture),
                format!("{:?}", platform.system),
            ),
        );
        return;
    };
    let exported: HashSet<&str> = part.exports.iter().map(String::as_str).collect();
    let missing: Vec<String> =
        symbols::required(model, identifier).into_iter().filter(|n| !exported.contains(n.as_str())).collect();
    if !missing.is_empty() {
        let prefixed = missing.iter().any(|n| exported.contains(format!("{identifier}_{n}").as_str()));
        let hint = if prefixed {
            "; they carry the prefix that only source code and static libraries have"
        } else {
            ""
        };
        let shown = missing.iter().take(5).cloned().collect::<Vec<_>>().join(", ");
        let more = if missing.len() > 5 { ", ..." } else { "" };
        out.add(path, rules::symbol_missing(path, missing.len(), shown, more, hint));
    }
}
