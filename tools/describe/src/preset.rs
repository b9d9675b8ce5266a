//! Presets: start values in a TOML file, each in any unit of its quantity, checked against the declarations.
//!
//! ```toml
//! name = "maxon-305015"
//! model = "AnnulusCooledMotor"
//! description = "..."
//!
//! [start]
//! "motor.R_ref" = { value = 386, unit = "mOhm" }
//! "motor.J" = "33.3 g.cm2"
//! "drive_mode" = "current"
//!
//! [experiment]
//! stop = "10 min"
//! step = 0.01
//! ```

mod nearest;
mod values;

use crate::Experiment;
pub use nearest::nearest;
use physics::declare::Causality;
use physics::model::{Declaration, ModelType};
use physics::models::series_elastic_actuator::MOTOR_DATA;
use std::collections::BTreeMap;
use std::path::Path;
use toml::de::DeValue;
pub use values::{Source, StartValues, conversion, from_text, unknown};

/// The built-in presets: name and text of every file in `examples/presets`, in the order of the names.
const BUILT_IN: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/presets.rs"));

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
    /// The times of the default experiment, where the preset gives them.
    pub experiment: Option<Experiment>,
    /// The file, whose comments name the sources of the values; empty for derived values.
    pub file: String,
}

/// The errors in a preset: a sentence with file and line for each, on lines of their own.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct PresetError(String);

impl Preset {
    /// The built-in presets, in the order of their names.
    ///
    /// # Errors
    /// One sentence if a text is not a preset.
    pub fn built_in() -> Result<Vec<Preset>, PresetError> {
        BUILT_IN.iter().map(|(name, _)| Preset::load(name)).collect()
    }

    /// The text of a built-in preset.
    pub fn text(name: &str) -> Option<&'static str> {
        BUILT_IN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    /// The preset of a built-in name or of a file.
    pub fn load(name_or_file: &str) -> Result<Preset, PresetError> {
        if let Some((name, text)) = BUILT_IN.iter().find(|(name, _)| *name == name_or_file) {
            return Preset::parse(text, &format!("preset {name}"));
        }
        match delimited::read_text(Path::new(name_or_file)) {
            Ok(text) => Preset::parse(&text, name_or_file),
            Err(error) => {
                if name_or_file.contains(['/', '\\']) || name_or_file.ends_with(".toml") {
                    return Err(PresetError(format!("the preset {name_or_file} cannot be read ({error})")));
                }
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
            experiment: None,
            file: String::new(),
        })
    }

    /// The source of a value: the comment behind it, or the one in the line before.
    pub fn source_of(&self, name: &str) -> Option<String> {
        comment(&self.file, name)
    }

    /// What the file says of the calibration that made it, in lines `#: keyword: value`.
    pub fn calibration(&self) -> Vec<(String, String)> {
        let lines = self.file.lines().filter_map(|line| line.strip_prefix(CALIBRATION)?.split_once(": "));
        lines.map(|(keyword, value)| (keyword.to_owned(), value.to_owned())).collect()
    }

    /// The preset of a text; `file` names it in errors.
    pub fn parse(text: &str, file: &str) -> Result<Preset, PresetError> {
        let mut source = Source::new(text, file);
        let table = source.table();
        let mut words = BTreeMap::new();
        let (mut start, mut experiment) = (None, None);
        for (key, value) in table.get_ref() {
            match (key.get_ref().as_ref(), value.get_ref()) {
                (known @ ("name" | "model" | "description"), DeValue::String(word)) => {
                    words.insert(known, (word.to_string(), value.span().start));
                }
                (known @ ("name" | "model" | "description"), _) => {
                    source.error(value.span().start, format!("{known} must be a string"));
                }
                ("start", DeValue::Table(values)) => start = Some(values),
                ("experiment", DeValue::Table(values)) => {
                    experiment = Some(values::experiment(values, &mut source))
                }
                ("datasheet", DeValue::Table(_)) => source.error(
                    key.span().start,
                    format!("{file} is a datasheet and no preset; `motor-fmu preset new --from {file}` writes its preset"),
                ),
                (other, _) => {
                    let keys = "the keys are name, model, description, [start] and [experiment]";
                    source.error(key.span().start, format!("{other} is not a key of a preset; {keys}"));
                }
            }
        }
        let mut word = |key: &str| {
            let found = words.get(key).cloned();
            if found.is_none() {
                source.error(0, format!("the key {key} is missing"));
            }
            found.unwrap_or_default()
        };
        let (name, (model, model_at)) = (word("name").0, word("model"));
        let kind = physics::models::by_name(&model);
        if kind.is_none() && words.contains_key("model") {
            let known: Vec<&str> = physics::models::ALL.iter().map(|m| (m.declaration)().name).collect();
            let hint = nearest(&model, known.iter().copied());
            source.error(
                model_at,
                format!("{model} is not a model; the models are {}{hint}", known.join(", ")),
            );
        }
        let starts = match (kind, start) {
            (Some(kind), Some(table)) => StartValues::of_table((kind.declaration)(), table, &mut source),
            _ => StartValues::default(),
        };
        let description = words.get("description").map(|(text, _)| text.clone()).unwrap_or_default();
        source.finish(Preset { name, model, description, starts, experiment, file: text.to_owned() })
    }
}

/// Begins a line of a preset about the calibration that made it.
pub const CALIBRATION: &str = "#: ";

