//! The text of a file: encoding, byte order mark, ends of lines, and bytes that are no text.

use crate::Fault;
use encoding_rs::{Encoding, UTF_8, WINDOWS_1252};
use std::borrow::Cow;
use std::path::Path;
use std::{fs, io};

/// The text of a file in any of these encodings, without its byte order mark: of a TOML file, too.
///
/// # Errors
/// A file that cannot be read, or one that is no text.
pub fn read_text(path: &Path) -> io::Result<String> {
    let text = decoded(&fs::read(path)?).into_owned();
    match text.contains('\0') {
        true => Err(io::Error::new(
            io::ErrorKind::InvalidData,
            "the file is not text in UTF-8, UTF-16 with a byte order mark or Windows-1252",
        )),
        false => Ok(text),
    }
}

/// The folder to which file names in the text of a file are relative: its own, or the present one where the text comes from a pipe
/// (`/dev/stdin`, a process substitution of the shell).
pub fn folder(path: &Path) -> &Path {
    let is_pipe = fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir());
    path.parent().filter(|_| !is_pipe).unwrap_or(Path::new(""))
}

/// The text of a table, with the ends of lines of Unix if it has those of old Macs.
pub(crate) fn of_table(bytes: &[u8]) -> String {
    let text = decoded(bytes).into_owned();
    if text.contains('\n') { text } else { text.replace('\r', "\n") }
}

/// The text of the bytes of a file.
fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    match Encoding::for_bom(bytes) {
        Some((encoding, mark)) => encoding.decode_without_bom_handling(&bytes[mark..]).0,
        None => UTF_8
            .decode_without_bom_handling_and_without_replacement(bytes)
            .unwrap_or_else(|| WINDOWS_1252.decode_without_bom_handling(bytes).0),
    }
}

/// A fault if the text has NUL bytes.
pub(crate) fn check(text: &str) -> Result<(), Fault> {
    let Some(first) = text.find('\0') else { return Ok(()) };
    let before = &text[..first];
    let is_control = |c: char| c.is_control() && !matches!(c, '\t' | '\n' | '\r' | '\u{c}');
    Err(if before.contains('\n') && !before.contains(is_control) {
        let message =
            "the line has NUL bytes, as after an interruption of the logger: delete them".to_owned();
        Fault { line: line_at(text, first), message }
    } else {
        Fault { line: 1, message: "the file is not text; a spreadsheet must be saved as CSV".to_owned() }
    })
}

/// Removes NUL bytes at the end of the text, which a logger leaves that was interrupted, and the row that it did not complete. The
/// result says so.
pub(crate) fn remove_tail(text: &mut String) -> Option<Fault> {
    let first = text.find('\0')?;
    let only_nul = text[first..].chars().all(|c| c == '\0' || c.is_whitespace());
    if !only_nul || check(text).is_err_and(|fault| fault.line == 1) {
        return None;
    }
    let line = line_at(text, first);
    let end = text[..first].rfind('\n').map_or(0, |at| at + 1);
    let row = if text[end..first].trim().is_empty() { "" } else { " and the incomplete row before them" };
    text.truncate(end);
    let message =
        format!("NUL bytes at the end of the file{row} are skipped, as an interrupted logger leaves them");
    Some(Fault { line, message })
}

/// Number of the line at a byte, from 1.
pub(crate) fn line_at(text: &str, byte: usize) -> u64 {
    1 + text.as_bytes()[..byte].iter().filter(|b| **b == b'\n').count() as u64
}
