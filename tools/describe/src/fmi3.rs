//! The FMI 3.0 model description of a model.

use crate::preset::StartValues;
use crate::xml::{self, Xml, description, element, empty, list};
use crate::{Dependencies, TOOL, VERSION};
use physics::declare::{Causality, Kind};
use physics::model::{Declaration, Entry, ModelType, TIME};
use std::io;

/// The text of modelDescription.xml.
pub fn model_description(kind: &ModelType, starts: &StartValues) -> String {
    let declaration = (kind.declaration)();
    let root = vec![
        ("fmiVersion", "3.0".to_string()),
        ("modelName", declaration.name.to_string()),
        ("instantiationToken", declaration.token.clone()),
        ("description", declaration.description.to_string()),
        ("version", VERSION.to_string()),
        ("license", "MIT".to_string()),
        ("generationTool", TOOL.to_string()),
        ("variableNamingConvention", "structured".to_string()),
    ];
    xml::document("fmiModelDescription", &root, |xml| {
        let yes = || "true".to_string();
        let co_simulation = vec![
            ("modelIdentifier", declaration.name.to_string()),
            ("canGetAndSetFMUState", yes()),
            ("canSerializeFMUState", yes()),
            ("canHandleVariableCommunicationStepSize", yes()),
        ];
        empty(xml, "CoSimulation", &co_simulation)?;
        xml::unit_definitions(xml, declaration)?;
        type_definitions(xml, declaration)?;
        xml::log_categories(xml)?;
        xml::default_experiment(xml)?;
        element(xml, "ModelVariables", &vec![], |xml| {
            time(xml)?;
            declaration.entries.iter().try_for_each(|entry| variable(xml, entry, starts))
        })?;
        element(xml, "ModelStructure", &vec![], |xml| {
            let found = Dependencies::of(kind);
            let reference = |k: usize| u64::from(declaration.entries[k].value_reference);
            for (name, unknowns) in [("Output", &found.running), ("InitialUnknown", &found.initial)] {
                for (output, on) in unknowns {
                    let attributes = vec![
                        ("valueReference", reference(*output).to_string()),
                        ("dependencies", list(on.iter().map(|k| reference(*k)))),
                    ];
                    empty(xml, name, &attributes)?;
                }
            }
            Ok(())
        })
    })
}

fn type_definitions(xml: &mut Xml, declaration: &Declaration) -> io::Result<()> {
    element(xml, "TypeDefinitions", &vec![], |xml| {
        xml::enumerations(declaration).iter().try_for_each(|t| {
            let attributes = vec![("name", t.name.to_string()), ("description", description(t.doc))];
            element(xml, "EnumerationType", &attributes, |xml| {
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
}

fn time(xml: &mut Xml) -> io::Result<()> {
    let attributes = vec![
        ("name", "time".to_string()),
        ("valueReference", TIME.to_string()),
        ("description", "Simulation time".to_string()),
        ("causality", "independent".to_string()),
        ("variability", "continuous".to_string()),
        ("unit", "s".to_string()),
    ];
    empty(xml, "Float64", &attributes)
}

fn variable(xml: &mut Xml, entry: &Entry, starts: &StartValues) -> io::Result<()> {
    let mut attributes = vec![
        ("name", entry.name.clone()),
        ("valueReference", entry.value_reference.to_string()),
        ("description", description(entry.row.doc)),
    ];
    attributes.extend(xml::role_attributes(entry));
    let start = (entry.row.causality != Causality::Output).then(|| starts.of(entry));
    let element = match entry.row.kind {
        Kind::Real => {
            attributes.extend(xml::real_attributes(entry, starts));
            "Float64"
        }
        Kind::Boolean => {
            attributes.extend(start.map(|s| ("start", (s != 0.0).to_string())));
            "Boolean"
        }
        Kind::Enumeration(t) => {
            attributes.push(("declaredType", t.name.to_string()));
            attributes.extend(start.map(|s| ("start", xml::number(s))));
            "Enumeration"
        }
    };
    empty(xml, element, &attributes)
}
