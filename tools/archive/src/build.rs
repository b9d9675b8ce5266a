//! Packs a model into an FMU archive, the same bytes at every run.

mod error;
pub use error::BuildError;

use crate::metadata::{self, MadeOf};
use crate::native::Native;
pub use crate::platform::{HERE, Library, Platform, library_path};
use crate::{documentation, object_file, reference, terminals};
use describe::{
    Dependencies, Experiment, ModelType, Preset, Resources, StartValues, fmi2, fmi3, start_values,
};
use rayon::prelude::*;
use std::fs;
use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};
pub use terms::load::{FILE_NAME as LOAD_FILE, LoadFile};
pub use terms::{FILE_NAME as EFFECTS_FILE, TermText, TermsError, TermsFile, of_resources};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

/// Sources and licences of the gait data in the library.
const GAIT_DATA: &str = concat!(
    include_str!("../../../fmu-src/physics/data/gait-walking-stairs-cc0/SOURCE.md"),
    "\n",
    include_str!("../../../fmu-src/physics/data/gait-schwartz2008/SOURCE.md"),
);
/// Whose work is compiled into the library, and its licences: written by `cargo xtask licenses`.
const THIRD_PARTY: &str = include_str!("../assets/third-party.txt");
const ICON_SVG: &[u8] = include_bytes!("../assets/icon.svg");
/// The same, rendered.
const ICON_PNG: &[u8] = include_bytes!("../assets/icon.png");

/// The variable that selects the load table, and its item.
pub const LOAD_ACTIVITY: (&str, &str) = ("gait.activity", "table");

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

/// Additional content of an archive.
#[derive(Clone, Copy, Debug, Default)]
pub struct Contents<'a> {
    /// Start values and default experiment.
    pub preset: Option<&'a Preset>,
    /// Terms that are data.
    pub effects: Option<&'a TermsFile>,
    /// Load table; it is the activity at the start.
    pub load: Option<&'a LoadFile>,
}

/// Writes `<out>/<standard>/<Model>.fmu` and gives its path.
pub fn build(
    kind: &ModelType,
    standard: Standard,
    contents: Contents<'_>,
    library: &Path,
    out: &Path,
) -> Result<PathBuf, BuildError> {
    build_all(kind, &[standard], contents, &[Library::here(library)], out).map(|mut paths| paths.remove(0))
}

/// `<out>/<standard>/<Model>.fmu`.
pub fn archive_path(out: &Path, standard: Standard, model: &str) -> PathBuf {
    out.join(standard.folder()).join(format!("{model}.fmu"))
}

/// The same for several standards, in their order, with a library for each of several platforms; what all need is found once.
pub fn build_all(
    kind: &ModelType,
    standards: &[Standard],
    contents: Contents<'_>,
    libraries: &[Library],
    out: &Path,
) -> Result<Vec<PathBuf>, BuildError> {
    let name = (kind.declaration)().name;
    if let Some(preset) = contents.preset.filter(|p| p.model != name) {
        return Err(BuildError(format!("preset {} is for {} and not for {name}", preset.name, preset.model)));
    }
    let mut starts = contents.preset.map(|p| p.starts.clone()).unwrap_or_default();
    let resources = resources(kind, contents)?;
    if resources.load.is_some() {
        select_table(kind, &mut starts);
    }
    let given = contents.preset.and_then(|p| p.experiment);
    let (starts, experiment) = describe::experiment::of(kind, &starts, &resources, given);
    let binaries =
        libraries.par_iter().map(|library| binary(library, &starts)).collect::<Result<Vec<_>, _>>()?;
    let native = Native { kind, starts: &starts, resources: &resources };
    let (found, common) =
        rayon::join(|| Dependencies::of(kind, &resources, &starts), || common(&native, contents));
    let write = |standard: &Standard| {
        let path = archive_path(out, *standard, name);
        let bytes = pack(&entries(&native, *standard, &found, experiment, &binaries, &common));
        let written = bytes.and_then(|bytes| {
            fs::create_dir_all(path.parent().unwrap_or(out))?;
            fs::write(&path, bytes)
        });
        match written {
            Ok(()) => Ok(path),
            Err(error) => Err(BuildError(format!("{} cannot be written: {error}", path.display()))),
        }
    };
    standards.par_iter().map(write).collect()
}

/// The data of an archive, where the model takes them.
fn resources(kind: &ModelType, contents: Contents<'_>) -> Result<Resources, BuildError> {
    let declaration = (kind.declaration)();
    let name = declaration.name;
    let terms = contents.effects.map_or(Ok(Vec::new()), TermsFile::terms)?;
    let model = (kind.new)();
    for (term, text) in terms.iter().zip(contents.effects.into_iter().flat_map(|file| &file.terms)) {
        if let Some(why) = model.refusal(term) {
            let port = term.port.name();
            let what =
                if text.name.is_empty() { format!("at port {port}") } else { format!("\"{}\"", text.name) };
            return Err(BuildError(format!("{EFFECTS_FILE}: {name} does not take the term {what}: {why}")));
        }
    }
    let load = contents.load.map(LoadFile::table).transpose()?;
    if let Some(table) = &load
        && !(kind.new)().set_load(table)
    {
        return Err(BuildError(format!("{name} has no use for a load table; GaitLoad has")));
    }
    Ok(Resources { terms, load })
}

/// The activity of an archive with a load table is that table.
fn select_table(kind: &ModelType, starts: &mut StartValues) {
    let (name, item) = LOAD_ACTIVITY;
    if let Some(entry) = (kind.declaration)().by_name(name)
        && let Ok(value) = describe::preset::from_text(entry, item, false)
    {
        starts.set(entry, value);
    }
}

