//! Values that the user sets on an FMU although they have no effect in the selected modes.
//!
//! An FMU of ours is recognised by its token, which is that of the variable table; the native model with the archive's start
//! values and terms answers.

use ::study::bench::Bench;
use archive::build::TermsFile;
use cosim::Archive;
use describe::usage::{self, Scope};
use describe::{Entry, Model, models};
use std::path::Path;

/// Folder and file of terms in an archive.
const TERMS: [&str; 2] = ["resources", "effects.json"];

/// A sentence about the settings `sets` and the columns `inputs` that have no effect; `None` where all have one or nothing is
/// known of the FMU.
pub fn note<'a>(
    archive: &Archive,
    sets: &'a [(String, String)],
    inputs: impl Iterator<Item = &'a str>,
) -> Option<String> {
    let description = archive.description();
    let is_this = |kind: &&describe::ModelType| (kind.declaration)().token == description.token;
    let declaration = (models::ALL.iter().find(is_this)?.declaration)();
    let mut bench = Bench::new(declaration.name, None).ok()?;
    for variable in &description.variables {
        if let Some(start) = &variable.start {
            // Start values of outputs and states are none that can be set.
            let _ = bench.set_text(&variable.name, start);
        }
    }
    for (name, text) in sets {
        bench.set_text(name, text).ok()?;
    }
    let mut model = bench.into_model();
    take_terms(model.as_mut(), archive.dir());
    let set: Vec<&str> = sets.iter().map(|(name, _)| name.as_str()).collect();
    let mut asked: Vec<&'static Entry> = Vec::new();
    for name in set.iter().copied().chain(inputs) {
        if let Some(entry) = declaration.by_name(name).filter(|e| asked.iter().all(|a| a.name != e.name)) {
            asked.push(entry);
        }
    }
    let found = usage::unused(model.as_ref(), &asked, Scope::Transient);
    let source =
        |entry: &Entry| if set.contains(&entry.name.as_str()) { "--set" } else { "--input" }.to_owned();
    let sentence = usage::sentence(&found, source)?;
    let settings = usage::other_modes(&found);
    Some(match settings.is_empty() {
        true => sentence,
        false => format!(
            "{sentence}; to use them: {}",
            settings.split(", ").map(|s| format!("--set {s}")).collect::<Vec<_>>().join(" ")
        ),
    })
}

/// The terms that the archive carries, where it carries any.
fn take_terms(model: &mut dyn Model, folder: &Path) {
    let path = TERMS.iter().fold(folder.to_path_buf(), |path, part| path.join(part));
    if let Ok(terms) = TermsFile::load(&path).and_then(|file| file.terms()) {
        model.set_terms(&terms);
    }
}
