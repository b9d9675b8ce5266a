//! Attributes and annotations that all files of FMI 3.0 have in common, after `fmi3Annotation.xsd`.

use super::types::Type;
use super::*;

pub(super) const NAME: &[Attribute] = &[required("name", Type::Text)];
pub(super) const NAME_AND_DESCRIPTION: &[Attribute] =
    &[required("name", Type::Text), optional("description", Type::Text)];

static ANNOTATION: Element = Element {
    name: "Annotation",
    attributes: &[&[required("type", Type::Text)]],
    any_attribute: false,
    content: Content::Any(UNBOUNDED),
};
/// Everything may be annotated.
pub(super) static ANNOTATIONS: Element = element("Annotations", &[], &[at_least_one(&[&ANNOTATION])]);
pub(super) static ANNOTATED: [Slot; 1] = [maybe(&[&ANNOTATIONS])];
