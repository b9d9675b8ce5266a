//! Notes about the values of a study: those without effect in the selected modes, and those that belong to another motor.

use crate::StudyError;
use crate::bench::Bench;
use crate::steady::Setup;
use describe::Preset;
use describe::usage::{self, Scope, Unused};
use physics::declare::Unit;
use physics::model::Entry;
use rayon::prelude::*;

/// Friction that a motor without preset does not have.
const FRICTION: [&str; 2] = ["effect.coulomb_friction.tau_c", "effect.viscous_friction.k"];

/// What is to be noted at a point.
#[derive(Default)]
pub(crate) struct Notes {
    pub asked: Vec<Asked>,
    /// The preset, and what it does not give although the result depends on it.
    pub foreign: Vec<(String, &'static Entry)>,
    /// Whether the motor has no preset and no friction, and friction would matter.
    pub is_frictionless: bool,
    /// Further sentences.
    pub others: Vec<String>,
}

impl Notes {
    /// Adds what is foreign to a motor; `is_given` is true for a value that is set beside the preset.
    pub fn add_foreign(&mut self, bench: &Bench, preset: Option<&Preset>, is_given: impl Fn(&str) -> bool) {
        let entries = || bench.declaration().entries.iter();
        let Some(preset) = preset else {
            let has_none = |e: &Entry| bench.clone().get(&e.name).is_ok_and(|value| value == 0.0);
            let friction: Vec<_> = entries().filter(|e| FRICTION.contains(&e.name.as_str())).collect();
            self.is_frictionless |=
                friction.iter().all(|e| has_none(e)) && !bench.effective(&friction).is_empty();
            return;
        };
        let given = preset.starts.entries();
        let value_of =
            |e: &Entry| given.iter().find(|(reference, _)| *reference == e.value_reference).map(|g| g.1);
        // The declared values are those of a motor that may be this one.
        if entries()
            .filter(|e| e.name.starts_with("motor."))
            .all(|e| value_of(e).is_none_or(|v| v == e.row.start))
        {
            return;
        }
        let of_motor = |e: &&Entry| {
            let is_size = matches!(
                e.row.unit,
                Unit::KelvinPerWatt | Unit::WattPerKelvin | Unit::Metre | Unit::Kilogram
            );
            // A fan is bought as it is, and what is 0 is not there.
            e.is_settable() && is_size && e.row.start != 0.0 && !e.name.starts_with("fan.")
        };
        let missing: Vec<_> =
            entries().filter(of_motor).filter(|e| value_of(e).is_none() && !is_given(&e.name)).collect();
        self.foreign.extend(bench.effective(&missing).into_iter().map(|e| (preset.name.clone(), e)));
    }

