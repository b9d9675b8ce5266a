//! Resolves the ends of connections to connectors and variables.
use super::parts::{Parts, Port};
use super::structure::{Connection, Connector, Direction, End, Sort};
use super::units::{Affine, conversion, unit_of};
use crate::error::suggestion;
use crate::value::nearest;
use crate::{Causality, Error, Kind, Unit, Variable};

/// An end of a connection, found.
pub(crate) enum Found<'a> {
    Variable {
        port: Port,
        direction: Direction,
        unit: Option<Unit>,
        to_connector: Affine,
        from_connector: Affine,
    },
    System {
        name: &'a str,
        declared: Option<&'a Connector>,
    },
}

/// Looks an end up among the components and connectors.
pub(crate) fn find<'a>(parts: Parts<'a>, connection: &Connection, end: &'a End) -> Result<Found<'a>, Error> {
    let structure = parts.structure;
    let fault = |message: String| connection.place.fault(format!("{connection}: {message}"));
    let Some(name) = &end.component else {
        let declared = structure.connectors.as_ref().map(|all| all.iter().find(|c| c.name == end.connector));
        return match declared {
            Some(None) => Err(fault(format!("the system has no connector {}", end.connector))),
            Some(found) => Ok(Found::System { name: &end.connector, declared: found }),
            None => Ok(Found::System { name: &end.connector, declared: None }),
        };
    };
    let Some(component) = structure.components.iter().position(|c| c.name == *name) else {
        let names = structure.components.iter().map(|c| c.name.as_str());
        return Err(fault(format!("there is no component {name}{}", suggestion(&nearest(name, names)))));
    };
    let description = parts.description(component);
    let Some(variable) = description.variables.iter().position(|v| v.name == end.connector) else {
        let signals = description.variables.iter().filter(|v| direction(v) != Direction::Parameter);
        let near = nearest(&end.connector, signals.map(|v| v.name.as_str()));
        return Err(fault(format!("{name} has no variable {}{}", end.connector, suggestion(&near))));
    };
    let port = Port { component, variable };
    let variable = parts.variable(port);
    let inner = unit_of(description, variable);
    let direction = direction(variable);
    let Some(connectors) = &structure.components[component].connectors else {
        let (to_connector, from_connector) = (Affine::IDENTITY, Affine::IDENTITY);
        return Ok(Found::Variable { port, direction, unit: inner, to_connector, from_connector });
    };
    let connector = connectors.iter().find(|c| c.name == end.connector);
    let connector =
        connector.ok_or_else(|| fault(format!("component {name} has no connector {}", end.connector)))?;
    let at = |message: String| connector.place.fault(format!("connector {end}: {message}"));
    if connector.direction != direction {
        return Err(at(format!(
            "it is an {} here and a variable of causality {} in the FMU",
            connector.direction, variable.causality
        )));
    }
    if let Some(declared) = connector.sort.filter(|s| *s != sort(variable.kind)) {
        return Err(at(format!("it is {declared:?} here and {:?} in the FMU", variable.kind)));
    }
    let outer = connector.unit.clone().or_else(|| inner.clone());
    let way = |a: &Option<Unit>, b: &Option<Unit>| conversion(a.as_ref(), b.as_ref(), variable.relative);
    let (Some(to_connector), Some(from_connector)) = (way(&inner, &outer), way(&outer, &inner)) else {
        return Err(at(format!(
            "its unit {} is not compatible with the variable, whose unit is {}",
            named(&outer),
            named(&inner)
        )));
    };
    Ok(Found::Variable { port, direction, unit: outer, to_connector, from_connector })
}

pub(crate) fn direction(variable: &Variable) -> Direction {
    match variable.causality {
        Causality::Input => Direction::Input,
        Causality::Output => Direction::Output,
        _ => Direction::Parameter,
    }
}

pub(crate) fn sort(kind: Kind) -> Sort {
    match kind {
        Kind::Float64 | Kind::Float32 => Sort::Real,
        Kind::Boolean => Sort::Boolean,
        Kind::String => Sort::String,
        Kind::Enumeration => Sort::Enumeration,
        Kind::Binary | Kind::Clock => Sort::Binary,
        _ => Sort::Integer,
    }
}

pub(crate) fn apart(a: &str, a_unit: &Option<Unit>, b: &str, b_unit: &Option<Unit>) -> String {
    format!("{a} is in {} and {b} in {}: these cannot be converted", named(a_unit), named(b_unit))
}

pub(crate) fn named(unit: &Option<Unit>) -> &str {
    unit.as_ref().map_or("no unit", |u| &u.name)
}

pub(crate) fn no_signal(name: &str, variable: &Variable) -> String {
    format!("{name} is a {}, and connections join outputs and inputs", variable.causality)
}
