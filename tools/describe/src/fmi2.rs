//! The FMI 2.0 model description of a model.

use crate::preset::StartValues;
use crate::xml::{self, Xml, element, empty, list};
use crate::{Dependencies, Experiment, Resources, Unknown};
use physics::declare::Kind;
use physics::model::{Declaration, Entry};
use std::io;

const CAN_EXCHANGE: &[&str] = &[
    "canNotUseMemoryManagementFunctions",
    "canGetAndSetFMUstate",
    "canSerializeFMUstate",
    "providesDirectionalDerivative",
];

const CAN: &[&str] = &[
    "canHandleVariableCommunicationStepSize",
    "canInterpolateInputs",
    "canNotUseMemoryManagementFunctions",
    "canGetAndSetFMUstate",
    "canSerializeFMUstate",
    "providesDirectionalDerivative",
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
    let mut root = xml::root("2.0", ("guid", token), declaration);
    root.push(("numberOfEventIndicators", declaration.indicators.len().to_string()));
    let listed = Listed::new(declaration, starts);
    xml::document("fmiModelDescription", &root, |xml| {
        xml::preamble(xml, declaration, [CAN_EXCHANGE, CAN], experiment, |xml, attributes, items| {
            element(xml, "SimpleType", attributes, |xml| element(xml, "Enumeration", &vec![], items))
        })?;
        element(xml, "ModelVariables", &vec![], |xml| {
            let unit = vec![("unit", "s".to_string())];
            element(xml, "ScalarVariable", &xml::time_attributes(), |xml| empty(xml, "Real", &unit))?;
            listed.entries().try_for_each(|entry| scalar_variable(xml, entry, starts, &listed))
        })?;
        element(xml, "ModelStructure", &vec![], |xml| {
            let unknown = |xml: &mut Xml, unknown: &Unknown| {
                let time = unknown.on_time.then_some(1);
                let dependencies = list(time.into_iter().chain(unknown.on.iter().map(|k| listed.index(*k))));
                let index = listed.index(unknown.entry).to_string();
                empty(xml, "Unknown", &vec![("index", index), ("dependencies", dependencies)])
            };
            let lists = [
                ("Outputs", &found.outputs),
                ("Derivatives", &found.rates),
                ("InitialUnknowns", &found.initial),
            ];
            lists.into_iter().try_for_each(|(name, unknowns)| {
                element(xml, name, &vec![], |xml| unknowns.iter().try_for_each(|u| unknown(xml, u)))
            })
        })
    })
}

/// The variables of an archive, numbered as in FMI 2: from 1, which is time.
struct Listed {
    declaration: &'static Declaration,
    /// The number of each entry; 0 if it is not listed.
    number: Vec<u64>,
}

impl Listed {
    fn new(declaration: &'static Declaration, starts: &StartValues) -> Listed {
        let mut last = 1;
        let number = declaration.entries.iter().map(|entry| {
            let shown = starts.shows(declaration, entry);
            last += u64::from(shown);
            if shown { last } else { 0 }
        });
        Listed { declaration, number: number.collect() }
    }

    fn entries(&self) -> impl Iterator<Item = &'static Entry> + '_ {
        self.declaration.entries.iter().zip(&self.number).filter(|(_, n)| **n > 0).map(|(entry, _)| entry)
    }

    fn index(&self, entry: usize) -> u64 {
        self.number[entry]
    }
}

fn scalar_variable(xml: &mut Xml, entry: &Entry, starts: &StartValues, listed: &Listed) -> io::Result<()> {
    let start = xml::start_attribute(entry, starts);
    element(xml, "ScalarVariable", &xml::variable_attributes(entry), |xml| match entry.row.kind {
        Kind::Real => {
            let mut attributes = xml::real_attributes(entry, starts);
            if let Some(state) = xml::state_of(listed.declaration, entry) {
                attributes.push(("derivative", listed.index(state).to_string()));
            }
            empty(xml, "Real", &attributes)
        }
        Kind::Integer => empty(xml, "Integer", &xml::integer_attributes(entry, starts)),
        Kind::Boolean => empty(xml, "Boolean", &start.into_iter().collect()),
        Kind::Enumeration(t) => {
            let declared = ("declaredType", t.name.to_string());
            empty(xml, "Enumeration", &[declared].into_iter().chain(start).collect())
        }
    })
}
