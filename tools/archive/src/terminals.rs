//! Which variables belong together where a model is connected: `terminalsAndIcons.xml` of FMI 3.

use describe::xml::{self, Attributes, element, empty};
use describe::{Causality, Declaration};
use serde::Deserialize;
use std::sync::LazyLock;

/// The folder in the archive.
pub const FOLDER: &str = "terminalsAndIcons";

/// A variable, and its kind at its terminal.
type Member = (String, String);

/// A place where a model may be connected.
#[derive(Deserialize)]
struct Place {
    name: String,
    /// The variable of the models that have it.
    of: String,
    what: String,
    members: Vec<Member>,
}

#[derive(Deserialize)]
struct Places {
    place: Vec<Place>,
}

static PLACES: LazyLock<Vec<Place>> = LazyLock::new(|| {
    toml::from_str::<Places>(include_str!("terminals.toml")).expect("the tests read this file").place
});

/// A terminal of a model.
pub struct Terminal {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// The variables that the model has of it, each with its kind.
    pub members: Vec<&'static Member>,
}

/// The terminals of a model, with the members that it has.
pub fn of(declaration: &Declaration) -> Vec<Terminal> {
    let connects = |name: &str| {
        let entry = declaration.by_name(name);
        entry.is_some_and(|e| e.row.causality != Causality::Parameter)
    };
    let with_members = |place: &'static Place| {
        let members = place.members.iter().filter(|(variable, _)| connects(variable)).collect();
        connects(&place.of).then_some(Terminal { name: &place.name, what: &place.what, members })
    };
    PLACES.iter().filter_map(with_members).collect()
}

/// terminalsAndIcons.xml: the icon, and the terminals on its edges.
pub fn document(declaration: &Declaration) -> String {
    let texts = |all: &[(&'static str, &str)]| -> Attributes {
        all.iter().map(|(name, value)| (*name, (*value).to_owned())).collect()
    };
    let corners = [("x1", "-100"), ("y1", "-100"), ("x2", "100"), ("y2", "100")];
    let system = [&corners[..], &[("suggestedScalingFactorTo_mm", "0.1")]].concat();
    let terminals = of(declaration);
    xml::document("fmiTerminalsAndIcons", &texts(&[("fmiVersion", "3.0")]), |xml| {
        element(xml, "GraphicalRepresentation", &vec![], |xml| {
            empty(xml, "CoordinateSystem", &texts(&system))?;
            empty(xml, "Icon", &texts(&corners))
        })?;
        if terminals.is_empty() {
            return Ok(());
        }
        element(xml, "Terminals", &vec![], |xml| {
            terminals.iter().try_for_each(|terminal| {
                let attributes =
                    [("name", terminal.name), ("matchingRule", "bus"), ("description", terminal.what)];
                element(xml, "Terminal", &texts(&attributes), |xml| {
                    terminal.members.iter().try_for_each(|(variable, kind)| {
                        let member =
                            [("variableName", variable), ("memberName", variable), ("variableKind", kind)];
                        let member = member.map(|(name, value)| (name, value.as_str()));
                        empty(xml, "TerminalMemberVariable", &texts(&member))
                    })
                })
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use describe::models;

    #[test]
    fn every_member_is_somewhere_a_variable() {
        for (variable, _) in PLACES.iter().flat_map(|place| &place.members) {
            let known = models::ALL
                .iter()
                .any(|m| of((m.declaration)()).iter().any(|t| t.members.iter().any(|m| m.0 == *variable)));
            assert!(known, "{variable}");
        }
    }

    #[test]
    fn every_model_has_its_terminals() {
        for kind in models::ALL {
            let declaration = (kind.declaration)();
            let names: Vec<_> = of(declaration).iter().map(|t| t.name).collect();
            let expected: &[&str] = match declaration.name {
                "SeriesElasticActuator" => &["motor", "joint", "supply"],
                "GaitLoad" => &["joint"],
                _ => &["electrical", "shaft", "heat"],
            };
            assert_eq!(names, expected, "{}", declaration.name);
        }
    }
}
