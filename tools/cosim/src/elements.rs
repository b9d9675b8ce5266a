//! The elements of `modelDescription.xml` in one shape for both standards, with their nodes: the tolerant reader.
//!
//! [`ModelDescription`](crate::ModelDescription) is made from it and is strict; a validator works on it directly. What
//! cannot be read is `None` here; defaults of the standards are filled in.
use crate::xml::{Xml, child, children, elements, short, unsigned};
use crate::{FmiVersion, Kind};
use roxmltree::Node;
use std::collections::HashMap;
use std::fmt::{Display, Formatter};

pub use crate::description::FILE;

/// A model description.
pub struct Model<'a> {
    /// The file.
    pub xml: &'a Xml<'a>,
    /// The standard by whose rules it is read.
    pub version: FmiVersion,
    /// The root element.
    pub root: Node<'a, 'a>,
    /// `ModelExchange`, `CoSimulation`, `ScheduledExecution` elements.
    pub interfaces: Vec<Node<'a, 'a>>,
    /// All type definitions, in the order of the file.
    pub types: Vec<TypeDefinition<'a>>,
    /// All variables, in the order of the file.
    pub variables: Vec<Variable<'a>>,
    /// The model structure.
    pub structure: Structure<'a>,
    by_type_name: HashMap<&'a str, usize>,
    by_reference: HashMap<u32, usize>,
}

/// A variable.
pub struct Variable<'a> {
    /// The element with name and causality.
    pub node: Node<'a, 'a>,
    /// The element with the typed attributes; in FMI 3 the same.
    pub typed: Node<'a, 'a>,
    /// `name`, empty when absent.
    pub name: &'a str,
    /// `valueReference`
    pub reference: Option<u32>,
    /// The type; `Float64` for an FMI 2 variable without one, so that it still counts.
    pub kind: Kind,
    /// The typed element's name, for matching the declared type.
    pub type_name: &'a str,
    /// As written, `local` when absent.
    pub causality: &'a str,
    /// As written, or the default of the standard.
    pub variability: &'a str,
    /// As written.
    pub initial_written: Option<&'a str>,
    /// As written, or the default of the table; `None` where the table has none.
    pub initial: Option<&'a str>,
    /// `declaredType`
    pub declared_type: Option<&'a str>,
    /// A start value is written.
    pub has_start: bool,
    /// `derivative`: index (FMI 2) or value reference (FMI 3).
    pub derivative: Option<u32>,
    /// The attribute `clocks` is there.
    pub clocked: bool,
    /// FMI 3 `Alias` elements.
    pub aliases: Vec<Node<'a, 'a>>,
}

impl Variable<'_> {
    /// Whether it has dimensions.
    pub fn is_array(&self) -> bool {
        children(self.typed, "Dimension").next().is_some()
    }

    /// Whether the importer may set it before or during initialisation.
    pub fn is_settable(&self) -> bool {
        self.variability != "constant"
            && (self.causality == "input" || matches!(self.initial, Some("exact" | "approx")))
    }
}

/// The name in quotes, for messages.
impl Display for Variable<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        write!(f, "\"{}\"", short(self.name))
    }
}

/// A type definition.
pub struct TypeDefinition<'a> {
    /// The element with the name.
    pub node: Node<'a, 'a>,
    /// The element with the typed attributes; in FMI 3 the same.
    pub typed: Node<'a, 'a>,
    /// `name`
    pub name: &'a str,
    /// As a variable's element would be called.
    pub type_name: &'a str,
}

/// The name in quotes, for messages.
impl Display for TypeDefinition<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        write!(f, "\"{}\"", short(self.name))
    }
}

/// An entry of the model structure.
pub struct Unknown<'a> {
    /// The element.
    pub node: Node<'a, 'a>,
    /// Index (FMI 2) or value reference (FMI 3) as written.
    pub reference: Option<u32>,
    /// Position in [`Model::variables`].
    pub variable: Option<usize>,
}

