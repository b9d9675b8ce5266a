//! The model description as the semantic rules need it: one shape for both standards, defaults filled in.
//!
//! Reading is lenient. What cannot be read is `None`, because the schema rules have already reported it.

use std::collections::HashMap;

use roxmltree::Node;

use super::finding::{Findings, short};
use super::rules;
use super::schema::types::{parse_boolean, parse_double, parse_integer};
use super::xml::Xml;

/// Which standard the FMU follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Version {
    Fmi2,
    Fmi3,
}

/// The base type of a variable; FMI 2 `Real` and `Integer` are 64-bit floats and 32-bit integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Kind {
    Float32,
    Float64,
    /// Any integer type.
    Integer,
    UInt64,
    Boolean,
    String,
    Binary,
    Enumeration,
    Clock,
}

impl Kind {
    pub(crate) fn is_float(self) -> bool {
        matches!(self, Kind::Float32 | Kind::Float64)
    }
    fn of(element: &str) -> Option<Kind> {
        Some(match element {
            "Real" | "Float64" => Kind::Float64,
            "Float32" => Kind::Float32,
            "UInt64" => Kind::UInt64,
            "Integer" | "Int8" | "UInt8" | "Int16" | "UInt16" | "Int32" | "UInt32" | "Int64" => Kind::Integer,
            "Boolean" => Kind::Boolean,
            "String" => Kind::String,
            "Binary" => Kind::Binary,
            "Enumeration" => Kind::Enumeration,
            "Clock" => Kind::Clock,
            _ => return None,
        })
    }
}

/// A variable.
pub(crate) struct Variable<'a> {
    /// The element with name and causality.
    pub(crate) node: Node<'a, 'a>,
    /// The element with the typed attributes; in FMI 3 the same.
    pub(crate) typed: Node<'a, 'a>,
    pub(crate) name: &'a str,
    pub(crate) reference: Option<u32>,
    pub(crate) kind: Kind,
    /// The typed element's name, for matching the declared type.
    pub(crate) type_name: &'a str,
    pub(crate) causality: &'a str,
    pub(crate) variability: &'a str,
    /// As written.
    pub(crate) initial_written: Option<&'a str>,
    /// As written, or the default of the table; `None` where the table has none.
    pub(crate) initial: Option<&'a str>,
    pub(crate) declared_type: Option<&'a str>,
    pub(crate) has_start: bool,
    pub(crate) derivative: Option<u32>,
    pub(crate) clocked: bool,
    pub(crate) aliases: Vec<Node<'a, 'a>>,
}

impl<'a> Variable<'a> {
    /// `Variable "x"`, the start of most messages.
    pub(crate) fn label(&self) -> String {
        format!("Variable \"{}\"", short(self.name))
    }
    pub(crate) fn is_array(&self) -> bool {
        self.typed.children().any(|c| c.has_tag_name("Dimension"))
    }
    /// Whether the importer may set it before or during initialisation.
    pub(crate) fn is_settable(&self) -> bool {
        self.variability != "constant"
            && (self.causality == "input" || matches!(self.initial, Some("exact" | "approx")))
    }
}

/// A type definition.
pub(crate) struct TypeDefinition<'a> {
    pub(crate) node: Node<'a, 'a>,
    /// The element with the typed attributes.
    pub(crate) typed: Node<'a, 'a>,
    pub(crate) name: &'a str,
    /// As a variable's element would be called.
    pub(crate) type_name: &'a str,
}

/// An entry of the model structure.
pub(crate) struct Unknown<'a> {
    pub(crate) node: Node<'a, 'a>,
    /// Index (FMI 2) or value reference (FMI 3) as written.
    pub(crate) reference: Option<u32>,
    /// Position in [`Model::variables`].
    pub(crate) variable: Option<usize>,
}

/// The lists of the model structure.
#[derive(Default)]
pub(crate) struct Structure<'a> {
    pub(crate) outputs: Vec<Unknown<'a>>,
    pub(crate) derivatives: Vec<Unknown<'a>>,
    pub(crate) clocked_states: Vec<Unknown<'a>>,
    pub(crate) initial_unknowns: Vec<Unknown<'a>>,
    pub(crate) event_indicators: Vec<Unknown<'a>>,
}