    /// The sentences for several points, with the names in `varied`: what has no effect at any of them, and what is foreign at one.
    pub fn sentences(points: Vec<Notes>, varied: &[&str]) -> Vec<String> {
        let (mut all, mut foreign, mut others) = (Vec::<Asked>::new(), Vec::new(), Vec::new());
        let mut is_frictionless = false;
        for point in points {
            for one in point.asked {
                match all.iter_mut().find(|a| a.preset == one.preset && a.entry.name == one.entry.name) {
                    None => all.push(one),
                    Some(before) => before.unused = both(before.unused.take(), one.unused),
                }
            }
            is_frictionless |= point.is_frictionless;
            add_new(&mut foreign, point.foreign, |a, b| a.0 == b.0 && a.1.name == b.1.name);
            add_new(&mut others, point.others, |a, b| a == b);
        }
        let mut sources: Vec<Option<String>> = Vec::new();
        add_new(&mut sources, all.iter().map(|a| a.preset.clone()), |a, b| a == b);
        let sentence = |source: &Option<String>| {
            let found: Vec<Unused> =
                all.iter().filter(|a| a.preset == *source).filter_map(|a| a.unused.clone()).collect();
            usage::sentence(&found, |entry| match source {
                Some(preset) => format!("preset {preset}"),
                None if varied.contains(&entry.name.as_str()) => "--vary".to_owned(),
                None => "--set".to_owned(),
            })
        };
        let mut sentences: Vec<String> = sources.iter().filter_map(sentence).collect();
        sentences.extend(others);
        let mut presets: Vec<&String> = Vec::new();
        add_new(&mut presets, foreign.iter().map(|f| &f.0), |a, b| a == b);
        for preset in presets {
            let values = foreign
                .iter()
                .filter(|f| f.0 == *preset)
                .map(|(_, e)| format!("{} = {} {}", e.name, present::number(e.row.start), e.row.unit.name()));
            sentences.push(format!(
                "the result depends on values of another motor, the defaults of the model, which preset {preset} does not give: {}",
                values.collect::<Vec<_>>().join(", ")
            ));
        }
        if is_frictionless {
            sentences.push(format!(
                "no preset is chosen: the motor has no friction ({} = 0), which the result depends on; the preset of a motor has it",
                FRICTION.join(" = 0, ")
            ));
        }
        sentences
    }
}

/// Adds what is not there yet.
fn add_new<T>(all: &mut Vec<T>, more: impl IntoIterator<Item = T>, is_same: impl Fn(&T, &T) -> bool) {
    for one in more {
        if all.iter().all(|other| !is_same(other, &one)) {
            all.push(one);
        }
    }
}

impl Setup {
    /// What the user set without effect on the steady state in the selected modes, in one sentence each for the values
    /// set by name and for the values of the preset, and the values of another motor on which the result depends. A value of the preset
    /// counts if it has an effect in the modes that the preset itself selects.
    ///
    /// # Errors
    /// As [`bench`](Setup::bench).
    pub fn notes(&self) -> Result<Vec<String>, StudyError> {
        Setup::notes_of(std::slice::from_ref(self), &[])
    }

    /// The [`notes`](Setup::notes) of several points, with the names in `varied`.
    ///
    /// # Errors
    /// As [`bench`](Setup::bench).
    pub fn notes_of(points: &[Setup], varied: &[&str]) -> Result<Vec<String>, StudyError> {
        let noted = points.par_iter().map(|point| {
            let mut notes = Notes { asked: point.asked(varied)?, ..Notes::default() };
            let is_set = |name: &str| point.sets.iter().any(|(set, _)| set == name);
            let mut bench = point.bench()?;
            notes.add_foreign(&bench, point.preset.as_ref(), is_set);
            let is_driven = ["duty", "load_torque", "drive_mode", "mechanical_mode"].into_iter().any(is_set);
            if is_driven && !is_set("voltage") && is_without_supply(&mut bench)? {
                notes.others.push(
                    "voltage = 0 V is the default: without supply the terminals are short-circuited; --set voltage=... sets it"
                        .to_owned(),
                );
            }
            Ok(notes)
        });
        Ok(Notes::sentences(noted.collect::<Result<_, StudyError>>()?, varied))
    }

