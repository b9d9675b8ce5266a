//! Inputs over time of a system: columns `component.variable`, or connectors of the system.
use super::connections::Connections;
use super::parts::{Parts, Port};
use super::settings::owner;
use super::units::{Affine, conversion, unit_of};
use crate::input::{Target, content};
use crate::quantity::{of_column, unknown_column};
use crate::{Error, InputTable};
use std::path::Path;

/// Reads the table at `path` for the inputs of a system that nothing else sets. A column without a unit is in the
/// unit of the variable, or in its display unit; a connector of the system may have a unit of its own.
pub(crate) fn read(
    path: &Path,
    parts: Parts,
    connections: &Connections,
    display_units: bool,
) -> Result<InputTable, Error> {
    let (bytes, path) = content(path)?;
    InputTable::parse_for(path, &bytes, &|name, unit| {
        let targets = targets(name, unit, parts, connections, display_units)?;
        for (_, port) in &targets {
            if connections.sets[port.component].iter().any(|(v, _)| *v == port.variable) {
                return Err(format!("column {name}: {} has a constant value already", parts.name(*port)));
            }
            if let Some(reason) = connections.other_source(parts, *port) {
                return Err(format!("column {}: {reason}", parts.name(*port)));
            }
        }
        Ok(targets.into_iter().map(|(target, _)| target).collect())
    })
}

fn targets<'a>(
    name: &str,
    unit: Option<&str>,
    parts: Parts<'a>,
    connections: &Connections,
    display_units: bool,
) -> Result<Vec<(Target<'a>, Port)>, String> {
    let mut targets = Vec::new();
    for input in connections.system_inputs.iter().filter(|s| s.name == name) {
        let (description, variable) = (parts.description(input.port.component), parts.variable(input.port));
        let is_of_connector = unit.is_none() || input.unit.as_ref().map(|u| u.name.as_str()) == unit;
        let displayed = connections.displayed(parts, name).filter(|_| display_units && unit.is_none());
        // In the display unit of the input or the unit of the connector, else in another one, which the FMU defines.
        let to_connector = if let Some((first, _)) = displayed {
            of_column(parts.description(first.component), parts.variable(first), None, true)?
        } else if is_of_connector {
            Affine::IDENTITY
        } else {
            let inner = unit_of(description, variable);
            let outward = conversion(inner.as_ref(), input.unit.as_ref(), variable.relative);
            of_column(description, variable, unit, false)?.then(outward.unwrap_or(Affine::IDENTITY))
        };
        let convert = to_connector.then(input.convert);
        let target = Target { component: input.port.component, description, variable, convert };
        targets.push((target, input.port));
    }
    if !targets.is_empty() {
        return Ok(targets);
    }
    let Some((component, inner)) = owner(parts.structure, name) else {
        return Err(format!(
            "unknown column: {name} is neither component.variable nor an input of the system"
        ));
    };
    let description = parts.description(component);
    let variable = description.settable(inner).map_err(|e| unknown_column(description, inner, &e))?;
    let place = description.variables.iter().position(|v| v.name == inner).unwrap_or(0);
    let convert = of_column(description, variable, unit, display_units)?;
    let port = Port { component, variable: place };
    Ok(vec![(Target { component, description, variable, convert }, port)])
}
