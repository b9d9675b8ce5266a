//! The reader of `modelDescription.xml`. It takes what it needs and is strict only there.
use super::structure::output_dependencies;
use super::*;
use crate::Error;
use roxmltree::{Document, Node};
use std::str::FromStr;

const FILE: &str = "modelDescription.xml";

impl ModelDescription {
    /// Reads the text of a `modelDescription.xml` of FMI 2.0 or 3.0.
    ///
    /// # Errors
    /// [`Error::Description`] with the line: no XML, another standard, a missing or unreadable attribute.
    pub fn parse(xml: &str) -> Result<Self, Error> {
        let xml = xml.strip_prefix('\u{feff}').unwrap_or(xml);
        let document = Document::parse(xml).map_err(|e| Error::Description {
            file: FILE.to_owned(),
            line: e.pos().row,
            message: format!("not well-formed XML: {e}"),
        })?;
        let root = document.root_element();
        if root.tag_name().name() != "fmiModelDescription" {
            return Err(fault(
                root,
                format!("the root is <{}>, not <fmiModelDescription>", root.tag_name().name()),
            ));
        }
        let text = required(root, "fmiVersion")?;
        let version = match text.split('.').next() {
            Some("2") => FmiVersion::V2,
            Some("3") => FmiVersion::V3,
            _ => {
                return Err(fault(
                    root,
                    format!("fmiVersion {text:?} is not supported, only 2.0 and 3.0 are"),
                ));
            }
        };
        let types = Types::parse(child(root, "TypeDefinitions"), version)?;
        let mut variables = Vec::new();
        for node in children(child(root, "ModelVariables")) {
            let variable = match version {
                FmiVersion::V2 => variable2(node, &types)?,
                FmiVersion::V3 => variable3(node, &types)?,
            };
            variables.extend(variable);
        }
        let output_dependencies = output_dependencies(child(root, "ModelStructure"), version, &variables)?;
        Ok(Self {
            fmi_version: version,
            model_name: required(root, "modelName")?.to_owned(),
            token: required(root, if version == FmiVersion::V2 { "guid" } else { "instantiationToken" })?
                .to_owned(),
            description: optional(root, "description"),
            generation_tool: optional(root, "generationTool"),
            co_simulation: child(root, "CoSimulation").map(interface).transpose()?,
            model_exchange: child(root, "ModelExchange").map(interface).transpose()?,
            default_experiment: experiment(child(root, "DefaultExperiment"))?,
            log_categories: children(child(root, "LogCategories"))
                .filter_map(|n| optional(n, "name"))
                .collect(),
            units: children(child(root, "UnitDefinitions")).map(unit).collect::<Result<_, _>>()?,
            enumerations: types.enumerations,
            variables,
            output_dependencies,
        })
    }
}

/// Attributes that variables inherit from a declared type.
#[derive(Default)]
struct Inherited {
    unit: Option<String>,
    display_unit: Option<String>,
    relative: Option<bool>,
    min: Option<f64>,
    max: Option<f64>,
}

struct Types {
    simple: std::collections::HashMap<String, Inherited>,
    enumerations: Vec<Enumeration>,
}

impl Types {
    fn parse(parent: Option<Node>, version: FmiVersion) -> Result<Self, Error> {
        let mut types = Self { simple: Default::default(), enumerations: Vec::new() };
        for node in children(parent) {
            let name = required(node, "name")?.to_owned();
            // FMI 2 wraps the type in a SimpleType, FMI 3 does not.
            let body = match version {
                FmiVersion::V2 => match node.children().find(Node::is_element) {
                    Some(body) => body,
                    None => continue,
                },
                FmiVersion::V3 => node,
            };
            if matches!(body.tag_name().name(), "Enumeration" | "EnumerationType") {
                let item = |n| {
                    Ok(EnumerationItem { name: required(n, "name")?.to_owned(), value: need(n, "value")? })
                };
                let items = children(Some(body)).filter(|n| n.tag_name().name() == "Item").map(item);
                types
                    .enumerations
                    .push(Enumeration { name: name.clone(), items: items.collect::<Result<_, _>>()? });
            }
            types.simple.insert(name, inherited(body)?);
        }
        Ok(types)
    }
}

fn inherited(node: Node) -> Result<Inherited, Error> {
    Ok(Inherited {
        unit: optional(node, "unit"),
        display_unit: optional(node, "displayUnit"),
        relative: flag(node, "relativeQuantity")?,
        min: number(node, "min")?,
        max: number(node, "max")?,
    })
}

