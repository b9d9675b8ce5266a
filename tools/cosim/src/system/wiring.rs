//! The names of a system held against its FMUs: who feeds whom, with which conversion, and which values are set.
use super::structure::{Component, Connection, Connector, Direction, End, Place, Setting, Sort, Structure};
use super::units::{Affine, conversion, unit_of};
use crate::value::nearest;
use crate::{Archive, Causality, Error, Kind, ModelDescription, Unit, Value, Variable};

/// A variable of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Port {
    pub(crate) component: usize,
    /// Place in the FMU's list of variables.
    pub(crate) variable: usize,
}

/// An input that is fed by an output.
#[derive(Clone, Debug)]
pub(crate) struct Feed {
    pub(crate) port: Port,
    /// Place in [`Wiring::outputs`].
    pub(crate) source: usize,
    pub(crate) convert: Affine,
    /// The connection in the structure.
    pub(crate) connection: usize,
}

/// An output of the system itself.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    pub(crate) name: String,
    pub(crate) port: Port,
    pub(crate) convert: Affine,
    pub(crate) unit: Option<Unit>,
}

/// Everything that the master needs to know of the connections.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wiring {
    /// Outputs that feed something, each once.
    pub(crate) outputs: Vec<Port>,
    pub(crate) feeds: Vec<Feed>,
    pub(crate) shown: Vec<Shown>,
    /// Values to set, by component; variables by their place.
    pub(crate) sets: Vec<Vec<(usize, Value)>>,
    /// What is odd but no error.
    pub(crate) notes: Vec<String>,
}

/// A structure with the archive of each component.
#[derive(Clone, Copy)]
pub(crate) struct Parts<'a> {
    pub(crate) structure: &'a Structure,
    pub(crate) archives: &'a [Archive],
}

impl<'a> Parts<'a> {
    pub(crate) fn description(&self, component: usize) -> &'a ModelDescription {
        self.archives[component].description()
    }

    pub(crate) fn variable(&self, port: Port) -> &'a Variable {
        &self.description(port.component).variables[port.variable]
    }

    /// `component.variable`
    pub(crate) fn name(&self, port: Port) -> String {
        format!("{}.{}", self.structure.components[port.component].name, self.variable(port).name)
    }
}

/// An end of a connection, found.
enum Found<'a> {
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

/// Resolves every name. `overrides` are settings `component.variable` or inputs of the system that win over the
/// file's.
pub(crate) fn resolve(parts: Parts, overrides: &[(String, String)]) -> Result<Wiring, Error> {
    let structure = parts.structure;
    let mut wiring = Wiring { sets: vec![Vec::new(); structure.components.len()], ..Wiring::default() };
    let mut given: Vec<(&Setting, bool)> = structure.settings.iter().map(|s| (s, false)).collect();
    let nowhere = Place { file: "".into(), line: 0 };
    let asked: Vec<Setting> = overrides
        .iter()
        .map(|(name, text)| Setting {
            name: name.clone(),
            text: text.clone(),
            unit: None,
            place: nowhere.clone(),
        })
        .collect();
    given.extend(asked.iter().map(|s| (s, true)));

    for (index, component) in structure.components.iter().enumerate() {
        for setting in &component.settings {
            let set = value(parts.description(index), &setting.name, setting, None);
            wiring.put(index, set.map_err(|e| told(component, setting, false, e))?);
        }
    }
    let mut system_inputs: Vec<(&Setting, bool, bool)> = Vec::new();
    for (setting, asked) in given {
        match owner(structure, &setting.name) {
            Some((index, name)) => {
                let set = value(parts.description(index), name, setting, None);
                wiring.put(index, set.map_err(|e| told(&structure.components[index], setting, asked, e))?);
            }
            None => system_inputs.push((setting, asked, false)),
        }
    }
    for (index, connection) in structure.connections.iter().enumerate() {
        wiring.connect(parts, index, connection, &mut system_inputs)?;
    }
    if let Some((setting, asked, _)) = system_inputs.iter().find(|(_, _, used)| !used) {
        let message = "is neither component.variable nor an input of the system".to_owned();
        return Err(refused(setting, *asked, message));
    }
    wiring.check_open_inputs(parts)?;
    Ok(wiring)
}

