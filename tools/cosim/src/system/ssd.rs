//! The reader of SSP 1.0: the archive, `SystemStructure.ssd` in it, and parameter sets inline or in files.
use super::structure::{Component, Connection, Connector, Direction, End, Place, Setting, Sort, Structure};
use crate::archive::unpacked;
use crate::xml::{Fault, Xml, child, elements};
use crate::{Error, Unit};
use roxmltree::Node;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

/// Where the standard puts the default description of a package.
pub(crate) const MAIN: &str = "SystemStructure.ssd";
/// MIME type of a component that is an FMU.
pub(crate) const FMU: &str = "application/x-fmu-sharedlibrary";
/// Type of the annotation with the step size, for which SSP 1.0 has no element.
pub(crate) const STEP_ANNOTATION: &str = "com.opensimulationplatform";

/// Unpacks and reads the package at `path`.
pub(crate) fn read(path: &Path) -> Result<Structure, Error> {
    let dir = unpacked(path).map_err(|e| match e {
        Error::Archive { path, reason, .. } => Error::Archive { path, kind: "SSP", reason },
        other => other,
    })?;
    let text = match fs::read_to_string(dir.path().join(MAIN)) {
        Ok(text) => text,
        Err(e) => {
            let reason = match e.kind() {
                io::ErrorKind::NotFound => format!("it has no {MAIN}"),
                io::ErrorKind::InvalidData => format!("its {MAIN} is not UTF-8 text"),
                _ => format!("its {MAIN} cannot be read: {e}"),
            };
            return Err(Error::Archive { path: path.to_owned(), kind: "SSP", reason });
        }
    };
    let reader = Reader { package: path.display().to_string(), dir: dir.path().to_owned() };
    let mut structure = reader.structure(&text)?;
    structure.files = Some(Arc::new(dir));
    Ok(structure)
}

struct Reader {
    package: String,
    dir: PathBuf,
}

/// A file of the package with the units that it defines.
struct File<'x> {
    name: Arc<str>,
    xml: &'x Xml<'x>,
    units: Vec<Unit>,
}

/// A fault in the file called `name`.
fn in_file(name: &Arc<str>) -> impl Fn(Fault) -> Error {
    |Fault { line, message }| Place { file: name.clone(), line }.fault(message)
}

impl File<'_> {
    fn place(&self, node: Node) -> Place {
        Place { file: self.name.clone(), line: self.xml.line(node) }
    }

    fn fault(&self, node: Node, message: impl Into<String>) -> Error {
        self.place(node).fault(message)
    }

    fn required<'a>(&self, node: Node<'a, '_>, name: &str) -> Result<&'a str, Error> {
        self.xml.required(node, name).map_err(in_file(&self.name))
    }

    fn number<T: FromStr>(&self, node: Node, name: &str) -> Result<Option<T>, Error> {
        self.xml.number(node, name).map_err(in_file(&self.name))
    }

    /// The unit that an attribute refers to.
    fn unit(&self, node: Node) -> Result<Option<Unit>, Error> {
        let Some(name) = node.attribute("unit") else { return Ok(None) };
        let defined = self.units.iter().find(|u| u.name == name).cloned();
        defined
            .map(Some)
            .ok_or_else(|| self.fault(node, format!("the unit {name:?} is not defined in the file")))
    }

    fn units(&mut self, parent: Option<Node>) -> Result<(), Error> {
        for node in elements(parent).filter(|n| n.tag_name().name() == "Unit") {
            self.units.push(self.xml.unit(node).map_err(in_file(&self.name))?);
        }
        Ok(())
    }
}

