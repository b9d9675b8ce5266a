//! What a sweep computes at a point: a motor at constant inputs, or under a load.

use super::shown::Shown;
use super::vary::{Choice, PRESET, Vary};
use super::{count, grid_point};
use crate::StudyError;
use crate::notes::Notes;
use crate::steady::{Continuous, Setup, continuous_torque, steady};
use crate::walk::{Known, Load, Objective, Setting, TIME_TO_LIMIT};
use describe::Preset;
use describe::preset::nearest;
use physics::declare::Kind;
use physics::model::Entry;
use serde::Serialize;
use units::Conversion;

/// Units of what a motor takes, loses or has to bear: temperature, power, energy, pressure, voltage, current, resistance.
const COSTS: [&str; 7] = ["K", "W", "J", "Pa", "V", "A", "Ohm"];

/// A quantity that a sweep computes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Target {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Whether the least value is the best, as of a temperature.
    pub least_is_best: bool,
    /// Whether it is a difference of two temperatures.
    #[serde(skip)]
    pub is_difference: bool,
    /// The value of a point at which the simulated time ends before the quantity has one: a lower limit of it.
    #[serde(skip)]
    pub most: Option<f64>,
}

impl Target {
    /// The objective of a name, which may state its direction: `NAME:min` or `NAME:max`.
    ///
    /// # Errors
    /// The case has no such quantity.
    pub fn objective(case: &dyn Case, text: &str) -> Result<Target, StudyError> {
        let directed = [(":min", true), (":max", false)];
        match directed.iter().find_map(|(end, least)| Some((text.strip_suffix(end)?, *least))) {
            Some((name, least_is_best)) => Ok(Target { least_is_best, ..case.target(name)? }),
            None => case.target(text),
        }
    }

    /// The unit in which its values are shown.
    pub fn shown(&self) -> Shown {
        Shown::display(self.unit, self.is_difference)
    }
}

/// A model whose variables can be varied and whose quantities can be computed.
pub trait Case: Sync {
    /// The quantity of a name.
    ///
    /// # Errors
    /// The case has no such quantity.
    fn target(&self, name: &str) -> Result<Target, StudyError>;
    /// Unit of a variable; none for an enumeration or a preset.
    ///
    /// # Errors
    /// There is no such variable.
    fn unit(&self, name: &str) -> Result<&'static str, StudyError>;
    /// The conversion of numbers of a variable in `unit` to SI units.
    ///
    /// # Errors
    /// There is no such variable, or it is of another quantity.
    fn conversion(&self, name: &str, unit: &str) -> Result<Conversion, StudyError>;
    /// The quantities with these values, set last; `known` is from a point near this one.
    ///
    /// # Errors
    /// A value that is refused, or no steady state.
    fn at(
        &self,
        sets: &[(&str, &Choice)],
        targets: &[Target],
        known: &mut Known,
    ) -> Result<Vec<f64>, StudyError>;
    /// Whether a value is taken.
    ///
    /// # Errors
    /// One sentence why not.
    fn takes(&self, name: &str, value: &Choice) -> Result<(), StudyError>;
    /// Limits of a variable, where it has some.
    fn limits(&self, name: &str) -> Option<(f64, f64)>;
    /// What a variable is: the first clause of its description.
    fn meaning(&self, name: &str) -> Option<&'static str>;
    /// What has no effect at any point, in sentences.
    ///
    /// # Errors
    /// A value that is refused.
    fn notes(&self, _: &[Vary]) -> Result<Vec<String>, StudyError> {
        Ok(Vec::new())
    }
    /// Source of the measured data that the case uses, if any.
    ///
    /// # Errors
    /// A case without the source of its data.
    fn source(&self) -> Result<Option<String>, StudyError> {
        Ok(None)
    }
}

/// The preset among the varied values.
fn preset(sets: &[(&str, &Choice)]) -> Result<Option<Preset>, StudyError> {
    let named = sets.iter().find(|(name, _)| *name == PRESET);
    Ok(named.map(|(_, choice)| Preset::load(&choice.text())).transpose()?)
}

/// The unit of a variable with a declaration; items and flags have none.
fn unit_of(entry: &Entry) -> &'static str {
    match entry.row.kind {
        Kind::Enumeration(_) | Kind::Boolean => "1",
        _ => entry.row.unit.name(),
    }
}

