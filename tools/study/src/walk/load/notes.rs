//! Notes about a load: settings without effect, values of another motor, a table that ends before its period.

use super::*;
use crate::notes::{Asked, Notes};
use crate::reproduce::significant;
use crate::walk::{shaft, stride};
use describe::usage::Scope;

impl Load {
    /// The sentences for this load.
    ///
    /// # Errors
    /// A load that does not start.
    pub fn notes(&self) -> Result<Vec<String>, StudyError> {
        Ok(Notes::sentences(vec![self.noted(&[])?], &[]))
    }

    /// What is to be noted; `varied` are settings of a sweep.
    pub(crate) fn noted(&self, varied: &[&str]) -> Result<Notes, StudyError> {
        let mut notes = Notes { others: self.speed_notes()?, ..Notes::default() };
        let mut names: Vec<&str> = self.origin.sets.iter().map(|(name, _)| name.as_str()).collect();
        names.extend(varied);
        for name in names.into_iter().filter(|name| Setting::named(name).is_none()) {
            let source = if varied.contains(&name) { "--vary" } else { "--set" };
            self.ask(name, source, &mut notes)?;
        }
        for part in self.parts() {
            let given = |name: &str| self.explicit.contains(name) || part.explicit.contains(name);
            notes.add_foreign(&part.in_its_modes()?[0], self.origin.preset.as_ref(), given);
            if let Some(cycle) = part.cycle.as_ref().map(|(cycle, _)| cycle).or(part.at_joint.as_ref()) {
                notes.others.extend(cycle.gap_note());
            }
        }
        Ok(notes)
    }

    /// The models in the modes in which they run.
    fn in_its_modes(&self) -> Result<[Bench; 3], StudyError> {
        let mut benches = self.prepared()?;
        if self.cycle.is_some() {
            shaft::set_modes(&mut benches[0])?;
        }
        Ok(benches)
    }

    /// Adds whether a setting has an effect in any part of the load.
    fn ask(&self, name: &str, source: &str, notes: &mut Notes) -> Result<(), StudyError> {
        let (mut asked, mut is_given) = (None, true);
        for part in self.parts() {
            let benches = part.in_its_modes()?;
            let Some(place) = benches.iter().position(|b| b.knows(name, None)) else { continue };
            let by_load = match &part.cycle {
                Some(_) => shaft::GIVEN.contains(&name),
                None => stride::is_given(place, name, &benches[0]),
            };
            if by_load {
                continue;
            }
            is_given = false;
            let one = Asked::of(&benches[place], vec![benches[place].entry(name)?], None, Scope::Transient);
            for mut one in one {
                if part.cycle.is_some() {
                    one.forget_mode(&shaft::GIVEN);
                }
                if asked.as_ref().is_none_or(Asked::is_unused) {
                    asked = Some(one);
                }
            }
        }
        if is_given {
            notes.others.push(format!("{name} ({source}) has no effect with --load: the load gives it"));
        }
        notes.asked.extend(asked);
        Ok(())
    }
}

impl Cycle {
    /// A sentence where the period ends later than one row after the last one.
    fn gap_note(&self) -> Option<String> {
        let table = self.table(1.0);
        let last = *table.times.last()?;
        let longest = table.times.windows(2).map(|t| t[1] - t[0]).fold(0.0, f64::max);
        let gap = self.period() - last;
        (gap > 1.01 * longest).then(|| {
            let [period, last, gap] = [self.period(), last, gap].map(significant);
            format!(
                "the period of {period} s is longer than the table, which ends at {last} s: over {gap} s torque and speed are interpolated \
                 to the first row"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: &str = "time,torque,speed\n0,0.01,1\n0.5,0.02,2\n1,0.01,1\n";

    fn load(cycle: &str, preset: &str, sets: &[(&str, &str)]) -> Load {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("c.csv"), ROWS).unwrap();
        let file = folder.path().join("l.toml");
        let columns = "file = \"c.csv\"\ntime = \"time\"\ntorque = \"torque\"\nspeed = \"speed\"\n";
        std::fs::write(&file, format!("[cycle]\n{columns}{cycle}")).unwrap();
        let sets: Vec<_> = sets.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
        Load::read(&file, Preset::load(preset).ok().as_ref(), &sets).unwrap()
    }

    #[test]
    fn settings_that_a_load_does_not_use_are_named() {
        let sets = [("load_torque", "1"), ("imposed_speed", "100"), ("duty", "1"), ("fan_command", "0.5")];
        let notes = load("", "maxon-305015", &sets).notes().unwrap();
        assert_eq!(notes.len(), 2, "{notes:?}");
        assert_eq!(notes[0], "load_torque and duty (--set) have no effect in the selected modes");
        assert_eq!(notes[1], "imposed_speed (--set) has no effect with --load: the load gives it");
        let gait = |sets: &[(&str, &str)]| {
            let sets: Vec<_> = sets.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
            let preset = Preset::load("maxon-305015").ok();
            let text = "[motor]\ndrive_mode = \"current\"\n";
            Load::parse(text, "gait.toml", preset.as_ref(), &sets).unwrap().notes().unwrap()
        };
        assert_eq!(gait(&[("gait.body_mass", "70"), ("transmission.ratio", "200")]), Vec::<String>::new());
        assert!(gait(&[("load_torque", "1")])[0].contains("the load gives it"));
    }

    #[test]
    fn values_of_another_motor_and_a_long_period_are_named() {
        let notes = load("period = \"9 s\"\n", "maxon-re40-148877", &[("fan_command", "1")]).notes().unwrap();
        assert_eq!(notes.len(), 2, "{notes:?}");
        assert!(notes[0].contains("the table, which ends at 1.000 s"), "{notes:?}");
        assert!(notes[1].ends_with("conductance.G_forced = 0.113 W/K"), "{notes:?}");
        assert!(load("", "maxon-re40-148877", &[]).notes().unwrap().is_empty());
    }

    #[test]
    fn an_empty_file_and_two_columns_of_one_name_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        for (name, text, words) in [
            ("e.toml", "# nothing\n", "e.toml is empty"),
            ("c.csv", "time,torque,speed,torque\n0,1,1,2\n1,1,1,2\n2,1,1,2\n", "several columns torque"),
        ] {
            let file = folder.path().join(name);
            std::fs::write(&file, text).unwrap();
            let error = Load::read(&file, None, &[]).err().unwrap().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
