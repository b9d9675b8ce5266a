//! Values that the user sets on an FMU although they have no effect in the selected modes.
//!
//! An FMU of ours is recognised by its token, which selects the model; the native model with the archive's start values and resources
//! answers.

use ::study::bench::Bench;
use archive::build::of_resources;
use cosim::{Archive, ModelDescription};
use describe::usage::{self, Scope};
use describe::{Entry, models};

/// Why one of the settings names a variable that an FMU of ours does not serve; `None` where there is none. `prefix` comes before
/// its name.
pub fn unserved(prefix: &str, description: &ModelDescription, sets: &[(String, String)]) -> Option<String> {
    let declaration = (models::by_token(&description.token)?.declaration)();
    sets.iter().find_map(|(name, _)| declaration.unserved(name.strip_prefix(prefix)?))
}

/// A sentence about the settings `sets` and the columns `inputs` that have no effect; `None` where all have one or nothing is
/// known of the FMU.
pub fn note<'a>(
    archive: &Archive,
    sets: &'a [(String, String)],
    inputs: impl Iterator<Item = &'a str>,
) -> Option<String> {
    let description = archive.description();
    let declaration = (models::by_token(&description.token)?.declaration)();
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
    if let Ok(resources) = of_resources(&archive.dir().join("resources")) {
        resources.give(model.as_mut());
    }
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
