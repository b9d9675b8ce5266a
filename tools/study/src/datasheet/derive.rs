//! Start values from a datasheet, each with where it is from, the variables that keep their defaults, and the text of the preset.

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

/// One of the ways to derive a variable: the formula, the quantities and variables that it needs, and how.
pub struct Derived {
    name: &'static str,
    formula: &'static str,
    needs: &'static [&'static str],
    of: fn(&[f64]) -> f64,
}

const fn from(name: &'static str, key: &'static [&'static str]) -> Derived {
    Derived { name, formula: "", needs: key, of: |v| v[0] }
}

const fn derived(
    name: &'static str,
    formula: &'static str,
    needs: &'static [&'static str],
    of: fn(&[f64]) -> f64,
) -> Derived {
    Derived { name, formula, needs, of }
}

/// The ways, in order: of a variable, the first whose needs are there counts. A need is a printed quantity or a variable above.
const WAYS: &[Derived] = &[
    from("motor.k_t", &["torque_constant"]),
    derived("motor.k_t", "1 / speed constant", &["speed_constant"], |v| 1.0 / v[0]),
    from("motor.k_t", &["back_emf_constant"]),
    derived("motor.k_t", "1 / current constant", &["current_constant"], |v| 1.0 / v[0]),
    derived("motor.k_t", "stall torque / stall current", &["stall_torque", "stall_current"], |v| v[0] / v[1]),
    derived(
        "motor.k_t",
        "(U - R I_0) / no-load speed",
        &["nominal_voltage", "terminal_resistance", "no_load_current", "no_load_speed"],
        |v| (v[0] - v[1] * v[2]) / v[3],
    ),
    derived("motor.k_t", "motor constant x sqrt(R)", &["motor_constant", "terminal_resistance"], |v| {
        v[0] * v[1].sqrt()
    }),
    derived("motor.k_t", "sqrt(R / motor regulation)", &["terminal_resistance", "motor_regulation"], |v| {
        (v[0] / v[1]).sqrt()
    }),
    derived(
        "motor.k_t",
        "sqrt(R / speed/torque gradient)",
        &["terminal_resistance", "speed_torque_gradient"],
        |v| (v[0] / v[1]).sqrt(),
    ),
    from("motor.R_ref", &["terminal_resistance"]),
    derived("motor.R_ref", "U / stall current", &["nominal_voltage", "stall_current"], |v| v[0] / v[1]),
    derived("motor.R_ref", "k_t U / stall torque", &["motor.k_t", "nominal_voltage", "stall_torque"], |v| {
        v[0] * v[1] / v[2]
    }),
    derived("motor.R_ref", "speed/torque gradient x k_t^2", &["speed_torque_gradient", "motor.k_t"], |v| {
        v[0] * v[1] * v[1]
    }),
    derived("motor.R_ref", "motor regulation x k_t^2", &["motor_regulation", "motor.k_t"], |v| {
        v[0] * v[1] * v[1]
    }),
    derived("motor.R_ref", "(k_t / motor constant)^2", &["motor.k_t", "motor_constant"], |v| {
        (v[0] / v[1]).powi(2)
    }),
    from("motor.T_ref", &["reference_temperature"]),
    from("motor.L", &["terminal_inductance"]),
    derived("motor.L", "electrical time constant x R", &["electrical_time_constant", "motor.R_ref"], |v| {
        v[0] * v[1]
    }),
    from("motor.J", &["rotor_inertia"]),
    derived(
        "motor.J",
        "mechanical time constant x k_t^2 / R",
        &["mechanical_time_constant", "motor.k_t", "motor.R_ref"],
        |v| v[0] * v[1] * v[1] / v[2],
    ),
    derived(
        "motor.J",
        "k_t U / (R x angular acceleration)",
        &["motor.k_t", "nominal_voltage", "motor.R_ref", "angular_acceleration"],
        |v| v[0] * v[1] / (v[2] * v[3]),
    ),
    from("motor.pole_pairs", &["pole_pairs"]),
    derived("motor.pole_pairs", "number of poles / 2", &["poles"], |v| v[0] / 2.0),
    from("motor.mass", &["mass"]),
    // Static and dynamic friction are the no-load loss, split by its dependence on the speed.
    derived(
        "effect.coulomb_friction.tau_c",
        "static friction torque",
        &["static_friction_torque", "dynamic_friction"],
        |v| v[0],
    ),
    derived(
        "effect.viscous_friction.k",
        "dynamic friction torque over speed",
        &["dynamic_friction", "static_friction_torque"],
        |v| v[0],
    ),
    derived(
        "effect.coulomb_friction.tau_c",
        "k_t I_0, all of the no-load loss",
        &["motor.k_t", "no_load_current"],
        |v| v[0] * v[1],
    ),
    from("effect.coulomb_friction.tau_c", &["friction_torque"]),
    from("effect.coulomb_friction.tau_c", &["static_friction_torque"]),
    from("thermal.R_wh", &["resistance_winding_housing"]),
    derived(
        "thermal.R_wh",
        "resistance winding-ambient - resistance housing-ambient",
        &["resistance_winding_ambient", "resistance_housing_ambient"],
        |v| v[0] - v[1],
    ),
    derived(
        "thermal.C_w",
        "winding time constant / R_wh",
        &["winding_time_constant", "resistance_winding_housing"],
        |v| v[0] / v[1],
    ),
    derived(
        "conductance.G_still",
        "1 / thermal resistance housing-ambient",
        &["resistance_housing_ambient"],
        |v| 1.0 / v[0],
    ),
    derived(
        "conductance.G_still",
        "1 / (resistance winding-ambient - resistance winding-housing)",
        &["resistance_winding_ambient", "resistance_winding_housing"],
        |v| 1.0 / (v[0] - v[1]),
    ),
    derived(
        "thermal.C_h",
        "motor time constant / R_ha - C_w",
        &["motor_time_constant", "resistance_housing_ambient", "thermal.C_w"],
        |v| v[0] / v[1] - v[2],
    ),
    from("thermal.T_w_max", &["max_winding_temperature"]),
    from("housing.diameter", &["diameter"]),
    from("housing.length", &["length"]),
];

