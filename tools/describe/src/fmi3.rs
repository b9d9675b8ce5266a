//! The FMI 3.0 model description of a model.

use crate::Dependencies;
use crate::preset::StartValues;
use crate::xml::{self, Xml, element, empty, list};
use physics::declare::Kind;
use physics::model::{Declaration, Entry};
use std::io;

const CAN: &[&str] =
    &["canGetAndSetFMUState", "canSerializeFMUState", "canHandleVariableCommunicationStepSize"];

/// The text of modelDescription.xml of an archive with these start values and dependencies.
pub fn model_description(declaration: &Declaration, starts: &StartValues, found: &Dependencies) -> String {
    xml::document("fmiModelDescription", &xml::root("3.0", "instantiationToken", declaration), |xml| {
        empty(xml, "CoSimulation", &xml::interface(declaration, CAN))?;
        xml::unit_definitions(xml, declaration)?;
        xml::type_definitions(xml, declaration, |xml, attributes, items| {
            element(xml, "EnumerationType", attributes, items)
        })?;
        xml::log_categories(xml)?;
        xml::default_experiment(xml)?;
        element(xml, "ModelVariables", &vec![], |xml| {
            let time = [xml::time_attributes(), vec![("unit", "s".to_string())]].concat();
            empty(xml, "Float64", &time)?;
            declaration.entries.iter().try_for_each(|entry| variable(xml, entry, starts))
        })?;
        element(xml, "ModelStructure", &vec![], |xml| {
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

fn variable(xml: &mut Xml, entry: &Entry, starts: &StartValues) -> io::Result<()> {
    let mut attributes = xml::variable_attributes(entry);
    let start = xml::start_attribute(entry, starts);
    let element = match entry.row.kind {
        Kind::Real => {
            attributes.extend(xml::real_attributes(entry, starts));
            "Float64"
        }
        Kind::Integer => {
            attributes.extend(xml::integer_attributes(entry, starts));
            "Int64"
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
    empty(xml, element, &attributes)
}
