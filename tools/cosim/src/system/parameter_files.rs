//! Parameters of a system as SSP 1.0 has them: their values (SSV) and the mapping to variables of components (SSM), in files of the package.
//!
//! The values also stand at the components, for tools that read no mapping. A value of the system takes precedence over them, so a
//! change in the SSV file reaches all variables.
use super::connections::Connections;
use super::parts::Parts;
use super::settings::{owner, value};
use super::structure::{Place, Setting, Shared};
use super::tags::{NAMESPACES, Tag, document, leaf, list, node, unit_tag};
use super::units::Affine;
use crate::Kind;
use std::io;

/// Names in the package.
pub(super) const VALUES: &str = "resources/parameters.ssv";
pub(super) const MAPPING: &str = "resources/parameters.ssm";
/// The name of the parameter set. Tools that read the sets of one name only, those of the components, do not read this one.
const PARAMETER_SET: &str = "parameters";
const MAPPING_NAMESPACE: (&str, &str) =
    ("xmlns:ssm", "http://ssp-standard.org/SSP1/SystemStructureParameterMapping");

/// Text of both files; none without parameters.
pub(super) fn files(parts: Parts, connections: &Connections) -> io::Result<Option<[String; 2]>> {
    let (mut values, mut entries, mut units) = (Vec::new(), Vec::new(), Vec::new());
    for shared in &parts.structure.shared {
        let targets: Vec<&(String, Affine)> =
            shared.targets.iter().filter(|target| in_effect(parts, connections, shared, target)).collect();
        let Some(tag) = targets.first().and_then(|(target, _)| typed(parts, target, &shared.text)) else {
            continue;
        };
        let unit = shared.unit.as_ref().filter(|unit| unit.base.is_some());
        let mut attributes = vec![("value", shared.text.as_str())];
        attributes.extend(unit.map(|unit| ("unit", unit.name.as_str())));
        values.push(node("ssv:Parameter", &[("name", &shared.name)], vec![leaf(tag, &attributes)]));
        units.extend(unit.filter(|unit| !units.contains(unit)));
        entries.extend(targets.into_iter().map(|(target, linear)| entry(&shared.name, target, *linear)));
    }
    let Some(values) = list("ssv:Parameters", values) else { return Ok(None) };
    let units = units.into_iter().filter_map(|unit| Some(unit_tag(&unit.name, &unit.base?))).collect();
    let [common, _, of_values] = NAMESPACES;
    let set = [of_values, common, ("version", "1.0"), ("name", PARAMETER_SET)];
    let mapping = [MAPPING_NAMESPACE, common, ("version", "1.0")];
    let children = [Some(values), list("ssv:Units", units)].into_iter().flatten().collect();
    Ok(Some([
        document(&node("ssv:ParameterSet", &set, children))?,
        document(&node("ssm:ParameterMapping", &mapping, entries))?,
    ]))
}

/// The binding of both files in the system.
pub(super) fn binding() -> Tag {
    let mapping = leaf("ssd:ParameterMapping", &[("source", MAPPING)]);
    let binding = node("ssd:ParameterBinding", &[("source", VALUES)], vec![mapping]);
    node("ssd:ParameterBindings", &[], vec![binding])
}

/// Whether the variable has the value of the parameter, which a later setting may have replaced.
fn in_effect(
    parts: Parts,
    connections: &Connections,
    shared: &Shared,
    (target, linear): &(String, Affine),
) -> bool {
    let Some((component, name)) = owner(parts.structure, target) else { return false };
    let setting = Setting {
        name: name.to_owned(),
        text: shared.text.clone(),
        unit: shared.unit.clone(),
        linear: *linear,
        place: Place { file: "".into(), line: 0 },
    };
    value(parts.description(component), name, &setting, None, None)
        .is_ok_and(|value| connections.sets[component].contains(&value))
}

/// The element of a value for a variable.
fn typed(parts: Parts, target: &str, text: &str) -> Option<&'static str> {
    let (component, name) = owner(parts.structure, target)?;
    let variable = parts.description(component).variables.iter().find(|variable| variable.name == name)?;
    Some(match variable.kind {
        Kind::Float64 | Kind::Float32 => "ssv:Real",
        Kind::Boolean => "ssv:Boolean",
        Kind::String => "ssv:String",
        Kind::Binary | Kind::Clock => "ssv:Binary",
        Kind::Enumeration if text.trim().parse::<i64>().is_err() => "ssv:Enumeration",
        _ => "ssv:Integer",
    })
}

fn entry(source: &str, target: &str, Affine { factor, offset }: Affine) -> Tag {
    let attributes = [("source", source), ("target", target)];
    if (Affine { factor, offset }) == Affine::IDENTITY {
        return leaf("ssm:MappingEntry", &attributes);
    }
    let (factor, offset) = (factor.to_string(), offset.to_string());
    let linear = leaf("ssc:LinearTransformation", &[("factor", &factor), ("offset", &offset)]);
    node("ssm:MappingEntry", &attributes, vec![linear])
}
