//! Rules on the archive itself: names, methods, flags, sizes.

use std::collections::{HashMap, HashSet};
use std::io::{self, Read};

use super::directory::{Directory, RawEntry};
use super::finding::{Findings, short};
use super::rules;

/// An archive opened for reading its files.
pub(crate) type Archive = ::zip::ZipArchive<std::io::BufReader<std::fs::File>>;

/// An entry both this large and this compressible serves no FMU.
const BOMB_SIZE: u64 = 128 << 20;
const BOMB_RATIO: u64 = 200;
/// All entries together.
const BOMB_TOTAL: u64 = 8 << 30;

/// Checks every entry of the directory.
pub(crate) fn check(directory: &Directory, out: &mut Findings) {
    if directory.spanned {
        out.add(&rules::ARCHIVE_SPANNED, "archive", "The archive is split over several disks");
    }
    let mut seen = HashSet::new();
    let mut folded: HashMap<String, String> = HashMap::new();
    let mut total = 0_u64;
    for entry in &directory.entries {
        let name = entry.text();
        check_name(&name, out);
        check_storage(entry, &name, out);
        total = total.saturating_add(entry.size);
        if !seen.insert(entry.name.clone()) {
            let message = format!("The entry \"{}\" occurs more than once in the archive", short(&name));
            out.add(&rules::ENTRY_DUPLICATE, &name, message);
        } else if let Some(other) = folded.insert(name.to_lowercase(), name.clone()) {
            let message = format!(
                "The entries \"{}\" and \"{}\" differ only in case and overwrite each other where file names do not",
                short(&other),
                short(&name)
            );
            out.add(&rules::ENTRY_CASE, &name, message);
        }
    }
    if total > BOMB_TOTAL {
        let message =
            format!("The archive unpacks to {total} bytes, more than the {BOMB_TOTAL} allowed here");
        out.add(&rules::ARCHIVE_BOMB, "archive", message);
    }
}

fn check_name(name: &str, out: &mut Findings) {
    let shown = short(name);
    let normal = name.replace('\\', "/");
    let drive = normal.as_bytes().get(1) == Some(&b':') && normal.as_bytes()[0].is_ascii_alphabetic();
    let absolute = normal.starts_with('/') || drive;
    let outside = normal.split('/').any(|part| part == "..");
    let unportable = !drive && name.chars().any(|c| "<>:\"|?*".contains(c) || c.is_control());
    for (is_wrong, rule, what) in [
        (name.contains('\\'), &rules::ENTRY_BACKSLASH, "contains a backslash; only / separates folders"),
        (absolute, &rules::ENTRY_ABSOLUTE, "is absolute and would be unpacked outside its folder"),
        (outside, &rules::ENTRY_OUTSIDE, "contains \"..\" and would be unpacked outside its folder"),
        (!name.is_ascii(), &rules::ENTRY_NOT_ASCII, "is not plain ASCII, which some systems cannot unpack"),
        (unportable, &rules::ENTRY_UNPORTABLE, "has a character that Windows does not allow in file names"),
    ] {
        if is_wrong {
            out.add(rule, name, format!("The entry name \"{shown}\" {what}"));
        }
    }
}

fn check_storage(entry: &RawEntry, name: &str, out: &mut Findings) {
    let shown = short(name);
    if entry.is_encrypted() {
        out.add(&rules::ENTRY_ENCRYPTED, name, format!("The entry \"{shown}\" is encrypted"));
    }
    if ![0, 8].contains(&entry.method) {
        let message = format!(
            "The entry \"{shown}\" uses compression method {}; only 0 (store) and 8 (deflate) are allowed",
            entry.method
        );
        out.add(&rules::ENTRY_METHOD, name, message);
    } else if entry.version_needed & 0xFF > 20 {
        let needed = entry.version_needed & 0xFF;
        let message = format!(
            "The entry \"{shown}\" needs version {}.{} of zip to extract; at most 2.0 is allowed",
            needed / 10,
            needed % 10
        );
        out.add(&rules::ENTRY_VERSION, name, message);
    }
    if entry.method == 0 && entry.has_data_descriptor() {
        out.add(&rules::ENTRY_DESCRIPTOR, name, format!("The stored entry \"{shown}\" has general purpose bit 3 set, which only deflated entries may have"));
    }
    if entry.is_link() {
        out.add(&rules::ENTRY_LINK, name, format!("The entry \"{shown}\" is a symbolic link"));
    }
    if entry.local_name.as_ref().is_some_and(|local| *local != entry.name) {
        let local = String::from_utf8_lossy(entry.local_name.as_deref().unwrap_or_default()).into_owned();
        let message =
            format!("The directory calls the entry \"{shown}\", its own header \"{}\"", short(&local));
        out.add(&rules::ENTRY_HEADER, name, message);
    }
    if entry.size > BOMB_SIZE && entry.size / entry.compressed.max(1) > BOMB_RATIO {
        let message =
            format!("The entry \"{shown}\" of {} bytes unpacks to {} bytes", entry.compressed, entry.size);
        out.add(&rules::ARCHIVE_BOMB, name, message);
    }
}

/// Unpacks every entry once without storing it, to detect damaged entries and wrong sizes before they are used.
///
/// Entries that cannot be read for a reason already reported (method, encryption) are passed over.
pub(crate) fn check_content(archive: &mut Archive, directory: &Directory, out: &mut Findings) {
    if directory.entries.iter().fold(0_u64, |sum, e| sum.saturating_add(e.size)) > BOMB_TOTAL {
        return;
    }
    for index in 0..archive.len() {
        let name =
            archive.name_for_index(index).and_then(Result::ok).map(|n| n.into_owned()).unwrap_or_default();
        let is_reported =
            |e: &RawEntry| e.text() == name && (e.is_encrypted() || ![0, 8].contains(&e.method));
        if directory.entries.iter().any(is_reported) {
            continue;
        }
        let Ok(mut entry) = archive.by_index(index) else {
            let message = format!("The entry \"{}\" cannot be read: its header is damaged", short(&name));
            out.add(&rules::ENTRY_DAMAGED, &name, message);
            continue;
        };
        let size = entry.size();
        let what = match io::copy(&mut (&mut entry).take(size.saturating_add(1)), &mut io::sink()) {
            Ok(read) if read == size => continue,
            Ok(_) => format!("does not unpack to the {size} bytes that it declares"),
            Err(e) => format!("cannot be unpacked: {e}"),
        };
        out.add(&rules::ENTRY_DAMAGED, &name, format!("The entry \"{}\" {what}", short(&name)));
    }
}

/// Reads one file of the archive, at most `most` bytes; `None` when absent, too large or damaged.
pub(crate) fn read(archive: &mut Archive, name: &str, most: u64) -> Option<Vec<u8>> {
    let entry = archive.by_name(name).ok()?;
    if entry.size() > most {
        return None;
    }
    let mut bytes = Vec::new();
    entry.take(most).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}
