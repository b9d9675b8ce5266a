//! Which variables belong together where a model is connected: `terminalsAndIcons.xml` of both standards.

use describe::Declaration;
use describe::xml::{self, Attributes, element, empty};
use serde::Deserialize;
use std::sync::LazyLock;

/// The folder in the archive.
pub const FOLDER: &str = "terminalsAndIcons";

/// A variable at a terminal; an array in the file.
#[derive(Deserialize)]
#[serde(from = "(String, String, String)")]
pub struct Member {
    /// Name of the variable.
    pub variable: String,
    /// Name that is matched between terminals.
    pub name: String,
    /// `signal`, `inflow` or `outflow`.
    pub kind: String,
}

impl From<(String, String, String)> for Member {
    fn from((variable, name, kind): (String, String, String)) -> Member {
        Member { variable, name, kind }
    }
}

/// A terminal of a model.
#[derive(Deserialize)]
pub struct Terminal {
    model: String,
    /// Its name.
    pub name: String,
    /// Terminals of the same kind match.
    kind: String,
    /// What it is.
    pub what: String,
    /// Its variables.
    pub members: Vec<Member>,
}

#[derive(Deserialize)]
struct Terminals {
    terminal: Vec<Terminal>,
}

static TERMINALS: LazyLock<Vec<Terminal>> = LazyLock::new(|| {
    toml::from_str::<Terminals>(include_str!("terminals.toml")).expect("the tests read this file").terminal
});

/// The terminals of a model.
pub fn of(declaration: &Declaration) -> Vec<&'static Terminal> {
    TERMINALS.iter().filter(|terminal| terminal.model == declaration.name).collect()
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
                let attributes = [
                    ("name", terminal.name.as_str()),
                    ("matchingRule", "bus"),
                    ("terminalKind", &terminal.kind),
                    ("description", &terminal.what),
                ];
                element(xml, "Terminal", &texts(&attributes), |xml| {
                    terminal.members.iter().try_for_each(|member| {
                        let attributes = [
                            ("variableName", member.variable.as_str()),
                            ("memberName", &member.name),
                            ("variableKind", &member.kind),
                        ];
                        empty(xml, "TerminalMemberVariable", &texts(&attributes))
                    })
                })
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use describe::{Causality, models};

    fn terminal(model: &str, name: &str) -> (&'static Declaration, &'static Terminal) {
        let declaration = (models::by_name(model).unwrap().declaration)();
        (declaration, of(declaration).into_iter().find(|terminal| terminal.name == name).unwrap())
    }

    #[test]
    fn every_model_has_terminals_of_inputs_and_outputs() {
        for kind in models::ALL {
            let declaration = (kind.declaration)();
            assert!(!of(declaration).is_empty());
            for member in of(declaration).iter().flat_map(|terminal| &terminal.members) {
                let entry = declaration.by_name(&member.variable);
                let causality = entry.map(|entry| entry.row.causality);
                assert!(
                    matches!(causality, Some(Causality::Input | Causality::Output)),
                    "{}",
                    member.variable
                );
                assert!(["signal", "inflow", "outflow"].contains(&member.kind.as_str()));
            }
        }
    }

    /// Members of one name connect an output with an input of the same unit, and a flow out of one model flows into the other.
    #[test]
    fn terminals_of_one_kind_connect_by_member_names() {
        let shaft = ["angle", "speed", "torque"];
        for ([one, at], [other, there], names) in [
            (["AnnulusCooledMotor", "shaft"], ["SeriesElasticActuator", "motor"], &shaft[..]),
            (["BrushedGearmotor", "shaft"], ["SeriesElasticActuator", "motor"], &shaft),
            (
                ["AnnulusCooledMotor", "electrical"],
                ["SeriesElasticActuator", "drive"],
                &["voltage", "current_command", "current", "power"],
            ),
            (
                ["SeriesElasticActuator", "joint"],
                ["GaitLoad", "joint"],
                &["angle", "speed", "torque_demand", "torque"],
            ),
        ] {
            let ((one, here), (other, there)) = (terminal(one, at), terminal(other, there));
            assert_eq!(here.kind, there.kind);
            let mut matched = Vec::new();
            for a in &here.members {
                let Some(b) = there.members.iter().find(|b| b.name == a.name) else { continue };
                let row = |declaration: &Declaration, member: &Member| {
                    declaration.by_name(&member.variable).unwrap().row
                };
                let (left, right) = (row(one, a), row(other, b));
                assert_eq!(left.unit, right.unit, "{}", a.name);
                assert_ne!(left.causality, right.causality, "{}", a.name);
                let kinds = [a.kind.as_str(), b.kind.as_str()];
                assert!(matches!(
                    kinds,
                    ["signal", "signal"] | ["inflow", "outflow"] | ["outflow", "inflow"]
                ));
                matched.push(a.name.as_str());
            }
            assert_eq!(matched, names);
        }
    }
}
