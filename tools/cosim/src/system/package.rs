//! The writer of SSP 1.0: `SystemStructure.ssd` with everything inline, and the FMUs below `resources`.
//!
//! Other tools support only a part of the standard, so the file uses the common part: the usual prefixes; only connected inputs are
//! connectors; values of enumerations are integers, as in FMI 2; units are those of the FMUs; the step size is in an
//! annotation that other masters read as well.
use super::connections::{Connections, resolve};
use super::parts::{Parts, Port};
use super::ssd::{FMU, MAIN, STEP_ANNOTATION};
use super::structure::{Component, Connector, End};
use super::units::unit_of;
use crate::{BaseUnit, Causality, Error, Kind, Unit, Value, Variable};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Cursor, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Names of the XML prefixes.
const NAMESPACES: [(&str, &str); 3] = [
    ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
    ("xmlns:ssd", "http://ssp-standard.org/SSP1/SystemStructureDescription"),
    ("xmlns:ssv", "http://ssp-standard.org/SSP1/SystemStructureParameterValues"),
];
const STEP_NAMESPACE: (&str, &str) = ("xmlns:osp", "http://opensimulationplatform.com/SSP/OSPAnnotations");

/// Writes the archive.
pub(crate) fn write(parts: Parts, path: &Path) -> Result<(), Error> {
    let connections = resolve(parts, &[])?;
    super::order::order(parts, &connections)?;
    let io = |source| Error::Io { action: "write", path: path.to_owned(), source };
    let resources = resources(&parts.structure.components);
    let xml = Document::new(parts, &connections, &resources).text().map_err(io)?;
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let failed = |e: zip::result::ZipError| io(io::Error::other(e));
    zip.start_file(MAIN, entry(CompressionMethod::Deflated)).map_err(failed)?;
    zip.write_all(xml.as_bytes()).map_err(io)?;
    for (source, name) in &resources {
        let read =
            |source_error| Error::Io { action: "read", path: (*source).to_owned(), source: source_error };
        let bytes = fs::read(source).map_err(read)?;
        // FMUs are compressed already.
        zip.start_file(name.as_str(), entry(CompressionMethod::Stored)).map_err(failed)?;
        zip.write_all(&bytes).map_err(io)?;
    }
    let bytes = zip.finish().map_err(failed)?.into_inner();
    fs::write(path, bytes).map_err(io)
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

type Written = io::Result<()>;

struct Document<'a> {
    parts: Parts<'a>,
    connections: &'a Connections,
    resources: &'a [(&'a Path, String)],
    units: BTreeMap<String, BaseUnit>,
    xml: Writer<Vec<u8>>,
}