impl Wiring {
    /// Later values win.
    fn put(&mut self, component: usize, (variable, value): (usize, Value)) {
        let sets = &mut self.sets[component];
        sets.retain(|(v, _)| *v != variable);
        sets.push((variable, value));
    }

    fn connect(
        &mut self,
        parts: Parts,
        index: usize,
        connection: &Connection,
        system_inputs: &mut [(&Setting, bool, bool)],
    ) -> Result<(), Error> {
        let fault = |message: String| connection.place.fault(format!("{connection}: {message}"));
        let start = find(parts, connection, &connection.start)?;
        let end = find(parts, connection, &connection.end)?;
        match (start, end) {
            (a @ Found::Variable { .. }, b @ Found::Variable { .. }) => {
                self.join(parts, index, connection, a, b)
            }
            (Found::System { .. }, Found::System { .. }) => {
                Err(fault("both ends are connectors of the system, no component is between them".to_owned()))
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
                    self.shown.push(Shown { name: name.to_owned(), port, convert, unit: outer.or(unit) });
                    return Ok(());
                }
                if direction == Direction::Parameter {
                    return Err(fault(no_signal(&parts.name(port), parts.variable(port))));
                }
                self.check_free(parts, index, port)?;
                let convert = between(connection, outer.as_ref(), unit.as_ref(), relative)
                    .ok_or_else(|| fault(apart(name, &outer, &parts.name(port), &unit)))?;
                let mut text = None;
                for entry in system_inputs.iter_mut().filter(|(s, _, _)| s.name == *name) {
                    entry.2 = true;
                    text = Some(*entry);
                }
                let Some((setting, asked, _)) = text else { return Ok(()) };
                let variable = &parts.variable(port).name;
                let way = convert.then(from_connector);
                let set =
                    value(parts.description(port.component), variable, setting, Some((outer.as_ref(), way)));
                let component = &parts.structure.components[port.component];
                self.put(port.component, set.map_err(|e| told(component, setting, asked, e))?);
                Ok(())
            }
        }
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
        let linear = Affine { factor: connection.factor, offset: connection.offset };
        if linear != Affine::IDENTITY && !y.kind.is_float() {
            return Err(fault("a linear transformation is for real values".to_owned()));
        }
        let units = between(connection, from_unit.as_ref(), to_unit.as_ref(), u.relative)
            .ok_or_else(|| fault(apart(&parts.name(source), &from_unit, &parts.name(target), &to_unit)))?;
        let slot = self.outputs.iter().position(|p| *p == source).unwrap_or_else(|| {
            self.outputs.push(source);
            self.outputs.len() - 1
        });
        let convert = to_connector.then(units).then(linear).then(from_connector);
        self.feeds.push(Feed { port: target, source: slot, convert, connection: index });
        Ok(())
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

    /// Inputs that nobody feeds keep their start value, if they have one.
    fn check_open_inputs(&mut self, parts: Parts) -> Result<(), Error> {
        for (index, component) in parts.structure.components.iter().enumerate() {
            let mut open: Vec<&str> = Vec::new();
            for (place, variable) in parts.description(index).variables.iter().enumerate() {
                let fed = self.feeds.iter().any(|f| f.port == Port { component: index, variable: place })
                    || self.sets[index].iter().any(|(v, _)| *v == place);
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

/// Looks an end up among the components and connectors.
fn find<'a>(parts: Parts<'a>, connection: &Connection, end: &'a End) -> Result<Found<'a>, Error> {
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
        return Err(fault(format!("there is no component {name}{}", hint(nearest(name, names)))));
    };
    let description = parts.description(component);
    let Some(variable) = description.variables.iter().position(|v| v.name == end.connector) else {
        let signals = description.variables.iter().filter(|v| direction(v) != Direction::Parameter);
        let near = nearest(&end.connector, signals.map(|v| v.name.as_str()));
        return Err(fault(format!("{name} has no variable {}{}", end.connector, hint(near))));
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
            "its unit {} is no unit of the variable, which is in {}",
            named(&outer),
            named(&inner)
        )));
    };
    Ok(Found::Variable { port, direction, unit: outer, to_connector, from_connector })
}

