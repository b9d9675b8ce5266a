//! From the elements of `modelDescription.xml` to a [`ModelDescription`]; strict for the elements that it uses.
use super::*;
use crate::Error;
use crate::elements::{self, Model, TypeDefinition, Unknown};
use crate::xml::{Fault, Xml, child, children, elements};
use roxmltree::Node;

impl ModelDescription {
    /// Reads the text of a `modelDescription.xml` of FMI 2.0 or 3.0.
    ///
    /// # Errors
    /// [`Error::Text`] with the line: no XML, another standard, a missing or unreadable attribute.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let description = Xml::read(text).and_then(|xml| read(&xml));
        let file = FILE.to_owned();
        description.map_err(|Fault { line, message }| Error::Text { file, line: line.into(), message })
    }
}

fn read(xml: &Xml) -> Result<ModelDescription, Fault> {
    let root = xml.root();
    if root.tag_name().name() != "fmiModelDescription" {
        let message = format!("the root is <{}>, not <fmiModelDescription>", root.tag_name().name());
        return Err(xml.fault(root, message));
    }
    let text = xml.required(root, "fmiVersion")?;
    let version = match text.split('.').next() {
        Some("2") => FmiVersion::V2,
        Some("3") => FmiVersion::V3,
        _ => {
            let message = format!("fmiVersion {text:?} is not supported, only 2.0 and 3.0 are");
            return Err(xml.fault(root, message));
        }
    };
    let model = Model::read(xml, version);
    let optional = |name| root.attribute(name).map(str::to_owned);
    Ok(ModelDescription {
        fmi_version: version,
        enumerations: model.types.iter().filter_map(|t| enumeration(xml, t)).collect::<Result<_, _>>()?,
        variables: model.variables.iter().map(|v| variable(&model, v)).collect::<Result<_, _>>()?,
        state_count: model.structure.derivatives.len(),
        indicator_count: xml.number(root, "numberOfEventIndicators")?.unwrap_or(0),
        output_dependencies: model
            .structure
            .outputs
            .iter()
            .map(|u| dependencies(&model, u))
            .collect::<Result<_, _>>()?,
        model_name: xml.required(root, "modelName")?.to_owned(),
        token: xml
            .required(root, if version == FmiVersion::V2 { "guid" } else { "instantiationToken" })?
            .to_owned(),
        description: optional("description"),
        generation_tool: optional("generationTool"),
        interfaces: model.interfaces.iter().map(|n| interface(&model, *n)).collect::<Result<_, _>>()?,
        default_experiment: experiment(xml, child(root, "DefaultExperiment"))?,
        log_categories: elements(child(root, "LogCategories"))
            .filter_map(|n| n.attribute("name").map(str::to_owned))
            .collect(),
        units: elements(child(root, "UnitDefinitions")).map(|n| unit(xml, n)).collect::<Result<_, _>>()?,
    })
}