impl<'a> Document<'a> {
    fn new(parts: Parts<'a>, connections: &'a Connections, resources: &'a [(&'a Path, String)]) -> Self {
        let xml = Writer::new_with_indent(Vec::new(), b' ', 2);
        Self { parts, connections, resources, units: BTreeMap::new(), xml }
    }

    fn text(mut self) -> io::Result<String> {
        let structure = self.parts.structure;
        self.xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        let mut root: Vec<(&str, &str)> = NAMESPACES.to_vec();
        // At the root: libcosim takes an attribute of its own element for an algorithm.
        root.extend(structure.step.map(|_| STEP_NAMESPACE));
        root.extend([("name", structure.name.as_str()), ("version", "1.0"), ("generationTool", "motor-fmu")]);
        self.open("ssd:SystemStructureDescription", &root)?;
        self.open("ssd:System", &[("name", &structure.name)])?;
        self.system_connectors()?;
        self.open("ssd:Elements", &[])?;
        for index in 0..structure.components.len() {
            self.component(index)?;
        }
        self.close("ssd:Elements")?;
        self.connections()?;
        self.close("ssd:System")?;
        self.unit_definitions()?;
        self.experiment()?;
        self.close("ssd:SystemStructureDescription")?;
        let mut bytes = self.xml.into_inner();
        bytes.push(b'\n');
        String::from_utf8(bytes).map_err(io::Error::other)
    }

    /// Connectors of the system: ends of connections without a component.
    fn system_connectors(&mut self) -> Written {
        let declared = self.parts.structure.connectors.as_deref();
        let mut ports: Vec<(String, &str, Port)> = Vec::new();
        for connection in &self.parts.structure.connections {
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
        if ports.is_empty() {
            return Ok(());
        }
        self.open("ssd:Connectors", &[])?;
        for (name, kind, port) in ports {
            let unit = unit_in(declared, &name);
            self.connector(&name, kind, port, unit)?;
        }
        self.close("ssd:Connectors")
    }

    fn component(&mut self, index: usize) -> Written {
        let component = &self.parts.structure.components[index];
        let resources = self.resources;
        let source = resources.iter().find(|(p, _)| *p == component.path).map_or("", |(_, name)| name);
        let attributes = [
            ("name", component.name.as_str()),
            ("type", FMU),
            ("source", &uri(source)),
            ("implementation", "CoSimulation"),
        ];
        self.open("ssd:Component", &attributes)?;
        let description = self.parts.description(index);
        self.open("ssd:Connectors", &[])?;
        for (place, variable) in description.variables.iter().enumerate() {
            let port = Port { component: index, variable: place };
            let ends = self.parts.structure.connections.iter().flat_map(|c| [&c.start, &c.end]);
            let joined = ends.into_iter().any(|end| self.port(end) == Some(port));
            let plain = variable.dimensions.is_empty()
                && (variable.kind.is_numeric() && variable.kind != Kind::Enumeration || joined);
            if plain && (variable.causality == Causality::Output || joined) {
                let unit = unit_in(component.connectors.as_deref(), &variable.name);
                self.connector(&variable.name, kind_of(variable), port, unit)?;
            }
        }
        self.close("ssd:Connectors")?;
        self.values(index)?;
        self.close("ssd:Component")
    }

    /// A connector for a variable, with the unit that the structure declares, else the variable's.
    fn connector(&mut self, name: &str, kind: &str, port: Port, unit: Option<Unit>) -> Written {
        let variable = self.parts.variable(port);
        self.open("ssd:Connector", &[("name", name), ("kind", kind)])?;
        match variable.kind {
            Kind::Float64 | Kind::Float32 => {
                let own = || unit_of(self.parts.description(port.component), variable);
                match unit.or_else(own).and_then(|u| self.define(u)) {
                    Some(unit) => self.empty("ssc:Real", &[("unit", &unit)])?,
                    None => self.empty("ssc:Real", &[])?,
                }
            }
            Kind::Boolean => self.empty("ssc:Boolean", &[])?,
            Kind::String => self.empty("ssc:String", &[])?,
            Kind::Binary | Kind::Clock => self.empty("ssc:Binary", &[])?,
            // The items of the type are defined in the FMU and are not repeated in SSP.
            Kind::Enumeration => {}
            _ => self.empty("ssc:Integer", &[])?,
        }
        self.close("ssd:Connector")
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

    fn values(&mut self, index: usize) -> Written {
        let (parts, connections) = (self.parts, self.connections);
        let sets = &connections.sets[index];
        if sets.is_empty() {
            return Ok(());
        }
        for tag in ["ssd:ParameterBindings", "ssd:ParameterBinding", "ssd:ParameterValues"] {
            self.open(tag, &[])?;
        }
        let name = parts.structure.components[index].name.as_str();
        self.open("ssv:ParameterSet", &[("version", "1.0"), ("name", name)])?;
        self.open("ssv:Parameters", &[])?;
        for (variable, value) in sets {
            let variable = &parts.description(index).variables[*variable];
            self.open("ssv:Parameter", &[("name", &variable.name)])?;
            match value {
                Value::Real(x) => self.empty("ssv:Real", &[("value", &x.to_string())])?,
                Value::Integer(x) => self.empty("ssv:Integer", &[("value", &x.to_string())])?,
                Value::Boolean(x) => self.empty("ssv:Boolean", &[("value", &x.to_string())])?,
                Value::String(x) => self.empty("ssv:String", &[("value", x)])?,
            }
            self.close("ssv:Parameter")?;
        }
        for tag in [
            "ssv:Parameters",
            "ssv:ParameterSet",
            "ssd:ParameterValues",
            "ssd:ParameterBinding",
            "ssd:ParameterBindings",
        ] {
            self.close(tag)?;
        }
        Ok(())
    }

    fn connections(&mut self) -> Written {
        let structure = self.parts.structure;
        if structure.connections.is_empty() {
            return Ok(());
        }
        self.open("ssd:Connections", &[])?;
        for connection in &structure.connections {
            // Some readers require the source first.
            let backwards = self.port(&connection.start).is_some_and(|p| {
                connection.end.component.is_some()
                    && connection.start.component.is_some()
                    && self.parts.variable(p).causality == Causality::Input
            });
            let (from, to) = if backwards {
                (&connection.end, &connection.start)
            } else {
                (&connection.start, &connection.end)
            };
            let mut attributes: Vec<(&str, &str)> = Vec::new();
            if let Some(element) = &from.component {
                attributes.push(("startElement", element));
            }
            attributes.push(("startConnector", &from.connector));
            if let Some(element) = &to.component {
                attributes.push(("endElement", element));
            }
            attributes.push(("endConnector", &to.connector));
            if !connection.convert_units {
                attributes.push(("suppressUnitConversion", "true"));
            }
            if (connection.factor, connection.offset) == (1.0, 0.0) {
                self.empty("ssd:Connection", &attributes)?;
                continue;
            }
            self.open("ssd:Connection", &attributes)?;
            let (factor, offset) = (connection.factor.to_string(), connection.offset.to_string());
            self.empty("ssc:LinearTransformation", &[("factor", &factor), ("offset", &offset)])?;
            self.close("ssd:Connection")?;
        }
        self.close("ssd:Connections")
    }

    fn unit_definitions(&mut self) -> Written {
        if self.units.is_empty() {
            return Ok(());
        }
        self.open("ssd:Units", &[])?;
        for (name, base) in std::mem::take(&mut self.units) {
            self.open("ssc:Unit", &[("name", &name)])?;
            let mut texts: Vec<(&str, String)> = Vec::new();
            let used = BaseUnit::NAMES.into_iter().zip(base.exponents).filter(|(_, e)| *e != 0);
            texts.extend(used.map(|(name, exponent)| (name, exponent.to_string())));
            if base.factor != 1.0 {
                texts.push(("factor", base.factor.to_string()));
            }
            if base.offset != 0.0 {
                texts.push(("offset", base.offset.to_string()));
            }
            let attributes: Vec<(&str, &str)> = texts.iter().map(|(n, t)| (*n, t.as_str())).collect();
            self.empty("ssc:BaseUnit", &attributes)?;
            self.close("ssc:Unit")?;
        }
        self.close("ssd:Units")
    }

    fn experiment(&mut self) -> Written {
        let structure = self.parts.structure;
        let times = [("startTime", structure.start), ("stopTime", structure.stop)];
        let texts: Vec<(&str, String)> =
            times.into_iter().filter_map(|(name, t)| Some((name, t?.to_string()))).collect();
        let attributes: Vec<(&str, &str)> = texts.iter().map(|(n, t)| (*n, t.as_str())).collect();
        let Some(step) = structure.step else {
            return if attributes.is_empty() {
                Ok(())
            } else {
                self.empty("ssd:DefaultExperiment", &attributes)
            };
        };
        self.open("ssd:DefaultExperiment", &attributes)?;
        self.open("ssd:Annotations", &[])?;
        self.open("ssc:Annotation", &[("type", STEP_ANNOTATION)])?;
        self.open("osp:Algorithm", &[])?;
        self.empty("osp:FixedStepAlgorithm", &[("baseStepSize", &step.to_string())])?;
        for tag in ["osp:Algorithm", "ssc:Annotation", "ssd:Annotations", "ssd:DefaultExperiment"] {
            self.close(tag)?;
        }
        Ok(())
    }

    /// The variable at an end of a connection; none for connectors of the system.
    fn port(&self, end: &End) -> Option<Port> {
        let name = end.component.as_ref()?;
        let component = self.parts.structure.components.iter().position(|c| c.name == *name)?;
        let variables = &self.parts.description(component).variables;
        Some(Port { component, variable: variables.iter().position(|v| v.name == end.connector)? })
    }

    fn open(&mut self, tag: &str, attributes: &[(&str, &str)]) -> Written {
        let start = BytesStart::new(tag).with_attributes(attributes.iter().copied());
        self.xml.write_event(Event::Start(start))
    }

    fn empty(&mut self, tag: &str, attributes: &[(&str, &str)]) -> Written {
        let start = BytesStart::new(tag).with_attributes(attributes.iter().copied());
        self.xml.write_event(Event::Empty(start))
    }

    fn close(&mut self, tag: &str) -> Written {
        self.xml.write_event(Event::End(BytesEnd::new(tag)))
    }
}

/// The unit that a declared connector has.
fn unit_in(connectors: Option<&[Connector]>, name: &str) -> Option<Unit> {
    connectors?.iter().find(|c| c.name == name)?.unit.clone()
}

fn kind_of(variable: &Variable) -> &'static str {
    if variable.causality == Causality::Output { "output" } else { "input" }
}

/// A name in the archive as a relative URI.
fn uri(name: &str) -> String {
    let mut uri = String::new();
    for byte in name.bytes() {
        if byte.is_ascii_alphanumeric() || b"/-._~".contains(&byte) {
            uri.push(byte.into());
        } else {
            uri.push_str(&format!("%{byte:02X}"));
        }
    }
    uri
}
