//! The reader of SSP 1.0 and 2.0: the archive and `SystemStructure.ssd` in it. Nested systems become flat (`flatten.rs`), parameter sets
//! and mappings are read in `bindings.rs`.
use super::flatten::{Edge, Joint, flat};
use super::structure::{
    Component, Connection, Connector, Direction, End, Leg, Place, Setting, Shared, Sort, Structure, Time,
};
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

pub(super) struct Reader {
    pub(super) package: String,
    dir: PathBuf,
}

/// A file of the package with the units that it defines.
pub(super) struct File<'x> {
    pub(super) name: Arc<str>,
    pub(super) xml: &'x Xml<'x>,
    pub(super) units: Vec<Unit>,
}

/// A fault in the file called `name`.
pub(super) fn in_file(name: &Arc<str>) -> impl Fn(Fault) -> Error {
    |Fault { line, message }| Place { file: name.clone(), line }.fault(message)
}

impl File<'_> {
    pub(super) fn place(&self, node: Node) -> Place {
        Place { file: self.name.clone(), line: self.xml.line(node) }
    }

    pub(super) fn fault(&self, node: Node, message: impl Into<String>) -> Error {
        self.place(node).fault(message)
    }

    pub(super) fn required<'a>(&self, node: Node<'a, '_>, name: &str) -> Result<&'a str, Error> {
        self.xml.required(node, name).map_err(in_file(&self.name))
    }

    pub(super) fn number<T: FromStr>(&self, node: Node, name: &str) -> Result<Option<T>, Error> {
        self.xml.number(node, name).map_err(in_file(&self.name))
    }

    /// The unit that an attribute refers to.
    pub(super) fn unit(&self, node: Node) -> Result<Option<Unit>, Error> {
        // Some tools write an empty unit where there is none.
        let Some(name) = node.attribute("unit").filter(|name| !name.is_empty()) else { return Ok(None) };
        let defined = self.units.iter().find(|u| u.name == name).cloned();
        defined
            .map(Some)
            .ok_or_else(|| self.fault(node, format!("the unit {name:?} is not defined in the file")))
    }

    pub(super) fn units(&mut self, parent: Option<Node>) -> Result<(), Error> {
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
        if !["1.", "2."].iter().any(|known| version.starts_with(known)) {
            let message = format!("version {version:?} is not supported; SSP 1 and SSP 2 are supported");
            return Err(file.fault(root, message));
        }
        file.units(child(root, "Units"))?;
        let system = child(root, "System").ok_or_else(|| file.fault(root, "there is no <System>"))?;
        let experiment = child(root, "DefaultExperiment");
        let time = |name| experiment.map_or(Ok(None), |n| time(&file, n, name));

        let mut whole = Whole::default();
        self.system(&file, system, "", &[], &mut whole)?;
        let Whole { components, settings, shared, edges, joints } = whole;
        let connectors = connectors(&file, system)?;
        let is_source = |end: &End| {
            let (of, gives) = match &end.component {
                None => (Some(&connectors), Direction::Input),
                Some(name) => {
                    let component = components.iter().find(|c| c.name == *name);
                    (component.and_then(|c| c.connectors.as_ref()), Direction::Output)
                }
            };
            let declared = of.and_then(|all| all.iter().find(|c| c.name == end.connector));
            declared.is_some_and(|c| c.direction == gives)
        };
        let connections = flat(edges, &joints, &is_source)?;
        Ok(Structure {
            name: root.attribute("name").or(system.attribute("name")).unwrap_or("system").to_owned(),
            start: time("startTime")?,
            stop: time("stopTime")?,
            step: experiment.map_or(Ok(None), |n| step(&file, n))?,
            components,
            connectors: Some(connectors),
            settings,
            shared,
            connections,
            files: None,
        })
    }

    /// What a system has, below `path`, which ends with a dot if it is not empty. `dictionaries` are those of the systems around it: name,
    /// name of the element that stands for it, entries.
    fn system(
        &self,
        file: &File,
        system: Node,
        path: &str,
        dictionaries: &[Dictionary],
        whole: &mut Whole,
    ) -> Result<(), Error> {
        let mut dictionaries = dictionaries.to_vec();
        for node in elements(child(system, "SignalDictionaries")) {
            dictionaries.push(self.dictionary(file, node, path)?);
        }
        let (settings, shared) = self.settings(file, system)?;
        for mut setting in settings {
            setting.name.insert_str(0, path);
            whole.settings.push(setting);
        }
        for mut one in shared {
            one.name.insert_str(0, path);
            one.targets.iter_mut().for_each(|(target, _)| target.insert_str(0, path));
            whole.shared.push(one);
        }
        // Names of references to dictionaries, and the elements that they stand for.
        let mut references: Vec<(String, String)> = Vec::new();
        for node in elements(child(system, "Elements")) {
            let name = file.required(node, "name")?;
            match node.tag_name().name() {
                "System" => {
                    let element = format!("{path}{name}");
                    for connector in connectors(file, node)? {
                        whole.joints.push(Joint { element: element.clone(), connector, is_entry: false });
                    }
                    self.system(file, node, &format!("{element}."), &dictionaries, whole)?;
                }
                "SignalDictionaryReference" => {
                    let meant = file.required(node, "dictionary")?;
                    let known = dictionaries.iter().rev().find(|d| d.name == meant);
                    let known = known.ok_or_else(|| {
                        file.fault(node, format!("element {name}: there is no signal dictionary {meant:?}"))
                    })?;
                    references.push((name.to_owned(), known.element.clone()));
                }
                _ => {
                    let mut component = self.component(file, node)?;
                    component.name.insert_str(0, path);
                    whole.components.push(component);
                }
            }
        }
        for dictionary in dictionaries.iter().filter(|d| d.path == path) {
            for connector in dictionary.entries.iter().cloned() {
                whole.joints.push(Joint { element: dictionary.element.clone(), connector, is_entry: true });
            }
        }
        for node in elements(child(system, "Connections")) {
            let mut connection = connection(file, node)?;
            let full = |end: &mut End| {
                let inside = end.component.is_none();
                end.component = match &end.component {
                    None if path.is_empty() => None,
                    None => Some(path.trim_end_matches('.').to_owned()),
                    Some(name) => {
                        let element = references.iter().find(|(reference, _)| reference == name);
                        Some(element.map_or_else(|| format!("{path}{name}"), |(_, element)| element.clone()))
                    }
                };
                inside
            };
            let (start_inside, end_inside) = (full(&mut connection.start), full(&mut connection.end));
            whole.edges.push(Edge { connection, start_inside, end_inside });
        }
        Ok(())
    }

    /// A signal dictionary, inline or in a file.
    fn dictionary(&self, file: &File, node: Node, path: &str) -> Result<Dictionary, Error> {
        let name = file.required(node, "name")?.to_owned();
        let mut entries = Vec::new();
        let mut read = |file: &File, root: Node| -> Result<(), Error> {
            for entry in root.descendants().filter(|n| n.tag_name().name() == "DictionaryEntry") {
                let name = file.required(entry, "name")?.to_owned();
                let (sort, unit) = typed(file, entry)?;
                let direction = Direction::Input;
                entries.push(Connector { name, direction, sort, unit, place: file.place(entry) });
            }
            Ok(())
        };
        match node.attribute("source") {
            None => read(file, node)?,
            Some(source) => self.with_file(file, node, source, "signal dictionary", |file| {
                let mut own = File { name: file.name.clone(), xml: file.xml, units: Vec::new() };
                own.units(child(file.xml.root(), "Units"))?;
                read(&own, file.xml.root())
            })?,
        }
        // No element can have this name, as a tab is none of its characters.
        let element = format!("{path}\t{name}");
        Ok(Dictionary { name, element, path: path.to_owned(), entries })
    }

    /// Reads a further file of the package.
    pub(super) fn with_file<T>(
        &self,
        file: &File,
        node: Node,
        source: &str,
        what: &str,
        read: impl FnOnce(&File) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let readable = self.resource(source).and_then(|p| fs::read_to_string(p).ok());
        let text = readable.ok_or_else(|| {
            file.fault(node, format!("the {what} file {source:?} is not in the package or is not text"))
        })?;
        let name: Arc<str> = format!("{}: {source}", self.package).into();
        let xml = Xml::read(&text).map_err(in_file(&name))?;
        read(&File { name, xml: &xml, units: Vec::new() })
    }

    fn component(&self, file: &File, node: Node) -> Result<Component, Error> {
        let name = file.required(node, "name")?.to_owned();
        match node.tag_name().name() {
            "Component" => {}
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
            settings: self.settings(file, node)?.0,
            place: file.place(node),
            name,
        })
    }

    /// The unpacked file behind a relative URI; `None` if it leads elsewhere.
    pub(super) fn resource(&self, uri: &str) -> Option<PathBuf> {
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
}

