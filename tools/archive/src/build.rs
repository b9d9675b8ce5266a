//! Packs a model into an FMU archive, the same bytes at every run.

use crate::documentation;
use describe::{Dependencies, ModelType, Preset, StartValues, fmi2, fmi3, start_values};
use std::fs;
use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};
pub use terms::{TermText, TermsError, TermsFile};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Which standard an archive follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standard {
    /// FMI 2.0.
    Fmi2,
    /// FMI 3.0.
    Fmi3,
}

impl Standard {
    /// Both, in order.
    pub const ALL: [Standard; 2] = [Standard::Fmi2, Standard::Fmi3];

    /// Name of the folder in `dist`.
    pub fn folder(self) -> &'static str {
        match self {
            Standard::Fmi2 => "fmi2",
            Standard::Fmi3 => "fmi3",
        }
    }
}

/// A platform that the library can be for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// Its name in FMI 3, and for the user.
    pub tuple: &'static str,
    /// Its name in FMI 2.
    pub fmi2: &'static str,
    /// Ending of a library.
    pub ending: &'static str,
}

/// The platform that this tool runs on.
pub const HERE: Platform = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    Platform { tuple: "x86_64-linux", fmi2: "linux64", ending: "so" }
} else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
    Platform { tuple: "aarch64-linux", fmi2: "aarch64-linux", ending: "so" }
} else if cfg!(all(target_os = "windows", target_arch = "x86_64")) {
    Platform { tuple: "x86_64-windows", fmi2: "win64", ending: "dll" }
} else if cfg!(target_arch = "aarch64") {
    Platform { tuple: "aarch64-darwin", fmi2: "darwin64", ending: "dylib" }
} else {
    Platform { tuple: "x86_64-darwin", fmi2: "darwin64", ending: "dylib" }
};