/// The lists of the model structure.
#[derive(Default)]
#[allow(missing_docs)] // the standard's words
pub struct Structure<'a> {
    pub outputs: Vec<Unknown<'a>>,
    pub derivatives: Vec<Unknown<'a>>,
    pub clocked_states: Vec<Unknown<'a>>,
    pub initial_unknowns: Vec<Unknown<'a>>,
    pub event_indicators: Vec<Unknown<'a>>,
}

impl<'a> Model<'a> {
    /// Reads a model description.
    pub fn read(xml: &'a Xml<'a>, version: FmiVersion) -> Self {
        let root: Node<'a, 'a> = xml.root();
        let is_interface =
            |n: &Node| ["ModelExchange", "CoSimulation", "ScheduledExecution"].contains(&n.tag_name().name());
        let interfaces = elements(Some(root)).filter(is_interface).collect();
        let types: Vec<_> = children(root, "TypeDefinitions")
            .flat_map(|list| elements(Some(list)))
            .filter_map(|node| read_type(node, version))
            .collect();
        let variables: Vec<_> = children(root, "ModelVariables")
            .flat_map(|list| elements(Some(list)))
            .filter_map(|node| read_variable(node, version))
            .collect();
        // The first of several claims a name or a reference; the rules report the others.
        let mut by_type_name = HashMap::new();
        types.iter().enumerate().for_each(|(i, t)| {
            by_type_name.entry(t.name).or_insert(i);
        });
        let mut by_reference = HashMap::new();
        for (i, v) in variables.iter().enumerate() {
            if let Some(r) = v.reference {
                by_reference.entry(r).or_insert(i);
            }
        }
        let structure = Structure::default();
        let mut model =
            Self { xml, version, root, interfaces, types, variables, structure, by_type_name, by_reference };
        model.structure = model.read_structure();
        model
    }

    fn read_structure(&self) -> Structure<'a> {
        let Some(node) = child(self.root, "ModelStructure") else { return Structure::default() };
        let list = |name2: &'static str, name3: &'static str| -> Vec<Unknown<'a>> {
            let (key, nodes): (&str, Vec<Node<'a, 'a>>) = match self.version {
                FmiVersion::V2 => {
                    ("index", children(node, name2).flat_map(|l| children(l, "Unknown")).collect())
                }
                FmiVersion::V3 => ("valueReference", children(node, name3).collect()),
            };
            let read = |node| {
                let reference = unsigned(node, key);
                Unknown { node, reference, variable: reference.and_then(|r| self.resolve(r)) }
            };
            nodes.into_iter().map(read).collect()
        };
        Structure {
            outputs: list("Outputs", "Output"),
            derivatives: list("Derivatives", "ContinuousStateDerivative"),
            clocked_states: list("", "ClockedState"),
            initial_unknowns: list("InitialUnknowns", "InitialUnknown"),
            event_indicators: list("", "EventIndicator"),
        }
    }

    /// The variable behind an index (FMI 2, from 1) or a value reference (FMI 3).
    pub fn resolve(&self, reference: u32) -> Option<usize> {
        match self.version {
            FmiVersion::V2 => (reference as usize).checked_sub(1).filter(|i| *i < self.variables.len()),
            FmiVersion::V3 => self.by_reference.get(&reference).copied(),
        }
    }

    /// What [`Model::resolve`] looks up, for messages.
    pub fn reference_word(&self) -> &'static str {
        match self.version {
            FmiVersion::V2 => "index",
            FmiVersion::V3 => "value reference",
        }
    }

    /// The definition of a variable's declared type.
    pub fn type_of(&self, variable: &Variable<'a>) -> Option<&TypeDefinition<'a>> {
        self.by_type_name.get(variable.declared_type?).map(|i| &self.types[*i])
    }

    /// A typed attribute of the variable, or the default of its declared type.
    pub fn attribute(&self, variable: &Variable<'a>, name: &str) -> Option<&'a str> {
        let own = variable.typed.attribute(name);
        own.or_else(|| self.type_of(variable).and_then(|t| t.typed.attribute(name)))
    }

    /// The variable behind its `derivative` attribute.
    pub fn state_of(&self, variable: &Variable<'a>) -> Option<usize> {
        variable.derivative.and_then(|r| self.resolve(r))
    }

    /// For each variable whether it is a continuous state, as declared by the listed derivatives.
    pub fn states(&self) -> Vec<bool> {
        let mut states = vec![false; self.variables.len()];
        for derivative in self.structure.derivatives.iter().filter_map(|u| u.variable) {
            if let Some(state) = self.state_of(&self.variables[derivative]) {
                states[state] = true;
            }
        }
        states
    }

    /// `file:line` of a node.
    pub fn place(&self, node: Node) -> String {
        format!("{FILE}:{}", self.xml.line(node))
    }

    /// Whether the interface type is declared.
    pub fn has(&self, interface: &str) -> bool {
        self.interfaces.iter().any(|i| i.has_tag_name(interface))
    }
}

fn read_type<'a>(node: Node<'a, 'a>, version: FmiVersion) -> Option<TypeDefinition<'a>> {
    let typed = match version {
        FmiVersion::V2 => typed_child(node)?,
        FmiVersion::V3 => node,
    };
    let name = typed.tag_name().name();
    let type_name = if version == FmiVersion::V3 { name.strip_suffix("Type")? } else { name };
    Some(TypeDefinition { node, typed, name: node.attribute("name")?, type_name })
}

/// FMI 2: the child element that names the type.
fn typed_child<'a>(node: Node<'a, 'a>) -> Option<Node<'a, 'a>> {
    elements(Some(node)).find(|c| Kind::of(FmiVersion::V2, c.tag_name().name()).is_some())
}

