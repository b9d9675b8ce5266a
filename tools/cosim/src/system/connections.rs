//! Resolves the names of a system in its FMUs: the source and the conversion of each connected input, and the values to set.
use super::ends::{Found, apart, find, no_signal, sort};
use super::parts::{Parts, Port};
use super::settings::{Given, given, owner, refused, setting_error, value};
use super::structure::{Connection, Direction, End, Setting};
use super::units::{Affine, conversion};
use crate::{Causality, DisplayUnit, Error, InputTable, Kind, Unit, Value};

/// An input that is connected to an output.
#[derive(Clone, Debug)]
pub(crate) struct InputConnection {
    pub(crate) port: Port,
    /// Place in [`Connections::outputs`].
    pub(crate) source: usize,
    pub(crate) convert: Affine,
    /// The connection in the structure.
    pub(crate) connection: usize,
}

/// An output of the system itself.
#[derive(Clone, Debug)]
pub(crate) struct SystemOutput {
    pub(crate) name: String,
    pub(crate) port: Port,
    pub(crate) convert: Affine,
    pub(crate) unit: Option<Unit>,
}

/// An input of the system itself, with one of the inputs that it goes to.
#[derive(Clone, Debug)]
pub(crate) struct SystemInput {
    pub(crate) name: String,
    pub(crate) port: Port,
    /// From the connector of the system to the input.
    pub(crate) convert: Affine,
    /// The unit of the connector of the system, if it declares one.
    pub(crate) unit: Option<Unit>,
}

/// The connections as the master uses them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Connections {
    /// Connected outputs, each once.
    pub(crate) outputs: Vec<Port>,
    pub(crate) inputs: Vec<InputConnection>,
    pub(crate) system_outputs: Vec<SystemOutput>,
    pub(crate) system_inputs: Vec<SystemInput>,
    /// Values to set, by component; variables by their place.
    pub(crate) sets: Vec<Vec<(usize, Value)>>,
    pub(crate) notes: Vec<String>,
}

/// Resolves every name; [`Connections::check_open_inputs`] checks the result. `overrides` are settings `component.variable` or inputs of the system that take precedence over
/// those of the file; with `display_units` their numbers without a unit are in display units.
pub(crate) fn resolve(
    parts: Parts,
    overrides: &[(String, String)],
    display_units: bool,
) -> Result<Connections, Error> {
    let structure = parts.structure;
    let mut connections =
        Connections { sets: vec![Vec::new(); structure.components.len()], ..Connections::default() };
    // The settings of variables, to be compared with the connections.
    let mut fixed: Vec<(Port, Setting, bool)> = Vec::new();
    for (index, component) in structure.components.iter().enumerate() {
        for setting in &component.settings {
            let set = value(parts.description(index), &setting.name, setting, None, None);
            let set = set.map_err(|e| setting_error(component, setting, false, e))?;
            fixed.push((Port { component: index, variable: set.0 }, setting.clone(), false));
            connections.put(index, set);
        }
    }
    // What belongs to no component is for inputs of the system.
    let mut given = given(structure, overrides);
    for Given { setting, asked, used } in &mut given {
        let Some((index, name)) = owner(structure, &setting.name) else { continue };
        let description = parts.description(index);
        let shown = description.variable(name).filter(|_| *asked && display_units);
        let shown = shown.and_then(|variable| description.display_unit(variable));
        let set = value(description, name, setting, None, shown.as_ref());
        let set = set.map_err(|e| setting_error(&structure.components[index], setting, *asked, e))?;
        fixed.push((Port { component: index, variable: set.0 }, setting.clone(), *asked));
        connections.put(index, set);
        *used = true;
    }
    for (index, connection) in structure.connections.iter().enumerate() {
        connections.connect(parts, index, connection)?;
    }
    for (port, setting, asked) in &fixed {
        connections.check_unconnected(parts, *port, setting, *asked)?;
    }
    connections.set_inputs(parts, &mut given, display_units)?;
    if let Some(Given { setting, asked, .. }) = given.iter().find(|g| !g.used) {
        let message = "is neither component.variable nor an input of the system".to_owned();
        return Err(refused(setting, *asked, message));
    }
    Ok(connections)
}

impl Connections {
    /// Later values win.
    fn put(&mut self, component: usize, (variable, value): (usize, Value)) {
        let sets = &mut self.sets[component];
        sets.retain(|(v, _)| *v != variable);
        sets.push((variable, value));
    }

