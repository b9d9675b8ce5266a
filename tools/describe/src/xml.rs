//! Common parts of both model descriptions: writer, numbers, units.

use crate::Experiment;
use crate::preset::StartValues;
use physics::declare::{Causality, Kind, Unit, Variability};
use physics::model::{Declaration, Entry, Slot};
use physics::token::Token;
use quick_xml::Writer;
use quick_xml::events::BytesText;
use std::io;

/// A writer into memory, which does not fail.
pub type Xml = Writer<Vec<u8>>;
/// Attributes of an element.
pub type Attributes = Vec<(&'static str, String)>;

/// A document with this root element.
pub fn document(
    root: &str,
    attributes: &Attributes,
    body: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> String {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    element(&mut xml, root, attributes, body).expect("writing to memory does not fail");
    let text = String::from_utf8(xml.into_inner()).expect("names and descriptions are UTF-8");
    format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{text}\n")
}

/// An element with content.
pub fn element(
    xml: &mut Xml,
    name: &str,
    attributes: &Attributes,
    body: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    xml.create_element(name)
        .with_attributes(attributes.iter().map(|(k, v)| (*k, v.as_str())))
        .write_inner_content(body)?;
    Ok(())
}

/// An element without content.
pub fn empty(xml: &mut Xml, name: &str, attributes: &Attributes) -> io::Result<()> {
    xml.create_element(name)
        .with_attributes(attributes.iter().map(|(k, v)| (*k, v.as_str())))
        .write_empty()?;
    Ok(())
}

/// An element with text alone.
pub fn text(xml: &mut Xml, name: &str, attributes: &Attributes, content: &str) -> io::Result<()> {
    xml.create_element(name)
        .with_attributes(attributes.iter().map(|(k, v)| (*k, v.as_str())))
        .write_text_content(BytesText::new(content))?;
    Ok(())
}

/// The attributes of the root: version and token, named as in the standard.
pub(crate) fn root(
    version: &str,
    (token_name, token): (&'static str, Token),
    declaration: &Declaration,
) -> Attributes {
    vec![
        ("fmiVersion", version.to_string()),
        ("modelName", declaration.name.to_string()),
        (token_name, token.to_string()),
        ("description", declaration.description.to_string()),
        ("version", crate::VERSION.to_string()),
        ("author", crate::AUTHOR.to_string()),
        ("copyright", format!("Copyright (c) 2026 {}", crate::AUTHOR)),
        ("license", crate::LICENSE.to_string()),
        ("generationTool", crate::TOOL.to_string()),
        ("variableNamingConvention", "structured".to_string()),
    ]
}

/// The attributes of an interface with these capabilities.
fn interface(declaration: &Declaration, capabilities: &[&'static str]) -> Attributes {
    let identifier = ("modelIdentifier", declaration.name.to_string());
    [identifier].into_iter().chain(capabilities.iter().map(|c| (*c, "true".to_string()))).collect()
}

/// All elements before the variables: both interfaces with their capabilities, units, enumeration types, log categories and default
/// experiment; `wrap` writes the element around the items of an enumeration.
pub(crate) fn preamble(
    xml: &mut Xml,
    declaration: &Declaration,
    [exchange, stepping]: [&[&'static str]; 2],
    experiment: Experiment,
    wrap: impl Fn(&mut Xml, &Attributes, &dyn Fn(&mut Xml) -> io::Result<()>) -> io::Result<()>,
) -> io::Result<()> {
    empty(xml, "ModelExchange", &interface(declaration, exchange))?;
    let mut stepping = interface(declaration, stepping);
    stepping.push(("maxOutputDerivativeOrder", "1".to_string()));
    empty(xml, "CoSimulation", &stepping)?;
    unit_definitions(xml, declaration)?;
    type_definitions(xml, declaration, wrap)?;
    log_categories(xml)?;
    default_experiment(xml, experiment)
}

/// The enumeration types; `wrap` writes the element around the items.
fn type_definitions(
    xml: &mut Xml,
    declaration: &Declaration,
    wrap: impl Fn(&mut Xml, &Attributes, &dyn Fn(&mut Xml) -> io::Result<()>) -> io::Result<()>,
) -> io::Result<()> {
    element(xml, "TypeDefinitions", &vec![], |xml| {
        enumerations(declaration).iter().try_for_each(|t| {
            let attributes = vec![("name", t.name.to_string()), ("description", description(t.doc))];
            wrap(xml, &attributes, &|xml| {
                t.items.iter().try_for_each(|i| {
                    let item = vec![
                        ("name", i.name.to_string()),
                        ("value", i.value.to_string()),
                        ("description", description(i.doc)),
                    ];
                    empty(xml, "Item", &item)
                })
            })
        })
    })
}

/// Name, value reference, description and causality of the independent variable.
pub(crate) fn time_attributes() -> Attributes {
    vec![
        ("name", "time".to_string()),
        ("valueReference", physics::model::TIME.to_string()),
        ("description", "Simulation time".to_string()),
        ("causality", "independent".to_string()),
        ("variability", "continuous".to_string()),
    ]
}

/// Name, value reference, description and causality of an FMI 2 variable; an element is a variable of its own.
pub(crate) fn variable_attributes(entry: &Entry) -> Attributes {
    attributes_of(entry, &entry.name, causality(entry))
}

/// Name, value reference, description, causality and variability of a variable.
pub(crate) fn attributes_of(entry: &Entry, name: &str, causality: &str) -> Attributes {
    let mut attributes = vec![
        ("name", name.to_string()),
        ("valueReference", entry.value_reference.to_string()),
        ("description", variable_description(entry)),
    ];
    attributes.extend(role_attributes(entry, causality));
    attributes
}

/// The start value of a variable, if it has one.
pub(crate) fn start_attribute(entry: &Entry, starts: &StartValues) -> Option<(&'static str, String)> {
    let start = starts.of(entry);
    let text = match entry.row.kind {
        _ if !entry.is_settable() => return None,
        Kind::Boolean => (start != 0.0).to_string(),
        Kind::Real | Kind::Integer | Kind::Enumeration(_) => number(start),
    };
    Some(("start", text))
}

fn log_categories(xml: &mut Xml) -> io::Result<()> {
    element(xml, "LogCategories", &vec![], |xml| {
        physics::model::LOG_CATEGORIES.iter().try_for_each(|(name, description)| {
            empty(
                xml,
                "Category",
                &vec![("name", name.to_string()), ("description", description.to_string())],
            )
        })
    })
}

fn default_experiment(xml: &mut Xml, experiment: Experiment) -> io::Result<()> {
    let attributes = vec![
        ("startTime", "0".to_string()),
        ("stopTime", number(experiment.stop)),
        ("tolerance", number(physics::model::TOLERANCE)),
        ("stepSize", number(experiment.step)),
    ];
    empty(xml, "DefaultExperiment", &attributes)
}

/// The units of the variables, with base units and display unit; the same text in both standards.
fn unit_definitions(xml: &mut Xml, declaration: &Declaration) -> io::Result<()> {
    let used =
        |unit: &&Unit| **unit == Unit::Second || declaration.entries.iter().any(|e| e.row.unit == **unit);
    element(xml, "UnitDefinitions", &vec![], |xml| {
        Unit::ALL.iter().filter(used).try_for_each(|unit| {
            element(xml, "Unit", &vec![("name", unit.name().to_string())], |xml| {
                if let Some(b) = unit.base() {
                    let powers = [
                        ("kg", b.kg),
                        ("m", b.m),
                        ("s", b.s),
                        ("A", b.A),
                        ("K", b.K),
                        ("mol", b.mol),
                        ("cd", b.cd),
                        ("rad", b.rad),
                    ];
                    let powers =
                        powers.iter().filter(|(_, p)| *p != 0).map(|(n, p)| (*n, p.to_string())).collect();
                    empty(xml, "BaseUnit", &powers)?;
                }
                let Some(shown) = unit.display() else { return Ok(()) };
                let mut attributes = vec![("name", shown.name.to_string())];
                if shown.factor != 1.0 {
                    attributes.push(("factor", number(shown.factor)));
                }
                if shown.offset != 0.0 {
                    attributes.push(("offset", number(shown.offset)));
                }
                empty(xml, "DisplayUnit", &attributes)
            })
        })
    })
}

/// The shortest text that is read as the same double.
fn number(value: f64) -> String {
    format!("{value}")
}

/// The attributes of a real variable, from unit to start, in the order of both standards.
pub(crate) fn real_attributes(entry: &Entry, starts: &StartValues) -> Attributes {
    let row = entry.row;
    let mut attributes = vec![("unit", row.unit.name().to_string())];
    let quantity = if row.relative { Some("TemperatureDifference") } else { row.unit.quantity() };
    attributes.extend(quantity.map(|quantity| ("quantity", quantity.to_string())));
    if row.unbounded {
        attributes.push(("unbounded", "true".to_string()));
    }
    if let Some(shown) = row.unit.display() {
        attributes.push(("displayUnit", shown.name.to_string()));
    }
    if row.relative {
        attributes.push(("relativeQuantity", "true".to_string()));
    }
    attributes.extend(limit_attributes(entry));
    attributes.push(("nominal", number(row.nominal)));
    attributes.extend(start_attribute(entry, starts));
    attributes
}

/// The index of the state of which this entry is the derivative.
pub(crate) fn state_of(declaration: &Declaration, entry: &Entry) -> Option<usize> {
    (entry.slot.group == Slot::RATES).then(|| declaration.states[entry.slot.row as usize][0])
}

/// The attributes of an integer: limits and start.
pub(crate) fn integer_attributes(entry: &Entry, starts: &StartValues) -> Attributes {
    limit_attributes(entry).chain(start_attribute(entry, starts)).collect()
}

fn limit_attributes(entry: &Entry) -> impl Iterator<Item = (&'static str, String)> {
    let limits = [("min", entry.row.min), ("max", entry.row.max)];
    limits.into_iter().filter(|(_, limit)| limit.is_finite()).map(|(name, limit)| (name, number(limit)))
}

pub(crate) fn causality(entry: &Entry) -> &'static str {
    match entry.row.causality {
        Causality::Parameter => "parameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
    }
}

/// Causality, variability and, where required, `initial`.
fn role_attributes(entry: &Entry, causality: &str) -> Attributes {
    let variability = match entry.row.variability {
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    };
    let mut attributes = vec![("causality", causality.to_string()), ("variability", variability.to_string())];
    match entry.row.causality {
        Causality::Parameter => attributes.push(("initial", "exact".to_string())),
        Causality::Output | Causality::Local => attributes.push(("initial", "calculated".to_string())),
        Causality::Input => {}
    }
    attributes
}

/// The description of a variable, with what the declaration says about its limits.
pub(crate) fn variable_description(entry: &Entry) -> String {
    let text = description(entry.row.doc);
    if entry.row.saturates { format!("{text}; saturates at its limits") } else { text }
}

/// The description as one line.
pub(crate) fn description(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The enumeration types of a model, each once.
fn enumerations(declaration: &Declaration) -> Vec<&'static physics::declare::Enumeration> {
    let mut types = Vec::new();
    for entry in &declaration.entries {
        if let Kind::Enumeration(t) = entry.row.kind
            && !types.contains(&t)
        {
            types.push(t);
        }
    }
    types
}

/// Indices or value references as a list.
pub(crate) fn list(numbers: impl Iterator<Item = u64>) -> String {
    numbers.map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
}