/// What the systems of a package have, with full names.
#[derive(Default)]
struct Whole {
    components: Vec<Component>,
    settings: Vec<Setting>,
    shared: Vec<Shared>,
    edges: Vec<Edge>,
    joints: Vec<Joint>,
}

/// A signal dictionary of a system.
#[derive(Clone)]
struct Dictionary {
    name: String,
    /// The element that stands for it in connections.
    element: String,
    /// The path of the system.
    path: String,
    entries: Vec<Connector>,
}

/// Type and unit of a connector or an entry. The types of SSP 2 are those of FMI 3.
fn typed(file: &File, node: Node) -> Result<(Option<Sort>, Option<Unit>), Error> {
    let mut found = (None, None);
    for body in elements(Some(node)) {
        let name = body.tag_name().name();
        let sort = match name {
            "Float64" | "Float32" => Some(Sort::Real),
            _ if name.starts_with("Int") || name.starts_with("UInt") => Some(Sort::Integer),
            _ => Sort::of(name),
        };
        if sort.is_some() {
            found = (sort, file.unit(body)?);
        }
    }
    Ok(found)
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
        let (sort, unit) = typed(file, node)?;
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
        legs: Vec::new(),
        place: file.place(node),
    };
    let mut leg = Leg::PLAIN;
    leg.convert_units = match node.attribute("suppressUnitConversion").map(str::trim) {
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
                leg.factor = file.number(body, "factor")?.unwrap_or(1.0);
                leg.offset = file.number(body, "offset")?.unwrap_or(0.0);
            }
            mapping if mapping.ends_with("MappingTransformation") => {
                return Err(file.fault(body, format!("{connection}: <{mapping}> is not supported")));
            }
            _ => {}
        }
    }
    connection.legs.push(leg);
    Ok(connection)
}

/// The step size of an annotation that other masters read as well.
fn step(file: &File, experiment: Node) -> Result<Option<Time>, Error> {
    let annotation =
        elements(child(experiment, "Annotations")).find(|n| n.attribute("type") == Some(STEP_ANNOTATION));
    let fixed =
        annotation.and_then(|a| a.descendants().find(|n| n.tag_name().name() == "FixedStepAlgorithm"));
    fixed.map_or(Ok(None), |n| time(file, n, "baseStepSize"))
}

/// A time of an attribute, s.
fn time(file: &File, node: Node, name: &str) -> Result<Option<Time>, Error> {
    let seconds: Option<f64> = file.number(node, name)?;
    Ok(seconds.map(|seconds| Time { seconds, place: file.place(node) }))
}
