//! An FMU file: a zip archive that is checked, unpacked into a temporary directory and described.
use crate::{Error, FmiVersion, Interface, ModelDescription};
use std::env::consts::{ARCH, OS};
use std::fs;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use tempfile::TempDir;
use zip::ZipArchive;

/// Entries that an archive may have.
const MAX_ENTRIES: usize = 100_000;
/// Bytes that any archive may unpack to ...
const ALWAYS_ALLOWED: u64 = 256 << 20;
/// ... that one may unpack to for each byte it has ...
const MAX_RATIO: u64 = 100;
/// ... and that none may exceed.
const NEVER_ALLOWED: u64 = 4 << 30;

/// An opened FMU. The unpacked files exist until the archive and all its instances are dropped.
#[derive(Clone, Debug)]
pub struct Archive {
    path: PathBuf,
    dir: Arc<TempDir>,
    description: ModelDescription,
}

impl Archive {
    /// Reads, checks and unpacks the FMU at `path`.
    ///
    /// # Errors
    /// A missing file; no zip, or a damaged one; names that would leave the directory; absurd sizes; no
    /// `modelDescription.xml`, or one that [`ModelDescription::parse`] refuses.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let dir = unpacked(path)?;
        let xml = match fs::read(dir.path().join("modelDescription.xml")) {
            Ok(bytes) => match crate::xml::decode(&bytes) {
                Ok((text, _)) => text.into_owned(),
                Err(line) => {
                    let what = "is not text of the declared encoding";
                    return Err(bad(path, format!("its modelDescription.xml, line {line}, {what}")));
                }
            },
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                return Err(bad(path, "it has no modelDescription.xml"));
            }
            Err(e) => return Err(Error::io("open", path)(e)),
        };
        let description = ModelDescription::parse(&xml).map_err(|e| match e {
            Error::Text { file, line, message } => {
                Error::Text { file: format!("{}: {file}", path.display()), line, message }
            }
            other => other,
        })?;
        Ok(Self { path: path.to_owned(), dir: Arc::new(dir), description })
    }

    /// The file that was opened.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The directory that holds the unpacked files.
    pub fn dir(&self) -> &Path {
        self.dir.path()
    }

    /// The content of `modelDescription.xml`.
    pub fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// The platforms that have a directory below `binaries`, sorted.
    pub fn platforms(&self) -> Vec<String> {
        let Ok(entries) = fs::read_dir(self.dir().join("binaries")) else { return Vec::new() };
        let directories = entries.flatten().filter(|e| e.path().is_dir());
        let mut names: Vec<String> =
            directories.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// The binary of one interface for this platform.
    pub(crate) fn binary_of(&self, interface: &Interface) -> Result<PathBuf, Error> {
        let version = self.description.fmi_version;
        let Some((platform, extension)) = platform(version) else {
            let reason = format!("cannot run here: FMI {version} has no name for the platform {ARCH}-{OS}");
            return Err(self.unsupported(reason));
        };
        let relative: PathBuf =
            ["binaries", platform, &format!("{}.{extension}", interface.model_identifier)].iter().collect();
        let binary = self.dir().join(&relative);
        if binary.is_file() {
            return Ok(binary);
        }
        let present = self.platforms();
        let present = if present.is_empty() { "none at all".to_owned() } else { present.join(", ") };
        let wanted = relative.display();
        Err(self.unsupported(format!("has no binary {wanted} for this platform, it has {present}")))
    }

    /// An error of this archive with a predicate.
    pub(crate) fn unsupported(&self, reason: impl Into<String>) -> Error {
        Error::unsupported(self.path.display(), reason)
    }

    /// A handle that keeps the unpacked files on disk.
    pub(crate) fn keep(&self) -> Arc<TempDir> {
        Arc::clone(&self.dir)
    }
}

/// A folder that is removed when it is dropped.
pub(crate) fn temporary_folder() -> Result<TempDir, Error> {
    let dir = tempfile::Builder::new().prefix("fmu-").tempdir();
    dir.map_err(Error::io("make a temporary folder (TMPDIR sets its place) in", &std::env::temp_dir()))
}

/// A directory with the content of the zip archive at `path`, checked as [`Archive::open`] says.
pub(crate) fn unpacked(path: &Path) -> Result<TempDir, Error> {
    let file = fs::File::open(path).map_err(Error::io("open", path))?;
    let meta = file.metadata().map_err(Error::io("open", path))?;
    if meta.is_dir() {
        return Err(bad(path, "it is a directory"));
    }
    let dir = temporary_folder()?;
    let limit = (meta.len().saturating_mul(MAX_RATIO)).clamp(ALWAYS_ALLOWED, NEVER_ALLOWED);
    unpack(path, file, dir.path(), limit)?;
    Ok(dir)
}

fn bad(path: &Path, reason: impl Into<String>) -> Error {
    Error::Archive { path: path.to_owned(), kind: "FMU", reason: reason.into() }
}