impl Reader {
    fn structure(&self, text: &str) -> Result<Structure, Error> {
        let name: Arc<str> = format!("{}: {MAIN}", self.package).into();
        let xml = Xml::read(text).map_err(in_file(&name))?;
        let root = xml.root();
        let mut file = File { name, xml: &xml, units: Vec::new() };
        if root.tag_name().name() != "SystemStructureDescription" {
            let message =
                format!("the root is <{}>, not <SystemStructureDescription>", root.tag_name().name());
            return Err(file.fault(root, message));
        }
        let version = file.required(root, "version")?;
        if !version.starts_with("1.") {
            return Err(
                file.fault(root, format!("version {version:?} is not supported; only SSP 1 is supported"))
            );
        }
        file.units(child(root, "Units"))?;
        let system = child(root, "System").ok_or_else(|| file.fault(root, "there is no <System>"))?;
        let experiment = child(root, "DefaultExperiment");
        let time = |name| experiment.map_or(Ok(None), |n| file.number(n, name));

        let mut components = Vec::new();
        for node in elements(child(system, "Elements")) {
            components.push(self.component(&file, node)?);
        }
        let mut connections = Vec::new();
        for node in elements(child(system, "Connections")) {
            connections.push(connection(&file, node)?);
        }
        Ok(Structure {
            name: root.attribute("name").or(system.attribute("name")).unwrap_or("system").to_owned(),
            start: time("startTime")?,
            stop: time("stopTime")?,
            step: experiment.map_or(Ok(None), |n| step(&file, n))?,
            components,
            connectors: Some(connectors(&file, system)?),
            settings: self.settings(&file, system)?,
            connections,
            files: None,
        })
    }

    fn component(&self, file: &File, node: Node) -> Result<Component, Error> {
        let name = file.required(node, "name")?.to_owned();
        match node.tag_name().name() {
            "Component" => {}
            "System" => {
                let message = format!("element {name} is a nested system; only flat systems are supported");
                return Err(file.fault(node, message));
            }
            other => {
                return Err(
                    file.fault(node, format!("element {name} is a <{other}>, which is not supported"))
                );
            }
        }
        let kind = node.attribute("type").unwrap_or(FMU);
        if kind != FMU {
            return Err(file.fault(node, format!("component {name} is of type {kind:?}, not an FMU ({FMU})")));
        }
        if node.attribute("implementation") == Some("ModelExchange") {
            let message =
                format!("component {name} requires Model Exchange; only Co-Simulation is supported");
            return Err(file.fault(node, message));
        }
        let source = file.required(node, "source")?.to_owned();
        let path = self.resource(&source).ok_or_else(|| {
            file.fault(node, format!("component {name}: the source {source:?} is not a file in the package"))
        })?;
        Ok(Component {
            step: step(file, node)?,
            path,
            source,
            connectors: Some(connectors(file, node)?),
            settings: self.settings(file, node)?,
            place: file.place(node),
            name,
        })
    }

    /// The unpacked file behind a relative URI; `None` if it leads elsewhere.
    fn resource(&self, uri: &str) -> Option<PathBuf> {
        let mut bytes = Vec::new();
        let mut rest = uri.bytes();
        while let Some(byte) = rest.next() {
            bytes.push(if byte == b'%' {
                let digit = |b: Option<u8>| (b? as char).to_digit(16);
                (digit(rest.next())? * 16 + digit(rest.next())?) as u8
            } else {
                byte
            });
        }
        let text = String::from_utf8(bytes).ok()?;
        use std::path::Component::{CurDir, Normal};
        let within = Path::new(&text).components().all(|c| matches!(c, Normal(_) | CurDir));
        (within && !text.is_empty()).then(|| self.dir.join(text))
    }

    /// All values that the bindings of an element give.
    fn settings(&self, file: &File, element: Node) -> Result<Vec<Setting>, Error> {
        let mut settings = Vec::new();
        for binding in elements(child(element, "ParameterBindings")) {
            let refuse =
                |what: &str| Err(file.fault(binding, format!("{what} of a binding is not supported")));
            if child(binding, "ParameterMapping").is_some() {
                return refuse("the mapping of names");
            }
            if binding.attribute("sourceBase") == Some("component") {
                return refuse("a source within the FMU");
            }
            let prefix = binding.attribute("prefix").unwrap_or("");
            if let Some(source) = binding.attribute("source") {
                let readable = self.resource(source).and_then(|p| fs::read_to_string(p).ok());
                let text = readable.ok_or_else(|| {
                    file.fault(
                        binding,
                        format!("the parameter file {source:?} is not in the package or is not text"),
                    )
                })?;
                let name: Arc<str> = format!("{}: {source}", self.package).into();
                let xml = Xml::read(&text).map_err(in_file(&name))?;
                let own = File { name, xml: &xml, units: Vec::new() };
                parameters(own, xml.root(), prefix, &mut settings)?;
            }
            for values in elements(child(binding, "ParameterValues")) {
                let inline = File { name: file.name.clone(), units: file.units.clone(), ..*file };
                parameters(inline, values, prefix, &mut settings)?;
            }
        }
        Ok(settings)
    }
}