fn read_variable<'a>(node: Node<'a, 'a>, version: FmiVersion) -> Option<Variable<'a>> {
    let (typed, type_name) = match version {
        FmiVersion::V2 if !node.has_tag_name("ScalarVariable") => return None,
        // A variable without its type element still counts, or every later index would be off by one.
        FmiVersion::V2 => typed_child(node).map_or((node, "Real"), |t| (t, t.tag_name().name())),
        FmiVersion::V3 => (node, node.tag_name().name()),
    };
    let kind = Kind::of(version, type_name)?;
    let causality = node.attribute("causality").unwrap_or("local");
    let by_default = match version {
        FmiVersion::V2 => "continuous",
        FmiVersion::V3
            if ["parameter", "structuralParameter", "calculatedParameter"].contains(&causality) =>
        {
            "fixed"
        }
        FmiVersion::V3 if kind.is_float() => "continuous",
        FmiVersion::V3 => "discrete",
    };
    let variability = node.attribute("variability").unwrap_or(by_default);
    let initial_written = node.attribute("initial");
    Some(Variable {
        node,
        typed,
        name: node.attribute("name").unwrap_or(""),
        reference: unsigned(node, "valueReference"),
        kind,
        type_name,
        causality,
        variability,
        initial_written,
        initial: initial_written.or_else(|| default_initial(version, causality, variability)),
        declared_type: typed.attribute("declaredType"),
        has_start: typed.attribute("start").is_some() || children(typed, "Start").next().is_some(),
        derivative: unsigned(typed, "derivative"),
        clocked: node.attribute("clocks").is_some(),
        aliases: if version == FmiVersion::V3 { children(node, "Alias").collect() } else { Vec::new() },
    })
}

/// The table of FMI 2.0 section 2.2.7 and FMI 3.0 section 2.4.7.5.
fn default_initial(version: FmiVersion, causality: &str, variability: &str) -> Option<&'static str> {
    match (causality, variability) {
        ("parameter" | "structuralParameter", "fixed" | "tunable") => Some("exact"),
        ("calculatedParameter", "fixed" | "tunable") => Some("calculated"),
        ("input", "discrete" | "continuous") if version == FmiVersion::V3 => Some("exact"),
        ("output" | "local", "constant") => Some("exact"),
        ("output", "discrete" | "continuous") => Some("calculated"),
        ("local", _) => Some("calculated"),
        _ => None,
    }
}
