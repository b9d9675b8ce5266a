//! Which variables belong together where a model is connected: `terminalsAndIcons.xml` of FMI 3.

use describe::{Causality, Declaration};
use quick_xml::Writer;
use std::io;

/// The folder in the archive.
pub const FOLDER: &str = "terminalsAndIcons";

/// A variable, and what it is at its terminal.
type Member = (&'static str, &'static str);
/// A place where a model may be connected: name, the variable that a model has which has it, what it is, and its members.
type Place = (&'static str, &'static str, &'static str, &'static [Member]);

/// A terminal of a model.
pub struct Terminal {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// The variables that the model has of it, each with its kind.
    pub members: Vec<Member>,
}

/// Potentials are signals; what flows is counted positive into the model (inflow) or out of it (outflow), as the
/// variables themselves are (fmu-src/README.md).
const PLACES: &[Place] = &[
    (
        "electrical",
        "current",
        "Winding, or the drive in front of it",
        &[
            ("voltage", "signal"),
            ("supply_voltage", "signal"),
            ("duty", "signal"),
            ("current_command", "signal"),
            ("current", "inflow"),
        ],
    ),
    (
        "shaft",
        "shaft_speed",
        "Shaft and the load on it",
        &[
            ("shaft_angle", "signal"),
            ("shaft_speed", "signal"),
            ("imposed_speed", "signal"),
            ("shaft_torque", "outflow"),
            ("load_torque", "outflow"),
        ],
    ),
    (
        "heat",
        "heat_to_ambient",
        "Heat flow to ambient",
        &[
            ("ambient_temperature", "signal"),
            ("housing_temperature", "signal"),
            ("fan_command", "signal"),
            ("heat_power", "inflow"),
            ("heat_to_ambient", "outflow"),
        ],
    ),
    (
        "motor",
        "motor_speed",
        "Motor that drives the actuator: its shaft and its winding",
        &[
            ("motor_angle", "signal"),
            ("motor_speed", "signal"),
            ("load_torque", "inflow"),
            ("voltage", "signal"),
            ("current_command", "signal"),
            ("motor_current", "outflow"),
        ],
    ),
    (
        "joint",
        "spring_deflection",
        "Joint that the actuator moves",
        &[
            ("joint_angle", "signal"),
            ("joint_speed", "signal"),
            ("torque_demand", "signal"),
            ("joint_torque", "outflow"),
        ],
    ),
    (
        "supply",
        "torque_error",
        "Supply in front of the drive",
        &[("supply_voltage", "signal"), ("supply_power", "inflow")],
    ),
    (
        "joint",
        "gait_phase",
        "Joint of the person who walks",
        &[
            ("joint_angle", "signal"),
            ("joint_speed", "signal"),
            ("torque_demand", "signal"),
            ("joint_torque", "inflow"),
        ],
    ),
];

/// The terminals of a model, with the members that it has.
pub fn of(declaration: &Declaration) -> Vec<Terminal> {
    let connects = |name: &str| {
        let entry = declaration.by_name(name);
        entry.is_some_and(|e| e.row.causality != Causality::Parameter)
    };
    let with_members = |&(name, key, what, members): &Place| {
        let members = members.iter().copied().filter(|(variable, _)| connects(variable)).collect();
        connects(key).then_some(Terminal { name, what, members })
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
                                    ("variableName", *variable),
                                    ("memberName", *variable),
                                    ("variableKind", *kind),
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
        for (variable, _) in PLACES.iter().flat_map(|(_, _, _, members)| members.iter()) {
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
