//! The generated files of `model-description/`: their text, and a check that they are up to date.

use crate::preset::StartValues;
use crate::{Dependencies, Resources, experiment};
use crate::{fmi2, fmi3, lock, markdown};
use physics::model::ModelType;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A reason why the files cannot be generated.
#[derive(Debug, thiserror::Error)]
pub enum GenerateError {
    /// Declarations that contradict the lock.
    #[error(transparent)]
    Lock(#[from] lock::LockError),
    /// A file cannot be written.
    #[error("{path} cannot be written: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
}

/// How the dependencies of a model are determined: [`Dependencies::of_all`], or [`Dependencies::sampled`] in less time.
pub type Determine = fn(&ModelType) -> Dependencies;

/// Every generated file below `folder`: path and text.
pub fn files(folder: &Path, determine: Determine) -> Result<Vec<(PathBuf, String)>, GenerateError> {
    let mut files = Vec::new();
    for kind in physics::models::ALL {
        let declaration = (kind.declaration)();
        let home = folder.join(declaration.name);
        let found = determine(kind);
        let resources = Resources::default();
        let (starts, experiment) = experiment::of(kind, &StartValues::default(), &resources, None);
        let two = fmi2::model_description(declaration, &starts, &resources, &found, experiment);
        let three = fmi3::model_description(declaration, &starts, &resources, &found, experiment);
        files.extend([(home.join("fmi2.xml"), two), (home.join("fmi3.xml"), three)]);
        files.push((home.join("parameters.md"), markdown::parameters(kind, &starts)));
        files.push((home.join("dependencies.toml"), found.text(declaration)));
    }
    let declarations: Vec<_> = physics::models::ALL.iter().map(|m| (m.declaration)()).collect();
    let path = folder.join("value-references.lock");
    let old = fs::read_to_string(&path).unwrap_or_default();
    files.push((path, lock::update(&old, &declarations)?));
    Ok(files)
}

/// The files that are out of date.
pub fn stale(folder: &Path, determine: Determine) -> Result<Vec<PathBuf>, GenerateError> {
    let differs = |(path, text): &(PathBuf, String)| fs::read_to_string(path).ok().as_ref() != Some(text);
    Ok(files(folder, determine)?.into_iter().filter(differs).map(|(path, _)| path).collect())
}

/// Writes all files.
pub fn write(folder: &Path, determine: Determine) -> Result<(), GenerateError> {
    for (path, text) in files(folder, determine)? {
        let home = path.parent().unwrap_or(folder);
        fs::create_dir_all(home)
            .and_then(|()| fs::write(&path, text))
            .map_err(|source| GenerateError::Write { path, source })?;
    }
    Ok(())
}
