//! The model over a run: inputs as measured, outputs at the rows.
//!
//! Inputs run along lines between rows; a blank input runs on a line between its neighbours. The model is the native
//! one, at the rows' own steps, which its integrator cuts where it must.

use crate::CalibrateError;
use crate::candidate::Change;
use crate::experiment::{Channel, Experiment, Run, Start};
use physics::model::{Declaration, Model, ModelType, Slot};

/// A model with the start values of an experiment, ready to be run with other parameters.
pub struct Bench {
    kind: &'static ModelType,
    /// Slots with the values that the preset and the experiment give.
    starts: Vec<(Slot, f64)>,
    inputs: Vec<Slot>,
    outputs: Vec<Slot>,
}

/// One run as the simulation takes it: every input known at every row.
pub struct Drive {
    /// Time of each row, s.
    pub time: Vec<f64>,
    /// Inputs by row, in SI units.
    inputs: Vec<Vec<f64>>,
}

impl Bench {
    /// The bench of an experiment; `preset` are the start values of its preset, by value reference.
    ///
    /// # Errors
    /// A run without ambient temperature where the experiment gives none.
    pub fn new(experiment: &Experiment, preset: &[(u32, f64)]) -> Result<Bench, CalibrateError> {
        let unknown = || CalibrateError(format!("{} is no model", experiment.model));
        let kind = physics::models::by_name(&experiment.model).ok_or_else(unknown)?;
        let declaration = (kind.declaration)();
        let slot = |name: &str| {
            let entry = declaration.by_name(name);
            entry.map(|e| e.slot).ok_or_else(|| CalibrateError(format!("{} has no {name}", declaration.name)))
        };
        let mut starts: Vec<(Slot, f64)> =
            preset.iter().filter_map(|(r, v)| Some((declaration.by_reference(*r)?.slot, *v))).collect();
        for (name, value) in &experiment.set {
            starts.push((slot(name)?, *value));
        }
        let of = |channels: &[&'static Channel], role: fn(&Channel) -> Option<&'static str>| {
            channels.iter().filter_map(|c| role(c)).map(slot).collect::<Result<Vec<_>, _>>()
        };
        Ok(Bench {
            kind,
            starts,
            inputs: of(&experiment.inputs, |c| c.input)?,
            outputs: of(&experiment.outputs, |c| c.output)?,
        })
    }

    /// The value of a parameter at the start.
    pub fn start_of(&self, slot: Slot) -> f64 {
        let last = self.starts.iter().rev().find(|(s, _)| *s == slot);
        last.map_or_else(|| (self.kind.new)().get(slot), |(_, value)| *value)
    }

    /// Every start value with a change, by full name; of several the last.
    pub fn values(&self, change: &Change) -> Vec<(String, f64)> {
        let mut values: Vec<(String, f64)> = Vec::new();
        for (slot, value) in self.starts.iter().chain(&change.values) {
            let entry = self.declaration().entries.iter().find(|e| e.slot == *slot);
            let Some(name) = entry.map(|e| &e.name) else { continue };
            match values.iter_mut().find(|(known, _)| known == name) {
                Some((_, place)) => *place = *value,
                None => values.push((name.clone(), *value)),
            }
        }
        values
    }

    /// The model's declaration.
    pub fn declaration(&self) -> &'static Declaration {
        (self.kind.declaration)()
    }

    /// The model changed, and started as the run starts.
    ///
    /// # Errors
    /// What the model says where it cannot start.
    pub fn begin(&self, drive: &Drive, change: &Change) -> Result<Box<dyn Model>, CalibrateError> {
        let mut model = (self.kind.new)();
        for (slot, value) in self.starts.iter().chain(&change.values) {
            model.set(*slot, *value);
        }
        if !change.terms.is_empty() && !model.set_terms(&change.terms) {
            return Err(CalibrateError(format!("{} carries no such terms", model.declaration().name)));
        }
        drive.hold(model.as_mut(), &self.inputs, 0);
        model.start(drive.time[0]).map_err(refused)?;
        Ok(model)
    }

    /// Outputs at every row, with the model changed: one column for each output, in SI units.
    ///
    /// # Errors
    /// What the model says where it cannot start or step.
    pub fn run(&self, drive: &Drive, change: &Change) -> Result<Vec<Vec<f64>>, CalibrateError> {
        let mut model = self.begin(drive, change)?;
        let rows = drive.time.len();
        let mut shown = vec![Vec::with_capacity(rows); self.outputs.len()];
        self.along(drive, model.as_mut(), |model, _| {
            for (column, slot) in shown.iter_mut().zip(&self.outputs) {
                column.push(model.get(*slot));
            }
        })?;
        Ok(shown)
    }

