//! Parameter sets (SSV) and parameter mappings (SSM) of SSP, inline or in files.
use super::ssd::{File, Reader};
use super::structure::{Setting, Shared};
use super::units::Affine;
use crate::Error;
use crate::xml::{child, elements};
use roxmltree::Node;

impl Reader {
    /// All values that the bindings of an element give. The prefix of a binding is part of the names in its mapping; with a mapping, only
    /// the parameters that it names are set.
    pub(super) fn settings(&self, file: &File, element: Node) -> Result<(Vec<Setting>, Vec<Shared>), Error> {
        let (mut settings, mut shared) = (Vec::new(), Vec::new());
        for binding in elements(child(element, "ParameterBindings")) {
            let prefix = binding.attribute("prefix").unwrap_or("");
            let mut own = Vec::new();
            self.check_base(file, binding)?;
            if let Some(source) = binding.attribute("source") {
                self.with_file(file, binding, source, "parameter", |file| {
                    parameters(file, file.xml.root(), prefix, &mut own)
                })?;
            }
            for values in elements(child(binding, "ParameterValues")) {
                parameters(file, values, prefix, &mut own)?;
            }
            let Some(mapping) = child(binding, "ParameterMapping") else {
                settings.append(&mut own);
                continue;
            };
            self.check_base(file, mapping)?;
            if let Some(source) = mapping.attribute("source") {
                self.with_file(file, mapping, source, "mapping", |file| {
                    mapped(file, file.xml.root(), &own, &mut settings, &mut shared)
                })?;
            }
            for inline in elements(Some(mapping)) {
                mapped(file, inline, &own, &mut settings, &mut shared)?;
            }
        }
        Ok((settings, shared))
    }

    fn check_base(&self, file: &File, node: Node) -> Result<(), Error> {
        match node.attribute("sourceBase") {
            Some("component") => Err(file.fault(node, "a source within the FMU is not supported")),
            _ => Ok(()),
        }
    }
}

/// The values of one `ParameterSet`.
fn parameters(file: &File, set: Node, prefix: &str, settings: &mut Vec<Setting>) -> Result<(), Error> {
    if set.tag_name().name() != "ParameterSet" {
        return Err(file.fault(set, format!("<{}> is not a <ParameterSet>", set.tag_name().name())));
    }
    let mut file = File { name: file.name.clone(), xml: file.xml, units: file.units.clone() };
    file.units(child(set, "Units"))?;
    for node in elements(child(set, "Parameters")) {
        let name = file.required(node, "name")?;
        let value = node.children().find(|n| n.is_element() && n.tag_name().name() != "Annotations");
        let value = value.ok_or_else(|| file.fault(node, format!("parameter {name} has no value")))?;
        settings.push(Setting {
            name: format!("{prefix}{name}"),
            text: file.required(value, "value")?.to_owned(),
            unit: file.unit(value)?,
            linear: Affine::IDENTITY,
            place: file.place(node),
        });
    }
    Ok(())
}

/// The values that one `ParameterMapping` makes of those of its binding.
fn mapped(
    file: &File,
    mapping: Node,
    from: &[Setting],
    settings: &mut Vec<Setting>,
    shared: &mut Vec<Shared>,
) -> Result<(), Error> {
    if mapping.tag_name().name() != "ParameterMapping" {
        let message = format!("<{}> is not a <ParameterMapping>", mapping.tag_name().name());
        return Err(file.fault(mapping, message));
    }
    for entry in elements(Some(mapping)).filter(|n| n.tag_name().name() == "MappingEntry") {
        let (source, target) = (file.required(entry, "source")?, file.required(entry, "target")?);
        let fault = |what: String| file.fault(entry, format!("mapping {source} -> {target}: {what}"));
        let Some(given) = from.iter().rev().find(|s| s.name == source) else {
            return Err(fault(format!("the binding has no parameter {source}")));
        };
        let mut setting = Setting { name: target.to_owned(), place: file.place(entry), ..given.clone() };
        if let Some("true" | "1") = entry.attribute("suppressUnitConversion").map(str::trim) {
            setting.unit = None;
        }
        for body in elements(Some(entry)) {
            match body.tag_name().name() {
                "LinearTransformation" => {
                    let factor = file.number(body, "factor")?.unwrap_or(1.0);
                    let offset = file.number(body, "offset")?.unwrap_or(0.0);
                    setting.linear = Affine { factor, offset };
                }
                transformation if transformation.ends_with("MappingTransformation") => {
                    let is_it = |n: &Node| n.attribute("source").map(str::trim) == Some(given.text.trim());
                    let found = elements(Some(body)).find(is_it);
                    let found =
                        found.ok_or_else(|| fault(format!("there is no entry for {}", given.text)))?;
                    setting.text = file.required(found, "target")?.to_owned();
                }
                _ => {}
            }
        }
        // A value that a table of the mapping replaces is a value of its own.
        if setting.text == given.text && setting.unit == given.unit {
            let target = (target.to_owned(), setting.linear);
            match shared.iter_mut().find(|known| known.name == source) {
                Some(known) => known.targets.push(target),
                None => shared.push(Shared {
                    name: source.to_owned(),
                    text: given.text.clone(),
                    unit: given.unit.clone(),
                    targets: vec![target],
                }),
            }
        }
        settings.push(setting);
    }
    Ok(())
}
