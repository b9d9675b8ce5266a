//! The FMI 3.0 model description of a model.

use crate::Dependencies;
use crate::preset::StartValues;
use crate::xml::{self, Xml, element, empty, list};
use physics::declare::Kind;
use physics::model::{Declaration, Entry};
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
];

/// The text of modelDescription.xml of an archive with these start values and dependencies.
pub fn model_description(
    declaration: &'static Declaration,
    starts: &StartValues,
    found: &Dependencies,
) -> String {
    xml::document("fmiModelDescription", &xml::root("3.0", "instantiationToken", declaration), |xml| {
        empty(xml, "ModelExchange", &xml::interface(declaration, CAN_EXCHANGE))?;
        let mut stepping = xml::interface(declaration, CAN);
        stepping.push(("maxOutputDerivativeOrder", "1".to_string()));
        empty(xml, "CoSimulation", &stepping)?;
        xml::unit_definitions(xml, declaration)?;
        xml::type_definitions(xml, declaration, |xml, attributes, items| {
            element(xml, "EnumerationType", attributes, items)
        })?;
        xml::log_categories(xml)?;
        xml::default_experiment(xml)?;
        element(xml, "ModelVariables", &vec![], |xml| {
            let time = [xml::time_attributes(), vec![("unit", "s".to_string())]].concat();
            empty(xml, "Float64", &time)?;
            let listed = declaration.entries.iter().filter(|entry| starts.shows(declaration, entry));
            listed.into_iter().try_for_each(|entry| variable(xml, declaration, entry, starts))
        })?;
        element(xml, "ModelStructure", &vec![], |xml| {
            let reference = |k: usize| u64::from(declaration.entries[k].value_reference);
            let lists = [
                ("Output", &found.outputs),
                ("ContinuousStateDerivative", &found.rates),
                ("InitialUnknown", &found.initial),
                ("EventIndicator", &found.indicators),
            ];
            for (name, unknowns) in lists {
                for unknown in unknowns {
                    let time = unknown.on_time.then_some(u64::from(physics::model::TIME));
                    let on = time.into_iter().chain(unknown.on.iter().map(|k| reference(*k)));
                    let attributes = vec![
                        ("valueReference", reference(unknown.entry).to_string()),
                        ("dependencies", list(on)),
                    ];
                    empty(xml, name, &attributes)?;
                }
            }
            Ok(())
        })
    })
}

fn variable(xml: &mut Xml, declaration: &Declaration, entry: &Entry, starts: &StartValues) -> io::Result<()> {
    let mut attributes = xml::variable_attributes(entry);
    let start = xml::start_attribute(entry, starts);
    let element = match entry.row.kind {
        Kind::Real => {
            attributes.extend(xml::real_attributes(entry, starts));
            if let Some(state) = xml::state_of(declaration, entry) {
                attributes.push(("derivative", declaration.entries[state].value_reference.to_string()));
            }
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
