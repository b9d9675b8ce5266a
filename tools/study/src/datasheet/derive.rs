//! Start values from a datasheet, each with where it is from, the variables that keep their defaults, and the text of the preset.

use super::ways::{Derived, ESTIMATES, REQUIRED, WAYS};
use super::{Datasheet, Quantity, Value, by_key};
use crate::StudyError;
use crate::reproduce::significant;
use describe::preset::{MOTOR, from_text};
use describe::{Causality, Entry, Kind, models};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// How sure a start value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Certainty {
    /// Printed in the datasheet.
    Datasheet,
    /// Computed from printed values.
    Derived,
    /// Neither; a rule that the preset names.
    Estimate,
    /// Not in the datasheet: the declared value, with its source.
    Default,
}

impl Certainty {
    /// In a word.
    pub fn text(self) -> &'static str {
        match self {
            Certainty::Datasheet => "datasheet",
            Certainty::Derived => "derived",
            Certainty::Estimate => "estimate",
            Certainty::Default => "default",
        }
    }
}

/// A start value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Given {
    /// Variable of the motor.
    pub name: String,
    /// Its value, SI.
    pub value: f64,
    /// Its SI unit.
    pub unit: &'static str,
    /// How sure it is.
    pub certainty: Certainty,
    /// Where it is from, with the numbers.
    pub source: String,
    /// Number and unit as printed, for a value that needs no formula.
    #[serde(skip)]
    printed: Option<(f64, String)>,
}

/// Begin of the text of a preset.
const HEADER: &str = "# Written by `motor-fmu preset new` from";

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A preset that follows from a datasheet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Draft {
    /// Name of the preset.
    pub name: String,
    /// Its model.
    pub model: &'static str,
    /// One line about the motor.
    pub description: String,
    /// Source of the values.
    pub datasheet: String,
    /// The start values, and the parameters that stay at their defaults.
    pub values: Vec<Given>,
    /// Printed values from which nothing follows and that nothing is compared with.
    pub not_used: Vec<String>,
}

impl Draft {
    /// The start values that follow from the datasheet.
    ///
    /// # Errors
    /// Values that no motor has, or too few of them: one sentence.
    pub fn new(sheet: &Datasheet) -> Result<Draft, StudyError> {
        let sheet = &sheet.with_static_friction();
        let kind = models::by_name(MOTOR).ok_or_else(|| StudyError::new(format!("no model {MOTOR}")))?;
        let declaration = (kind.declaration)();
        let mut found: BTreeMap<&str, Given> = BTreeMap::new();
        let mut used: Vec<&str> = vec!["poles"];
        for (way, certainty) in
            WAYS.iter().map(|w| (w, None)).chain(ESTIMATES.iter().map(|w| (w, Some(Certainty::Estimate))))
        {
            if found.contains_key(way.name) {
                continue;
            }
            let Some(entry) = declaration.by_name(way.name) else { continue };
            if let Some(given) = way.apply(entry, sheet, &found, certainty) {
                check(entry, &given)?;
                used.extend(way.needs);
                found.insert(way.name, given);
            }
        }
        for (name, how) in REQUIRED {
            if !found.contains_key(name) {
                return Err(StudyError::new(format!(
                    "{name} does not follow from the datasheet: give {how}"
                )));
            }
        }
        let mut values: Vec<Given> =
            WAYS.iter().chain(ESTIMATES).filter_map(|way| found.remove(way.name)).collect();
        let parameters = declaration.entries.iter().filter(|e| e.row.causality == Causality::Parameter);
        let left = parameters.filter(|e| values.iter().all(|v| v.name != e.name)).map(by_default);
        let left: Vec<Given> = left.collect();
        values.extend(left);
        let left = sheet.values.iter().filter(|v| v.quantity.of.is_none() && !used.contains(&v.quantity.key));
        Ok(Draft {
            not_used: left.map(|v| format!("{} {}", v.quantity.words, v.text())).collect(),
            name: sheet.name.clone(),
            model: MOTOR,
            description: sheet.description.clone(),
            datasheet: sheet.source.clone(),
            values,
        })
    }

    /// The values of a certainty.
    pub fn of(&self, certainty: Certainty) -> impl Iterator<Item = &Given> {
        self.values.iter().filter(move |v| v.certainty == certainty)
    }

    /// The defaults that are properties of the motor: without the effects that are off and without initial states.
    pub fn defaults(&self) -> impl Iterator<Item = &Given> {
        self.of(Certainty::Default).filter(|v| !v.is_off())
    }

    /// Whether a text is that of a preset of this name, of any datasheet.
    pub fn is_earlier(name: &str, text: &str) -> bool {
        text.starts_with(HEADER) && text.lines().any(|line| line == format!("name = {}", quoted(name)))
    }

