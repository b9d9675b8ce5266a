//! Reads the central directory of a zip file as it is written, before any library tidies it.
//!
//! Archive libraries hide faults that a validator must detect: they keep one of two entries of the same name, clean up
//! paths and ignore flags. Layout: PKWARE APPNOTE 4.3.7 (local header), 4.3.12 (central directory header),
//! 4.3.14 and 4.3.16 (end records).

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

/// One entry of the central directory, untouched.
pub(crate) struct RawEntry {
    pub(crate) name: Vec<u8>,
    /// The name in the local header; some readers use this one.
    pub(crate) local_name: Option<Vec<u8>>,
    pub(crate) version_needed: u16,
    pub(crate) flags: u16,
    pub(crate) method: u16,
    pub(crate) compressed: u64,
    pub(crate) size: u64,
    pub(crate) made_by: u16,
    pub(crate) external: u32,
}

impl RawEntry {
    /// The name for messages and look-ups.
    pub(crate) fn text(&self) -> String {
        String::from_utf8_lossy(&self.name).into_owned()
    }
    pub(crate) fn is_encrypted(&self) -> bool {
        self.flags & 1 != 0
    }
    pub(crate) fn has_data_descriptor(&self) -> bool {
        self.flags & 8 != 0
    }
    /// A symbolic link, as Unix tools store it in the upper half of the external attributes.
    pub(crate) fn is_link(&self) -> bool {
        self.made_by >> 8 == 3 && (self.external >> 16) & 0o170000 == 0o120000
    }
}

pub(crate) struct Directory {
    pub(crate) entries: Vec<RawEntry>,
    /// Bytes of the file.
    pub(crate) length: u64,
    /// More than one disk: a split or spanned archive.
    pub(crate) spanned: bool,
}

/// A directory larger than this is not one of an FMU.
const LARGEST_DIRECTORY: u64 = 256 << 20;

fn u16_at(b: &[u8], at: usize) -> u16 {
    b.get(at..at + 2).map_or(0, |s| u16::from_le_bytes([s[0], s[1]]))
}

fn u32_at(b: &[u8], at: usize) -> u32 {
    b.get(at..at + 4).map_or(0, |s| u32::from_le_bytes([s[0], s[1], s[2], s[3]]))
}

fn u64_at(b: &[u8], at: usize) -> u64 {
    u64::from(u32_at(b, at)) | u64::from(u32_at(b, at + 4)) << 32
}

fn read_at(file: &mut File, at: u64, length: u64) -> io::Result<Vec<u8>> {
    file.seek(SeekFrom::Start(at))?;
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads the central directory; `None` when the file has none.
pub(crate) fn read(file: &mut File) -> io::Result<Option<Directory>> {
    let length = file.seek(SeekFrom::End(0))?;
    let tail_at = length.saturating_sub(66_000);
    let tail = read_at(file, tail_at, 66_000)?;
    let Some(end) = (0..tail.len().saturating_sub(21)).rev().find(|&i| tail[i..].starts_with(b"PK\x05\x06"))
    else {
        return Ok(None);
    };
    let e = &tail[end..];
    let (mut count, mut size, mut offset) =
        (u64::from(u16_at(e, 10)), u64::from(u32_at(e, 12)), u64::from(u32_at(e, 16)));
    // 0xFFFF refers to the zip64 record and is not a disk number.
    let spanned = [u16_at(e, 4), u16_at(e, 6)].iter().any(|&d| d != 0 && d != u16::MAX);
    let mut directory_end = tail_at + end as u64;
    if let Some(locator) = end.checked_sub(20).map(|i| &tail[i..]).filter(|l| l.starts_with(b"PK\x06\x07")) {
        let record = read_at(file, u64_at(locator, 8), 56)?;
        if record.starts_with(b"PK\x06\x06") {
            (count, size, offset) = (u64_at(&record, 32), u64_at(&record, 40), u64_at(&record, 48));
            directory_end = u64_at(locator, 8);
        }
    }
    // Other data may precede the archive; then all offsets are too small by its length.
    let shift = directory_end.saturating_sub(size).saturating_sub(offset);
    let bytes = read_at(file, offset.saturating_add(shift), size.min(LARGEST_DIRECTORY))?;
    let mut entries = Vec::new();
    let mut at = 0;
    while entries.len() as u64 != count && bytes.get(at..).is_some_and(|b| b.starts_with(b"PK\x01\x02")) {
        let b = &bytes[at..];
        let (name, extra, comment) = (u16_at(b, 28) as usize, u16_at(b, 30) as usize, u16_at(b, 32) as usize);
        let Some(raw_name) = b.get(46..46 + name) else { break };
        let mut entry = RawEntry {
            name: raw_name.to_vec(),
            local_name: None,
            version_needed: u16_at(b, 6),
            flags: u16_at(b, 8),
            method: u16_at(b, 10),
            compressed: u64::from(u32_at(b, 20)),
            size: u64::from(u32_at(b, 24)),
            made_by: u16_at(b, 4),
            external: u32_at(b, 38),
        };
        let mut local = u64::from(u32_at(b, 42));
        widen(b.get(46 + name..46 + name + extra).unwrap_or_default(), &mut entry, &mut local);
        let head = read_at(file, local.saturating_add(shift), 30)?;
        if head.starts_with(b"PK\x03\x04") {
            let name_at = local.saturating_add(shift).saturating_add(30);
            entry.local_name = Some(read_at(file, name_at, u64::from(u16_at(&head, 26)))?);
        }
        entries.push(entry);
        at += 46 + name + extra + comment;
    }
    Ok(Some(Directory { entries, length, spanned }))
}

/// Takes the 64-bit sizes from the zip64 extra field, where the 32-bit fields are saturated (APPNOTE 4.5.3).
fn widen(mut extra: &[u8], entry: &mut RawEntry, local: &mut u64) {
    while extra.len() >= 4 {
        let (id, length) = (u16_at(extra, 0), u16_at(extra, 2) as usize);
        let Some(body) = extra.get(4..4 + length) else { return };
        if id == 1 {
            let mut at = 0;
            for field in [&mut entry.size, &mut entry.compressed, local] {
                if *field == u64::from(u32::MAX) {
                    *field = u64_at(body, at);
                    at += 8;
                }
            }
        }
        extra = &extra[4 + length..];
    }
}
