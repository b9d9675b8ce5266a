//! Reads a load file.

use super::super::cycle_file;
use super::*;

/// What to use in place of a variable that a cycle at the joint leaves without effect.
pub(super) fn without_effect(name: &str) -> Option<&'static str> {
    match name {
        ACTIVITY | "gait.joint" | "gait.body_mass" => Some(""),
        SCALE => Some("; use gait.support"),
        "cycle.ratio" => Some("; use transmission.ratio"),
        "cycle.efficiency" => Some("; use transmission.efficiency"),
        "cycle.inertia" => Some(": the torque of the file has to contain it"),
        "cycle.supply" => Some("; use supply_voltage"),
        _ => None,
    }
}

/// Makes a cycle the load table of the gait; `given` are the variables of the gait that the file sets.
fn put_at_joint(gait: &mut Bench, cycle: &Cycle, drive: &Drive, given: &[&str]) -> Result<(), String> {
    let changed = |setting: &&Setting| setting.get(drive) != setting.get(&Drive::default());
    let settings = SETTINGS.iter().filter(changed).map(|setting| setting.name).filter(|name| *name != SCALE);
    if let Some((name, instead)) =
        settings.chain(given.iter().copied()).find_map(|n| Some((n, without_effect(n)?)))
    {
        return Err(format!("{name} has no effect with [cycle] and [actuator]{instead}"));
    }
    gait.set_load(&cycle.table(drive.scale));
    gait.set_text(ACTIVITY, TABLE).map_err(|error| error.to_string())
}

/// The text of a load file, or that of one for a CSV file.
fn text_of(file: &Path) -> Result<String, StudyError> {
    if file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv")) {
        return cycle_file::usual::table_of(file).map_err(StudyError::new);
    }
    let text = delimited::read_text(file)
        .map_err(|e| StudyError::new(format!("the load {} cannot be read ({e})", file.display())))?;
    match text.parse::<toml::Table>() {
        Ok(table) if table.is_empty() => Err(StudyError::new(format!(
            "the load {} is empty; it has at least one of the tables [motor], [actuator], [gait], [cycle] and [mix]",
            file.display()
        ))),
        _ => Ok(text),
    }
}

impl Load {
    /// From a file; the motor starts from `preset`, and `sets` override both. A name in `sets` belongs to the first of motor,
    /// actuator and gait that has it.
    ///
    /// # Errors
    /// One sentence with file and line, or with name, value and limits.
    pub fn read(file: &Path, preset: Option<&Preset>, sets: &[(String, String)]) -> Result<Load, StudyError> {
        let path = file.display().to_string();
        // An error in the rows of a CSV file without a load file has its place already.
        let plain = |error: StudyError| {
            StudyError::new(error.to_string().replace(&format!("{path}:1: {path}"), &path))
        };
        Load::parsed(&text_of(file)?, &path, preset, sets, false).map_err(plain)
    }

    /// From the text of a file; `file` names it in errors.
    ///
    /// # Errors
    /// As [`read`](Load::read).
    pub fn parse(
        text: &str,
        file: &str,
        preset: Option<&Preset>,
        sets: &[(String, String)],
    ) -> Result<Load, StudyError> {
        Load::parsed(text, file, preset, sets, false)
    }

    fn parsed(
        text: &str,
        file: &str,
        preset: Option<&Preset>,
        sets: &[(String, String)],
        is_phase: bool,
    ) -> Result<Load, StudyError> {
        let mut tables = Vec::new();
        for (table, model) in TABLES {
            if let Some(kind) = models::by_name(model) {
                tables.push((table, (kind.declaration)()));
            }
        }
        let folder = delimited::folder(Path::new(file)).to_owned();
        let (mut cycle, mut mix) = (None, None);
        let values =
            StartValues::of_tables(text, file, &tables, &["cycle", "mix"], |name, value, source| {
                if name == "cycle" {
                    cycle = cycle_file::read(value, &folder, source);
                } else {
                    mix = MixFile::read(value, source);
                }
            })?;
        if is_phase && mix.is_some() {
            return Err(StudyError::new(format!("{file}: it has a [mix] and cannot be a phase of one")));
        }
        let used = |k: usize| !values[k].entries().is_empty();
        let at_joint = cycle.is_some() && used(THE_ACTUATOR);
        if cycle.is_some() && !at_joint && used(THE_GAIT) {
            return Err(StudyError::new(format!(
                "{file}: [cycle] without [actuator] is a load at the motor or behind its gear; [gait] has no effect with it"
            )));
        }
        let mut benches = [Bench::new(MOTOR, preset)?, Bench::new(ACTUATOR, None)?, Bench::new(GAIT, None)?];
        if cycle.is_none() || at_joint {
            benches[0].set_text(FREE_SHAFT.0, FREE_SHAFT.1)?;
        }
        benches[THE_ACTUATOR].set_text(POWER_SOURCE.0, POWER_SOURCE.1)?;
        for (bench, values) in benches.iter_mut().zip(&values) {
            bench.set_all(values)?;
        }
        let mut explicit = BTreeSet::new();
        for (bench, values) in benches[..=THE_ACTUATOR].iter().zip(&values) {
            let given = values.entries();
            let names = given.iter().filter_map(|(r, _)| bench.declaration().by_reference(*r));
            explicit.extend(names.map(|entry| entry.name.clone()));
        }
        let origin = Origin {
            text: text.to_owned(),
            file: file.to_owned(),
            preset: preset.cloned(),
            sets: sets.to_vec(),
        };
        let mut cycle = cycle.map(|(cycle, drive)| (Arc::new(cycle), drive));
        let carried = cycle.take_if(|_| at_joint);
        if let Some((cycle, drive)) = &carried {
            let of_gait = values[THE_GAIT].entries();
            let names = of_gait.iter().filter_map(|(r, _)| benches[THE_GAIT].declaration().by_reference(*r));
            let given: Vec<&str> = names.map(|entry| entry.name.as_str()).collect();
            put_at_joint(&mut benches[THE_GAIT], cycle, drive, &given)
                .map_err(|sentence| StudyError::new(format!("{file}: {sentence}")))?;
        }
        let at_joint = carried.map(|(cycle, _)| cycle);
        let mut load = Load { benches, explicit, cycle, at_joint, mix: None, origin: Arc::new(origin) };
        if let Some(mut mix) = mix {
            mix.load(|phase| {
                let mut found = match &phase.file {
                    Some(other) => {
                        let other = folder.join(other);
                        Load::parsed(&text_of(&other)?, &other.display().to_string(), preset, &[], true)?
                    }
                    None => load.clone(),
                };
                for (name, text) in &phase.sets {
                    found.set_text(name, text).map_err(|e| StudyError::new(format!("{file}: [mix]: {e}")))?;
                }
                Ok(found)
            })?;
            load.mix = Some(mix);
        }
        for (name, text) in sets {
            load.set_text(name, text)?;
        }
        Ok(load)
    }
}
