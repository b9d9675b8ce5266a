//! The rules that no schema can express, one file per theme.

mod aliases;
pub(crate) mod arrays;
mod clocks;
mod derivatives;
mod document;
mod initial_unknowns;
mod interfaces;
pub(super) mod names;
mod structure;
mod types;
mod unit_meaning;
mod units;
mod values;
mod variables;

use super::finding::{Findings, short};
use super::model::*;
use super::rules::{self, Rule};
use super::schema::types::Type;
use cosim::xml::{parse_double, parse_integer};
use roxmltree::Node;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Runs every semantic rule on a model description.
pub(crate) fn check(model: &Model, out: &mut Findings) {
    interfaces::check(model, out);
    document::check(model, out);
    names::check(model, out);
    units::check(model, out);
    types::check(model, out);
    variables::check(model, out);
    values::check(model, out);
    structure::check(model, out);
    derivatives::check(model, out);
    initial_unknowns::check(model, out);
    match model.version {
        FmiVersion::V2 => aliases::check(model, out),
        FmiVersion::V3 => {
            arrays::check(model, out);
            clocks::check(model, out);
        }
    }
}