/// Why an archive cannot be made: one sentence.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// The library is not where it should be.
    #[error(
        "the FMU library {path} cannot be read ({source}); `cargo build --release` puts it beside motor-fmu"
    )]
    Library {
        /// Where it was looked for.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The library does not take start values.
    #[error("the FMU library {path} does not fit this tool: {source}")]
    Patch {
        /// Which.
        path: PathBuf,
        /// Why.
        source: start_values::PatchError,
    },
    /// A preset for another model.
    #[error("preset {preset} is for {of} and not for {model}")]
    Preset {
        /// The preset.
        preset: String,
        /// Its model.
        of: String,
        /// The model that was asked for.
        model: &'static str,
    },
    /// Terms that do not hold.
    #[error(transparent)]
    Terms(#[from] TermsError),
    /// Terms for a model that carries none.
    #[error("{model} carries no terms, so it has no use for {}", terms::FILE_NAME)]
    NoTerms {
        /// The model.
        model: &'static str,
    },
    /// A file that cannot be written.
    #[error("{path} cannot be written: {source}")]
    Write {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// The FMU library beside the running program.
pub fn library_path() -> Result<PathBuf, BuildError> {
    let name = format!("{}motor_fmu.{}", std::env::consts::DLL_PREFIX, HERE.ending);
    match std::env::current_exe() {
        Ok(program) => Ok(program.with_file_name(name)),
        Err(source) => Err(BuildError::Library { path: PathBuf::from(name), source }),
    }
}

/// What is built into an archive beside the model.
#[derive(Clone, Copy, Debug, Default)]
pub struct Contents<'a> {
    /// Start values.
    pub preset: Option<&'a Preset>,
    /// Terms that are data.
    pub effects: Option<&'a TermsFile>,
}

/// Writes `<out>/<standard>/<Model>.fmu` and gives its path.
pub fn build(
    kind: &ModelType,
    standard: Standard,
    contents: Contents<'_>,
    library: &Path,
    out: &Path,
) -> Result<PathBuf, BuildError> {
    build_all(kind, &[standard], contents, library, out).map(|mut paths| paths.remove(0))
}

/// The same for several standards, in their order; what both need is found once.
pub fn build_all(
    kind: &ModelType,
    standards: &[Standard],
    contents: Contents<'_>,
    library: &Path,
    out: &Path,
) -> Result<Vec<PathBuf>, BuildError> {
    let name = (kind.declaration)().name;
    if let Some(preset) = contents.preset.filter(|p| p.model != name) {
        return Err(BuildError::Preset {
            preset: preset.name.clone(),
            of: preset.model.clone(),
            model: name,
        });
    }
    let starts = contents.preset.map(|p| p.starts.clone()).unwrap_or_default();
    let terms = contents.effects.map_or(Ok(Vec::new()), TermsFile::terms)?;
    if !terms.is_empty() && !(kind.new)().set_terms(&terms) {
        return Err(BuildError::NoTerms { model: name });
    }
    let read = fs::read(library);
    let mut binary = read.map_err(|source| BuildError::Library { path: library.to_path_buf(), source })?;
    start_values::patch(&mut binary, &starts.entries())
        .map_err(|source| BuildError::Patch { path: library.to_path_buf(), source })?;
    let found = Dependencies::of(kind, &terms, &starts);
    let write = |standard: &Standard| {
        let path = out.join(standard.folder()).join(format!("{name}.fmu"));
        let bytes = pack(&entries(kind, *standard, &starts, contents, &found, binary.clone()));
        let written = bytes.and_then(|bytes| {
            fs::create_dir_all(path.parent().unwrap_or(out))?;
            fs::write(&path, bytes)
        });
        written.map_err(|source| BuildError::Write { path: path.clone(), source })?;
        Ok(path)
    };
    standards.iter().map(write).collect()
}

/// A file of the archive.
struct File {
    name: String,
    bytes: Vec<u8>,
    executable: bool,
}

fn entries(
    kind: &ModelType,
    standard: Standard,
    starts: &StartValues,
    contents: Contents<'_>,
    found: &Dependencies,
    binary: Vec<u8>,
) -> Vec<File> {
    let declaration = (kind.declaration)();
    let name = declaration.name;
    let plain = |name: &str, text: String| File {
        name: name.to_string(),
        bytes: text.into_bytes(),
        executable: false,
    };
    let (description, platform, license) = match standard {
        Standard::Fmi2 => {
            (fmi2::model_description(declaration, starts, found), HERE.fmi2, "licenses/license.txt")
        }
        Standard::Fmi3 => (
            fmi3::model_description(declaration, starts, found),
            HERE.tuple,
            "documentation/licenses/license.txt",
        ),
    };
    let mut files = vec![
        plain("modelDescription.xml", description),
        File { name: format!("binaries/{platform}/{name}.{}", HERE.ending), bytes: binary, executable: true },
        plain("documentation/index.html", documentation::page(kind, starts, contents.preset)),
        plain(license, include_str!("../../../LICENSE").to_string()),
    ];
    files.extend(contents.effects.map(|file| plain(&format!("resources/{}", terms::FILE_NAME), file.text())));
    files
}

/// The archive's bytes: entries in the given order, no dates, fixed permissions.
fn pack(files: &[File]) -> io::Result<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for file in files {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(6))
            .last_modified_time(DateTime::default())
            .unix_permissions(if file.executable { 0o755 } else { 0o644 });
        zip.start_file(file.name.as_str(), options)?;
        zip.write_all(&file.bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use describe::models;
    use std::io::Read;

    fn library(folder: &Path) -> PathBuf {
        let path = folder.join("library");
        let mut bytes = b"code ".to_vec();
        bytes.extend(start_values::empty());
        fs::write(&path, bytes).unwrap();
        path
    }

    #[test]
    fn the_same_input_gives_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let library = library(folder.path());
        for standard in Standard::ALL {
            let make = |out: &str| {
                let path =
                    build(&models::ALL[0], standard, Contents::default(), &library, &folder.path().join(out))
                        .unwrap();
                fs::read(path).unwrap()
            };
            assert_eq!(make("a"), make("b"));
        }
    }

    #[test]
    fn a_preset_reaches_the_xml_and_the_binary() {
        let folder = tempfile::tempdir().unwrap();
        let library = library(folder.path());
        let preset = Preset::load("maxon-305015").unwrap();
        let contents = Contents { preset: Some(&preset), ..Contents::default() };
        let path = build(&models::ALL[0], Standard::Fmi2, contents, &library, folder.path()).unwrap();
        let mut zip = zip::ZipArchive::new(fs::File::open(path).unwrap()).unwrap();
        let mut read = |name: &str| {
            let mut bytes = Vec::new();
            zip.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
            bytes
        };
        let xml = String::from_utf8(read("modelDescription.xml")).unwrap();
        assert!(xml.contains("start=\"0.00983\""), "tau_c of the preset is the start value");
        let binary = read(&format!("binaries/{}/AnnulusCooledMotor.{}", HERE.fmi2, HERE.ending));
        let block: [u8; start_values::SIZE] = binary[5..].try_into().unwrap();
        assert!(start_values::entries(&block).any(|entry| entry == (1000, 9.83e-3)));
    }

    #[test]
    fn effects_are_packed_and_checked() {
        let folder = tempfile::tempdir().unwrap();
        let library = library(folder.path());
        let term = r#"{"port": "drag_torque", "coefficient": 1e-3}"#;
        let text = |terms: &str| format!(r#"{{"format": "motor-fmu effects 1", "terms": [{terms}]}}"#);
        let mut file = TermsFile::parse(&text(term), "x.json").unwrap();
        let make = |file: &TermsFile| {
            let contents = Contents { effects: Some(file), ..Contents::default() };
            build(&models::ALL[0], Standard::Fmi3, contents, &library, folder.path())
        };
        let mut zip = zip::ZipArchive::new(fs::File::open(make(&file).unwrap()).unwrap()).unwrap();
        let mut packed = String::new();
        zip.by_name("resources/effects.json").unwrap().read_to_string(&mut packed).unwrap();
        assert_eq!(TermsFile::parse(&packed, "resources").unwrap(), file);
        file.terms[0].port = "nowhere".to_string();
        assert!(make(&file).unwrap_err().to_string().contains("nowhere"));
    }

    #[test]
    fn a_preset_for_another_model_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut preset = Preset::load("maxon-305015").unwrap();
        preset.model = "Other".to_string();
        let library = library(folder.path());
        let contents = Contents { preset: Some(&preset), ..Contents::default() };
        let error = build(&models::ALL[0], Standard::Fmi2, contents, &library, folder.path()).unwrap_err();
        assert_eq!(error.to_string(), "preset maxon-305015 is for Other and not for AnnulusCooledMotor");
    }

    #[test]
    fn a_missing_library_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("nothing.so");
        let error = build(&models::ALL[0], Standard::Fmi3, Contents::default(), &missing, folder.path())
            .unwrap_err()
            .to_string();
        assert!(error.contains("nothing.so") && error.contains("cargo build --release"), "{error}");
    }
}
