//! `sources/buildDescription.xml`, after `fmi3BuildDescription.xsd`.

use super::fmi3_common::{ANNOTATED, ANNOTATIONS, NAME};
use super::types::Type;
use super::*;

const DESCRIPTION: &[Attribute] = &[optional("description", Type::Text)];

static SOURCE_FILE: Element = element("SourceFile", &[NAME], &ANNOTATED);
static OPTION: Element = element("Option", &[&[optional("value", Type::Text)], DESCRIPTION], &[]);
static PREPROCESSOR_DEFINITION: Element = element(
    "PreprocessorDefinition",
    &[NAME, &[optional("optional", Type::Boolean), optional("value", Type::Text)], DESCRIPTION],
    &[any_number(&[&OPTION]), maybe(&[&ANNOTATIONS])],
);
static INCLUDE_DIRECTORY: Element = element("IncludeDirectory", &[NAME], &ANNOTATED);
static SOURCE_FILE_SET: Element = element(
    "SourceFileSet",
    &[&[
        optional("name", Type::Text),
        optional("language", Type::Text),
        optional("compiler", Type::Text),
        optional("compilerOptions", Type::Text),
    ]],
    &[
        at_least_one(&[&SOURCE_FILE]),
        any_number(&[&PREPROCESSOR_DEFINITION]),
        any_number(&[&INCLUDE_DIRECTORY]),
        maybe(&[&ANNOTATIONS]),
    ],
);
static LIBRARY: Element = element(
    "Library",
    &[NAME, &[optional("version", Type::Text), optional("external", Type::Boolean)], DESCRIPTION],
    &ANNOTATED,
);
static BUILD_CONFIGURATION: Element = element(
    "BuildConfiguration",
    &[&[required("modelIdentifier", Type::Text), optional("platform", Type::Text)], DESCRIPTION],
    &[any_number(&[&SOURCE_FILE_SET]), any_number(&[&LIBRARY]), maybe(&[&ANNOTATIONS])],
);

/// The root element.
pub(crate) static BUILD_DESCRIPTION: Element = element(
    "fmiBuildDescription",
    &[&[required("fmiVersion", Type::Version3)]],
    &[at_least_one(&[&BUILD_CONFIGURATION]), maybe(&[&ANNOTATIONS])],
);
