//! The FMI 2.0 model description of a model.

use crate::preset::StartValues;
use crate::xml::{self, Xml, description, element, empty, list};
use crate::{Dependencies, TOOL, VERSION};
use physics::declare::{Causality, Kind};
use physics::model::{Entry, ModelType, TIME};
use std::io;

/// The text of modelDescription.xml.
pub fn model_description(kind: &ModelType, starts: &StartValues) -> String {
    let declaration = (kind.declaration)();
    let root = vec![
        ("fmiVersion", "2.0".to_string()),
        ("modelName", declaration.name.to_string()),
        ("guid", declaration.token.clone()),
        ("description", declaration.description.to_string()),
        ("version", VERSION.to_string()),
        ("license", "MIT".to_string()),
        ("generationTool", TOOL.to_string()),
        ("variableNamingConvention", "structured".to_string()),
        ("numberOfEventIndicators", "0".to_string()),
    ];
    xml::document("fmiModelDescription", &root, |xml| {
        let yes = || "true".to_string();
        let co_simulation = vec![
            ("modelIdentifier", declaration.name.to_string()),
            ("canHandleVariableCommunicationStepSize", yes()),
            ("canInterpolateInputs", yes()),
            ("canNotUseMemoryManagementFunctions", yes()),
            ("canGetAndSetFMUstate", yes()),
            ("canSerializeFMUstate", yes()),
        ];
        empty(xml, "CoSimulation", &co_simulation)?;
        xml::unit_definitions(xml, declaration)?;
        type_definitions(xml, declaration)?;
        xml::log_categories(xml)?;
        xml::default_experiment(xml)?;
        element(xml, "ModelVariables", &vec![], |xml| {
            time(xml)?;
            declaration.entries.iter().try_for_each(|entry| scalar_variable(xml, entry, starts))
        })?;
        element(xml, "ModelStructure", &vec![], |xml| {
            let found = Dependencies::of(kind);
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

fn type_definitions(xml: &mut Xml, declaration: &physics::model::Declaration) -> io::Result<()> {
    element(xml, "TypeDefinitions", &vec![], |xml| {
        xml::enumerations(declaration).iter().try_for_each(|t| {
            let attributes = vec![("name", t.name.to_string()), ("description", description(t.doc))];
            element(xml, "SimpleType", &attributes, |xml| {
                element(xml, "Enumeration", &vec![], |xml| {
                    t.items.iter().try_for_each(|i| {
                        let item = vec![
                            ("name", i.name.to_string()),
                            ("value", i.value.to_string()),
                            ("description", description(i.doc)),
                        ];
                        empty(xml, "Item", &item)
                    })
                })
            })
        })
    })
}

fn time(xml: &mut Xml) -> io::Result<()> {
    let attributes = vec![
        ("name", "time".to_string()),
        ("valueReference", TIME.to_string()),
        ("description", "Simulation time".to_string()),
        ("causality", "independent".to_string()),
        ("variability", "continuous".to_string()),
    ];
    element(xml, "ScalarVariable", &attributes, |xml| empty(xml, "Real", &vec![("unit", "s".to_string())]))
}

fn scalar_variable(xml: &mut Xml, entry: &Entry, starts: &StartValues) -> io::Result<()> {
    let mut attributes = vec![
        ("name", entry.name.clone()),
        ("valueReference", entry.value_reference.to_string()),
        ("description", description(entry.row.doc)),
    ];
    attributes.extend(xml::role_attributes(entry));
    let start = (entry.row.causality != Causality::Output).then(|| starts.of(entry));
    element(xml, "ScalarVariable", &attributes, |xml| match entry.row.kind {
        Kind::Real => empty(xml, "Real", &xml::real_attributes(entry, starts)),
        Kind::Boolean => {
            let start = start.map(|s| ("start", (s != 0.0).to_string()));
            empty(xml, "Boolean", &start.into_iter().collect())
        }
        Kind::Enumeration(t) => {
            let start = start.map(|s| ("start", xml::number(s)));
            let declared = ("declaredType", t.name.to_string());
            empty(xml, "Enumeration", &[declared].into_iter().chain(start).collect())
        }
    })
}
