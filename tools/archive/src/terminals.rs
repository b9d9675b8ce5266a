//! Which variables belong together where a model is connected: `terminalsAndIcons.xml` of FMI 3.

use describe::{Causality, Declaration};
use quick_xml::Writer;
use serde::Deserialize;
use std::io;
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
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    write(&mut xml, declaration).expect("writing to memory does not fail");
    let text = String::from_utf8(xml.into_inner()).expect("names and descriptions are UTF-8");
    format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{text}\n")
}

fn write(xml: &mut Writer<Vec<u8>>, declaration: &Declaration) -> io::Result<()> {
    let box_of = |x1: &'static str, y1: &'static str, x2: &'static str, y2: &'static str| {
        [("x1", x1), ("y1", y1), ("x2", x2), ("y2", y2)]
    };
    let terminals = of(declaration);
    xml.create_element("fmiTerminalsAndIcons").with_attribute(("fmiVersion", "3.0")).write_inner_content(
        |xml| {
            xml.create_element("GraphicalRepresentation").write_inner_content(|xml| {
                let system = box_of("-100", "-100", "100", "100");
                let scale = [("suggestedScalingFactorTo_mm", "0.1")];
                xml.create_element("CoordinateSystem")
                    .with_attributes(system.into_iter().chain(scale))
                    .write_empty()?;
                xml.create_element("Icon").with_attributes(system).write_empty()?;
                Ok(())
            })?;
            if terminals.is_empty() {
                return Ok(());
            }
            xml.create_element("Terminals").write_inner_content(|xml| {
                terminals.iter().try_for_each(|terminal| {
                    let attributes =
                        [("name", terminal.name), ("matchingRule", "bus"), ("description", terminal.what)];
                    xml.create_element("Terminal").with_attributes(attributes).write_inner_content(
                        |xml| {
                            terminal.members.iter().try_for_each(|(variable, kind)| {
                                let member = [
                                    ("variableName", variable.as_str()),
                                    ("memberName", variable.as_str()),
                                    ("variableKind", kind.as_str()),
                                ];
                                xml.create_element("TerminalMemberVariable")
                                    .with_attributes(member)
                                    .write_empty()
                                    .map(drop)
                            })
                        },
                    )?;
                    Ok(())
                })
            })?;
            Ok(())
        },
    )?;
    Ok(())
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
