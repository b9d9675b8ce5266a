//! The FMI 2.0 model description of a model.

use crate::Dependencies;
use crate::preset::StartValues;
use crate::xml::{self, Xml, element, empty, list};
use physics::declare::Kind;
use physics::model::{Declaration, Entry};
use std::io;

const CAN: &[&str] = &[
    "canHandleVariableCommunicationStepSize",
    "canInterpolateInputs",
    "canNotUseMemoryManagementFunctions",
    "canGetAndSetFMUstate",
    "canSerializeFMUstate",
];

/// The text of modelDescription.xml of an archive with these start values and dependencies.
pub fn model_description(declaration: &Declaration, starts: &StartValues, found: &Dependencies) -> String {
    let mut root = xml::root("2.0", "guid", declaration);
    root.push(("numberOfEventIndicators", "0".to_string()));
    xml::document("fmiModelDescription", &root, |xml| {
        empty(xml, "CoSimulation", &xml::interface(declaration, CAN))?;
        xml::unit_definitions(xml, declaration)?;
        xml::type_definitions(xml, declaration, |xml, attributes, items| {
            element(xml, "SimpleType", attributes, |xml| element(xml, "Enumeration", &vec![], items))
        })?;
        xml::log_categories(xml)?;
        xml::default_experiment(xml)?;
        element(xml, "ModelVariables", &vec![], |xml| {
            let unit = vec![("unit", "s".to_string())];
            element(xml, "ScalarVariable", &xml::time_attributes(), |xml| empty(xml, "Real", &unit))?;
            declaration.entries.iter().try_for_each(|entry| scalar_variable(xml, entry, starts))
        })?;
        element(xml, "ModelStructure", &vec![], |xml| {
            // Time is variable 1, and the entries follow in order.
            let unknown = |xml: &mut Xml, (output, on): &(usize, Vec<usize>)| {
                let dependencies = list(on.iter().map(|k| *k as u64 + 2));
                empty(
                    xml,
                    "Unknown",
                    &vec![("index", (output + 2).to_string()), ("dependencies", dependencies)],
                )
            };
            element(xml, "Outputs", &vec![], |xml| found.running.iter().try_for_each(|u| unknown(xml, u)))?;
            element(xml, "InitialUnknowns", &vec![], |xml| {
                found.initial.iter().try_for_each(|u| unknown(xml, u))
            })
        })
    })
}

fn scalar_variable(xml: &mut Xml, entry: &Entry, starts: &StartValues) -> io::Result<()> {
    let start = xml::start_attribute(entry, starts);
    element(xml, "ScalarVariable", &xml::variable_attributes(entry), |xml| match entry.row.kind {
        Kind::Real => empty(xml, "Real", &xml::real_attributes(entry, starts)),
        Kind::Integer => empty(xml, "Integer", &xml::integer_attributes(entry, starts)),
        Kind::Boolean => empty(xml, "Boolean", &start.into_iter().collect()),
        Kind::Enumeration(t) => {
            let declared = ("declaredType", t.name.to_string());
            empty(xml, "Enumeration", &[declared].into_iter().chain(start).collect())
        }
    })
}