/// The part of a description that says what the variable is; behind it stands what it depends on.
fn first_clause(entry: &'static Entry) -> Option<&'static str> {
    entry.row.doc.split([';', ':', '(']).next().map(|text| text.trim().trim_end_matches('.'))
}

/// The conversion of numbers of a variable in `unit` to SI units; only a variable with a declaration can be a difference.
fn conversion_of(name: &str, unit: &str, own: &str, entry: Option<&Entry>) -> Result<Conversion, StudyError> {
    let relative = entry.is_some_and(|entry| entry.row.relative);
    describe::preset::conversion(name, unit, own, relative).map_err(StudyError::new)
}

/// The names that are varied, without the preset.
fn names(vary: &[Vary]) -> Vec<&str> {
    vary.iter().map(|v| v.name.as_str()).filter(|name| *name != PRESET).collect()
}

/// Something of each point that notes are made for. Points within a range are in the same modes as its ends.
fn at_ends<T>(
    vary: &[Vary],
    of: impl Fn(&[(&str, &Choice)]) -> Result<T, StudyError>,
) -> Result<Vec<T>, StudyError> {
    let ends: Vec<Vary> = vary.iter().map(Vary::ends).collect();
    let at = |k| {
        let values = grid_point(&ends, k);
        of(&ends.iter().zip(&values).map(|(v, value)| (v.name.as_str(), value)).collect::<Vec<_>>())
    };
    (0..count(&ends)).map(at).collect()
}

/// A motor at constant inputs.
///
/// Its quantities are `continuous_torque`, N.m; `torque_density`, the same per total mass, N.m/kg; and the outputs in steady state.
#[derive(Clone, Debug)]
pub struct ConstantInputs {
    /// The motor and its inputs.
    pub setup: Setup,
}

impl ConstantInputs {
    fn point(&self, sets: &[(&str, &Choice)]) -> Result<Setup, StudyError> {
        let mut setup = self.setup.clone();
        if let Some(preset) = preset(sets)? {
            setup.preset = Some(preset);
        }
        let others = sets.iter().filter(|(name, _)| *name != PRESET);
        setup.sets.extend(others.map(|(name, value)| ((*name).to_owned(), value.text())));
        Ok(setup)
    }
}

impl Case for ConstantInputs {
    fn target(&self, name: &str) -> Result<Target, StudyError> {
        let bench = self.setup.bench()?;
        let output = if name == "continuous_torque" { "shaft_torque" } else { name };
        let Some(entry) = bench.declaration().by_name(output).filter(|_| bench.is_output(output)) else {
            if Objective::named(name).is_ok() {
                return Err(StudyError::new("it is an objective only with --load"));
            }
            let entries = bench.declaration().entries.iter().map(|e| e.name.as_str());
            let outputs = entries.filter(|name| bench.is_output(name)).chain(["continuous_torque"]);
            let hint = if name.is_empty() { String::new() } else { nearest(name, outputs) };
            return Err(StudyError::new(format!("it is no output of {}{hint}", bench.declaration().name)));
        };
        let unit = entry.row.unit.name();
        let is_difference = entry.row.relative;
        let is_delivered = ["mechanical", "shaft"].iter().any(|word| name.contains(word));
        let least_is_best = COSTS.contains(&unit) && !is_delivered && !is_difference;
        Ok(Target { name: name.to_owned(), unit, least_is_best, is_difference, most: None })
    }

    fn unit(&self, name: &str) -> Result<&'static str, StudyError> {
        if name == PRESET { Ok("1") } else { Ok(unit_of(self.setup.bench()?.entry(name)?)) }
    }

    fn conversion(&self, name: &str, unit: &str) -> Result<Conversion, StudyError> {
        let bench = self.setup.bench()?;
        conversion_of(name, unit, self.unit(name)?, Some(bench.entry(name)?))
    }

    fn at(
        &self,
        sets: &[(&str, &Choice)],
        targets: &[Target],
        _: &mut Known,
    ) -> Result<Vec<f64>, StudyError> {
        let mut bench = self.point(sets)?.bench()?;
        let at_limit = |name: &str| matches!(name, "continuous_torque" | "torque_density");
        let continuous =
            targets.iter().any(|t| at_limit(&t.name)).then(|| continuous_torque(&bench)).transpose()?;
        if targets.iter().any(|t| !at_limit(&t.name)) {
            steady(&mut bench)?;
        }
        let of = |target: &Target| match (target.name.as_str(), &continuous) {
            ("continuous_torque", Some(found)) => Ok(found.torque),
            ("torque_density", Some(Continuous { torque_density: Some(density), .. })) => Ok(*density),
            (output, _) => bench.get(output),
        };
        let mut of = of;
        targets.iter().map(&mut of).collect()
    }

    fn takes(&self, name: &str, value: &Choice) -> Result<(), StudyError> {
        self.point(&[(name, value)])?.bench().map(|_| ())
    }

    fn limits(&self, name: &str) -> Option<(f64, f64)> {
        let row = self.setup.bench().ok()?.entry(name).ok()?.row;
        Some((row.min, row.max))
    }

    fn meaning(&self, name: &str) -> Option<&'static str> {
        self.setup.bench().ok()?.entry(name).ok().and_then(first_clause)
    }

    fn notes(&self, vary: &[Vary]) -> Result<Vec<String>, StudyError> {
        let points = at_ends(vary, |sets| self.point(sets))?;
        Setup::notes_of(&points, &names(vary))
    }
}

