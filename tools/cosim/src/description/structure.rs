//! `ModelStructure`: what the outputs depend on.
use super::parse::{child, children, fault, parsed, required};
use super::*;
use crate::Error;
use roxmltree::Node;
use std::collections::HashMap;

/// The outputs that `ModelStructure` lists, with the places of what they depend on.
///
/// FMI 2 counts variables from 1, FMI 3 names value references. References to nowhere are faults; what an output
/// depends on without being a variable here (the independent variable of FMI 2, say) is left out.
pub(super) fn output_dependencies(
    structure: Option<Node>,
    version: FmiVersion,
    variables: &[Variable],
) -> Result<Vec<Dependencies>, Error> {
    let places: HashMap<u32, usize> = match version {
        FmiVersion::V2 => (0..variables.len()).map(|i| (i as u32 + 1, i)).collect(),
        FmiVersion::V3 => variables.iter().enumerate().map(|(i, v)| (v.value_reference, i)).collect(),
    };
    let entries: Vec<(Node, &str)> = match version {
        FmiVersion::V2 => {
            children(structure.and_then(|s| child(s, "Outputs"))).map(|n| (n, "index")).collect()
        }
        FmiVersion::V3 => children(structure)
            .filter(|n| n.tag_name().name() == "Output")
            .map(|n| (n, "valueReference"))
            .collect(),
    };
    let mut found = Vec::new();
    for (node, key) in entries {
        required(node, key)?;
        let place = parsed::<u32>(node, key)?.and_then(|k| places.get(&k)).copied();
        let Some(output) = place else {
            return Err(fault(
                node,
                format!("{key} = {:?} is no variable", node.attribute(key).unwrap_or("")),
            ));
        };
        let on = match node.attribute("dependencies") {
            None => None,
            Some(text) => {
                let mut on = Vec::new();
                for word in text.split_ascii_whitespace() {
                    let number: u32 = word
                        .parse()
                        .map_err(|_| fault(node, format!("dependencies has {word:?}, which is no number")))?;
                    on.extend(places.get(&number));
                }
                Some(on)
            }
        };
        found.push(Dependencies { output, on });
    }
    Ok(found)
}

impl ModelDescription {
    /// The inputs that the variable at place `output` passes on without a step in between; `None` if the FMU leaves
    /// that open, and then it may be all of them.
    pub fn feedthrough(&self, output: usize) -> Option<Vec<usize>> {
        let on = self.output_dependencies.iter().find(|d| d.output == output)?.on.as_ref()?;
        Some(on.iter().copied().filter(|i| self.variables[*i].causality == Causality::Input).collect())
    }
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
        assert_eq!(message.to_string(), "modelDescription.xml, line 8: index = \"6\" is no variable");
    }
}
