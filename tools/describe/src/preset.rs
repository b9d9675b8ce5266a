//! Presets: start values in a TOML file, each with its unit, checked against the declarations.
//!
//! ```toml
//! name = "maxon-305015"
//! model = "AnnulusCooledMotor"
//! description = "..."
//!
//! [start]
//! "motor.R_ref" = { value = 0.386, unit = "Ohm" }
//! "drive_mode" = "current"
//! ```

use physics::declare::{Causality, Elements, Kind};
use physics::model::{Declaration, Element, Entry, ModelType};
use physics::models::series_elastic_actuator::MOTOR_DATA;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The built-in presets: name and text of every file in `examples/presets`, in the order of the names.
const BUILT_IN: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/presets.rs"));

/// Start values that differ from the declared ones, by value reference.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StartValues(BTreeMap<u32, f64>);

impl StartValues {
    /// The start value of a variable.
    pub fn of(&self, entry: &Entry) -> f64 {
        self.0.get(&entry.value_reference).copied().unwrap_or(entry.row.start)
    }

    /// Whether a model description with these start values contains the variable: elements up to the number that the
    /// structural parameter gives.
    pub fn shows(&self, declaration: &Declaration, entry: &Entry) -> bool {
        match entry.element {
            Some(Element { index, of: Elements::UpTo(_, parameter), .. }) => {
                declaration.by_name(parameter).is_some_and(|count| f64::from(index) <= self.of(count))
            }
            _ => true,
        }
    }

    /// The values of a TOML text with tables for several models, in the order of `tables` (name of the table, declaration
    /// of the model). A missing table has no values.
    ///
    /// # Errors
    /// One sentence with file and line: invalid TOML, an unknown table, and all errors of a preset.
    pub fn of_tables(
        text: &str,
        file: &str,
        tables: &[(&str, &'static Declaration)],
    ) -> Result<Vec<StartValues>, PresetError> {
        let at = |offset: usize, message: String| located(text, file, offset, message);
        let mut found = vec![StartValues::default(); tables.len()];
        for (key, value) in parsed(text, file)?.get_ref() {
            let place = tables.iter().position(|(name, _)| *name == key.get_ref().as_ref());
            let (Some(place), DeValue::Table(values)) = (place, value.get_ref()) else {
                let known: Vec<String> = tables.iter().map(|(name, _)| format!("[{name}]")).collect();
                let message = format!("{} is not one of the tables {}", key.get_ref(), known.join(", "));
                return Err(at(key.span().start, message));
            };
            found[place] = StartValues::of_table(tables[place].1, values, &at)?;
        }
        Ok(found)
    }

    fn of_table(
        declaration: &'static Declaration,
        table: &DeTable<'_>,
        at: &impl Fn(usize, String) -> PresetError,
    ) -> Result<StartValues, PresetError> {
        let mut starts = StartValues::default();
        for (key, value) in table {
            let entry = declaration
                .by_name(key.get_ref())
                .ok_or_else(|| at(key.span().start, unknown(declaration, key.get_ref())))?;
            let number = number(entry, value).map_err(|message| at(value.span().start, message))?;
            starts.0.insert(entry.value_reference, number);
        }
        Ok(starts)
    }

    /// Whether a start value of the variable is given.
    pub fn names(&self, entry: &Entry) -> bool {
        self.0.contains_key(&entry.value_reference)
    }

    /// Value references and values, ascending.
    pub fn entries(&self) -> Vec<(u32, f64)> {
        self.0.iter().map(|(k, v)| (*k, *v)).collect()
    }
}

/// A checked preset.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    /// Its name.
    pub name: String,
    /// Its model.
    pub model: String,
    /// Its description.
    pub description: String,
    /// The values.
    pub starts: StartValues,
}

/// An error in a preset: one sentence with file and line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct PresetError(String);

fn located(text: &str, file: &str, offset: usize, message: String) -> PresetError {
    let line = 1 + text.as_bytes()[..offset.min(text.len())].iter().filter(|b| **b == b'\n').count();
    PresetError(format!("{file}:{line}: {message}"))
}

fn parsed<'a>(text: &'a str, file: &str) -> Result<Spanned<DeTable<'a>>, PresetError> {
    DeTable::parse(text)
        .map_err(|e| located(text, file, e.span().map_or(0, |s| s.start), e.message().replace('\n', " ")))
}

