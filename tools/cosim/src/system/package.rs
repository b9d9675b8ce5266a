//! The writer of SSP 1.0: `SystemStructure.ssd`, the parameters of the system (`parameter_files.rs`), and the FMUs below `resources`.
//!
//! Other tools support only a part of the standard, so the file uses the common part: the usual prefixes; only connected inputs are
//! connectors; values of enumerations are integers, as in FMI 2; units are those of the FMUs; the step size is in an
//! annotation that other masters read as well.
use super::connections::{Connections, between, resolve};
use super::dictionary::{self, Dictionary};
use super::parameter_files::{self, MAPPING, VALUES};
use super::parts::{Parts, Port};
use super::ssd::{FMU, MAIN, STEP_ANNOTATION};
use super::structure::{Component, Connection, End, Leg, Time, unit_in};
use super::tags::{NAMESPACES, Tag, between_ends, document, leaf, list, node, type_tag, unit_tag, within};
use super::times::{self, Times};
use super::units::{Affine, unit_of};
use crate::raw::encoded;
use crate::{BaseUnit, Causality, Error, Kind, Unit, Value, Variable};
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Cursor, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// The name of the parameter sets of all components: some tools read those of one name only.
const PARAMETER_SET: &str = "initialValues";
const STEP_NAMESPACE: (&str, &str) = ("xmlns:osp", "http://opensimulationplatform.com/SSP/OSPAnnotations");

/// What an SSP archive has beside components, values and connections.
#[derive(Clone, Copy, Debug, Default)]
pub struct SspForm {
    /// Leave out the inputs and outputs of the system, for tools that read connections between components only.
    pub components_only: bool,
    /// Connect the components through a signal dictionary (SSB) in a file of its own.
    pub dictionary: bool,
}

pub(crate) fn write(parts: Parts, path: &Path, form: SspForm) -> Result<(), Error> {
    let mut connections = resolve(parts, &[], false)?;
    connections.check_open_inputs(parts, None)?;
    let grid = times::grid(parts, Times::default(), None)?;
    times::check_component_steps(parts, &grid, parts.structure.step.is_some())?;
    let io = Error::io("write", path);
    let resources = resources(&parts.structure.components);
    let parameters = parameter_files::files(parts, &connections).map_err(&io)?;
    let mut document = Document {
        parts,
        has_parameters: parameters.is_some(),
        connections: &connections,
        inner_only: form.components_only,
        dictionary: None,
        resources: &resources,
        units: BTreeMap::new(),
    };
    document.dictionary =
        form.dictionary.then(|| Dictionary::of(parts, document.sources())).filter(|d| !d.is_empty());
    let dictionary = document.dictionary.as_ref().map(Dictionary::file).transpose().map_err(&io)?;
    let xml = document.text().map_err(&io)?;
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let failed = |e: zip::result::ZipError| io(io::Error::other(e));
    zip.start_file(MAIN, entry(CompressionMethod::Deflated)).map_err(&failed)?;
    zip.write_all(xml.as_bytes()).map_err(&io)?;
    for (name, text) in [VALUES, MAPPING].into_iter().zip(parameters.into_iter().flatten()) {
        zip.start_file(name, entry(CompressionMethod::Deflated)).map_err(&failed)?;
        zip.write_all(text.as_bytes()).map_err(&io)?;
    }
    if let Some(text) = dictionary {
        zip.start_file(dictionary::FILE, entry(CompressionMethod::Deflated)).map_err(&failed)?;
        zip.write_all(text.as_bytes()).map_err(&io)?;
    }
    for (source, name) in &resources {
        let bytes = fs::read(source).map_err(Error::io("read", source))?;
        // FMUs are compressed already.
        zip.start_file(name.as_str(), entry(CompressionMethod::Stored)).map_err(&failed)?;
        zip.write_all(&bytes).map_err(&io)?;
    }
    let bytes = zip.finish().map_err(&failed)?.into_inner();
    fs::write(path, bytes).map_err(&io)
}

fn entry(method: CompressionMethod) -> SimpleFileOptions {
    SimpleFileOptions::default()
        .compression_method(method)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644)
}