fn direction(variable: &Variable) -> Direction {
    match variable.causality {
        Causality::Input => Direction::Input,
        Causality::Output => Direction::Output,
        _ => Direction::Parameter,
    }
}

fn sort(kind: Kind) -> Sort {
    match kind {
        Kind::Float64 | Kind::Float32 => Sort::Real,
        Kind::Boolean => Sort::Boolean,
        Kind::String => Sort::String,
        Kind::Enumeration => Sort::Enumeration,
        Kind::Binary | Kind::Clock => Sort::Binary,
        _ => Sort::Integer,
    }
}

/// The conversion that a connection makes between the units of two connectors.
fn between(
    connection: &Connection,
    from: Option<&Unit>,
    to: Option<&Unit>,
    relative: bool,
) -> Option<Affine> {
    if connection.convert_units { conversion(from, to, relative) } else { Some(Affine::IDENTITY) }
}

/// The component that a setting `component.variable` belongs to, and the rest of the name.
fn owner<'a>(structure: &Structure, name: &'a str) -> Option<(usize, &'a str)> {
    let rest = |c: &Component| name.strip_prefix(c.name.as_str())?.strip_prefix('.');
    let all = structure.components.iter().enumerate().filter_map(|(i, c)| Some((i, rest(c)?)));
    // Names of SSP may have dots: the longest one counts.
    all.min_by_key(|(_, rest)| rest.len())
}

/// A setting as a value of the variable `name`. `way` leads from a connector of the system, with its unit, inward.
fn value(
    description: &ModelDescription,
    name: &str,
    setting: &Setting,
    way: Option<(Option<&Unit>, Affine)>,
) -> Result<(usize, Value), Error> {
    let variable = description.settable(name)?;
    let place = description.variables.iter().position(|v| v.name == name).unwrap_or(0);
    let inner = unit_of(description, variable);
    let (outer, way) = way.unwrap_or((inner.as_ref(), Affine::IDENTITY));
    let Some(convert) = conversion(setting.unit.as_ref(), outer, variable.relative) else {
        return Err(Error::Unsupported {
            name: variable.name.clone(),
            reason: format!(
                "is in {}, its value in {}: these cannot be converted",
                named(&inner),
                named(&setting.unit)
            ),
        });
    };
    let convert = convert.then(way);
    let number: Option<f64> = setting.text.trim().parse().ok();
    let text = match number.filter(|_| convert != Affine::IDENTITY && variable.kind.is_float()) {
        Some(number) => convert.of(number).to_string(),
        None => setting.text.clone(),
    };
    Ok((place, description.value_of(variable, &text)?))
}

/// What is wrong with a setting, and where it stands.
fn told(component: &Component, setting: &Setting, asked: bool, error: Error) -> Error {
    if asked {
        return refused(setting, true, format!("is refused: {error}"));
    }
    setting.place.fault(format!("component {}: {error}", component.name))
}

fn refused(setting: &Setting, asked: bool, reason: String) -> Error {
    if asked {
        return Error::Option {
            option: "setting",
            value: format!("{} = {}", setting.name, setting.text),
            reason,
        };
    }
    setting.place.fault(format!("{} {reason}", setting.name))
}

fn apart(a: &str, a_unit: &Option<Unit>, b: &str, b_unit: &Option<Unit>) -> String {
    format!("{a} is in {} and {b} in {}: these cannot be converted", named(a_unit), named(b_unit))
}

fn named(unit: &Option<Unit>) -> &str {
    unit.as_ref().map_or("no unit", |u| &u.name)
}

fn no_signal(name: &str, variable: &Variable) -> String {
    format!("{name} is a {}, and connections join outputs and inputs", variable.causality)
}

fn hint(near: Vec<String>) -> String {
    if near.is_empty() { String::new() } else { format!(", did you mean {}?", near.join(" or ")) }
}