impl Preset {
    /// The built-in presets, in the order of their names.
    ///
    /// # Errors
    /// One sentence if a text is not a preset.
    pub fn built_in() -> Result<Vec<Preset>, PresetError> {
        BUILT_IN.iter().map(|(name, _)| Preset::load(name)).collect()
    }

    /// The preset of a built-in name or of a file.
    pub fn load(name_or_file: &str) -> Result<Preset, PresetError> {
        if let Some((name, text)) = BUILT_IN.iter().find(|(name, _)| *name == name_or_file) {
            return Preset::parse(text, &format!("preset {name}"));
        }
        match std::fs::read_to_string(Path::new(name_or_file)) {
            Ok(text) => Preset::parse(&text, name_or_file),
            Err(error) => {
                let names = BUILT_IN.iter().map(|(name, _)| *name);
                let near = nearest(name_or_file, names);
                Err(PresetError(format!(
                    "preset {name_or_file} is neither a built-in preset (`motor-fmu presets` lists them{near}) nor a \
                     readable file ({error})"
                )))
            }
        }
    }

    /// What this preset says of `model`: itself where it is for that model; for the actuator, where this preset is of its
    /// motor, the control's motor data that follow from it (`MOTOR_DATA`); else nothing.
    pub fn for_model(&self, model: &ModelType) -> Option<Preset> {
        let declaration = (model.declaration)();
        if self.model == declaration.name {
            return Some(self.clone());
        }
        let motor = physics::models::by_name(MOTOR).filter(|_| self.model == MOTOR)?;
        let motor = (motor.declaration)();
        let value = |name: &str| motor.by_name(name).map(|entry| self.starts.of(entry));
        let starts = motor_data(declaration, value);
        (!starts.0.is_empty()).then(|| Preset {
            name: self.name.clone(),
            model: declaration.name.to_owned(),
            description: format!("motor data of the control from preset {}", self.name),
            starts,
        })
    }

    /// The preset of a text; `file` names it in errors.
    pub fn parse(text: &str, file: &str) -> Result<Preset, PresetError> {
        let at = |offset: usize, message: String| located(text, file, offset, message);
        let table = parsed(text, file)?;
        let mut words = BTreeMap::new();
        let mut start = None;
        for (key, value) in table.get_ref() {
            match (key.get_ref().as_ref(), value.get_ref()) {
                (known @ ("name" | "model" | "description"), DeValue::String(word)) => {
                    words.insert(known, (word.to_string(), value.span().start));
                }
                (known @ ("name" | "model" | "description"), _) => {
                    return Err(at(value.span().start, format!("{known} must be a string")));
                }
                ("start", DeValue::Table(values)) => start = Some(values),
                (other, _) => {
                    return Err(at(
                        key.span().start,
                        format!(
                            "{other} is not a key of a preset; the keys are name, model, description and [start]"
                        ),
                    ));
                }
            }
        }
        let word = |key: &str| {
            words.get(key).cloned().ok_or_else(|| PresetError(format!("{file}: the key {key} is missing")))
        };
        let (model, model_at) = word("model")?;
        let kind = physics::models::by_name(&model).ok_or_else(|| {
            let known: Vec<&str> = physics::models::ALL.iter().map(|m| (m.declaration)().name).collect();
            at(model_at, format!("{model} is not a model; the models are {}", known.join(", ")))
        })?;
        let starts = match start {
            Some(table) => StartValues::of_table((kind.declaration)(), table, &at)?,
            None => StartValues::default(),
        };
        let description = words.get("description").map(|(text, _)| text.clone()).unwrap_or_default();
        Ok(Preset { name: word("name")?.0, model, description, starts })
    }
}

/// The motor of the actuator.
pub const MOTOR: &str = "AnnulusCooledMotor";

/// The start values that the actuator derives from its motor, where `value` gives the motor's by name; none for another
/// model.
pub fn motor_data(declaration: &Declaration, value: impl Fn(&str) -> Option<f64>) -> StartValues {
    let derived = MOTOR_DATA.iter().filter_map(|(own, of_motor)| {
        let (own, value) = (declaration.by_name(own)?, value(of_motor)?);
        let is_given = own.row.causality != Causality::Input || value > 0.0;
        (is_given && own.check(value, false).is_ok()).then_some((own.value_reference, value))
    });
    match declaration.name {
        "SeriesElasticActuator" => StartValues(derived.collect()),
        _ => StartValues::default(),
    }
}