/// Objectives under a periodic load that belong to the greatest load that can be given continuously.
const AT_LIMIT: [&str; 3] = ["continuous_torque", "torque_density", "continuous_support"];

/// A motor under a periodic load.
#[derive(Clone)]
pub struct Walking {
    /// Motor and load.
    pub load: Load,
    /// Longest simulated time, h.
    pub hours: f64,
}

impl Walking {
    fn with(&self, sets: &[(&str, &Choice)]) -> Result<Load, StudyError> {
        let mut load = match preset(sets)? {
            Some(preset) => self.load.with_preset(&preset)?,
            None => self.load.clone(),
        };
        for (name, value) in sets.iter().filter(|(name, _)| *name != PRESET) {
            load.set_text(name, &value.text())?;
        }
        Ok(load)
    }
}

impl Case for Walking {
    fn target(&self, name: &str) -> Result<Target, StudyError> {
        let Objective { name, unit, least_is_best, .. } = Objective::named(name)?;
        let most = (name == TIME_TO_LIMIT).then_some(self.hours * 3600.0);
        Ok(Target { name: name.to_owned(), unit, least_is_best, is_difference: false, most })
    }

    fn unit(&self, name: &str) -> Result<&'static str, StudyError> {
        if name == PRESET {
            return Ok("1");
        }
        let (unit, entry) = self.load.unit(name)?;
        Ok(entry.map_or(unit, unit_of))
    }

    fn conversion(&self, name: &str, unit: &str) -> Result<Conversion, StudyError> {
        conversion_of(name, unit, self.unit(name)?, self.load.unit(name)?.1)
    }

    fn at(
        &self,
        sets: &[(&str, &Choice)],
        targets: &[Target],
        known: &mut Known,
    ) -> Result<Vec<f64>, StudyError> {
        let load = self.with(sets)?;
        known.next_load();
        let mut found = vec![f64::NAN; targets.len()];
        let mut order: Vec<usize> = (0..targets.len()).collect();
        // A search for the continuous torque takes long; a load without steady state is infeasible before it.
        order.sort_by_key(|k| AT_LIMIT.contains(&targets[*k].name.as_str()));
        for k in order {
            let name = &targets[k].name;
            let value = Objective::named(name)?.of(&load, self.hours, known);
            found[k] = value.map_err(|why| match AT_LIMIT.contains(&name.as_str()) {
                true => why,
                false => StudyError::new(format!("under the given load, {why}")),
            })?;
        }
        Ok(found)
    }

    fn takes(&self, name: &str, value: &Choice) -> Result<(), StudyError> {
        self.with(&[(name, value)]).map(|_| ())
    }

    fn limits(&self, name: &str) -> Option<(f64, f64)> {
        if let Some(setting) = Setting::named(name) {
            return Some(setting.limits());
        }
        let row = self.load.owner(name).ok()?.entry(name).ok()?.row;
        Some((row.min, row.max))
    }

    fn meaning(&self, name: &str) -> Option<&'static str> {
        self.load.owner(name).ok()?.entry(name).ok().and_then(first_clause)
    }

    fn notes(&self, vary: &[Vary]) -> Result<Vec<String>, StudyError> {
        let names = names(vary);
        let points = at_ends(vary, |sets| self.with(sets)?.noted(&names))?;
        Ok(Notes::sentences(points, &names))
    }

    fn source(&self) -> Result<Option<String>, StudyError> {
        self.load.source().map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a motor takes is minimized and what it gives is maximized, unless the objective states its direction.
    #[test]
    fn an_objective_has_a_direction() {
        let setup = Setup::new("AnnulusCooledMotor", None, &[("cooling_mode", "water_jacket")]);
        let of = |text: &str| Target::objective(&ConstantInputs { setup: setup.clone() }, text);
        for (text, least_is_best) in [
            ("pump_power", true),
            ("pump_power:max", false),
            ("air_pressure_drop", true),
            ("winding_margin", false),
            ("power_mechanical", false),
            ("power_mechanical:min", true),
        ] {
            let target = of(text).unwrap();
            assert_eq!(
                (target.least_is_best, text.starts_with(&target.name)),
                (least_is_best, true),
                "{text}"
            );
        }
        assert!(of("pump_power:least").unwrap_err().to_string().contains("it is no output"));
    }
}
