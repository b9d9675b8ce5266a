//! Reference results that an archive carries, in the place and with the manifest of the layered standard FMI-LS-REF:
//! a table of inputs that every importer can apply, and the outputs of the native model.
//!
//! The excitation is the same for all models: one after the other, each input goes from its start value to its nominal value. Between two
//! steps the inputs are constant, so that the result does not depend on the importer's interpolation of inputs.

use crate::native::{Native, Run};
use describe::{Causality, DEFAULT_STEP, DEFAULT_STOP, Entry};

/// The folder in the archive.
pub const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
/// Points between two rows of the results.
const DECIMATION: u32 = 10;
/// The manifest with places for names and numbers; its version of the layered standard is a draft.
const MANIFEST: &str = include_str!("../assets/fmi-ls-manifest.xml");

/// The table of inputs and the results, both as CSV.
pub struct Reference {
    /// Time and all inputs; two rows with the same time make a jump.
    pub inputs: String,
    /// Time and all outputs.
    pub results: String,
}

/// Names of the two files of a model.
pub fn file_names(model: &str) -> [String; 2] {
    [format!("{model}_in.csv"), format!("{model}_ref.csv")]
}

/// New value of an input, and its communication point.
pub struct Jump {
    /// The input.
    pub entry: &'static Entry,
    /// The new value.
    pub to: f64,
    /// The number of the communication point.
    pub at: u32,
}

/// The jumps of the drive, in order of time: between a tenth and nine tenths of the run, on rows of the results.
pub fn jumps(native: &Native<'_>) -> Vec<Jump> {
    let entries = (native.kind.declaration)().entries.iter();
    let inputs: Vec<&Entry> = entries.filter(|e| e.row.causality == Causality::Input).collect();
    let rows = points() / DECIMATION;
    let count = inputs.len() as u32;
    let jump = |(k, entry): (usize, &&'static Entry)| Jump {
        entry,
        to: entry.row.nominal.clamp(entry.row.min, entry.row.max),
        at: DECIMATION * (rows / 10 + rows * 8 / 10 * k as u32 / count),
    };
    inputs.iter().enumerate().map(jump).collect()
}

fn points() -> u32 {
    (DEFAULT_STOP / DEFAULT_STEP).round() as u32
}

/// Runs the model; `visit` sees it at every communication point, before the inputs jump there. `None` where the model
/// refuses its own start values.
pub fn drive(native: &Native<'_>, mut visit: impl FnMut(u32, &mut Run<'_>) -> Option<()>) -> Option<()> {
    let jumps = jumps(native);
    let mut run = native.start(&[], &[])?;
    for k in 0..=points() {
        visit(k, &mut run)?;
        for jump in jumps.iter().filter(|j| j.at == k) {
            run.set(&jump.entry.name, jump.to)?;
        }
        if k < points() {
            run.step(DEFAULT_STEP)?;
        }
    }
    Some(())
}

/// The drive and its results; `None` as [`drive`].
pub fn run(native: &Native<'_>) -> Option<Reference> {
    let jumps = jumps(native);
    let entries = &(native.kind.declaration)().entries;
    let outputs: Vec<&Entry> = entries.iter().filter(|e| e.row.causality == Causality::Output).collect();
    let time = |k: u32| f64::from(k) * DEFAULT_STEP;
    let line = |time: f64, values: &[f64]| {
        let cells: Vec<String> = std::iter::once(&time).chain(values).map(f64::to_string).collect();
        cells.join(",") + "\n"
    };
    let header =
        |names: &mut dyn Iterator<Item = &str>| names.fold("time".to_string(), |t, n| t + "," + n) + "\n";
    let mut values: Vec<f64> = jumps.iter().map(|j| native.starts.of(j.entry)).collect();
    let mut inputs = header(&mut jumps.iter().map(|j| j.entry.name.as_str())) + &line(0.0, &values);
    for (place, jump) in jumps.iter().enumerate() {
        inputs += &line(time(jump.at), &values);
        values[place] = jump.to;
        inputs += &line(time(jump.at), &values);
    }
    inputs += &line(DEFAULT_STOP, &values);
    let mut results = header(&mut outputs.iter().map(|e| e.name.as_str()));
    drive(native, |k, run| {
        // A row shows the outputs as they are after the step, under the inputs of that step, as an importer records them.
        if k % DECIMATION == 0 {
            results += &line(time(k), &outputs.iter().map(|e| run.value(e)).collect::<Vec<_>>());
        }
        Some(())
    })?;
    Some(Reference { inputs, results })
}

/// What lies in the folder, for the layered standard's readers.
pub fn manifest(model: &str) -> String {
    let [inputs, results] = file_names(model);
    let step = DEFAULT_STEP.to_string();
    [("{inputs}", inputs), ("{results}", results), ("{step}", step)]
        .iter()
        .fold(MANIFEST.to_owned(), |text, (place, value)| text.replace(place, value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use describe::{StartValues, models};

    #[test]
    fn every_input_jumps_once_and_every_model_answers() {
        for kind in models::ALL.iter() {
            let starts = StartValues::default();
            let native = Native { kind, starts: &starts, resources: &describe::Resources::default() };
            let jumps = jumps(&native);
            assert!(jumps.windows(2).all(|w| w[0].at < w[1].at), "one after the other");
            assert!(jumps.iter().all(|j| j.at % DECIMATION == 0 && (100..900).contains(&j.at)));
            let reference = run(&native).expect("the model takes its own start values");
            assert_eq!(reference.inputs.lines().count(), 1 + 2 + 2 * jumps.len());
            assert_eq!(reference.results.lines().count(), 1 + 1 + 100);
            let rows: Vec<&str> = reference.results.lines().collect();
            assert_ne!(
                rows[1].split_once(',').unwrap().1,
                rows[101].split_once(',').unwrap().1,
                "the model moves"
            );
        }
    }

    #[test]
    fn the_manifest_names_the_files() {
        let text = manifest("Motor");
        let document = roxmltree::Document::parse(&text).unwrap();
        let sources: Vec<_> = document.descendants().filter_map(|n| n.attribute("source")).collect();
        assert_eq!(sources, ["Motor_in.csv", "Motor_ref.csv", "../../documentation/index.html"]);
    }
}