    /// What is set by name or by the preset, each with whether it is without effect.
    fn asked(&self, varied: &[&str]) -> Result<Vec<Asked>, StudyError> {
        let bench = self.bench()?;
        let mut by_name: Vec<&'static Entry> = Vec::new();
        for name in self.sets.iter().map(|(name, _)| name.as_str()).chain(varied.iter().copied()) {
            let entry = bench.entry(name)?;
            if by_name.iter().all(|other| other.name != entry.name) {
                by_name.push(entry);
            }
        }
        let mut all = Asked::of(&bench, by_name.clone(), None, Scope::Steady);
        if let Some(preset) = &self.preset {
            let own = Bench::new(&self.model, Some(preset))?;
            let given =
                preset.starts.entries().into_iter().filter_map(|(r, _)| own.declaration().by_reference(r));
            let given: Vec<&'static Entry> =
                given.filter(|e| by_name.iter().all(|other| other.name != e.name)).collect();
            let without = own.unused(&given, Scope::Steady);
            let used = given.into_iter().filter(|e| without.iter().all(|u| u.entry.name != e.name));
            all.extend(Asked::of(&bench, used.collect(), Some(&preset.name), Scope::Steady));
        }
        Ok(all)
    }
}

/// Whether a motor is driven by a voltage, which is 0.
fn is_without_supply(bench: &mut Bench) -> Result<bool, StudyError> {
    let Ok(voltage) = bench.entry("voltage") else { return Ok(false) };
    Ok(voltage.is_settable() && bench.get("voltage")? == 0.0 && !bench.effective(&[voltage]).is_empty())
}

/// A value that is set, and the preset that sets it.
pub(crate) struct Asked {
    preset: Option<String>,
    entry: &'static Entry,
    unused: Option<Unused>,
}

impl Asked {
    pub fn is_unused(&self) -> bool {
        self.unused.is_some()
    }

    /// Names no mode that the user cannot select.
    pub fn forget_mode(&mut self, choices: &[&str]) {
        if let Some(unused) = &mut self.unused {
            unused.mode.take_if(|mode| choices.contains(&mode.choice));
        }
    }

    pub fn of(bench: &Bench, entries: Vec<&'static Entry>, preset: Option<&str>, scope: Scope) -> Vec<Asked> {
        let unused = bench.unused(&entries, scope);
        let one = |entry: &'static Entry| Asked {
            preset: preset.map(str::to_owned),
            entry,
            unused: unused.iter().find(|u| u.entry.name == entry.name).cloned(),
        };
        entries.into_iter().map(one).collect()
    }
}