/// A model description.
pub(crate) struct Model<'a> {
    pub(crate) xml: &'a Xml<'a>,
    pub(crate) version: Version,
    pub(crate) root: Node<'a, 'a>,
    /// `ModelExchange`, `CoSimulation`, `ScheduledExecution` elements.
    pub(crate) interfaces: Vec<Node<'a, 'a>>,
    pub(crate) types: Vec<TypeDefinition<'a>>,
    pub(crate) variables: Vec<Variable<'a>>,
    pub(crate) structure: Structure<'a>,
    by_type_name: HashMap<&'a str, usize>,
    by_reference: HashMap<u32, usize>,
}

/// Child elements of a name.
pub(crate) fn children<'a>(node: Node<'a, 'a>, name: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(move |c| c.has_tag_name(name))
}

/// An xs:unsignedInt attribute.
pub(crate) fn unsigned(node: Node, name: &str) -> Option<u32> {
    node.attribute(name).and_then(parse_integer).and_then(|v| u32::try_from(v).ok())
}

/// An xs:double attribute.
pub(crate) fn double(node: Node, name: &str) -> Option<f64> {
    node.attribute(name).and_then(parse_double)
}

/// An xs:boolean attribute that is true.
pub(crate) fn is_true(node: Node, name: &str) -> bool {
    node.attribute(name).and_then(parse_boolean) == Some(true)
}

/// A list of xs:unsignedInt; unreadable items are left out.
pub(crate) fn unsigned_list(text: &str) -> Vec<u32> {
    text.split_ascii_whitespace()
        .filter_map(|t| parse_integer(t).and_then(|v| u32::try_from(v).ok()))
        .collect()
}

impl<'a> Model<'a> {
    /// Another file of the archive must be of the model description's version.
    pub(crate) fn check_version_of(&self, other: &Xml, out: &mut Findings) {
        let root = other.root();
        let (here, there) = (root.attribute("fmiVersion"), self.root.attribute("fmiVersion"));
        if self.version == Version::Fmi3 && here.is_some() && here != there {
            let message = format!(
                "fmiVersion is \"{}\" here and \"{}\" in modelDescription.xml",
                short(here.unwrap_or_default()),
                short(there.unwrap_or_default())
            );
            out.add(&rules::VERSION_MISMATCH, other.place(root), message);
        }
    }