/// A library with the start values in it, for its platform and no other. It is compressed here, once for the archives of all standards.
fn binary(library: &Library, starts: &StartValues) -> Result<(Platform, Vec<u8>), BuildError> {
    let (path, platform) = (library.path.display(), library.platform.tuple);
    let mut binary = fs::read(&library.path).map_err(|error| BuildError::library(&library.path, &error))?;
    if let Some(found) = object_file::platform(&binary).filter(|found| found != platform) {
        return Err(BuildError(format!("the library {path} is for {found} and not for {platform}")));
    }
    // Further exports may meet other libraries' names in an importer.
    let names = object_file::foreign_exports(&binary).join(", ");
    if !names.is_empty() {
        return Err(BuildError(format!("the library {path} exports {names} beside the functions of FMI")));
    }
    start_values::patch(&mut binary, &starts.entries())
        .map_err(|error| BuildError(format!("the FMU library {path} does not fit this tool: {error}")))?;
    let alone = [File { name: String::new(), content: Content::Executable(&binary) }];
    let compressed =
        pack(&alone).map_err(|e| BuildError(format!("the library {path} cannot be packed: {e}")))?;
    Ok((library.platform, compressed))
}

/// A file of the archive.
struct File<'a> {
    name: String,
    content: Content<'a>,
}

enum Content<'a> {
    Plain(Vec<u8>),
    Executable(&'a [u8]),
    /// The only file of another archive.
    Packed(&'a [u8]),
}

fn file<'a>(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> File<'a> {
    File { name: name.into(), content: Content::Plain(bytes.into()) }
}

/// Common content of the archives of both standards.
fn common(native: &Native<'_>, contents: Contents<'_>) -> Vec<(String, Vec<u8>)> {
    let name = (native.kind.declaration)().name;
    let page = documentation::page(native, contents.preset);
    let mut files = vec![("documentation/index.html".to_string(), page.into_bytes())];
    let made_of = MadeOf {
        preset: contents.preset,
        terms: contents.effects.map(|effects| effects.terms.len()),
        load: contents.load.map(|load| load.source.as_str()),
    };
    files.push((metadata::FILE.to_owned(), metadata::document(native, made_of).into_bytes()));
    if let Some(run) = reference::run(native) {
        let [inputs, results] = reference::file_names(name);
        let entry = |file: &str, text: String| (format!("{}/{file}", reference::FOLDER), text.into_bytes());
        files.extend([
            entry("fmi-ls-manifest.xml", reference::manifest(name)),
            entry(&inputs, run.inputs),
            entry(&results, run.results),
        ]);
    }
    let effects = |file: &TermsFile| (format!("resources/{EFFECTS_FILE}"), file.text().into_bytes());
    files.extend(contents.effects.map(effects));
    let load = |file: &LoadFile| (format!("resources/{LOAD_FILE}"), file.text().into_bytes());
    files.extend(contents.load.map(load));
    files
}

fn entries<'a>(
    native: &Native<'_>,
    standard: Standard,
    found: &Dependencies,
    experiment: Experiment,
    binaries: &'a [(Platform, Vec<u8>)],
    common: &[(String, Vec<u8>)],
) -> Vec<File<'a>> {
    let (declaration, starts, resources) = ((native.kind.declaration)(), native.starts, native.resources);
    let name = declaration.name;
    let description = match standard {
        Standard::Fmi2 => fmi2::model_description(declaration, starts, resources, found, experiment),
        Standard::Fmi3 => fmi3::model_description(declaration, starts, resources, found, experiment),
    };
    let licenses = "documentation/licenses";
    let mut files = vec![file("modelDescription.xml", description)];
    for (platform, packed) in binaries {
        let folder = if standard == Standard::Fmi2 { platform.fmi2 } else { platform.tuple };
        let name = format!("binaries/{folder}/{name}.{}", platform.ending);
        files.push(File { name, content: Content::Packed(packed) });
    }
    files.push(file(format!("{licenses}/license.txt"), include_str!("../../../LICENSE")));
    files.push(file(format!("{licenses}/third-party.txt"), THIRD_PARTY));
    files.push(file(format!("{licenses}/gait-data.txt"), GAIT_DATA));
    if standard == Standard::Fmi2 {
        files.push(file("model.png", ICON_PNG));
    }
    // FMI 2.0.4 and later take the folder over from FMI 3.0 (FMI 2.0.5 section 2.3).
    let entry = |name: &str, bytes: &[u8]| file(format!("{}/{name}", terminals::FOLDER), bytes);
    files.extend([
        entry("terminalsAndIcons.xml", terminals::document(declaration).as_bytes()),
        entry("icon.png", ICON_PNG),
        entry("icon.svg", ICON_SVG),
    ]);
    files.extend(common.iter().map(|(name, bytes)| file(name.as_str(), bytes.as_slice())));
    files
}

/// The archive's bytes: entries in the given order, no dates, fixed permissions.
fn pack(files: &[File]) -> io::Result<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for file in files {
        let (bytes, permissions) = match &file.content {
            Content::Plain(bytes) => (bytes.as_slice(), 0o644),
            Content::Executable(bytes) => (*bytes, 0o755),
            Content::Packed(archive) => {
                let mut archive = ZipArchive::new(Cursor::new(*archive))?;
                zip.raw_copy_file_rename(archive.by_index_raw(0)?, file.name.as_str())?;
                continue;
            }
        };
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(6))
            .last_modified_time(DateTime::default())
            .unix_permissions(permissions);
        zip.start_file(file.name.as_str(), options)?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}

#[cfg(test)]
mod tests;