/// The values of one `ParameterSet`.
fn parameters(mut file: File, set: Node, prefix: &str, settings: &mut Vec<Setting>) -> Result<(), Error> {
    if set.tag_name().name() != "ParameterSet" {
        return Err(file.fault(set, format!("<{}> is not a <ParameterSet>", set.tag_name().name())));
    }
    file.units(child(set, "Units"))?;
    for node in elements(child(set, "Parameters")) {
        let name = file.required(node, "name")?;
        let value = node.children().find(|n| n.is_element() && n.tag_name().name() != "Annotations");
        let value = value.ok_or_else(|| file.fault(node, format!("parameter {name} has no value")))?;
        settings.push(Setting {
            name: format!("{prefix}{name}"),
            text: file.required(value, "value")?.to_owned(),
            unit: file.unit(value)?,
            place: file.place(node),
        });
    }
    Ok(())
}

fn connectors(file: &File, element: Node) -> Result<Vec<Connector>, Error> {
    let mut connectors = Vec::new();
    for node in elements(child(element, "Connectors")) {
        let name = file.required(node, "name")?.to_owned();
        let kind = match file.required(node, "kind")? {
            "calculatedParameter" => "parameter",
            other => other,
        };
        let unknown = || file.fault(node, format!("connector {name}: unknown kind {kind:?}"));
        let direction = Direction::of(kind).ok_or_else(unknown)?;
        let (mut sort, mut unit) = (None, None);
        for body in elements(Some(node)) {
            let Some(known) = Sort::of(body.tag_name().name()) else { continue };
            (sort, unit) = (Some(known), file.unit(body)?);
        }
        connectors.push(Connector { name, direction, sort, unit, place: file.place(node) });
    }
    Ok(connectors)
}

fn connection(file: &File, node: Node) -> Result<Connection, Error> {
    let end = |element: &str, connector: &str| {
        Ok(End {
            component: node.attribute(element).map(str::to_owned),
            connector: file.required(node, connector)?.to_owned(),
        })
    };
    let mut connection = Connection {
        start: end("startElement", "startConnector")?,
        end: end("endElement", "endConnector")?,
        convert_units: true,
        factor: 1.0,
        offset: 0.0,
        place: file.place(node),
    };
    connection.convert_units = match node.attribute("suppressUnitConversion").map(str::trim) {
        None | Some("false" | "0") => true,
        Some("true" | "1") => false,
        Some(other) => {
            let message =
                format!("{connection}: suppressUnitConversion = {other:?} is neither true nor false");
            return Err(file.fault(node, message));
        }
    };
    for body in elements(Some(node)) {
        match body.tag_name().name() {
            "LinearTransformation" => {
                connection.factor = file.number(body, "factor")?.unwrap_or(1.0);
                connection.offset = file.number(body, "offset")?.unwrap_or(0.0);
            }
            mapping if mapping.ends_with("MappingTransformation") => {
                return Err(file.fault(body, format!("{connection}: <{mapping}> is not supported")));
            }
            _ => {}
        }
    }
    Ok(connection)
}

/// The step size of an annotation that other masters read as well.
fn step(file: &File, experiment: Node) -> Result<Option<f64>, Error> {
    let annotation =
        elements(child(experiment, "Annotations")).find(|n| n.attribute("type") == Some(STEP_ANNOTATION));
    let fixed =
        annotation.and_then(|a| a.descendants().find(|n| n.tag_name().name() == "FixedStepAlgorithm"));
    fixed.map_or(Ok(None), |n| file.number(n, "baseStepSize"))
}