fn enumeration(xml: &Xml, definition: &TypeDefinition) -> Option<Result<Enumeration, Fault>> {
    let item = |n| {
        let name = xml.required(n, "name")?.to_owned();
        Ok(EnumerationItem { name, value: xml.required_number(n, "value")? })
    };
    (definition.type_name == "Enumeration").then(|| {
        let items = children(definition.typed, "Item").map(item).collect::<Result<_, _>>()?;
        Ok(Enumeration { name: definition.name.to_owned(), items })
    })
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

fn inherited(xml: &Xml, node: Node) -> Result<Inherited, Fault> {
    Ok(Inherited {
        unit: node.attribute("unit").map(str::to_owned),
        display_unit: node.attribute("displayUnit").map(str::to_owned),
        relative: xml.flag(node, "relativeQuantity")?,
        min: xml.number(node, "min")?,
        max: xml.number(node, "max")?,
    })
}

fn variable<'a>(model: &Model<'a>, v: &elements::Variable<'a>) -> Result<Variable, Fault> {
    let (xml, node) = (model.xml, v.node);
    if model.version == FmiVersion::V2 && v.typed == node {
        let other = elements(Some(node)).find(|n| n.tag_name().name() != "Annotations");
        return Err(match other {
            Some(body) => xml.fault(body, format!("<{}> is not an FMI 2.0 type", body.tag_name().name())),
            None => xml.fault(node, format!("variable {} has no type", xml.required(node, "name")?)),
        });
    }
    let unknown = |name: &str, text: &str| xml.fault(node, format!("{name} {text:?} does not exist"));
    let causality = Causality::of(v.causality).ok_or_else(|| unknown("causality", v.causality))?;
    let variability = match node.attribute("variability") {
        // FMI 3: the default variability of parameters is fixed.
        None => match causality {
            Causality::Parameter | Causality::CalculatedParameter | Causality::StructuralParameter => {
                Variability::Fixed
            }
            _ if v.kind.is_float() => Variability::Continuous,
            _ => Variability::Discrete,
        },
        Some(word) => Variability::of(word).ok_or_else(|| unknown("variability", word))?,
    };
    let initial = v.initial_written.map(|word| Initial::of(word).ok_or_else(|| unknown("initial", word)));
    let initial = initial.transpose()?;
    let own = inherited(xml, v.typed)?;
    let from_type = model.type_of(v).map(|t| inherited(xml, t.typed)).transpose()?.unwrap_or_default();
    let dimensions = children(v.typed, "Dimension").map(|dimension| {
        Ok(match xml.number(dimension, "start")? {
            Some(size) => Dimension::Size(size),
            None => Dimension::Reference(xml.required_number(dimension, "valueReference")?),
        })
    });
    let start = match model.version {
        FmiVersion::V3 if matches!(v.kind, Kind::String | Kind::Binary) => {
            child(node, "Start").and_then(|start| start.attribute("value"))
        }
        _ => v.typed.attribute("start"),
    };
    Ok(Variable {
        name: xml.required(node, "name")?.to_owned(),
        value_reference: xml.required_number(node, "valueReference")?,
        kind: v.kind,
        causality,
        variability,
        initial,
        start: start.map(str::to_owned),
        unit: own.unit.or(from_type.unit),
        display_unit: own.display_unit.or(from_type.display_unit),
        relative: own.relative.or(from_type.relative).unwrap_or(false),
        min: own.min.or(from_type.min),
        max: own.max.or(from_type.max),
        description: node.attribute("description").map(str::to_owned),
        intermediate_update: xml.flag(v.typed, "intermediateUpdate")?.unwrap_or(false),
        line: xml.line(node),
        dimensions: dimensions.collect::<Result<_, _>>()?,
        declared_type: v.declared_type.map(str::to_owned),
        clock: if v.kind == Kind::Clock { Some(clock(model, v)?) } else { None },
    })
}

fn clock<'a>(model: &Model<'a>, v: &elements::Variable<'a>) -> Result<ClockTicks, Fault> {
    let number = |name| -> Result<Option<f64>, Fault> {
        match model.attribute(v, name) {
            Some(text) => text.trim().parse().map(Some).map_err(|_| {
                model.xml.fault(v.node, format!("{name} = {text:?} is not a number of the right kind"))
            }),
            None => Ok(None),
        }
    };
    let word = model.attribute(v, "intervalVariability").unwrap_or("");
    let variability = IntervalVariability::of(word)
        .ok_or_else(|| model.xml.fault(v.node, format!("intervalVariability {word:?} does not exist")))?;
    let fraction = number("intervalCounter")?.zip(number("resolution")?).map(|(n, per)| n / per);
    Ok(ClockTicks { variability, interval: number("intervalDecimal")?.or(fraction) })
}

/// Dependencies of an output. Entries that are not variables here (as the independent variable of FMI 2) are omitted.
fn dependencies(model: &Model, unknown: &Unknown) -> Result<Dependencies, Fault> {
    let (xml, node) = (model.xml, unknown.node);
    let key = if model.version == FmiVersion::V2 { "index" } else { "valueReference" };
    let text = xml.required(node, key)?;
    xml.number::<u32>(node, key)?;
    let output = unknown.variable;
    let output = output.ok_or_else(|| xml.fault(node, format!("{key} = {text:?} is not a variable")))?;
    let Some(text) = node.attribute("dependencies") else { return Ok(Dependencies { output, on: None }) };
    let mut on = Vec::new();
    for word in text.split_ascii_whitespace() {
        let wrong = |_| xml.fault(node, format!("dependencies has {word:?}, which is not a number"));
        on.extend(model.resolve(word.parse().map_err(wrong)?));
    }
    Ok(Dependencies { output, on: Some(on) })
}

