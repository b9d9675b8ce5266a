//! The resource folder of an archive from the importer's URI or path.

use crate::instance::Standard;
use std::path::PathBuf;

/// Where the resources of the archive are.
#[derive(Clone, Debug, Default)]
pub struct Location {
    /// Text from the importer; `None` for NULL.
    given: Option<String>,
    /// The folder of this text, which may not exist.
    pub folder: Option<PathBuf>,
}

impl Location {
    /// The location in the importer's text, which `locate` converts to a folder.
    pub fn new(given: Option<&str>, locate: fn(&str) -> Option<PathBuf>) -> Location {
        Location { given: given.map(str::to_owned), folder: given.and_then(locate) }
    }

    /// Why there are no data of this file: the second half of a sentence.
    pub fn without(&self, file: &str, standard: Standard) -> String {
        let Some(given) = &self.given else {
            return "the importer passed no resource location (NULL)".to_owned();
        };
        if given.is_empty() {
            return "the importer passed an empty resource location".to_owned();
        }
        match &self.folder {
            None => format!("the resource location {given} is not a file URI with a path"),
            Some(folder) if folder.join(file).exists() => {
                format!("{} contains none", folder.join(file).display())
            }
            Some(folder) if folder.is_dir() => {
                format!("the resource folder {} has no {file}", folder.display())
            }
            Some(_) if standard == Standard::Three && strip_scheme(given).is_some() => {
                format!("the resource location {given} is a URI, and FMI 3 requires a path")
            }
            Some(folder) => format!("the resource folder {} does not exist", folder.display()),
        }
    }
}

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