    fn connect(&mut self, parts: Parts, index: usize, connection: &Connection) -> Result<(), Error> {
        let fault = |message: String| connection.place.fault(format!("{connection}: {message}"));
        let start = find(parts, connection, &connection.start)?;
        let end = find(parts, connection, &connection.end)?;
        match (start, end) {
            (a @ Found::Variable { .. }, b @ Found::Variable { .. }) => {
                self.join(parts, index, connection, a, b)
            }
            (Found::System { .. }, Found::System { .. }) => {
                Err(fault("both ends are connectors of the system".to_owned()))
            }
            (
                Found::System { name, declared },
                Found::Variable { port, direction, unit, to_connector, from_connector },
            )
            | (
                Found::Variable { port, direction, unit, to_connector, from_connector },
                Found::System { name, declared },
            ) => {
                if let Some(other) = declared.filter(|c| c.direction != direction) {
                    return Err(fault(format!(
                        "{} is an {direction} and the system's {name} an {}",
                        parts.name(port),
                        other.direction
                    )));
                }
                let outer = declared.and_then(|c| c.unit.clone());
                let relative = parts.variable(port).relative;
                if direction == Direction::Output {
                    let convert = between(connection, unit.as_ref(), outer.as_ref(), relative)
                        .ok_or_else(|| fault(apart(&parts.name(port), &unit, name, &outer)))?;
                    let convert = to_connector.then(convert);
                    if self.system_outputs.iter().any(|s| s.name == name) {
                        return Err(fault(format!("the system's output {name} has a source already")));
                    }
                    self.system_outputs.push(SystemOutput {
                        name: name.to_owned(),
                        port,
                        convert,
                        unit: outer.or(unit),
                    });
                    return Ok(());
                }
                if direction == Direction::Parameter {
                    return Err(fault(no_signal(&parts.name(port), parts.variable(port))));
                }
                self.check_free(parts, index, port)?;
                let convert = between(connection, outer.as_ref(), unit.as_ref(), relative)
                    .ok_or_else(|| fault(apart(name, &outer, &parts.name(port), &unit)))?;
                let way = convert.then(from_connector);
                self.system_inputs.push(SystemInput {
                    name: name.to_owned(),
                    port,
                    convert: way,
                    unit: outer.clone(),
                });
                Ok(())
            }
        }
    }

    /// Gives the inputs of the system their values, the last one of each.
    fn set_inputs(&mut self, parts: Parts, given: &mut [Given], display_units: bool) -> Result<(), Error> {
        for place in 0..self.system_inputs.len() {
            let SystemInput { name, port, convert, unit } = self.system_inputs[place].clone();
            let mut last = None;
            for entry in given.iter_mut().filter(|g| g.setting.name == name) {
                entry.used = true;
                last = Some(entry);
            }
            let Some(Given { setting, asked, .. }) = last else { continue };
            let shown = self.displayed(parts, &name).filter(|_| *asked && display_units);
            let shown = shown.map(|(_, display)| display);
            let variable = &parts.variable(port).name;
            let way = Some((unit.as_ref(), convert));
            let set = value(parts.description(port.component), variable, setting, way, shown.as_ref());
            let component = &parts.structure.components[port.component];
            self.put(port.component, set.map_err(|e| setting_error(component, setting, *asked, e))?);
        }
        Ok(())
    }

    /// The display unit of an input of the system: that of the first variable that has one and takes the numbers as they are.
    pub(crate) fn displayed(&self, parts: Parts, name: &str) -> Option<(Port, DisplayUnit)> {
        let same = self.system_inputs.iter().filter(|s| s.name == name && s.convert == Affine::IDENTITY);
        let display = |port: Port| parts.description(port.component).display_unit(parts.variable(port));
        same.map(|input| input.port).find_map(|port| Some((port, display(port)?)))
    }

    /// A connection between two components.
    fn join(
        &mut self,
        parts: Parts,
        index: usize,
        connection: &Connection,
        a: Found,
        b: Found,
    ) -> Result<(), Error> {
        let fault = |message: String| connection.place.fault(format!("{connection}: {message}"));
        let (Found::Variable { port: p, direction: d, .. }, Found::Variable { port: q, direction: e, .. }) =
            (&a, &b)
        else {
            return Ok(());
        };
        let (from, to) = match (d, e) {
            (Direction::Output, Direction::Input) => (a, b),
            (Direction::Input, Direction::Output) => (b, a),
            (Direction::Output, Direction::Output) => return Err(fault("both ends are outputs".to_owned())),
            (Direction::Input, Direction::Input) => return Err(fault("both ends are inputs".to_owned())),
            (Direction::Parameter, _) => return Err(fault(no_signal(&parts.name(*p), parts.variable(*p)))),
            (_, Direction::Parameter) => return Err(fault(no_signal(&parts.name(*q), parts.variable(*q)))),
        };
        let Found::Variable { port: source, unit: from_unit, to_connector, .. } = from else { return Ok(()) };
        let Found::Variable { port: target, unit: to_unit, from_connector, .. } = to else { return Ok(()) };
        let (y, u) = (parts.variable(source), parts.variable(target));
        for (port, variable) in [(source, y), (target, u)] {
            if !variable.dimensions.is_empty() || !variable.kind.is_numeric() {
                let what = if variable.dimensions.is_empty() { "no number" } else { "an array" };
                return Err(fault(format!(
                    "{} is {what}, and only scalar numbers are connected",
                    parts.name(port)
                )));
            }
        }
        if sort(y.kind) != sort(u.kind) {
            return Err(fault(format!(
                "{} is {:?} and {} is {:?}",
                parts.name(source),
                sort(y.kind),
                parts.name(target),
                sort(u.kind)
            )));
        }
        self.check_free(parts, index, target)?;
        if connection.is_linear() && !y.kind.is_float() {
            return Err(fault("a linear transformation is for real values".to_owned()));
        }
        let units = between(connection, from_unit.as_ref(), to_unit.as_ref(), u.relative)
            .ok_or_else(|| fault(apart(&parts.name(source), &from_unit, &parts.name(target), &to_unit)))?;
        let slot = self.outputs.iter().position(|p| *p == source).unwrap_or_else(|| {
            self.outputs.push(source);
            self.outputs.len() - 1
        });
        let convert = to_connector.then(units).then(from_connector);
        self.inputs.push(InputConnection { port: target, source: slot, convert, connection: index });
        Ok(())
    }

