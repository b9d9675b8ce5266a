//! A signal dictionary as SSP 1.0 has it (SSB), in a file of the package: each output that is connected to a component is an entry, and
//! the connections go through the entries.
use super::parts::{Parts, Port};
use super::structure::{End, unit_in};
use super::tags::{NAMESPACES, Tag, document, leaf, list, node, type_tag, unit_tag};
use super::units::unit_of;
use crate::{Kind, Unit};
use std::io;

/// Name in the package.
pub(super) const FILE: &str = "resources/signals.ssb";
const NAME: &str = "signals";
const NAMESPACE: (&str, &str) = ("xmlns:ssb", "http://ssp-standard.org/SSP1/SystemStructureSignalDictionary");

/// A signal, with the output that gives it.
struct Entry {
    source: End,
    kind: Kind,
    unit: Option<Unit>,
}

/// The entries, and the name of the element that stands for the dictionary.
pub(super) struct Dictionary {
    element: String,
    entries: Vec<Entry>,
}

impl Dictionary {
    /// The dictionary of all connections between components. Enumerations, whose items no file of SSP repeats, are not in it.
    pub(super) fn of<'e>(parts: Parts, sources: impl Iterator<Item = (&'e End, Port)>) -> Dictionary {
        let components = &parts.structure.components;
        let numbered = |k: usize| if k == 1 { NAME.to_owned() } else { format!("{NAME}-{k}") };
        let taken = |name: &String| components.iter().any(|component| component.name == *name);
        let element = (1..).map(numbered).find(|name| !taken(name)).unwrap_or_default();
        let mut entries: Vec<Entry> = Vec::new();
        for (source, port) in sources {
            let variable = parts.variable(port);
            if variable.kind == Kind::Enumeration || entries.iter().any(|entry| entry.source == *source) {
                continue;
            }
            let declared = unit_in(components[port.component].connectors.as_deref(), &source.connector);
            let own = || unit_of(parts.description(port.component), variable);
            let unit = declared.or_else(own).filter(|unit| unit.base.is_some());
            entries.push(Entry { source: source.clone(), kind: variable.kind, unit });
        }
        Dictionary { element, entries }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The entry of an output, as the end of a connection.
    pub(super) fn entry(&self, source: &End) -> Option<End> {
        let entry = self.entries.iter().find(|entry| entry.source == *source)?;
        Some(End { component: Some(self.element.clone()), connector: entry.source.to_string() })
    }

    /// Each output with its entry.
    pub(super) fn sources(&self) -> impl Iterator<Item = (&End, End)> {
        self.entries.iter().filter_map(|entry| Some((&entry.source, self.entry(&entry.source)?)))
    }

    /// The element that stands for the dictionary.
    pub(super) fn reference(&self) -> Tag {
        let connector = |entry: &Entry| {
            let name = entry.source.to_string();
            node(
                "ssd:Connector",
                &[("name", &name), ("kind", "inout")],
                type_tag(entry.kind, None).into_iter().collect(),
            )
        };
        let attributes = [("name", self.element.as_str()), ("dictionary", NAME)];
        let connectors = self.entries.iter().map(connector).collect();
        node(
            "ssd:SignalDictionaryReference",
            &attributes,
            list("ssd:Connectors", connectors).into_iter().collect(),
        )
    }

    /// The text of the file.
    pub(super) fn file(&self) -> io::Result<String> {
        let mut units: Vec<&Unit> = Vec::new();
        let mut children = Vec::new();
        for entry in &self.entries {
            let own = entry.unit.as_ref();
            units.extend(own.filter(|unit| !units.contains(unit)));
            let tag = type_tag(entry.kind, own.map(|unit| unit.name.as_str()));
            children.push(node(
                "ssb:DictionaryEntry",
                &[("name", &entry.source.to_string())],
                tag.into_iter().collect(),
            ));
        }
        let units = units.into_iter().filter_map(|unit| Some(unit_tag(&unit.name, &unit.base?))).collect();
        children.extend(list("ssb:Units", units));
        let [common, ..] = NAMESPACES;
        document(&node("ssb:SignalDictionary", &[NAMESPACE, common, ("version", "1.0")], children))
    }
}

/// The dictionary in the system.
pub(super) fn declaration() -> Tag {
    let one = leaf("ssd:SignalDictionary", &[("name", NAME), ("source", FILE)]);
    node("ssd:SignalDictionaries", &[], vec![one])
}
