//! The resource folder of an archive from the importer's URI or path.

use std::path::PathBuf;

/// The folder of an FMI 2 `fmuResourceLocation`, a URI of the scheme `file`. A plain path is accepted too, because importers
/// pass it. `None` for an empty text or another scheme.
pub fn of_uri(uri: &str) -> Option<PathBuf> {
    let Some(rest) = strip_scheme(uri) else {
        return if uri.contains("://") { None } else { of_path(uri) };
    };
    // file:///path, file://host/path or file:/path: the path starts at the slash after the host.
    let path = match rest.strip_prefix("//") {
        Some(with_host) => &with_host[with_host.find('/')?..],
        None => rest,
    };
    let path = decoded(path);
    // On Windows the drive follows the slash: /C:/folder.
    let bytes = path.as_bytes();
    let drive = bytes.len() > 2 && bytes[0] == b'/' && bytes[1].is_ascii_alphabetic() && bytes[2] == b':';
    of_path(if drive { &path[1..] } else { &path })
}

/// The folder of an FMI 3 `resourcePath`. `None` for an empty text.
pub fn of_path(path: &str) -> Option<PathBuf> {
    (!path.is_empty()).then(|| PathBuf::from(path))
}

/// The part after the scheme, which is case-insensitive.
fn strip_scheme(uri: &str) -> Option<&str> {
    let (scheme, rest) = uri.split_once(':')?;
    scheme.eq_ignore_ascii_case("file").then_some(rest)
}

/// The text with each %xx replaced by its byte; other text is unchanged.
fn decoded(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let byte = tail
            .get(..2)
            .filter(|_| first == b'%')
            .and_then(|digits| std::str::from_utf8(digits).ok())
            .and_then(|digits| u8::from_str_radix(digits, 16).ok());
        bytes.push(byte.unwrap_or(first));
        rest = if byte.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