    /// The text of the preset.
    pub fn toml(&self) -> String {
        let mut text = String::new();
        let _ = writeln!(text, "{HEADER} {}.", self.source());
        text += "# Each comment begins with how sure the value is: datasheet = value of that source; derived = computed from such\n\
                 # values as stated; estimate = a rule as stated. Parameters that are not named keep the defaults at the end.\n";
        let _ = writeln!(text, "name = {}", quoted(&self.name));
        let _ = writeln!(text, "model = {}", quoted(self.model));
        let _ = writeln!(text, "description = {}\n\n[start]", quoted(&self.description));
        for given in self.values.iter().filter(|v| v.certainty != Certainty::Default) {
            let (value, unit) = given.printed.clone().unwrap_or((given.value, given.unit.to_owned()));
            let value = format!("{:?} = {{ value = {value}, unit = {} }}", given.name, quoted(&unit));
            let _ = writeln!(text, "{value:75} # {}: {}", given.certainty.text(), given.source);
        }
        text += "\n# Defaults, not from this motor:\n";
        for given in self.defaults() {
            let _ = writeln!(
                text,
                "#   {} = {}{}: {}",
                given.name,
                given.shown(),
                given.unit_text(),
                given.source
            );
        }
        text
    }

    fn source(&self) -> &str {
        if self.datasheet.is_empty() { "a datasheet that was not named" } else { &self.datasheet }
    }
}

impl Given {
    /// Whether it switches an effect off or only shapes one that is off, or is an initial state: no property of the motor.
    fn is_off(&self) -> bool {
        let used = ["effect.coulomb_friction", "effect.viscous_friction"];
        let effect = self.name.starts_with("effect.") && !used.iter().any(|name| self.name.starts_with(name));
        effect || self.name.starts_with("initial.")
    }

    /// The value; the item of an enumeration.
    pub fn shown(&self) -> String {
        let item = models::by_name(MOTOR).and_then(|kind| {
            let entry = (kind.declaration)().by_name(&self.name)?;
            let Kind::Enumeration(t) = entry.row.kind else { return None };
            t.items.iter().find(|i| f64::from(i.value) == self.value).map(|i| i.name.to_owned())
        });
        item.unwrap_or_else(|| shortest(self.value))
    }

    /// A space and the unit; nothing for a pure number.
    pub fn unit_text(&self) -> String {
        if self.unit == "1" { String::new() } else { format!(" {}", self.unit) }
    }
}

impl Derived {
    fn apply(
        &self,
        entry: &Entry,
        sheet: &Datasheet,
        found: &BTreeMap<&str, Given>,
        certainty: Option<Certainty>,
    ) -> Option<Given> {
        let unit = entry.row.unit.name();
        let needs: Vec<Need<'_>> = self
            .needs
            .iter()
            .map(|need| match by_key(need) {
                Some(quantity) => sheet.value(need).map(|v| Need::Printed(quantity, v)),
                None => found.get(need).map(Need::Found),
            })
            .collect::<Option<_>>()?;
        let values: Vec<f64> = needs.iter().map(Need::value).collect();
        let value = (self.of)(&values);
        let (name, direct) = (entry.name.clone(), self.formula.is_empty());
        let texts: Vec<String> = needs.iter().map(Need::text).collect();
        Some(match (direct, &needs[0]) {
            (true, Need::Printed(quantity, printed)) => Given {
                name,
                value,
                unit,
                certainty: Certainty::Datasheet,
                source: format!("{} {}", quantity.words, printed.text()),
                printed: Some(printed.given.clone()),
            },
            _ => Given {
                name,
                value,
                unit,
                certainty: certainty.unwrap_or(Certainty::Derived),
                source: format!(
                    "{} = {}{} with {}",
                    self.formula,
                    significant(value),
                    unit_text(unit),
                    texts.join(", ")
                ),
                printed: None,
            },
        })
    }
}

/// The number as it is where that is short, else with four digits.
fn shortest(value: f64) -> String {
    let plain = value.to_string();
    if plain.len() <= 8 { plain } else { significant(value) }
}

fn unit_text(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

/// What a way needs, where it is there.
enum Need<'a> {
    Printed(&'static Quantity, &'a Value),
    Found(&'a Given),
}

impl Need<'_> {
    fn value(&self) -> f64 {
        match self {
            Need::Printed(_, value) => value.si,
            Need::Found(given) => given.value,
        }
    }

    fn text(&self) -> String {
        match self {
            Need::Printed(quantity, value) => format!("{} {}", quantity.words, value.text()),
            Need::Found(given) => format!("{} {}{}", given.name, significant(given.value), given.unit_text()),
        }
    }
}

/// A value that the model does not take, with the printed values that it follows from.
fn check(entry: &Entry, given: &Given) -> Result<(), StudyError> {
    from_text(entry, &given.value.to_string(), false).map(|_| ()).map_err(|sentence| {
        StudyError::new(format!("{sentence} ({}: {})", given.certainty.text(), given.source))
    })
}

fn by_default(entry: &Entry) -> Given {
    let row = entry.row;
    let source = match row.source {
        "" => "default of the model".to_owned(),
        source => format!("default: {source}"),
    };
    Given {
        name: entry.name.clone(),
        value: row.start,
        unit: row.unit.name(),
        certainty: Certainty::Default,
        source,
        printed: None,
    }
}
