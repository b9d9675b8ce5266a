//! Notes about the values of a steady state: those without effect in the selected modes.

use super::Setup;
use crate::StudyError;
use crate::bench::Bench;
use describe::usage::{self, Scope, Unused};
use physics::model::Entry;
use rayon::prelude::*;

impl Setup {
    /// What the user set without effect on the steady state in the selected modes, in one sentence each for the values
    /// set by name and for the values of the preset. A value of the preset counts if it has
    /// an effect in the modes that the preset itself selects.
    ///
    /// # Errors
    /// As [`bench`](Setup::bench).
    pub fn notes(&self) -> Result<Vec<String>, StudyError> {
        Setup::notes_of(std::slice::from_ref(self), &[])
    }

    /// The [`notes`](Setup::notes) of several points, with the names in `varied`: what has no effect at any of them.
    ///
    /// # Errors
    /// As [`bench`](Setup::bench).
    pub fn notes_of(points: &[Setup], varied: &[&str]) -> Result<Vec<String>, StudyError> {
        let asked = points.par_iter().map(|point| point.asked(varied)).collect::<Result<Vec<_>, _>>()?;
        let mut all: Vec<Asked> = Vec::new();
        for one in asked.into_iter().flatten() {
            match all.iter_mut().find(|a| a.preset == one.preset && a.entry.name == one.entry.name) {
                None => all.push(one),
                Some(before) => before.unused = both(before.unused.take(), one.unused),
            }
        }
        let mut sources: Vec<Option<String>> = Vec::new();
        for asked in &all {
            if !sources.contains(&asked.preset) {
                sources.push(asked.preset.clone());
            }
        }
        let sentence = |source: &Option<String>| {
            let found: Vec<Unused> =
                all.iter().filter(|a| a.preset == *source).filter_map(|a| a.unused.clone()).collect();
            usage::sentence(&found, |entry| match source {
                Some(preset) => format!("preset {preset}"),
                None if varied.contains(&entry.name.as_str()) => "--vary".to_owned(),
                None => "--set".to_owned(),
            })
        };
        Ok(sources.iter().filter_map(sentence).collect())
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
        let mut all = Asked::of(&bench, by_name.clone(), None);
        if let Some(preset) = &self.preset {
            let own = Bench::new(&self.model, Some(preset))?;
            let given =
                preset.starts.entries().into_iter().filter_map(|(r, _)| own.declaration().by_reference(r));
            let given: Vec<&'static Entry> =
                given.filter(|e| by_name.iter().all(|other| other.name != e.name)).collect();
            let without = own.unused(&given, Scope::Steady);
            let used = given.into_iter().filter(|e| without.iter().all(|u| u.entry.name != e.name));
            all.extend(Asked::of(&bench, used.collect(), Some(&preset.name)));
        }
        Ok(all)
    }
}

/// A value that is set, and the preset that sets it.
struct Asked {
    preset: Option<String>,
    entry: &'static Entry,
    unused: Option<Unused>,
}

impl Asked {
    fn of(bench: &Bench, entries: Vec<&'static Entry>, preset: Option<&str>) -> Vec<Asked> {
        let unused = bench.unused(&entries, Scope::Steady);
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
    use describe::Preset;

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
            case.notes(&vary).unwrap()
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
        let current = [("current_command", "1")];
        let none = notes(&current, &["coolant_flow_rate=1e-6,1e-5", "cooling_mode=bare,conductance"]);
        assert_eq!(none, ["coolant_flow_rate (--vary) has no effect in the selected modes"]);
        let of_presets = notes(&current, &["preset=maxon-305015,maxon-re40-148877", "cooling_mode=bare"]);
        let (one, other) = ("(preset maxon-305015) has no effect with", "(preset maxon-re40-148877) has");
        assert!(of_presets.len() == 2 && of_presets[0].contains(one), "{of_presets:?}");
        assert!(of_presets[1].contains(other), "{of_presets:?}");
    }
}