    /// The value of a connected input would have no effect. A parameter set of an SSP file, whose components declare their connectors, may
    /// contain one, as start value.
    fn check_unconnected(
        &self,
        parts: Parts,
        port: Port,
        setting: &Setting,
        asked: bool,
    ) -> Result<(), Error> {
        let is_start_value = !asked && parts.structure.components[port.component].connectors.is_some();
        let Some(reason) = self.other_source(parts, port).filter(|_| !is_start_value) else {
            return Ok(());
        };
        Err(refused(
            setting,
            asked,
            if asked { format!("has no effect: {reason}") } else { format!("= {}: {reason}", setting.text) },
        ))
    }

    /// A sentence on the connection that drives this input; `None` if none does.
    pub(crate) fn other_source(&self, parts: Parts, port: Port) -> Option<String> {
        let input = self.inputs.iter().find(|i| i.port == port)?;
        let connection = &parts.structure.connections[input.connection];
        Some(format!("{} has a source already, the {connection}", parts.name(port)))
    }

    /// An input has one source.
    fn check_free(&self, parts: Parts, index: usize, port: Port) -> Result<(), Error> {
        let structure = parts.structure;
        let name = parts.name(port);
        let same = |end: &End| end.component.is_some() && end.to_string() == name;
        let earlier = structure.connections[..index].iter().find(|c| same(&c.start) || same(&c.end));
        match earlier {
            None => Ok(()),
            Some(other) => Err(structure.connections[index].place.fault(format!(
                "{}: {name} has a source already, the {other} in line {}",
                structure.connections[index], other.place.line
            ))),
        }
    }

    /// Unconnected inputs that are in no table keep their start value, if they have one.
    pub(crate) fn check_open_inputs(
        &mut self,
        parts: Parts,
        table: Option<&InputTable>,
    ) -> Result<(), Error> {
        let columns = table.map_or(&[][..], InputTable::columns);
        for (index, component) in parts.structure.components.iter().enumerate() {
            let mut open: Vec<&str> = Vec::new();
            for (place, variable) in parts.description(index).variables.iter().enumerate() {
                let fed = self.inputs.iter().any(|f| f.port == Port { component: index, variable: place })
                    || self.sets[index].iter().any(|(v, _)| *v == place)
                    || columns.iter().any(|c| (c.component, c.variable) == (index, place));
                if variable.causality != Causality::Input || variable.kind == Kind::Clock || fed {
                    continue;
                }
                if variable.start.is_none() {
                    return Err(component.place.fault(format!(
                        "component {}: the input {} has no connection, no value and no start value",
                        component.name, variable.name
                    )));
                }
                open.push(&variable.name);
            }
            if !open.is_empty() {
                let what =
                    if open.len() == 1 { "stays at its start value" } else { "stay at their start values" };
                self.notes.push(format!("{}: {} {what}", component.name, open.join(", ")));
            }
        }
        Ok(())
    }
}

/// The conversion that a connection makes between the units of two connectors.
pub(crate) fn between(
    connection: &Connection,
    from: Option<&Unit>,
    to: Option<&Unit>,
    relative: bool,
) -> Option<Affine> {
    let (mut unit, mut all) = (from, Affine::IDENTITY);
    for (place, leg) in connection.legs.iter().enumerate() {
        let is_last = place + 1 == connection.legs.len();
        let next = if is_last { to } else { leg.unit.as_ref().or(unit) };
        let units = if leg.convert_units { conversion(unit, next, relative)? } else { Affine::IDENTITY };
        all = all.then(units).then(Affine { factor: leg.factor, offset: leg.offset });
        unit = next;
    }
    Some(all)
}
