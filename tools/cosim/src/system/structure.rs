//! A system as described in TOML or SSP: names and places in the file, not yet resolved in the FMUs.
use super::units::Affine;
use crate::description::words;
use crate::{Error, Unit};
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use tempfile::TempDir;

/// File and line, for messages.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) file: Arc<str>,
    pub(crate) line: u32,
}

impl Place {
    /// The sentence `message` about this place.
    pub(crate) fn fault(&self, message: impl Into<String>) -> Error {
        Error::Text { file: self.file.to_string(), line: self.line.into(), message: message.into() }
    }
}

/// A time of a file (s), with its place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Time {
    pub(crate) seconds: f64,
    pub(crate) place: Place,
}

words! {
    /// What a connector is to the element that has it; parameters can be set but not connected.
    pub(crate) enum Direction {
        Input "input" "input",
        Output "output" "output",
        Parameter "parameter" "parameter",
    }
}

words! {
    /// The types of SSP; each corresponds to several FMI types.
    pub(crate) enum Sort {
        Real "Real" "Real",
        Integer "Integer" "Integer",
        Boolean "Boolean" "Boolean",
        String "String" "String",
        Enumeration "Enumeration" "Enumeration",
        Binary "Binary" "Binary",
    }
}

/// A connector that the file declares.
#[derive(Clone, Debug)]
pub(crate) struct Connector {
    pub(crate) name: String,
    pub(crate) direction: Direction,
    pub(crate) sort: Option<Sort>,
    /// The unit that values have at the connector; that of the variable when absent.
    pub(crate) unit: Option<Unit>,
    pub(crate) place: Place,
}

/// The unit that a declared connector has.
pub(crate) fn unit_in(connectors: Option<&[Connector]>, name: &str) -> Option<Unit> {
    connectors?.iter().find(|c| c.name == name)?.unit.clone()
}

/// A value for a parameter or an input, as text.
#[derive(Clone, Debug)]
pub(crate) struct Setting {
    pub(crate) name: String,
    pub(crate) text: String,
    /// The unit of the value; that of the variable when absent.
    pub(crate) unit: Option<Unit>,
    /// The transformation of a parameter mapping, after the conversion of units.
    pub(crate) linear: Affine,
    pub(crate) place: Place,
}

/// A parameter of the system: one value for variables of several components.
#[derive(Clone, Debug)]
pub(crate) struct Shared {
    pub(crate) name: String,
    pub(crate) text: String,
    /// The unit of the value; that of the variables when absent.
    pub(crate) unit: Option<Unit>,
    /// Variables as `component.variable`, each with the transformation of the value after the conversion of units.
    pub(crate) targets: Vec<(String, Affine)>,
}

/// A component: one instance of an FMU.
#[derive(Clone, Debug)]
pub(crate) struct Component {
    pub(crate) name: String,
    /// Its communication step, where it is shorter than that of the system.
    pub(crate) step: Option<Time>,
    /// The FMU as the file names it, and where that is.
    pub(crate) source: String,
    pub(crate) path: PathBuf,
    /// `None`: every variable of the FMU is a connector.
    pub(crate) connectors: Option<Vec<Connector>>,
    pub(crate) settings: Vec<Setting>,
    pub(crate) place: Place,
}

/// One end of a connection.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct End {
    /// The component; the system itself when absent.
    pub(crate) component: Option<String>,
    pub(crate) connector: String,
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.component {
            Some(component) => write!(f, "{component}.{}", self.connector),
            None => f.write_str(&self.connector),
        }
    }
}

/// A connection. Which end is the source follows from the connectors, not from the order.
#[derive(Clone, Debug)]
pub(crate) struct Connection {
    pub(crate) start: End,
    pub(crate) end: End,
    /// One, or several where the connection passes connectors of nested systems; from the source on.
    pub(crate) legs: Vec<Leg>,
    pub(crate) place: Place,
}

impl Connection {
    /// Whether it connects two components, not one with an input or output of the system.
    pub(crate) fn is_inner(&self) -> bool {
        self.start.component.is_some() && self.end.component.is_some()
    }
}

/// What a connection does with a value.
#[derive(Clone, Debug)]
pub(crate) struct Leg {
    pub(crate) convert_units: bool,
    /// `target = factor * source + offset`, after the conversion of units.
    pub(crate) factor: f64,
    pub(crate) offset: f64,
    /// The unit of the connector at its end, where that is one of a nested system or a signal dictionary.
    pub(crate) unit: Option<Unit>,
}

impl Leg {
    pub(crate) const PLAIN: Self = Self { convert_units: true, factor: 1.0, offset: 0.0, unit: None };
}

impl Connection {
    /// Whether values are transformed, apart from the conversion of units.
    pub(crate) fn is_linear(&self) -> bool {
        self.legs.iter().any(|leg| (leg.factor, leg.offset) != (1.0, 0.0))
    }
}

impl fmt::Display for Connection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "connection {} -> {}", self.start, self.end)
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Structure {
    pub(crate) name: String,
    pub(crate) start: Option<Time>,
    pub(crate) stop: Option<Time>,
    pub(crate) step: Option<Time>,
    pub(crate) components: Vec<Component>,
    /// Connectors of the system itself; `None`: those that the connections name.
    pub(crate) connectors: Option<Vec<Connector>>,
    /// Values for `component.variable` or for an input of the system.
    pub(crate) settings: Vec<Setting>,
    /// Where values of `settings` come from, which a mapping gives to several variables.
    pub(crate) shared: Vec<Shared>,
    pub(crate) connections: Vec<Connection>,
    /// Unpacked files that must stay while components point there.
    pub(crate) files: Option<Arc<TempDir>>,
}
