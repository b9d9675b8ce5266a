//! Checks at instantiation that model description, library and resources belong to one archive.
//!
//! The token has a fingerprint of the archive's contents ([`physics::token`]). Terms and a load table may be added or replaced without a
//! compiler; only their absence is refused, because the FMU would then silently compute the results of another model.

use crate::instance::Standard;
use crate::refusal::{Outcome, Refused};
use crate::resources::Location;
use physics::model::ModelType;
use physics::models;
use physics::resources::Resources;
use physics::token::{Contents, Token};

/// The model that the token selects, and the archive's contents according to the token.
///
/// # Errors
/// A token of no model of this library, or of an archive with other start values than those in this library.
pub fn selected(token: Option<&str>) -> Outcome<(&'static ModelType, Contents)> {
    let text = token.unwrap_or("NULL");
    let found = token.and_then(|token| Some((models::by_token(token)?, Token::parse(token)?)));
    let Some((kind, token)) = found else {
        let known: Vec<&str> = models::ALL.iter().map(|m| (m.declaration)().name).collect();
        return Err(Refused::error(format!(
            "the token {text} is not known to this library, which has the models {}; modelDescription.xml is from another build.",
            known.join(", ")
        )));
    };
    let declaration = (kind.declaration)();
    let contents = token.contents(declaration.token);
    if contents.starts != Resources::default().contents(crate::start_values()).starts {
        return Err(Refused::error(format!(
            "{}: the token {text} of modelDescription.xml is that of other start values than those in this library; \
             modelDescription.xml and library are of different builds, for example of different presets.",
            declaration.name
        )));
    }
    Ok((kind, contents))
}

/// Refuses resources without data that the archive was built with.
///
/// # Errors
/// Missing terms or a missing load table, with the cause.
pub fn check(
    kind: &ModelType,
    contents: Contents,
    resources: &Resources,
    location: &Location,
    standard: Standard,
) -> Outcome {
    let terms = contents.terms != 0 && resources.terms.is_empty();
    let load = contents.load != 0 && resources.load.is_none();
    let missing = [(terms, "terms", terms::FILE_NAME), (load, "load table", terms::load::FILE_NAME)];
    match missing.into_iter().find(|(is_missing, ..)| *is_missing) {
        None => Ok(()),
        Some((_, what, file)) => Err(Refused::error(format!(
            "{} was built with the {what} of resources/{file}, but {}; without the {what} the results would be those of another model.",
            (kind.declaration)().name,
            location.without(file, standard)
        ))),
    }
}