/// Fractions of a motor of the library, their medians (tests.rs): of the thermal resistance winding-ambient between winding and
/// housing, and of the heat capacity in the winding; and heat capacity over mass, J/(kg.K).
pub(super) const OF_LIBRARY: (f64, f64, f64) = (0.24, 0.09, 460.0);

/// Estimates for what the datasheet does not print: a default that belongs to the declared motor would not go with the rest.
const ESTIMATES: &[Derived] = &[
    derived(
        "thermal.R_wh",
        "0.24 of the resistance winding-ambient, the median of the presets",
        &["resistance_winding_ambient"],
        |v| OF_LIBRARY.0 * v[0],
    ),
    derived(
        "conductance.G_still",
        "1 / (resistance winding-ambient - R_wh)",
        &["resistance_winding_ambient", "thermal.R_wh"],
        |v| 1.0 / (v[0] - v[1]),
    ),
    derived("thermal.C_w", "winding time constant / R_wh", &["winding_time_constant", "thermal.R_wh"], |v| {
        v[0] / v[1]
    }),
    derived(
        "thermal.C_w",
        "0.09 of motor time constant / R_ha, the median of the presets",
        &["motor_time_constant", "conductance.G_still"],
        |v| OF_LIBRARY.1 * v[0] * v[1],
    ),
    derived("thermal.C_w", "0.09 x 460 J/(kg.K) x mass, the medians of the presets", &["mass"], |v| {
        OF_LIBRARY.1 * OF_LIBRARY.2 * v[0]
    }),
    derived(
        "thermal.C_h",
        "motor time constant / R_ha - C_w",
        &["motor_time_constant", "conductance.G_still", "thermal.C_w"],
        |v| v[0] * v[1] - v[2],
    ),
    derived(
        "thermal.C_h",
        "460 J/(kg.K) x mass - C_w, the median of the presets",
        &["mass", "thermal.C_w"],
        |v| OF_LIBRARY.2 * v[0] - v[1],
    ),
    derived("thermal.C_r", "C_h / 4, the ratio of the declared motor", &["thermal.C_h"], |v| v[0] / 4.0),
    derived(
        "annulus.outer_diameter",
        "diameter + 10 mm, the gap of the declared annulus",
        &["housing.diameter"],
        |v| v[0] + 0.01,
    ),
    derived("annulus.length", "length of the motor", &["housing.length"], |v| v[0]),
];

/// Without these there is no motor.
const REQUIRED: [(&str, &str); 2] = [
    ("motor.k_t", "torque_constant, speed_constant, back_emf_constant, or stall_torque with stall_current"),
    (
        "motor.R_ref",
        "terminal_resistance, motor_constant, motor_regulation, or nominal_voltage with stall_current or stall_torque",
    ),
];

/// A preset that follows from a datasheet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Draft {
    /// Name of the preset.
    pub name: String,
    /// Its model.
    pub model: &'static str,
    /// One line about the motor.
    pub description: String,
    /// Where the values are printed.
    pub datasheet: String,
    /// The start values, and the parameters that stay at their defaults.
    pub values: Vec<Given>,
}

impl Draft {
    /// The start values that follow from the datasheet.
    ///
    /// # Errors
    /// Values that no motor has, or too few of them: one sentence.
    pub fn new(sheet: &Datasheet) -> Result<Draft, StudyError> {
        let kind = models::by_name(MOTOR).ok_or_else(|| StudyError::new(format!("no model {MOTOR}")))?;
        let declaration = (kind.declaration)();
        let mut found: BTreeMap<&str, Given> = BTreeMap::new();
        for (way, certainty) in
            WAYS.iter().map(|w| (w, None)).chain(ESTIMATES.iter().map(|w| (w, Some(Certainty::Estimate))))
        {
            if found.contains_key(way.name) {
                continue;
            }
            let Some(entry) = declaration.by_name(way.name) else { continue };
            if let Some(given) = way.apply(entry, sheet, &found, certainty) {
                check(entry, &given)?;
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
        Ok(Draft {
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

    /// The text of the preset.
    pub fn toml(&self) -> String {
        let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
        let mut text = String::new();
        let _ = writeln!(text, "# Written by `motor-fmu preset new` from {}.", self.source());
        text += "# Each comment begins with how sure the value is: datasheet = printed in that source; derived = computed from printed\n\
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
        "" => "declared default of the model".to_owned(),
        source => format!("declared default: {source}"),
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