    /// Reads the model description.
    pub(crate) fn read(xml: &'a Xml<'a>, version: Version) -> Model<'a> {
        let root: Node<'a, 'a> = xml.root();
        let interfaces = root
            .children()
            .filter(|c| {
                ["ModelExchange", "CoSimulation", "ScheduledExecution"].contains(&c.tag_name().name())
            })
            .collect();
        let types: Vec<_> = children(root, "TypeDefinitions")
            .flat_map(|list| list.children().filter(Node::is_element))
            .filter_map(|node| read_type(node, version))
            .collect();
        let variables: Vec<_> = children(root, "ModelVariables")
            .flat_map(|list| list.children().filter(Node::is_element))
            .filter_map(|node| read_variable(node, version))
            .collect();
        // The first of several claims a name or a reference; the others are reported by the rules.
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
        let mut model = Model {
            xml,
            version,
            root,
            interfaces,
            types,
            variables,
            structure: Structure::default(),
            by_type_name,
            by_reference,
        };
        model.structure = model.read_structure();
        model
    }

    fn read_structure(&self) -> Structure<'a> {
        let Some(node) = children(self.root, "ModelStructure").next() else { return Structure::default() };
        let list = |name2: &'static str, name3: &'static str| -> Vec<Unknown<'a>> {
            let (key, nodes): (&str, Vec<Node<'a, 'a>>) = match self.version {
                Version::Fmi2 => {
                    ("index", children(node, name2).flat_map(|l| children(l, "Unknown")).collect())
                }
                Version::Fmi3 => ("valueReference", children(node, name3).collect()),
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
    pub(crate) fn resolve(&self, reference: u32) -> Option<usize> {
        match self.version {
            Version::Fmi2 => (reference as usize).checked_sub(1).filter(|i| *i < self.variables.len()),
            Version::Fmi3 => self.by_reference.get(&reference).copied(),
        }
    }

    /// What [`Model::resolve`] looks up, for messages.
    pub(crate) fn reference_word(&self) -> &'static str {
        match self.version {
            Version::Fmi2 => "index",
            Version::Fmi3 => "value reference",
        }
    }

    /// The definition of a variable's declared type.
    pub(crate) fn type_of(&self, variable: &Variable<'a>) -> Option<&TypeDefinition<'a>> {
        self.by_type_name.get(variable.declared_type?).map(|i| &self.types[*i])
    }

    /// A typed attribute of the variable, or the default of its declared type.
    pub(crate) fn attribute(&self, variable: &Variable<'a>, name: &str) -> Option<&'a str> {
        let own = variable.typed.attribute(name);
        own.or_else(|| self.type_of(variable).and_then(|t| t.typed.attribute(name)))
    }

    /// The variable behind its `derivative` attribute.
    pub(crate) fn state_of(&self, variable: &Variable<'a>) -> Option<usize> {
        variable.derivative.and_then(|r| self.resolve(r))
    }

    /// For each variable whether it is a continuous state, as declared by the listed derivatives.
    pub(crate) fn states(&self) -> Vec<bool> {
        let mut states = vec![false; self.variables.len()];
        for derivative in self.structure.derivatives.iter().filter_map(|u| u.variable) {
            if let Some(state) = self.state_of(&self.variables[derivative]) {
                states[state] = true;
            }
        }
        states
    }

    /// `file:line` of a node.
    pub(crate) fn place(&self, node: Node) -> String {
        self.xml.place(node)
    }

    /// Whether the interface type is declared.
    pub(crate) fn has(&self, interface: &str) -> bool {
        self.interfaces.iter().any(|i| i.has_tag_name(interface))
    }
}

fn read_type<'a>(node: Node<'a, 'a>, version: Version) -> Option<TypeDefinition<'a>> {
    let typed = match version {
        Version::Fmi2 => node.children().find(|c| Kind::of(c.tag_name().name()).is_some())?,
        Version::Fmi3 => node,
    };
    let name = typed.tag_name().name();
    let type_name = if version == Version::Fmi3 { name.strip_suffix("Type")? } else { name };
    Some(TypeDefinition { node, typed, name: node.attribute("name")?, type_name })
}

fn read_variable<'a>(node: Node<'a, 'a>, version: Version) -> Option<Variable<'a>> {
    let typed = match version {
        Version::Fmi2 => node.children().find(|c| Kind::of(c.tag_name().name()).is_some()),
        Version::Fmi3 => Some(node),
    };
    // A variable without its type element still counts, or every later FMI 2 index would be off by one.
    let (typed, type_name) = typed.map_or((node, "Real"), |t| (t, t.tag_name().name()));
    let kind = Kind::of(type_name)?;
    let causality = node.attribute("causality").unwrap_or("local");
    let by_default = match version {
        Version::Fmi2 => "continuous",
        Version::Fmi3 if ["parameter", "structuralParameter", "calculatedParameter"].contains(&causality) => {
            "fixed"
        }
        Version::Fmi3 if kind.is_float() => "continuous",
        Version::Fmi3 => "discrete",
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
        aliases: if version == Version::Fmi3 { children(node, "Alias").collect() } else { Vec::new() },
    })
}

/// The table of FMI 2.0 section 2.2.7 and FMI 3.0 section 2.4.7.5.
fn default_initial(version: Version, causality: &str, variability: &str) -> Option<&'static str> {
    match (causality, variability) {
        ("parameter" | "structuralParameter", "fixed" | "tunable") => Some("exact"),
        ("calculatedParameter", "fixed" | "tunable") => Some("calculated"),
        ("input", "discrete" | "continuous") if version == Version::Fmi3 => Some("exact"),
        ("output" | "local", "constant") => Some("exact"),
        ("output", "discrete" | "continuous") => Some("calculated"),
        ("local", _) => Some("calculated"),
        _ => None,
    }
}