/// Without effect at two points; no mode is the reason where the points have different ones.
fn both(one: Option<Unused>, other: Option<Unused>) -> Option<Unused> {
    let (one, other) = (one?, other?);
    Some(Unused { mode: one.mode.filter(|mode| other.mode.as_ref() == Some(mode)), ..other })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::{Case, ConstantInputs, Vary};

    fn setup(sets: &[(&str, &str)]) -> Setup {
        Setup::new("AnnulusCooledMotor", Preset::load("maxon-305015").ok(), sets)
    }

    /// A resistance of the data sheet that the selected cooling mode drops is named, and one that it uses is not.
    #[test]
    fn values_without_effect_are_named() {
        let notes = |sets: &[(&str, &str)]| setup(sets).notes().unwrap();
        let power = ("electrical_power", "10");
        assert_eq!(notes(&[power]), Vec::<String>::new());
        let dropped = notes(&[power, ("cooling_mode", "bare")]);
        assert_eq!(
            dropped,
            [
                "conductance.G_still (preset maxon-305015) has no effect with cooling_mode = bare, only with cooling_mode = conductance"
            ]
        );
        let set = notes(&[
            power,
            ("conductance.G_forced", "0.2"),
            ("cooling_mode", "annulus_push"),
            ("voltage", "3"),
        ]);
        assert_eq!(set.len(), 2, "{set:?}");
        for words in [
            "conductance.G_forced (--set) has no effect with cooling_mode = annulus_push",
            "voltage (--set) has no effect with drive_mode = power, only with drive_mode = voltage or pwm",
        ] {
            assert!(set[0].contains(words), "{words} in {set:?}");
        }
        assert!(set[1].starts_with("conductance.G_still (preset"), "{set:?}");
        let varied = Setup::notes_of(&[setup(&[power])], &["fan.flow_max"]).unwrap();
        assert!(
            varied[0].starts_with("fan.flow_max (--vary) has no effect with cooling_mode = conductance"),
            "{varied:?}"
        );
    }

    /// The notes of a sweep are those of its points: modes follow from the varied inputs, and varied modes count.
    #[test]
    fn a_sweep_names_what_has_no_effect_at_any_point() {
        let notes = |sets: &[(&str, &str)], vary: &[&str]| {
            let case = ConstantInputs { setup: Setup::new("AnnulusCooledMotor", None, sets) };
            let vary: Vec<Vary> = vary.iter().map(|text| Vary::parse(text).unwrap()).collect();
            let mut found = case.notes(&vary).unwrap();
            found.retain(|note| note.contains("no effect"));
            found
        };
        for (sets, vary) in [
            (&[][..], &["current_command=1,3"][..]),
            (&[], &["electrical_power=1:10:3"]),
            (&[("voltage", "10")], &["duty=0.1,0.5"]),
            (&[("voltage", "24")], &["load_torque=0.05,0.1"]),
            (&[("current_command", "1")], &["coolant_flow_rate=1e-6,1e-5", "cooling_mode=bare,water_jacket"]),
        ] {
            assert_eq!(notes(sets, vary), Vec::<String>::new(), "{vary:?}");
        }
        let supply = |sets: &[(&str, &str)]| {
            let found = Setup::new("AnnulusCooledMotor", None, sets).notes().unwrap();
            found.iter().any(|note| note.contains("voltage = 0 V is the default"))
        };
        assert!(supply(&[("duty", "0.5")]) && supply(&[("load_torque", "0.1")]));
        assert!(!supply(&[("fan_command", "1")]) && !supply(&[("duty", "0.5"), ("voltage", "9")]));
        let current = [("current_command", "1")];
        let none = notes(&current, &["coolant_flow_rate=1e-6,1e-5", "cooling_mode=bare,conductance"]);
        assert_eq!(none, ["coolant_flow_rate (--vary) has no effect in the selected modes"]);
        let of_presets = notes(&current, &["preset=maxon-305015,maxon-re40-148877", "cooling_mode=bare"]);
        let (one, other) = ("(preset maxon-305015) has no effect with", "(preset maxon-re40-148877) has");
        assert!(of_presets[0].contains(one), "{of_presets:?}");
        assert!(of_presets[1].contains(other), "{of_presets:?}");
    }

    /// The conductance of one fan on one motor, and sizes: named where the result depends on them and the preset gives others.
    #[test]
    fn values_of_another_motor_are_named() {
        let notes = |preset: &str, sets: &[(&str, &str)]| {
            let found = Setup::new("AnnulusCooledMotor", Preset::load(preset).ok(), sets).notes().unwrap();
            found.into_iter().find(|note| note.contains("another motor")).unwrap_or_default()
        };
        let re40 = "maxon-re40-148877";
        assert_eq!(notes(re40, &[]), "");
        let fan = notes(re40, &[("fan_command", "1")]);
        assert!(fan.ends_with("maxon-re40-148877 does not give: conductance.G_forced = 0.113 W/K"), "{fan}");
        assert_eq!(notes(re40, &[("fan_command", "1"), ("conductance.G_forced", "0.2")]), "");
        assert_eq!(notes("maxon-305015", &[("fan_command", "1")]), "", "the motor of the declaration");
        let bare = notes(re40, &[("cooling_mode", "bare")]);
        assert!(bare.contains("thermal.G_wr") && !bare.contains("housing.diameter"), "{bare}");
    }

    /// At a standstill friction has no effect.
    #[test]
    fn the_motor_without_preset_has_no_friction() {
        let notes = |sets: &[(&str, &str)]| Setup::new("AnnulusCooledMotor", None, sets).notes().unwrap();
        assert_eq!(notes(&[("current_command", "1")]), Vec::<String>::new());
        let turning = notes(&[("imposed_speed", "1000")]);
        assert!(turning.len() == 1 && turning[0].contains("no friction"), "{turning:?}");
        assert_eq!(notes(&[("imposed_speed", "1000"), (FRICTION[0], "1e-3")]), Vec::<String>::new());
    }
}
