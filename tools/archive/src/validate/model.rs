//! The model description as the semantic rules need it: the elements that `cosim` reads, with their lines.
//!
//! What cannot be read is `None` there, because the schema rules have already reported it.

use super::finding::{Findings, short};
use super::rules;
use super::xml::Xml;
pub(crate) use cosim::elements::{Model, Unknown, Variable};
pub(crate) use cosim::xml::{children, double, is_true, unsigned, unsigned_list};
pub(crate) use cosim::{FmiVersion, Kind};

/// Another file of the archive must be of the model description's version.
pub(crate) fn check_version_of(model: &Model, other: &Xml, out: &mut Findings) {
    let root = other.root();
    let (here, there) = (root.attribute("fmiVersion"), model.root.attribute("fmiVersion"));
    if model.version == FmiVersion::V3 && here.is_some() && here != there {
        out.add(
            other.place(root),
            rules::version_mismatch(short(here.unwrap_or_default()), short(there.unwrap_or_default())),
        );
    }
}