/// This machine's directory below `binaries` and its library extension.
fn platform(version: FmiVersion) -> Option<(&'static str, &'static str)> {
    Some(match (version, ARCH, OS) {
        (FmiVersion::V2, "x86_64", "linux") => ("linux64", "so"),
        (FmiVersion::V2, "x86", "linux") => ("linux32", "so"),
        (FmiVersion::V2, "x86_64", "windows") => ("win64", "dll"),
        (FmiVersion::V2, "x86", "windows") => ("win32", "dll"),
        (FmiVersion::V2, "x86_64" | "aarch64", "macos") => ("darwin64", "dylib"),
        (_, "x86_64", "linux") => ("x86_64-linux", "so"),
        (_, "x86", "linux") => ("x86-linux", "so"),
        // FMI 2.0 names no such platform; the name of FMI 3.0 is what tools use there, too.
        (_, "aarch64", "linux") => ("aarch64-linux", "so"),
        (_, "x86_64", "windows") => ("x86_64-windows", "dll"),
        (_, "x86", "windows") => ("x86-windows", "dll"),
        (_, "aarch64", "windows") => ("aarch64-windows", "dll"),
        (_, "x86_64", "macos") => ("x86_64-darwin", "dylib"),
        (_, "aarch64", "macos") => ("aarch64-darwin", "dylib"),
        _ => return None,
    })
}

/// Unpacks all entries of `file` into `dir`, writing `limit` bytes at most.
fn unpack(path: &Path, file: fs::File, dir: &Path, limit: u64) -> Result<(), Error> {
    let damaged = |e: zip::result::ZipError| bad(path, e.to_string());
    let mut bytes = io::BufReader::new(file);
    let begin = io::BufRead::fill_buf(&mut bytes).map_err(Error::io("read", path))?;
    let what = match begin {
        [] => "it is empty",
        [b'P', b'K', ..] => "it is a damaged or incomplete zip archive",
        _ => "it is not a zip archive",
    };
    // A zip archive may follow another content.
    let mut archive = ZipArchive::new(bytes).map_err(|_| bad(path, what))?;
    if archive.len() > MAX_ENTRIES {
        return Err(bad(path, format!("it has {} entries, the limit is {MAX_ENTRIES}", archive.len())));
    }
    let mut left = limit;
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(damaged)?;
        let name = entry.name().map_err(damaged)?.into_owned();
        check_name(path, &name)?;
        let target = dir.join(&name);
        let failed = Error::io("unpack", &target);
        if entry.is_dir() {
            fs::create_dir_all(&target).map_err(&failed)?;
            continue;
        }
        if let Some(parent) = target.parent() {
            fs::create_dir_all(parent).map_err(&failed)?;
        }
        // Symbolic links are never made: their target becomes the content of a plain file.
        let mut out = fs::File::create(&target).map_err(failed)?;
        // The limit applies to the unpacked bytes, not to the declared size.
        let mut bounded = (&mut entry).take(left + 1);
        let written =
            io::copy(&mut bounded, &mut out).map_err(|e| bad(path, format!("entry {name}: {e}")))?;
        if written > left {
            return Err(bad(path, format!("it unpacks to more than {} MiB", limit >> 20)));
        }
        left -= written;
    }
    Ok(())
}

/// Refuses names that could lead out of the directory, here or on another system.
fn check_name(path: &Path, name: &str) -> Result<(), Error> {
    let plain = Path::new(name).components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    let foreign = name.contains(['\\', '\0']) || name.as_bytes().get(1) == Some(&b':');
    if name.is_empty() || !plain || foreign {
        return Err(bad(path, format!("entry {name:?} is not a relative path with forward slashes")));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_lead_out_are_refused() {
        let refused = |name| check_name(Path::new("x.fmu"), name).is_err();
        for name in ["../x", "a/../../x", "/etc/x", "C:/x", "a\\..\\x", "", "a\0b"] {
            assert!(refused(name), "{name:?}");
        }
        for name in ["modelDescription.xml", "binaries/linux64/a.so", "a/..b", "a/"] {
            assert!(!refused(name), "{name:?}");
        }
    }

    #[test]
    fn what_is_no_archive_is_said() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("x.fmu");
        for (content, expected) in [
            (&b""[..], "it is empty"),
            (b"a text", "it is not a zip archive"),
            (b"PK\x03\x04", "it is a damaged or incomplete zip archive"),
        ] {
            fs::write(&path, content).unwrap();
            let message = Archive::open(&path).unwrap_err().to_string();
            assert!(
                message.ends_with(&format!("x.fmu is not a usable FMU archive: {expected}")),
                "{message}"
            );
        }
    }

    #[test]
    fn unpacking_stops_at_the_limit() {
        use std::io::Write;
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("bomb.fmu");
        let mut zip = zip::ZipWriter::new(fs::File::create(&path).unwrap());
        zip.start_file("big", zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(&vec![0; 5 << 20]).unwrap();
        zip.finish().unwrap();
        let out = dir.path().join("out");
        fs::create_dir(&out).unwrap();
        let open = || fs::File::open(&path).unwrap();
        let message = unpack(&path, open(), &out, 3 << 20).unwrap_err().to_string();
        assert!(message.ends_with("it unpacks to more than 3 MiB"), "{message}");
        assert!(unpack(&path, open(), &out, 5 << 20).is_ok());
    }
}