/// The FMUs, each once, with their names in the archive, in the order of the names.
fn resources(components: &[Component]) -> Vec<(&Path, String)> {
    let mut named: Vec<(&Path, String)> = Vec::new();
    for component in components {
        let path = component.path.as_path();
        if named.iter().any(|(p, _)| *p == path) {
            continue;
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        // Files of the same name from two folders.
        let numbered = |k: usize| match k {
            1 => format!("resources/{stem}.fmu"),
            _ => format!("resources/{stem}-{k}.fmu"),
        };
        let taken = |name: &String| named.iter().any(|(_, n)| n == name);
        let name = (1..).map(numbered).find(|n| !taken(n)).unwrap_or_default();
        named.push((path, name));
    }
    named.sort_by(|a, b| a.1.cmp(&b.1));
    named
}

struct Document<'a> {
    parts: Parts<'a>,
    /// Whether the package has files with parameters of the system.
    has_parameters: bool,
    connections: &'a Connections,
    /// Without inputs and outputs of the system.
    inner_only: bool,
    dictionary: Option<Dictionary>,
    resources: &'a [(&'a Path, String)],
    units: BTreeMap<String, BaseUnit>,
}

impl Document<'_> {
    fn text(mut self) -> io::Result<String> {
        let structure = self.parts.structure;
        let mut root: Vec<(&str, &str)> = NAMESPACES.to_vec();
        // At the root: libcosim takes an attribute of its own element for an algorithm.
        let has_step = structure.step.is_some() || structure.components.iter().any(|c| c.step.is_some());
        root.extend(has_step.then_some(STEP_NAMESPACE));
        root.extend([("name", structure.name.as_str()), ("version", "1.0"), ("generationTool", "motor-fmu")]);
        let mut system: Vec<Tag> = self.system_connectors().into_iter().collect();
        system.extend(self.has_parameters.then(parameter_files::binding));
        let mut components: Vec<Tag> =
            (0..structure.components.len()).map(|index| self.component(index)).collect();
        components.extend(self.dictionary.as_ref().map(Dictionary::reference));
        system.push(node("ssd:Elements", &[], components));
        system.extend(list("ssd:Connections", self.connections()));
        system.extend(self.dictionary.as_ref().map(|_| dictionary::declaration()));
        let mut children = vec![node("ssd:System", &[("name", &structure.name)], system)];
        children.extend(self.unit_definitions());
        children.extend(self.experiment());
        document(&node("ssd:SystemStructureDescription", &root, children))
    }

    /// The connections that are written.
    fn written(&self) -> impl Iterator<Item = &Connection> {
        let inner_only = self.inner_only;
        self.parts.structure.connections.iter().filter(move |c| !inner_only || c.is_inner())
    }

    /// The outputs that are connected to a component, once for each connection.
    fn sources(&self) -> impl Iterator<Item = (&End, Port)> {
        let inner = self.written().filter(|connection| connection.is_inner());
        inner.map(|connection| self.ends(connection).0).filter_map(|end| Some((end, self.port(end)?)))
    }

    /// Connectors of the system: ends of connections without a component.
    fn system_connectors(&mut self) -> Option<Tag> {
        let declared = self.parts.structure.connectors.as_deref();
        let mut ports: Vec<(String, &str, Port)> = Vec::new();
        for connection in self.parts.structure.connections.iter().filter(|_| !self.inner_only) {
            let (outer, inner) = match (&connection.start.component, &connection.end.component) {
                (None, Some(_)) => (&connection.start, &connection.end),
                (Some(_), None) => (&connection.end, &connection.start),
                _ => continue,
            };
            let Some(port) = self.port(inner) else { continue };
            if !ports.iter().any(|(name, _, _)| *name == outer.connector) {
                ports.push((outer.connector.clone(), kind_of(self.parts.variable(port)), port));
            }
        }
        let tags = ports.into_iter().map(|(name, kind, port)| {
            let unit = unit_in(declared, &name);
            self.connector(&name, kind, port, unit)
        });
        list("ssd:Connectors", tags.collect())
    }

    fn component(&mut self, index: usize) -> Tag {
        let component = &self.parts.structure.components[index];
        let source = self.resources.iter().find(|(p, _)| *p == component.path).map_or("", |(_, name)| name);
        let attributes = [
            ("name", component.name.as_str()),
            ("type", FMU),
            ("source", &encoded(source, b"/-._~")),
            ("implementation", "CoSimulation"),
        ];
        let mut connectors = Vec::new();
        for (place, variable) in self.parts.description(index).variables.iter().enumerate() {
            let port = Port { component: index, variable: place };
            let ends = self.parts.structure.connections.iter().flat_map(|c| [&c.start, &c.end]);
            let joined = ends.into_iter().any(|end| self.port(end) == Some(port));
            let plain = variable.dimensions.is_empty()
                && (variable.kind.is_numeric() && variable.kind != Kind::Enumeration || joined);
            if plain && (variable.causality == Causality::Output || joined) {
                let unit = unit_in(component.connectors.as_deref(), &variable.name);
                connectors.push(self.connector(&variable.name, kind_of(variable), port, unit));
            }
        }
        let mut children = vec![node("ssd:Connectors", &[], connectors)];
        children.extend(self.values(index));
        children.extend(component.step.as_ref().map(|step| step_annotation(step.seconds)));
        node("ssd:Component", &attributes, children)
    }

    /// A connector for a variable, with the unit that the structure declares, else the variable's.
    fn connector(&mut self, name: &str, kind: &str, port: Port, unit: Option<Unit>) -> Tag {
        let variable = self.parts.variable(port);
        let unit = match variable.kind {
            Kind::Float64 | Kind::Float32 => {
                let own = || unit_of(self.parts.description(port.component), variable);
                unit.or_else(own).and_then(|u| self.define(u))
            }
            _ => None,
        };
        let sort = type_tag(variable.kind, unit.as_deref());
        node("ssd:Connector", &[("name", name), ("kind", kind)], sort.into_iter().collect())
    }

    /// The name under which a unit is defined in the file: its own, or a numbered one if another FMU means something
    /// else by it. None for a unit without definition.
    fn define(&mut self, unit: Unit) -> Option<String> {
        let base = unit.base?;
        let numbered = |k: usize| if k == 1 { unit.name.clone() } else { format!("{} ({k})", unit.name) };
        let fits = |name: &String| self.units.get(name).is_none_or(|known| *known == base);
        let name = (1..).map(numbered).find(fits)?;
        self.units.insert(name.clone(), base);
        Some(name)
    }

    fn values(&self, index: usize) -> Option<Tag> {
        let variables = &self.parts.description(index).variables;
        let value = |(variable, value): &(usize, Value)| {
            let (tag, text) = match value {
                Value::Real(x) => ("ssv:Real", x.to_string()),
                Value::Integer(x) => ("ssv:Integer", x.to_string()),
                Value::Boolean(x) => ("ssv:Boolean", x.to_string()),
                Value::String(x) => ("ssv:String", x.clone()),
                Value::Binary(x) => ("ssv:Binary", x.iter().map(|byte| format!("{byte:02x}")).collect()),
            };
            let name = &variables[*variable].name;
            node("ssv:Parameter", &[("name", name)], vec![leaf(tag, &[("value", &text)])])
        };
        let parameters = list("ssv:Parameters", self.connections.sets[index].iter().map(value).collect())?;
        let set = node("ssv:ParameterSet", &[("version", "1.0"), ("name", PARAMETER_SET)], vec![parameters]);
        Some(within(&["ssd:ParameterBindings", "ssd:ParameterBinding", "ssd:ParameterValues"], set))
    }

    /// Connections between components pass the signal dictionary, if there is one.
    fn connections(&self) -> Vec<Tag> {
        let through = |connection: &Connection| {
            let (from, to) = self.ends(connection);
            match self.dictionary.as_ref().and_then(|d| d.entry(from)).filter(|_| connection.is_inner()) {
                Some(entry) => self.connection(connection, &entry, to),
                None => self.connection(connection, from, to),
            }
        };
        let into = self.dictionary.iter().flat_map(Dictionary::sources);
        into.map(|(from, to)| leaf("ssd:Connection", &between_ends(from, &to)))
            .chain(self.written().map(through))
            .collect()
    }

    /// The ends of a connection, the source first, which some readers require.
    fn ends<'c>(&self, connection: &'c Connection) -> (&'c End, &'c End) {
        let backwards = self.port(&connection.start).is_some_and(|p| {
            connection.end.component.is_some()
                && connection.start.component.is_some()
                && self.parts.variable(p).causality == Causality::Input
        });
        match backwards {
            true => (&connection.end, &connection.start),
            false => (&connection.start, &connection.end),
        }
    }

    fn connection(&self, connection: &Connection, from: &End, to: &End) -> Tag {
        let mut attributes = between_ends(from, to);
        // A connection through nested systems becomes one, with the numbers of all its legs.
        let leg = match &connection.legs[..] {
            [leg] => leg.clone(),
            _ => {
                let unit = |end: &End| {
                    let (port, own) = (self.port(end), end.component.as_ref());
                    let component =
                        own.and_then(|n| self.parts.structure.components.iter().find(|c| c.name == *n));
                    let connectors = match component {
                        Some(component) => component.connectors.as_deref(),
                        None => self.parts.structure.connectors.as_deref(),
                    };
                    let inner = || {
                        port.and_then(|p| {
                            unit_of(self.parts.description(p.component), self.parts.variable(p))
                        })
                    };
                    unit_in(connectors, &end.connector).or_else(inner)
                };
                let relative = self.port(&connection.end).is_some_and(|p| self.parts.variable(p).relative);
                let (a, b) = (unit(&connection.start), unit(&connection.end));
                let Affine { factor, offset } =
                    between(connection, a.as_ref(), b.as_ref(), relative).unwrap_or(Affine::IDENTITY);
                Leg { convert_units: false, factor, offset, unit: None }
            }
        };
        attributes.extend((!leg.convert_units).then_some(("suppressUnitConversion", "true")));
        if (leg.factor, leg.offset) == (1.0, 0.0) {
            return leaf("ssd:Connection", &attributes);
        }
        let (factor, offset) = (leg.factor.to_string(), leg.offset.to_string());
        let linear = leaf("ssc:LinearTransformation", &[("factor", &factor), ("offset", &offset)]);
        node("ssd:Connection", &attributes, vec![linear])
    }

    fn unit_definitions(&self) -> Option<Tag> {
        list("ssd:Units", self.units.iter().map(|(name, base)| unit_tag(name, base)).collect())
    }

    fn experiment(&self) -> Option<Tag> {
        let structure = self.parts.structure;
        // Some tools need a start time.
        let seconds = |time: &Option<Time>| time.as_ref().map(|time| time.seconds);
        let start = seconds(&structure.start).or(Some(0.0));
        let times = [("startTime", start), ("stopTime", seconds(&structure.stop))];
        let attributes: Vec<_> = times.into_iter().filter_map(|(n, t)| Some((n, t?.to_string()))).collect();
        let children = seconds(&structure.step).map(|step| vec![step_annotation(step)]);
        let name = "ssd:DefaultExperiment";
        Some(Tag { name, attributes, children })
    }

    /// The variable at an end of a connection; none for connectors of the system.
    fn port(&self, end: &End) -> Option<Port> {
        let name = end.component.as_ref()?;
        let component = self.parts.structure.components.iter().position(|c| c.name == *name)?;
        let variables = &self.parts.description(component).variables;
        Some(Port { component, variable: variables.iter().position(|v| v.name == end.connector)? })
    }
}

/// The communication step, for which SSP 1.0 has no element.
fn step_annotation(step: f64) -> Tag {
    let algorithm = leaf("osp:FixedStepAlgorithm", &[("baseStepSize", &step.to_string())]);
    let annotation = [("type", STEP_ANNOTATION)];
    let annotation = node("ssc:Annotation", &annotation, vec![within(&["osp:Algorithm"], algorithm)]);
    within(&["ssd:Annotations"], annotation)
}

fn kind_of(variable: &Variable) -> &'static str {
    if variable.causality == Causality::Output { "output" } else { "input" }
}
