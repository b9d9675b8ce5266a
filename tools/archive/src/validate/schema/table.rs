//! The tables of the schemas, read from the text files beside this one.
//!
//! A definition begins at the left margin and may go on in indented lines; `#` begins a comment. `@name ...` gives words a
//! name, and `@name` among the words of a later definition is replaced by them. Any other first word is an element; what follows
//! a dot distinguishes elements of the same name. Its words are attributes (`name:type`, with `name!:type` for a required one and
//! `anyAttribute` for `xs:anyAttribute`), then `>` and the content: `any`, `any1` for at most one element of whatever kind,
//! or slots. A slot is an element or a choice `A|B`, with `?`, `*`, `+`, or `?2` for at most two.

use std::collections::HashMap;
use std::sync::LazyLock;

use super::types::Type;

/// The elements of one version of the standard.
pub(crate) struct Schema {
    elements: HashMap<&'static str, Element>,
}

/// An element of a schema.
pub(super) struct Element {
    pub(super) name: &'static str,
    pub(super) attributes: Vec<Attribute>,
    /// `xs:anyAttribute`: attributes that are not in the table are allowed.
    pub(super) any_attribute: bool,
    pub(super) content: Content,
}

/// Content model of an element.
pub(super) enum Content {
    /// A sequence of slots.
    Slots(Vec<Slot>),
    /// Anything, with at most so many child elements.
    Any(usize),
}

/// One place of a sequence: an element, or a choice of elements.
pub(super) struct Slot {
    choices: Vec<&'static str>,
    pub(super) least: usize,
    pub(super) most: usize,
}

/// An attribute of a schema.
pub(super) struct Attribute {
    pub(super) name: &'static str,
    pub(super) kind: Type,
    pub(super) required: bool,
}

pub(super) const UNBOUNDED: usize = usize::MAX;

/// `modelDescription.xml` of FMI 2.0.
pub(crate) static FMI2: LazyLock<Schema> =
    LazyLock::new(|| Schema::parse(concat!(include_str!("common.txt"), include_str!("fmi2.txt"))));
/// All files of FMI 3.0.
pub(crate) static FMI3: LazyLock<Schema> =
    LazyLock::new(|| Schema::parse(concat!(include_str!("common.txt"), include_str!("fmi3.txt"))));

impl Schema {
    fn parse(text: &'static str) -> Schema {
        let mut definitions: Vec<Vec<&str>> = Vec::new();
        for line in text.lines().filter(|l| !l.starts_with('#') && !l.is_empty()) {
            let words = line.split_ascii_whitespace();
            match definitions.last_mut().filter(|_| line.starts_with(' ')) {
                Some(definition) => definition.extend(words),
                None => definitions.push(words.collect()),
            }
        }
        let (mut groups, mut elements) = (HashMap::new(), HashMap::new());
        for definition in definitions {
            let expand = |word| groups.get(word).cloned().unwrap_or_else(|| vec![word]);
            let words: Vec<&str> = definition[1..].iter().copied().flat_map(expand).collect();
            if definition[0].starts_with('@') {
                groups.insert(definition[0], words);
            } else {
                elements.insert(definition[0], Element::parse(definition[0], &words));
            }
        }
        Schema { elements }
    }

    pub(super) fn element(&self, key: &str) -> &Element {
        self.elements.get(key).unwrap_or_else(|| panic!("the table has no element {key}"))
    }

    /// The elements that are allowed in a slot.
    pub(super) fn choices(&self, slot: &Slot) -> impl Iterator<Item = &Element> {
        slot.choices.iter().map(|key| self.element(key))
    }
}

impl Element {
    fn parse(key: &'static str, words: &[&'static str]) -> Element {
        let mut halves = words.split(|word| *word == ">");
        let attributes = halves.next().unwrap_or_default();
        let content = match halves.next().unwrap_or_default() {
            ["any"] => Content::Any(UNBOUNDED),
            ["any1"] => Content::Any(1),
            slots => Content::Slots(slots.iter().map(|word| Slot::parse(word)).collect()),
        };
        Element {
            name: key.split('.').next().unwrap_or(key),
            any_attribute: attributes.contains(&"anyAttribute"),
            attributes: attributes
                .iter()
                .filter(|word| **word != "anyAttribute")
                .map(|word| Attribute::parse(word))
                .collect(),
            content,
        }
    }
}

impl Attribute {
    fn parse(word: &'static str) -> Attribute {
        let (name, kind) =
            word.split_once(':').unwrap_or_else(|| panic!("{word} is neither name:type nor known"));
        let bare = name.trim_end_matches('!');
        Attribute { name: bare, kind: Type::parse(kind), required: bare != name }
    }
}

impl Slot {
    fn parse(word: &'static str) -> Slot {
        let limits = [("?2", 0, 2), ("?", 0, 1), ("*", 0, UNBOUNDED), ("+", 1, UNBOUNDED), ("", 1, 1)];
        let with = |(mark, least, most)| {
            let choices = word.strip_suffix(mark)?.split('|').collect();
            Some(Slot { choices, least, most })
        };
        limits.into_iter().find_map(with).expect("every text ends with no mark")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every name that a definition uses is defined, and every definition is used.
    #[test]
    fn the_tables_are_complete() {
        for (schema, roots) in [
            (&FMI2, &["fmiModelDescription"][..]),
            (&FMI3, &["fmiModelDescription", "fmiBuildDescription", "fmiTerminalsAndIcons"]),
        ] {
            let mut used = roots.to_vec();
            for element in schema.elements.values() {
                if let Content::Slots(slots) = &element.content {
                    slots.iter().for_each(|slot| assert!(schema.choices(slot).count() > 0));
                    used.extend(slots.iter().flat_map(|slot| &slot.choices));
                }
            }
            let unused: Vec<_> = schema.elements.keys().filter(|key| !used.contains(key)).collect();
            assert!(unused.is_empty(), "{unused:?}");
        }
    }
}