/// One `ScalarVariable`; `None` for anything else.
fn variable2(node: Node, types: &Types) -> Result<Option<Variable>, Error> {
    if node.tag_name().name() != "ScalarVariable" {
        return Ok(None);
    }
    let find = |n: &Node| n.is_element() && n.tag_name().name() != "Annotations";
    let Some(body) = node.children().find(find) else {
        return Err(fault(node, format!("variable {} has no type", required(node, "name")?)));
    };
    let kind = match body.tag_name().name() {
        "Real" => Kind::Float64,
        "Integer" => Kind::Int32,
        "Boolean" => Kind::Boolean,
        "String" => Kind::String,
        "Enumeration" => Kind::Enumeration,
        other => return Err(fault(body, format!("<{other}> is no FMI 2.0 type"))),
    };
    let default = if kind.is_float() { Variability::Continuous } else { Variability::Discrete };
    variable(node, body, kind, default, types).map(Some)
}

/// One typed variable element; `None` for elements of other meaning.
fn variable3(node: Node, types: &Types) -> Result<Option<Variable>, Error> {
    let kind = match node.tag_name().name() {
        "Float64" => Kind::Float64,
        "Float32" => Kind::Float32,
        "Int8" => Kind::Int8,
        "UInt8" => Kind::UInt8,
        "Int16" => Kind::Int16,
        "UInt16" => Kind::UInt16,
        "Int32" => Kind::Int32,
        "UInt32" => Kind::UInt32,
        "Int64" => Kind::Int64,
        "UInt64" => Kind::UInt64,
        "Boolean" => Kind::Boolean,
        "String" => Kind::String,
        "Binary" => Kind::Binary,
        "Enumeration" => Kind::Enumeration,
        "Clock" => Kind::Clock,
        _ => return Ok(None),
    };
    let default = if kind.is_float() { Variability::Continuous } else { Variability::Discrete };
    let mut variable = variable(node, node, kind, default, types)?;
    for dimension in children(Some(node)).filter(|n| n.tag_name().name() == "Dimension") {
        variable.dimensions.push(match parsed(dimension, "start")? {
            Some(size) => Dimension::Size(size),
            None => Dimension::Reference(need(dimension, "valueReference")?),
        });
    }
    if kind == Kind::String {
        variable.start =
            children(Some(node)).find(|n| n.tag_name().name() == "Start").and_then(|n| optional(n, "value"));
    }
    Ok(Some(variable))
}

/// What both standards share: `node` has name and role, `body` the type's attributes.
fn variable(
    node: Node,
    body: Node,
    kind: Kind,
    default: Variability,
    types: &Types,
) -> Result<Variable, Error> {
    let causality = match node.attribute("causality") {
        None | Some("local") => Causality::Local,
        Some("parameter") => Causality::Parameter,
        Some("calculatedParameter") => Causality::CalculatedParameter,
        Some("structuralParameter") => Causality::StructuralParameter,
        Some("input") => Causality::Input,
        Some("output") => Causality::Output,
        Some("independent") => Causality::Independent,
        Some(other) => return Err(fault(node, format!("causality {other:?} does not exist"))),
    };
    let variability = match node.attribute("variability") {
        // FMI 3: parameters are fixed unless they say otherwise.
        None => match causality {
            Causality::Parameter | Causality::CalculatedParameter | Causality::StructuralParameter => {
                Variability::Fixed
            }
            _ => default,
        },
        Some("constant") => Variability::Constant,
        Some("fixed") => Variability::Fixed,
        Some("tunable") => Variability::Tunable,
        Some("discrete") => Variability::Discrete,
        Some("continuous") => Variability::Continuous,
        Some(other) => return Err(fault(node, format!("variability {other:?} does not exist"))),
    };
    let initial = match node.attribute("initial") {
        None => None,
        Some("exact") => Some(Initial::Exact),
        Some("approx") => Some(Initial::Approx),
        Some("calculated") => Some(Initial::Calculated),
        Some(other) => return Err(fault(node, format!("initial {other:?} does not exist"))),
    };
    let own = inherited(body)?;
    let declared_type = optional(body, "declaredType");
    let none = Inherited::default();
    let from_type = declared_type.as_ref().and_then(|name| types.simple.get(name)).unwrap_or(&none);
    Ok(Variable {
        name: required(node, "name")?.to_owned(),
        value_reference: need(node, "valueReference")?,
        kind,
        causality,
        variability,
        initial,
        start: optional(body, "start"),
        unit: own.unit.or_else(|| from_type.unit.clone()),
        display_unit: own.display_unit.or_else(|| from_type.display_unit.clone()),
        relative: own.relative.or(from_type.relative).unwrap_or(false),
        min: own.min.or(from_type.min),
        max: own.max.or(from_type.max),
        description: optional(node, "description"),
        line: line(node),
        dimensions: Vec::new(),
        declared_type,
    })
}

