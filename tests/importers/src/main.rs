//! Rust importers of other projects, each with the same inputs: `importers NAME ARCHIVE DRIVE.json ROWS.json`.
//!
//! The files are those of `tests/python/importers`, and so is what a drive means. The importers' own API is used and no
//! function of the FMU is called past them.

mod with_fmi;
mod with_fmi_rs;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Parameters and inputs of an FMU.
#[derive(serde::Deserialize)]
struct Drive {
    /// The communication step.
    step: f64,
    /// Set before initialization.
    parameters: BTreeMap<String, f64>,
    /// A value for each step.
    inputs: BTreeMap<String, Vec<f64>>,
    /// What is read.
    outputs: Vec<String>,
}

/// A sentence that says what an importer could not do.
type Outcome<T> = Result<T, String>;
/// The outputs after initialization and after each step.
type Rows = Vec<Vec<f64>>;

/// An instance behind somebody's importer.
trait Motor {
    /// The value reference of a variable.
    fn reference(&self, name: &str) -> Outcome<u32>;
    /// Sets reals.
    fn set(&mut self, references: &[u32], values: &[f64]) -> Outcome<()>;
    /// From a fresh instance to one that steps; `set` is called before.
    fn initialize(&mut self) -> Outcome<()>;
    /// One step.
    fn step(&mut self, point: f64, size: f64) -> Outcome<()>;
    /// Reads reals.
    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Outcome<()>;
}

impl Drive {
    fn record(&self, motor: &mut dyn Motor) -> Outcome<Rows> {
        let references = |names: &mut dyn Iterator<Item = &String>| -> Outcome<Vec<u32>> {
            names.map(|name| motor.reference(name)).collect()
        };
        let parameters = references(&mut self.parameters.keys())?;
        let inputs = references(&mut self.inputs.keys())?;
        let outputs = references(&mut self.outputs.iter())?;
        let steps = self.inputs.values().map(Vec::len).min().ok_or("the drive has no inputs")?;
        let at = |k: usize| self.inputs.values().map(|values| values[k]).collect::<Vec<_>>();
        motor.set(&parameters, &self.parameters.values().copied().collect::<Vec<_>>())?;
        motor.set(&inputs, &at(0))?;
        motor.initialize()?;
        let mut rows = vec![vec![0.0; outputs.len()]; steps + 1];
        motor.get(&outputs, &mut rows[0])?;
        for k in 0..steps {
            motor.set(&inputs, &at(k))?;
            motor.step(k as f64 * self.step, self.step)?;
            motor.get(&outputs, &mut rows[k + 1])?;
        }
        Ok(rows)
    }
}

fn run() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, archive, drive, rows] = arguments.as_slice() else {
        return Err("usage: importers NAME ARCHIVE DRIVE.json ROWS.json".into());
    };
    let text = std::fs::read_to_string(drive).map_err(|e| format!("{drive} cannot be read: {e}"))?;
    let drive: Drive = serde_json::from_str(&text).map_err(|e| format!("{drive} is no drive: {e}"))?;
    let archive = Path::new(archive);
    let recorded = match name.as_str() {
        "fmi" => drive.record(&mut with_fmi::open(archive)?),
        "fmi-rs-2" => drive.record(&mut with_fmi_rs::open2(archive)?),
        "fmi-rs-3" => drive.record(&mut with_fmi_rs::open3(archive)?),
        "fmi-reads-3" => return with_fmi::read3(archive),
        _ => return Err(format!("there is no importer {name:?}")),
    }?;
    let text = serde_json::to_string(&recorded).map_err(|e| e.to_string())?;
    std::fs::write(PathBuf::from(rows), text).map_err(|e| format!("{rows} cannot be written: {e}"))
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(sentence) => {
            eprintln!("{sentence}");
            ExitCode::FAILURE
        }
    }
}