    /// Drives a started model along a run and shows it at every row.
    ///
    /// # Errors
    /// What the model says where it cannot step.
    pub fn along(
        &self,
        drive: &Drive,
        model: &mut dyn Model,
        mut see: impl FnMut(&mut dyn Model, usize),
    ) -> Result<(), CalibrateError> {
        for k in 0..drive.time.len() {
            see(model, k);
            let Some(next) = drive.time.get(k + 1) else { break };
            let h = next - drive.time[k];
            for (input, slot) in drive.inputs.iter().zip(&self.inputs) {
                model.set_slope(*slot, (input[k + 1] - input[k]) / h);
            }
            model.step(drive.time[k], h).map_err(refused)?;
            // To the last bit what was measured, whatever the slopes have added up to.
            drive.hold(model, &self.inputs, k + 1);
        }
        Ok(())
    }

    /// The outputs' places in the model, in the experiment's order.
    pub fn outputs(&self) -> &[Slot] {
        &self.outputs
    }

    /// The inputs' places in the model, in the experiment's order.
    pub fn inputs(&self) -> &[Slot] {
        &self.inputs
    }
}

fn refused(fault: physics::model::Fault) -> CalibrateError {
    CalibrateError(fault.to_string())
}

impl Drive {
    /// The inputs of a run.
    ///
    /// # Errors
    /// An input without a single reading; nodes that are to start as measured.
    pub fn new(experiment: &Experiment, run: &Run) -> Result<Drive, CalibrateError> {
        if run.start == Start::Measured {
            return Err(CalibrateError(format!("{}: start = \"measured\" is not supported yet", run.file)));
        }
        let time = run.table.time.clone();
        let columns = experiment.inputs.iter().zip(&run.table.columns);
        let inputs = columns
            .map(|(channel, column)| {
                filled(&time, column).ok_or_else(|| {
                    CalibrateError(format!("{}: the input {} has no reading", run.file, channel.column))
                })
            })
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Drive { time, inputs })
    }

    /// A run that was never driven: inputs by row, in SI units.
    pub fn of(time: Vec<f64>, inputs: Vec<Vec<f64>>) -> Drive {
        Drive { time, inputs }
    }

    /// The greatest value of an input.
    pub fn greatest(&self, input: usize) -> f64 {
        self.inputs[input].iter().fold(0.0, |most, x| most.max(*x))
    }

    /// An input at a row, in SI units.
    pub fn input(&self, input: usize, row: usize) -> f64 {
        self.inputs[input][row]
    }

    /// The greatest size of an input, at least 1.
    pub fn scale(&self, input: usize) -> f64 {
        self.inputs[input].iter().fold(1.0, |most, x| most.max(x.abs()))
    }

    /// The same run with one input moved throughout.
    pub fn with_input_moved(&self, input: usize, way: f64) -> Drive {
        let mut inputs = self.inputs.clone();
        inputs[input].iter_mut().for_each(|x| *x += way);
        Drive { time: self.time.clone(), inputs }
    }

    /// Gives the inputs of a row to a model.
    pub fn hold(&self, model: &mut dyn Model, slots: &[Slot], row: usize) {
        for (input, slot) in self.inputs.iter().zip(slots) {
            model.set(*slot, input[row]);
        }
    }
}

/// A column with its blanks on lines between their neighbours, held at its ends; `None` where all is blank.
fn filled(time: &[f64], column: &[f64]) -> Option<Vec<f64>> {
    let known: Vec<usize> = (0..column.len()).filter(|k| column[*k].is_finite()).collect();
    let (&first, &last) = (known.first()?, known.last()?);
    let mut full = column.to_vec();
    full[..first].fill(column[first]);
    full[last..].fill(column[last]);
    for pair in known.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        for k in a + 1..b {
            let share = (time[k] - time[a]) / (time[b] - time[a]);
            full[k] = column[a] + share * (column[b] - column[a]);
        }
    }
    Some(full)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blanks_lie_on_lines_and_ends_are_held() {
        let blank = f64::NAN;
        let full = filled(&[0.0, 1.0, 2.0, 4.0, 5.0], &[blank, 2.0, blank, 8.0, blank]).unwrap();
        assert_eq!(full, [2.0, 2.0, 4.0, 8.0, 8.0]);
        assert_eq!(filled(&[0.0, 1.0], &[blank, blank]), None);
    }
}
