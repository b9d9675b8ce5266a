//! The FMI 3.0 model description of a model.
//!
//! Elements of one declaration are one array with the value reference of the first; the parameter that gives the size is
//! structural.

use crate::preset::StartValues;
use crate::xml::{self, Xml, element, empty, list};
use crate::{Dependencies, Experiment, Resources, Unknown};
use physics::declare::{Elements, Kind};
use physics::model::{Declaration, Entry, Slot, TIME};
use std::io;

const CAN_EXCHANGE: &[&str] = &[
    "canGetAndSetFMUState",
    "canSerializeFMUState",
    "providesDirectionalDerivatives",
    "providesAdjointDerivatives",
];

const CAN: &[&str] = &[
    "canGetAndSetFMUState",
    "canSerializeFMUState",
    "canHandleVariableCommunicationStepSize",
    "providesDirectionalDerivatives",
    "providesAdjointDerivatives",
    "providesIntermediateUpdate",
    "mightReturnEarlyFromDoStep",
    "canReturnEarlyAfterIntermediateUpdate",
    "hasEventMode",
];

/// The text of modelDescription.xml of an archive with these start values, resources, dependencies and default experiment.
pub fn model_description(
    declaration: &'static Declaration,
    starts: &StartValues,
    resources: &Resources,
    found: &Dependencies,
    experiment: Experiment,
) -> String {
    let token = crate::token(declaration, starts, resources);
    let root = xml::root("3.0", ("instantiationToken", token), declaration);
    xml::document("fmiModelDescription", &root, |xml| {
        xml::preamble(xml, declaration, [CAN_EXCHANGE, CAN], experiment, |xml, attributes, items| {
            element(xml, "EnumerationType", attributes, items)
        })?;
        element(xml, "ModelVariables", &vec![], |xml| {
            let time = [xml::time_attributes(), vec![("unit", "s".to_string())]].concat();
            empty(xml, "Float64", &time)?;
            let listed = declaration.entries.iter().filter(|entry| is_first(entry));
            listed.into_iter().try_for_each(|entry| variable(xml, declaration, entry, starts))
        })?;
        element(xml, "ModelStructure", &vec![], |xml| {
            let arrays = declaration
                .states
                .iter()
                .map(|[state, _]| *state)
                .filter(|&k| is_output(&declaration.entries[k]));
            // An array of states that is an output depends on these states only.
            let shown = arrays.map(|entry| Unknown { entry, on: vec![entry], on_time: false });
            let outputs: Vec<Unknown> = found.outputs.iter().cloned().chain(shown).collect();
            let lists = [
                ("Output", &outputs),
                ("ContinuousStateDerivative", &found.rates),
                ("InitialUnknown", &found.initial),
                ("EventIndicator", &found.indicators),
            ];
            for (name, unknowns) in lists {
                for (reference, on) in whole(declaration, starts, unknowns) {
                    let attributes = vec![
                        ("valueReference", reference.to_string()),
                        ("dependencies", list(on.into_iter().map(u64::from))),
                    ];
                    empty(xml, name, &attributes)?;
                }
            }
            Ok(())
        })
    })
}

/// Whether an entry is a scalar, or the first element of an array and represents it.
fn is_first(entry: &Entry) -> bool {
    entry.element.is_none_or(|element| element.index == 1)
}

/// Whether an entry is an element of an array of states that is an output.
fn is_output(entry: &Entry) -> bool {
    entry.slot.group == Slot::STATES && entry.element.is_some_and(|element| element.shown)
}

/// The value reference of the variable, or of its array.
fn reference(entry: &Entry) -> u32 {
    entry.element.map_or(entry.value_reference, |element| entry.value_reference + 1 - element.index)
}

/// Variables and their dependencies by value reference; an array has those of all elements.
fn whole(declaration: &Declaration, starts: &StartValues, unknowns: &[Unknown]) -> Vec<(u32, Vec<u32>)> {
    let entry = |k: usize| &declaration.entries[k];
    let mut all: Vec<(u32, Vec<u32>)> = Vec::new();
    for unknown in unknowns.iter().filter(|unknown| starts.shows(declaration, entry(unknown.entry))) {
        let of = reference(entry(unknown.entry));
        let place = all.iter().position(|(there, _)| *there == of).unwrap_or_else(|| {
            all.push((of, Vec::new()));
            all.len() - 1
        });
        let on = &mut all[place].1;
        let time = unknown.on_time.then_some(TIME);
        for known in time.into_iter().chain(unknown.on.iter().map(|&k| reference(entry(k)))) {
            if !on.contains(&known) {
                on.push(known);
            }
        }
    }
    all
}

fn variable(xml: &mut Xml, declaration: &Declaration, entry: &Entry, starts: &StartValues) -> io::Result<()> {
    let name = if entry.element.is_some() { entry.row.name } else { &entry.name };
    let causality = if declaration.is_dimension(entry) {
        "structuralParameter"
    } else if is_output(entry) {
        "output"
    } else {
        xml::causality(entry)
    };
    let mut attributes = xml::attributes_of(entry, name, causality);
    if entry.is_intermediate() {
        attributes.push(("intermediateUpdate", "true".to_string()));
    }
    let start = xml::start_attribute(entry, starts);
    let kind = match entry.row.kind {
        Kind::Real => {
            attributes.extend(xml::real_attributes(entry, starts));
            if let Some(state) = xml::state_of(declaration, entry) {
                attributes.push(("derivative", declaration.entries[state].value_reference.to_string()));
            }
            "Float64"
        }
        Kind::Integer => {
            attributes.extend(xml::integer_attributes(entry, starts));
            if declaration.is_dimension(entry) { "UInt64" } else { "Int64" }
        }
        Kind::Boolean => {
            attributes.extend(start);
            "Boolean"
        }
        Kind::Enumeration(t) => {
            attributes.push(("declaredType", t.name.to_string()));
            attributes.extend(start);
            "Enumeration"
        }
    };
    let Some(of) = entry.element.map(|element| element.of) else { return empty(xml, kind, &attributes) };
    let size = match of {
        Elements::UpTo(_, parameter) => {
            let counts = declaration.by_name(parameter).map_or(TIME, |count| count.value_reference);
            ("valueReference", counts.to_string())
        }
        fixed => ("start", fixed.most().to_string()),
    };
    element(xml, kind, &attributes, |xml| empty(xml, "Dimension", &vec![size]))
}
