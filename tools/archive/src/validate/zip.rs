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
/// All entries together: never more than this, nor more than this times the size of the archive above that size. The same limits as
/// those of the importer in `cosim`.
const BOMB_TOTAL: u64 = 4 << 30;
const TOTAL_RATIO: u64 = 100;
const TOTAL_ALLOWED: u64 = 256 << 20;

/// Whether so many bytes are too many for an archive with these entries.
fn is_bomb(directory: &Directory) -> Option<u64> {
    let sum =
        |of: fn(&RawEntry) -> u64| directory.entries.iter().fold(0_u64, |sum, e| sum.saturating_add(of(e)));
    let (total, compressed) = (sum(|e| e.size), sum(|e| e.compressed));
    // Entries that share their bytes are counted once in the file and often here.
    let size = compressed.min(directory.length);
    let most = size.saturating_mul(TOTAL_RATIO).clamp(TOTAL_ALLOWED, BOMB_TOTAL);
    (total > most || compressed > directory.length).then_some(total)
}

/// Checks every entry of the directory.
pub(crate) fn check(directory: &Directory, out: &mut Findings) {
    if directory.spanned {
        out.add("archive", rules::archive_spanned());
    }
    let mut seen = HashSet::new();
    let mut folded: HashMap<String, String> = HashMap::new();
    for entry in &directory.entries {
        let name = entry.text();
        check_name(&name, out);
        check_storage(entry, &name, out);
        if !seen.insert(entry.name.clone()) {
            out.add(&name, rules::entry_duplicate(short(&name)));
        } else if let Some(other) = folded.insert(name.to_lowercase(), name.clone()) {
            out.add(&name, rules::entry_case(short(&other), short(&name)));
        }
    }
    if let Some(total) = is_bomb(directory) {
        out.add("archive", rules::archive_bomb(total, directory.length));
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
            out.add(name, rule.says(format!("The entry name \"{shown}\" {what}")));
        }
    }
}

fn check_storage(entry: &RawEntry, name: &str, out: &mut Findings) {
    let shown = &short(name);
    if entry.is_encrypted() {
        out.add(name, rules::entry_encrypted(shown));
    }
    if ![0, 8].contains(&entry.method) {
        out.add(name, rules::entry_method(shown, entry.method));
    } else if entry.version_needed & 0xFF > 20 {
        let needed = entry.version_needed & 0xFF;
        out.add(name, rules::entry_version(shown, needed / 10, needed % 10));
    }
    if entry.method == 0 && entry.has_data_descriptor() {
        out.add(name, rules::entry_descriptor(shown));
    }
    if entry.is_link() {
        out.add(name, rules::entry_link(shown));
    }
    if entry.local_name.as_ref().is_some_and(|local| *local != entry.name) {
        let local = String::from_utf8_lossy(entry.local_name.as_deref().unwrap_or_default()).into_owned();
        out.add(name, rules::entry_header(shown, short(&local)));
    }
    if entry.size > BOMB_SIZE && entry.size / entry.compressed.max(1) > BOMB_RATIO {
        out.add(name, rules::entry_bomb(shown, entry.compressed, entry.size));
    }
}

/// Unpacks every entry once without storing it, to detect damaged entries and wrong sizes before they are used.
///
/// Entries that cannot be read for a reason already reported (method, encryption) are passed over.
pub(crate) fn check_content(archive: &mut Archive, directory: &Directory, out: &mut Findings) {
    if is_bomb(directory).is_some() {
        return;
    }
    let unreadable = |e: &&RawEntry| e.is_encrypted() || ![0, 8].contains(&e.method);
    let reported: HashSet<String> = directory.entries.iter().filter(unreadable).map(RawEntry::text).collect();
    for index in 0..archive.len() {
        let name =
            archive.name_for_index(index).and_then(Result::ok).map(|n| n.into_owned()).unwrap_or_default();
        if reported.contains(&name) {
            continue;
        }
        let Ok(mut entry) = archive.by_index(index) else {
            out.add(&name, rules::entry_header_damaged(short(&name)));
            continue;
        };
        let size = entry.size();
        let what = match io::copy(&mut (&mut entry).take(size.saturating_add(1)), &mut io::sink()) {
            Ok(read) if read == size => continue,
            Ok(_) => format!("does not unpack to the {size} bytes that it declares"),
            Err(e) => format!("cannot be unpacked: {e}"),
        };
        out.add(&name, rules::entry_damaged(short(&name), what));
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