/// The comment behind the value of a variable, or the one in the line before.
fn comment(text: &str, name: &str) -> Option<String> {
    let lines: Vec<&str> = text.lines().collect();
    let is_of = |line: &str| {
        let key = line.split('=').next().unwrap_or_default().trim();
        key.trim_matches('"') == name
    };
    let at = lines.iter().position(|line| is_of(line))?;
    let behind = lines[at].rsplit_once('#').map(|(_, words)| words);
    let above = at.checked_sub(1).and_then(|k| lines[k].trim().strip_prefix('#'));
    Some(behind.or(above)?.trim().to_owned())
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

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(start: &str) -> String {
        let text = format!("name = \"x\"\nmodel = \"AnnulusCooledMotor\"\n\n[start]\n{start}\n");
        Preset::parse(&text, "x.toml").unwrap_err().to_string()
    }

    #[test]
    fn a_name_with_a_dot_needs_quotation_marks() {
        for text in ["motor.R_ref = 3", "effect.coulomb_friction.tau_c = 1e-3"] {
            let error = refusal(text);
            assert!(error.contains("x.toml:5: names with a dot need quotation marks: \""), "{error}");
        }
        assert!(refusal("\"motor.R_reff\" = 3").contains("did you mean motor.R_ref?"));
        assert!(refusal("ambient_temperature = 25").contains("473.15 K; 25 degC is within them"));
        assert!(refusal("\"motor.k_t\" = 1e297").contains("motor.k_t = 1e297 N.m/A"));
    }

    #[test]
    fn a_preset_may_have_a_default_experiment() {
        let of = |experiment: &str| {
            let text =
                format!("name = \"x\"\nmodel = \"AnnulusCooledMotor\"\n\n[experiment]\n{experiment}\n");
            Preset::parse(&text, "x.toml").map(|preset| preset.experiment).map_err(|error| error.to_string())
        };
        assert_eq!(of(""), Ok(Some(Experiment::default())));
        assert_eq!(of("stop = \"10 min\"\nstep = 0.01"), Ok(Some(Experiment { stop: 600.0, step: 0.01 })));
        for (wrong, words) in [
            ("stop = 0", "x.toml:5: stop is not a time above 0"),
            ("stop = \"5 V\"", "x.toml:5: stop is not a time"),
            ("step = 2", "x.toml:5: step = 2 s is longer than stop = 1 s"),
            ("end = 2", "x.toml:5: end is not a key of [experiment]"),
        ] {
            let message = of(wrong).unwrap_err();
            assert!(message.starts_with(words), "{message}");
        }
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

    /// The datasheet of the motor 305015, in its own units, gives the start values of the built-in preset.
    #[test]
    fn a_preset_takes_the_units_of_a_datasheet() {
        let text = r#"
            name = "x"
            model = "AnnulusCooledMotor"
            [start]
            "motor.R_ref" = "386 mΩ"
            "motor.T_ref" = { value = 25, unit = "degC" }
            "motor.alpha" = "0.39 %/K"
            "motor.L" = { value = 0.0653, unit = "mH" }
            "motor.k_t" = { value = 27.6, unit = "mNm/A" }
            "motor.J" = "33.3 gcm²"
            "motor.mass" = "300 g"
            "thermal.T_w_max" = "155 °C"
            "conductance.G_still" = { value = 7.4, unit = "K/W" }
            "effect.housing_sensor_lag.tau" = "2 min"
            "effect.winding_sensor_offset.offset" = "3 degC"
            imposed_speed = "16500 rpm""#;
        let found = Preset::parse(text, "x.toml").unwrap().starts;
        let declaration = (physics::models::ALL[0].declaration)();
        for (name, expected) in [
            ("motor.R_ref", 0.386),
            ("motor.T_ref", 298.15),
            ("motor.alpha", 0.0039),
            ("motor.L", 65.3e-6),
            ("motor.k_t", 0.0276),
            ("motor.J", 33.3e-7),
            ("motor.mass", 0.3),
            ("thermal.T_w_max", 428.15),
            ("conductance.G_still", 1.0 / 7.4),
            ("effect.housing_sensor_lag.tau", 120.0),
            ("effect.winding_sensor_offset.offset", 3.0),
            ("imposed_speed", 16500.0 * std::f64::consts::PI / 30.0),
        ] {
            let got = found.of(declaration.by_name(name).unwrap());
            assert!((got / expected - 1.0).abs() < 1e-14, "{name} = {got}, not {expected}");
        }
        let speed =
            |text: &str, display| from_text(declaration.by_name("imposed_speed").unwrap(), text, display);
        assert_eq!(speed("60", false), Ok(60.0));
        assert!((speed("60", true).unwrap() - 2.0 * std::f64::consts::PI).abs() < 1e-12);
        assert_eq!(speed("60 rad/s", true), Ok(60.0));
        assert!(speed("60 Hz", false).unwrap_err().contains("not a unit of the same quantity"));
    }

    /// All errors of a file, in the order of its lines; broken TOML does not hide them.
    #[test]
    fn all_errors_are_reported_at_once() {
        let error = refusal(
            "\"motor.R_reff\" = 1\n\"motor.R_ref\" = -1\n\"motor.L\" = \"3 Ohm\"\n\"motor.J\" = = 3\ndrive_mode = \"curent\"",
        );
        let lines: Vec<&str> = error.lines().collect();
        assert_eq!(lines.len(), 5, "{error}");
        for (k, line) in lines.iter().enumerate() {
            assert!(line.starts_with(&format!("x.toml:{}: ", 5 + k)), "{error}");
        }
        assert!(lines[4].contains("did you mean current?"), "{error}");
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
        let missing = Preset::parse("name = \"x\"\n", "x.toml").unwrap_err().to_string();
        assert!(missing.contains("the key model is missing"), "{missing}");
        let missing = Preset::load("maxon-305016").unwrap_err().to_string();
        assert!(
            missing.contains("maxon-305016") && missing.contains("did you mean maxon-305015?"),
            "{missing}"
        );
    }
}