fn interface(model: &Model, node: Node) -> Result<Interface, Fault> {
    let xml = model.xml;
    let model_identifier = xml.required(node, "modelIdentifier")?.to_owned();
    // It becomes a file name, so it must not contain path separators.
    let good = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
    if model_identifier.is_empty() || model_identifier.starts_with('.') || !model_identifier.chars().all(good)
    {
        return Err(xml.fault(node, format!("modelIdentifier {model_identifier:?} is not an identifier")));
    }
    let is = |name| Ok(xml.flag(node, name)?.unwrap_or(false));
    // The two standards spell some flags differently.
    let either = |a, b| Ok(xml.flag(node, a)?.or(xml.flag(node, b)?).unwrap_or(false));
    Ok(Interface {
        kind: match node.tag_name().name() {
            "ModelExchange" => InterfaceType::ModelExchange,
            "ScheduledExecution" => InterfaceType::ScheduledExecution,
            _ => InterfaceType::CoSimulation,
        },
        model_identifier,
        needs_execution_tool: is("needsExecutionTool")?,
        only_once_per_process: is("canBeInstantiatedOnlyOncePerProcess")?,
        can_get_and_set_state: either("canGetAndSetFMUstate", "canGetAndSetFMUState")?,
        can_serialize_state: either("canSerializeFMUstate", "canSerializeFMUState")?,
        provides_directional_derivatives: either(
            "providesDirectionalDerivative",
            "providesDirectionalDerivatives",
        )?,
        provides_adjoint_derivatives: is("providesAdjointDerivatives")?,
        needs_completed_step: match model.version {
            FmiVersion::V2 => !is("completedIntegratorStepNotNeeded")?,
            FmiVersion::V3 => is("needsCompletedIntegratorStep")?,
        },
        can_handle_variable_step: is("canHandleVariableCommunicationStepSize")?,
        can_interpolate_inputs: is("canInterpolateInputs")?,
        provides_intermediate_update: is("providesIntermediateUpdate")?,
        max_output_derivative_order: xml.number(node, "maxOutputDerivativeOrder")?.unwrap_or(0),
        fixed_internal_step_size: xml.number(node, "fixedInternalStepSize")?,
        has_event_mode: is("hasEventMode")?,
        line: xml.line(node),
    })
}

fn experiment(xml: &Xml, node: Option<Node>) -> Result<DefaultExperiment, Fault> {
    let Some(node) = node else { return Ok(DefaultExperiment::default()) };
    Ok(DefaultExperiment {
        start: xml.number(node, "startTime")?,
        stop: xml.number(node, "stopTime")?,
        tolerance: xml.number(node, "tolerance")?,
        step: xml.number(node, "stepSize")?,
    })
}

fn unit(xml: &Xml, node: Node) -> Result<Unit, Fault> {
    let display = children(node, "DisplayUnit").map(|n| {
        Ok(DisplayUnit {
            name: xml.required(n, "name")?.to_owned(),
            factor: xml.number(n, "factor")?.unwrap_or(1.0),
            offset: xml.number(n, "offset")?.unwrap_or(0.0),
            inverse: xml.flag(n, "inverse")?.unwrap_or(false),
        })
    });
    Ok(Unit { display_units: display.collect::<Result<_, _>>()?, ..xml.unit(node)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_standards_say_what_outputs_depend_on() {
        let two = r#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><ModelVariables>
            <ScalarVariable name="y" valueReference="7" causality="output"><Real/></ScalarVariable>
            <ScalarVariable name="z" valueReference="8" causality="output"><Real/></ScalarVariable>
            <ScalarVariable name="u" valueReference="9" causality="input"><Real start="0"/></ScalarVariable>
            <ScalarVariable name="p" valueReference="1" causality="parameter"><Real start="0"/></ScalarVariable>
            <ScalarVariable name="w" valueReference="2" causality="output"><Real/></ScalarVariable>
            </ModelVariables><ModelStructure><Outputs><Unknown index="1" dependencies="3 4"/>
            <Unknown index="2" dependencies=""/><Unknown index="5"/></Outputs></ModelStructure></fmiModelDescription>"#;
        let three = r#"<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="g"><ModelVariables>
            <Float64 name="y" valueReference="7" causality="output"/>
            <Float64 name="z" valueReference="8" causality="output"/>
            <Float64 name="u" valueReference="9" causality="input" start="0"/>
            <Float64 name="p" valueReference="1" causality="parameter" start="0"/>
            <Float64 name="w" valueReference="2" causality="output"/>
            </ModelVariables><ModelStructure><Output valueReference="7" dependencies="9 1"/>
            <Output valueReference="8" dependencies=""/><Output valueReference="2"/></ModelStructure></fmiModelDescription>"#;
        for xml in [two, three] {
            let d = ModelDescription::parse(xml).unwrap();
            assert_eq!(d.feedthrough(0), Some(vec![2]), "of u and p only the input counts");
            assert_eq!(d.feedthrough(1), Some(vec![]));
            assert_eq!(d.feedthrough(4), None);
        }
        let message = ModelDescription::parse(&two.replace("index=\"5\"", "index=\"6\"")).unwrap_err();
        assert_eq!(message.to_string(), "modelDescription.xml, line 8: index = \"6\" is not a variable");
    }
}