fn interface(node: Node) -> Result<Interface, Error> {
    let model_identifier = required(node, "modelIdentifier")?.to_owned();
    // It becomes a file name: nothing that leads elsewhere.
    let good = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
    if model_identifier.is_empty() || model_identifier.starts_with('.') || !model_identifier.chars().all(good)
    {
        return Err(fault(node, format!("modelIdentifier {model_identifier:?} is no identifier")));
    }
    let is = |name| Ok(flag(node, name)?.unwrap_or(false));
    // The two standards spell some flags differently.
    let either = |a, b| Ok(flag(node, a)?.or(flag(node, b)?).unwrap_or(false));
    Ok(Interface {
        model_identifier,
        needs_execution_tool: is("needsExecutionTool")?,
        only_once_per_process: is("canBeInstantiatedOnlyOncePerProcess")?,
        can_get_and_set_state: either("canGetAndSetFMUstate", "canGetAndSetFMUState")?,
        can_serialize_state: either("canSerializeFMUstate", "canSerializeFMUState")?,
        provides_directional_derivatives: either(
            "providesDirectionalDerivative",
            "providesDirectionalDerivatives",
        )?,
        can_handle_variable_step: is("canHandleVariableCommunicationStepSize")?,
        can_interpolate_inputs: is("canInterpolateInputs")?,
        max_output_derivative_order: parsed(node, "maxOutputDerivativeOrder")?.unwrap_or(0),
        fixed_internal_step_size: number(node, "fixedInternalStepSize")?,
        has_event_mode: is("hasEventMode")?,
        line: line(node),
    })
}

fn experiment(node: Option<Node>) -> Result<DefaultExperiment, Error> {
    let Some(node) = node else { return Ok(DefaultExperiment::default()) };
    Ok(DefaultExperiment {
        start: number(node, "startTime")?,
        stop: number(node, "stopTime")?,
        tolerance: number(node, "tolerance")?,
        step: number(node, "stepSize")?,
    })
}

fn unit(node: Node) -> Result<Unit, Error> {
    let display = children(Some(node)).filter(|n| n.tag_name().name() == "DisplayUnit").map(|n| {
        Ok(DisplayUnit {
            name: required(n, "name")?.to_owned(),
            factor: number(n, "factor")?.unwrap_or(1.0),
            offset: number(n, "offset")?.unwrap_or(0.0),
            inverse: flag(n, "inverse")?.unwrap_or(false),
        })
    });
    Ok(Unit {
        name: required(node, "name")?.to_owned(),
        base: child(node, "BaseUnit").map(base_unit).transpose()?,
        display_units: display.collect::<Result<_, _>>()?,
    })
}

/// `BaseUnit`, the same in both standards and in system structures.
pub(crate) fn base_unit(node: Node) -> Result<BaseUnit, Error> {
    let mut exponents = [0; 8];
    for (exponent, name) in exponents.iter_mut().zip(BaseUnit::NAMES) {
        *exponent = parsed(node, name)?.unwrap_or(0);
    }
    Ok(BaseUnit {
        exponents,
        factor: number(node, "factor")?.unwrap_or(1.0),
        offset: number(node, "offset")?.unwrap_or(0.0),
    })
}

fn line(node: Node) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

pub(super) fn fault(node: Node, message: String) -> Error {
    Error::Description { file: FILE.to_owned(), line: line(node), message }
}

pub(super) fn child<'a, 'd>(node: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
    node.children().find(|n| n.tag_name().name() == name)
}

pub(super) fn children<'a, 'd: 'a>(node: Option<Node<'a, 'd>>) -> impl Iterator<Item = Node<'a, 'd>> {
    node.into_iter().flat_map(|n| n.children()).filter(Node::is_element)
}

fn optional(node: Node, name: &str) -> Option<String> {
    node.attribute(name).map(str::to_owned)
}

pub(super) fn required<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, Error> {
    let absent = || fault(node, format!("<{}> has no attribute {name}", node.tag_name().name()));
    node.attribute(name).ok_or_else(absent)
}

pub(super) fn parsed<T: FromStr>(node: Node, name: &str) -> Result<Option<T>, Error> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    let wrong = |_| fault(node, format!("{name} = {text:?} is not a number of the right kind"));
    text.trim().parse().map(Some).map_err(wrong)
}

fn need<T: FromStr>(node: Node, name: &str) -> Result<T, Error> {
    required(node, name)?;
    parsed(node, name)?.ok_or_else(|| fault(node, format!("{name} is missing")))
}

fn number(node: Node, name: &str) -> Result<Option<f64>, Error> {
    parsed(node, name)
}

fn flag(node: Node, name: &str) -> Result<Option<bool>, Error> {
    match node.attribute(name).map(str::trim) {
        None => Ok(None),
        Some("true" | "1") => Ok(Some(true)),
        Some("false" | "0") => Ok(Some(false)),
        Some(other) => Err(fault(node, format!("{name} = {other:?} is neither true nor false"))),
    }
}