/// The question for the most similar of the known names; empty if there is none.
fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let nearest = known.min_by_key(|candidate| strsim::levenshtein(candidate, name));
    nearest.map(|candidate| format!("; did you mean {candidate}?")).unwrap_or_default()
}

/// One sentence about an unknown name, with the most similar known one.
pub fn unknown(declaration: &Declaration, name: &str) -> String {
    let hint = nearest(name, declaration.entries.iter().map(|e| e.name.as_str()));
    format!("{} has no variable {name}{hint}", declaration.name)
}

/// The checked number of a value in a preset.
fn number(entry: &Entry, value: &Spanned<DeValue<'_>>) -> Result<f64, String> {
    let name = &entry.name;
    let unit = entry.row.unit.name();
    let value = match value.get_ref() {
        DeValue::Table(table) => {
            for key in table.keys() {
                if !matches!(key.get_ref().as_ref(), "value" | "unit") {
                    return Err(format!(
                        "{name} has the unknown key {}; the keys are value and unit",
                        key.get_ref()
                    ));
                }
            }
            match table.get("unit").map(|u| u.get_ref()) {
                Some(DeValue::String(given)) if given.as_ref() == unit => {}
                None => {}
                Some(given) => {
                    let given = given.as_str().unwrap_or("not a string");
                    return Err(format!("{name} has the unit \"{unit}\", not \"{given}\""));
                }
            }
            table.get("value").ok_or_else(|| format!("{name} has no value"))?.get_ref()
        }
        plain => plain,
    };
    let number = match (value, entry.row.kind) {
        (DeValue::Float(text), _) => text.as_str().replace('_', "").parse::<f64>().ok(),
        (DeValue::Integer(text), _) => {
            i64::from_str_radix(text.as_str(), text.radix()).ok().map(|n| n as f64)
        }
        (DeValue::Boolean(flag), Kind::Boolean) => Some(f64::from(u8::from(*flag))),
        (DeValue::String(item), Kind::Enumeration(t)) => {
            let found = t.items.iter().find(|i| i.name == item.as_ref());
            let Some(found) = found else {
                let names: Vec<&str> = t.items.iter().map(|i| i.name).collect();
                return Err(format!("{name} = {item} is not one of {}", names.join(", ")));
            };
            Some(f64::from(found.value))
        }
        _ => None,
    };
    let number = number.ok_or_else(|| format!("the value of {name} is not a number in {unit}"))?;
    entry
        .check(number, false)
        .map_err(|refusal| entry.explain(number, &refusal).trim_end_matches('.').to_string())?;
    Ok(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(start: &str) -> String {
        let text = format!("name = \"x\"\nmodel = \"AnnulusCooledMotor\"\n\n[start]\n{start}\n");
        Preset::parse(&text, "x.toml").unwrap_err().to_string()
    }

    #[test]
    fn the_built_in_presets_are_valid() {
        for (name, _) in BUILT_IN {
            let preset = Preset::load(name).unwrap();
            assert_eq!(preset.name, *name);
            assert!(!preset.starts.entries().is_empty());
        }
    }

    /// The declared values of the gearmotor equal those of its preset.
    #[test]
    fn the_gearmotor_is_declared_as_its_preset() {
        let preset = Preset::load("bdcm-37d").unwrap();
        let declaration = (physics::models::by_name("BrushedGearmotor").unwrap().declaration)();
        for (value_reference, value) in preset.starts.entries() {
            let entry = declaration.by_reference(value_reference).unwrap();
            assert_eq!(entry.row.start, value, "{}", entry.name);
        }
    }

    /// tau_c = k_t I_0 of the datasheet: 27.6 mN.m/A * 0.356 A.
    #[test]
    fn a_preset_changes_the_start_values_it_names() {
        let preset = Preset::load("maxon-305015").unwrap();
        let declaration = (physics::models::ALL[0].declaration)();
        let start = |name: &str| preset.starts.of(declaration.by_name(name).unwrap());
        assert!((start("effect.coulomb_friction.tau_c") - 0.0276 * 0.356).abs() < 5e-6);
        assert_eq!(start("thermal.C_h"), 149.4);
        assert_eq!(start("effect.viscous_friction.k"), 0.0, "other values stay as declared");
    }

    /// The actuator's control gets the motor's data, from any preset of the motor; no other model does.
    #[test]
    fn the_actuator_follows_the_motors_preset() {
        let text = "name = \"x\"\nmodel = \"AnnulusCooledMotor\"\n[start]\n\"motor.R_ref\" = 1.1\n\
                    \"motor.k_t\" = 0.0535\nvoltage = 24\n";
        let preset = Preset::parse(text, "x.toml").unwrap();
        let by_name = |name: &str| physics::models::by_name(name).unwrap();
        let derived = preset.for_model(by_name("SeriesElasticActuator")).unwrap();
        let declaration = (by_name(&derived.model).declaration)();
        let start = |name: &str| derived.starts.of(declaration.by_name(name).unwrap());
        assert_eq!([start("control.R"), start("control.k_t"), start("supply_voltage")], [1.1, 0.0535, 24.0]);
        assert_eq!(start("control.J"), 33.3e-7, "what the preset does not name is the declared motor's");
        let plain =
            Preset::load("maxon-305015").unwrap().for_model(by_name("SeriesElasticActuator")).unwrap();
        assert!((plain.starts.of(declaration.by_name("control.tau_c").unwrap()) - 9.83e-3).abs() < 1e-12);
        assert!(preset.for_model(by_name("GaitLoad")).is_none());
        assert!(preset.for_model(by_name("AnnulusCooledMotor")).is_some());
        assert!(Preset::load("bdcm-37d").unwrap().for_model(by_name("SeriesElasticActuator")).is_none());
    }

    #[test]
    fn values_may_be_numbers_tables_and_names() {
        let text = "name = \"x\"\nmodel = \"AnnulusCooledMotor\"\n[start]\n\"motor.R_ref\" = 1\n\
                    drive_mode = \"current\"\n\"motor.L\" = { value = 1e-4, unit = \"H\" }\n\
                    \"motor.pole_pairs\" = 7\n";
        let preset = Preset::parse(text, "x.toml").unwrap();
        assert_eq!(preset.starts.entries(), [(80, 3.0), (100, 1.0), (103, 1e-4), (107, 7.0)]);
    }

    #[test]
    fn errors_name_file_line_variable_value_and_limits() {
        for (start, words) in [
            ("\"motor.R_reff\" = 1", &["x.toml:5", "motor.R_reff", "did you mean motor.R_ref?"][..]),
            ("\n\"motor.R_ref\" = -1", &["x.toml:6", "motor.R_ref = -1 Ohm", "0.0001 ... 10000 Ohm"]),
            ("\"motor.R_ref\" = { value = 1, unit = \"V\" }", &["x.toml:5", "\"Ohm\"", "\"V\""]),
            ("\"motor.R_ref\" = { value = 1, units = \"Ohm\" }", &["x.toml:5", "units"]),
            ("\"motor.R_ref\" = { unit = \"Ohm\" }", &["x.toml:5", "no value"]),
            ("\"motor.R_ref\" = \"much\"", &["x.toml:5", "not a number in Ohm"]),
            ("\"motor.R_ref\" = nan", &["x.toml:5", "not a finite number"]),
            (
                "\"motor.pole_pairs\" = 1.5",
                &["x.toml:5", "motor.pole_pairs = 1.5 is not a whole number", "1 ... 100"],
            ),
            ("drive_mode = \"steam\"", &["x.toml:5", "steam", "voltage, pwm, current, power"]),
            ("current = 1", &["x.toml:5", "computed by the model"]),
            ("\"motor.R_ref\" = ", &["x.toml:5"]),
        ] {
            let error = refusal(start);
            assert!(words.iter().all(|w| error.contains(w)), "{words:?} in {error}");
            assert!(!error.contains('\n'), "{error}");
        }
        let other = Preset::parse("name = \"x\"\nmodel = \"Other\"\n", "x.toml").unwrap_err().to_string();
        assert!(other.contains("x.toml:2") && other.contains("AnnulusCooledMotor"), "{other}");
        let key = Preset::parse("nam = \"x\"\n", "x.toml").unwrap_err().to_string();
        assert!(key.contains("x.toml:1: nam is not a key"), "{key}");
        let missing = Preset::load("maxon-305016").unwrap_err().to_string();
        assert!(
            missing.contains("maxon-305016") && missing.contains("did you mean maxon-305015?"),
            "{missing}"
        );
    }
}
