//! Simulation of a run: inputs as measured, outputs at the rows.
//!
//! Inputs are interpolated linearly between rows; a blank input is interpolated between its neighbours. The native model takes
//! communication steps from row to row; its integrator uses substeps where needed.

use crate::CalibrateError;
use crate::deadline::Deadline;
use crate::experiment::{Channel, Experiment, Role, Run, Start};
use crate::initial::columns::Column;
use crate::initial::{self, Started, Warm};
use crate::overrides::Override;
use crate::smoothing;
use physics::model::{Declaration, Model, ModelType, Slot};
use physics::terms::{GenericTerm, Law, MOST_DRIVERS, Port, Product};
use std::sync::Arc;

/// Model with the start values of an experiment, which can be run with other parameters.
#[derive(Clone)]
pub struct Bench {
    /// Factors on the default integration tolerances of heat, and of current and speed: 1 for full accuracy.
    pub ease: [f64; 2],
    /// Whether a run continues past the limits of validity: a fit with poor start values needs residuals there as well.
    pub lenient: bool,
    /// Deadline of the simulations.
    pub deadline: Deadline,
    kind: &'static ModelType,
    /// Slots with the start values of preset and experiment.
    starts: Vec<(Slot, f64)>,
    /// Model with these start values. A copy costs less than setting them, each of which changes everything that follows from it.
    template: Arc<dyn Model>,
    /// Limits of validity that no run reaches.
    widest: Vec<(Slot, f64)>,
    inputs: Vec<Slot>,
    outputs: Vec<Slot>,
}

/// Simulation data of one run: a value of every input at every row.
#[derive(Clone)]
pub struct Drive {
    /// Time of each row, s.
    pub time: Vec<f64>,
    /// Inputs by row, in SI units.
    inputs: Vec<Vec<f64>>,
    /// Start values specific to this run.
    set: Vec<(Slot, f64)>,
    /// Sensors of the nodes that do not start at the ambient temperature; empty if the run starts there.
    pub warm: Vec<Warm>,
    /// Readings of the other outputs that the start of a lag is estimated from.
    pub others: Vec<Column>,
}

/// The lower one of the limits that end a run.
const LOWEST: &str = "validity.lowest_temperature";
/// Rows between checks of the deadline. Numerical: a check costs less than a row.
const ROWS_A_LOOK: usize = 16;

/// Outputs of a run by column, and the reason why it ends before its last row.
pub type Ended = (Vec<Vec<f64>>, Option<String>);

impl Bench {
    /// Bench model of an experiment; `preset` are the start values of its preset, by value reference.
    ///
    /// # Errors
    /// A run without ambient temperature, if the experiment gives none.
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
        // If one width of the friction reversal zone is stated, it applies to all friction elements without a stated width.
        let said = |slot: Slot| starts.iter().rev().find(|(s, _)| *s == slot).map(|(_, value)| *value);
        let narrow = declaration.by_name("effect.coulomb_friction.w_small").and_then(|e| said(e.slot));
        let others =
            declaration.entries.iter().filter(|e| e.name.ends_with(".w_small") && said(e.slot).is_none());
        let others: Vec<Slot> = others.map(|e| e.slot).collect();
        starts.extend(narrow.into_iter().flat_map(|w| others.iter().map(move |slot| (*slot, w))));
        let mut template = (kind.new)();
        template.set_all(&starts);
        let limits = declaration.entries.iter().filter(|e| e.is_limit_of_validity());
        let widest = limits.map(|e| (e.slot, if e.name == LOWEST { e.row.min } else { e.row.max })).collect();
        let of = |channels: &[&'static Channel], role: fn(&Channel) -> Option<&'static str>| {
            channels.iter().filter_map(|c| role(c)).map(slot).collect::<Result<Vec<_>, _>>()
        };
        Ok(Bench {
            ease: [1.0; 2],
            lenient: false,
            deadline: Deadline::default(),
            kind,
            starts,
            template: template.into(),
            widest,
            inputs: of(&experiment.inputs, |c| c.input)?,
            outputs: of(&experiment.outputs, |c| c.output)?,
        })
    }

    /// Whether the model takes laws.
    pub fn takes_laws(&self) -> bool {
        let law = Law::Product(Product { coefficient: 1.0, factors: [None; MOST_DRIVERS] });
        self.template.refusal(&GenericTerm::new(Port::HousingHeat, law)).is_none()
    }

    /// Start value of a parameter.
    pub fn start_of(&self, slot: Slot) -> f64 {
        let last = self.starts.iter().rev().find(|(s, _)| *s == slot);
        last.map_or_else(|| self.template.boxed_clone().get(slot), |(_, value)| *value)
    }

    /// Initial temperatures by full name of a run that starts at measured ones, with a change applied.
    ///
    /// # Errors
    /// The message of the model if it cannot start.
    pub fn initial(&self, drive: &Drive, change: &Override) -> Result<Vec<(String, f64)>, CalibrateError> {
        if drive.warm.is_empty() {
            return Ok(Vec::new());
        }
        Ok(self.named(&self.started(drive, change)?.initial))
    }

    /// All start values with a change and the run's own settings, by full name; the last of duplicates applies.
    pub fn values(&self, drive: &Drive, change: &Override) -> Vec<(String, f64)> {
        self.named(self.starts.iter().chain(&change.values).chain(&drive.set))
    }

    /// Values by full name, limited to their range; the last of duplicates applies.
    fn named<'a>(&self, all: impl IntoIterator<Item = &'a (Slot, f64)>) -> Vec<(String, f64)> {
        let mut values: Vec<(String, f64)> = Vec::new();
        for (slot, value) in all {
            let entry = self.declaration().entries.iter().find(|e| e.slot == *slot);
            let Some(entry) = entry else { continue };
            // An FMU rejects values outside the limits.
            let (name, value) = (&entry.name, &value.clamp(entry.row.min, entry.row.max));
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

    /// Model with the change applied, initialised for the start of the run.
    ///
    /// # Errors
    /// The message of the model if it cannot start.
    pub fn begin(&self, drive: &Drive, change: &Override) -> Result<Box<dyn Model>, CalibrateError> {
        Ok(self.started(drive, change)?.model)
    }

    /// The same at these [unknowns](Started::unknowns).
    ///
    /// # Errors
    /// The message of the model if it cannot start.
    pub fn begin_at(
        &self,
        drive: &Drive,
        change: &Override,
        unknowns: &[f64],
    ) -> Result<Started, CalibrateError> {
        let mut model = self.set_up(drive, change)?;
        let (indicated, lags) = unknowns.split_at(drive.warm.len());
        let mut lags = initial::lags::values(model.declaration(), change, lags);
        lags.retain(|(slot, _)| !self.starts.iter().chain(&drive.set).any(|(known, _)| known == slot));
        model.set_all(&lags);
        let mut initial = self.start(model.as_mut(), drive, indicated)?;
        initial.extend(lags);
        model.ease(self.ease);
        Ok(Started { model, unknowns: unknowns.to_vec(), initial })
    }

    /// Model with the change applied and the inputs of the first row.
    fn set_up(&self, drive: &Drive, change: &Override) -> Result<Box<dyn Model>, CalibrateError> {
        let mut model = self.template.boxed_clone();
        // The run's own settings override every trial value.
        let widest = if self.lenient { &self.widest[..] } else { &[] };
        model.set_all(&[&change.values, &drive.set, widest].concat());
        if !change.terms.is_empty() && !model.set_terms(&change.terms) {
            return Err(CalibrateError(format!("{} carries no such terms", model.declaration().name)));
        }
        drive.hold(model.as_mut(), &self.inputs, 0);
        Ok(model)
    }

    /// Outputs at every row with a change applied: one column for each output, in SI units.
    ///
    /// # Errors
    /// The message of the model if it cannot start or step.
    pub fn run(&self, drive: &Drive, change: &Override) -> Result<Vec<Vec<f64>>, CalibrateError> {
        Ok(self.run_to_end(drive, change)?.0)
    }

    /// The same, and the reason why the run ends before its last row; `None` if it does not.
    ///
    /// # Errors
    /// As [`run`](Bench::run).
    pub fn run_to_end(&self, drive: &Drive, change: &Override) -> Result<Ended, CalibrateError> {
        let mut model = self.begin(drive, change)?;
        let rows = drive.time.len();
        let mut shown = vec![Vec::with_capacity(rows); self.outputs.len()];
        let ending = self.along(drive, model.as_mut(), |model, _| {
            for (column, slot) in shown.iter_mut().zip(&self.outputs) {
                column.push(model.get(*slot));
            }
        })?;
        Ok((shown, ending))
    }

    /// Simulates an initialised model along a run and calls `see` at every row. A model that reaches a limit of validity keeps its state
    /// for the remaining rows, so that a candidate with such parameters fails by its residuals; the reason is returned.
    ///
    /// # Errors
    /// The message of the model if it cannot step.
    pub fn along(
        &self,
        drive: &Drive,
        model: &mut dyn Model,
        see: impl FnMut(&mut dyn Model, usize),
    ) -> Result<Option<String>, CalibrateError> {
        self.along_rows(drive, drive.time.len(), model, see)
    }

    /// The same for the first rows of a run.
    ///
    /// # Errors
    /// The message of the model if it cannot step.
    pub fn along_rows(
        &self,
        drive: &Drive,
        rows: usize,
        model: &mut dyn Model,
        mut see: impl FnMut(&mut dyn Model, usize),
    ) -> Result<Option<String>, CalibrateError> {
        let mut ending = None;
        for k in 0..rows {
            see(model, k);
            let Some(next) = drive.time[..rows].get(k + 1) else { break };
            if ending.is_some() {
                continue;
            }
            if k % ROWS_A_LOOK == 0 && self.deadline.is_over() {
                return Err(CalibrateError("the time budget is used up".to_string()));
            }
            let h = next - drive.time[k];
            for (input, slot) in drive.inputs.iter().zip(&self.inputs) {
                model.set_slope(*slot, (input[k + 1] - input[k]) / h);
            }
            match model.step(drive.time[k], h) {
                Err(fault) if model.ended() => {
                    ending = Some(fault.0);
                    continue;
                }
                outcome => outcome.map_err(refused)?,
            }
            // Sets the measured value exactly: input derivatives accumulate rounding errors.
            drive.hold(model, &self.inputs, k + 1);
        }
        Ok(ending)
    }

    /// Slots of the outputs in the model, in the experiment's order.
    pub fn outputs(&self) -> &[Slot] {
        &self.outputs
    }

    /// Slots of the inputs in the model, in the experiment's order.
    pub fn inputs(&self) -> &[Slot] {
        &self.inputs
    }

    /// The value that the model uses for a reading of the `k`-th input.
    pub fn limited(&self, k: usize, reading: f64) -> f64 {
        let entry = self.declaration().entries.iter().find(|e| e.slot == self.inputs[k]);
        entry.map_or(reading, |e| e.row.limited(reading))
    }
}

/// The message of a model as an error.
pub fn refused(fault: physics::model::Fault) -> CalibrateError {
    CalibrateError(fault.to_string())
}

impl Drive {
    /// Inputs and initial readings of a run.
    ///
    /// # Errors
    /// An input without any reading.
    pub fn new(experiment: &Experiment, run: &Run) -> Result<Drive, CalibrateError> {
        let time = run.table.time.clone();
        let columns = experiment.inputs.iter().zip(&run.table.columns);
        let mut inputs = columns
            .map(|(channel, column)| {
                filled(&time, column).ok_or_else(|| {
                    CalibrateError(format!("{}: the input {} has no reading", run.file, channel.column))
                })
            })
            .collect::<Result<Vec<_>, _>>()?;
        let model = physics::models::by_name(&experiment.model);
        let slot = |name: &str| model.and_then(|m| Some((m.declaration)().by_name(name)?.slot));
        // A parameter that is unknown in this run has no fixed value in it.
        let same = || experiment.runs.iter().filter(|r| r.file == run.file);
        let is_unknown = |name: &String| {
            same().any(|r| r.role == Role::Fit) && same().any(|r| r.priors.iter().any(|p| p.name == *name))
        };
        let set = run.set.iter().filter(|(name, _)| !is_unknown(name));
        let set = set.filter_map(|(name, value)| Some((slot(name)?, *value)));
        let set = initial::measured(experiment, run).chain(set).collect();
        let warm = match run.start {
            Start::Measured => initial::sensors(experiment, run),
            Start::Ambient => Vec::new(),
        };
        // Noise near a limit (such as zero power) is clipped: an FMU rejects values outside the limits.
        for (column, channel) in inputs.iter_mut().zip(&experiment.inputs) {
            let entry = channel.input.and_then(|name| (model?.declaration)().by_name(name));
            if let Some(entry) = entry {
                column.iter_mut().for_each(|x| *x = x.clamp(entry.row.min, entry.row.max));
            }
        }
        Ok(Drive { time, inputs, set, warm, others: Vec::new() })
    }

    /// Artificial run: inputs by row, in SI units.
    pub fn of(time: Vec<f64>, inputs: Vec<Vec<f64>>) -> Drive {
        Drive { time, inputs, set: Vec::new(), warm: Vec::new(), others: Vec::new() }
    }

    /// Greatest value of an input.
    pub fn greatest(&self, input: usize) -> f64 {
        self.inputs[input].iter().fold(0.0, |most, x| most.max(*x))
    }

    /// An input at a row, in SI units.
    pub fn input(&self, input: usize, row: usize) -> f64 {
        self.inputs[input][row]
    }

    /// Greatest absolute value of an input, at least 1.
    pub fn scale(&self, input: usize) -> f64 {
        self.inputs[input].iter().fold(1.0, |most, x| most.max(x.abs()))
    }

    /// Copy of the run with a function of row and reading in place of one input.
    pub fn with_input(&self, input: usize, of: impl Fn(usize, f64) -> f64) -> Drive {
        let mut inputs = self.inputs.clone();
        inputs[input].iter_mut().enumerate().for_each(|(row, x)| *x = of(row, *x));
        self.with_inputs(inputs)
    }

    /// Inputs by row, in the experiment's order, in SI units, without blanks.
    pub fn inputs(&self) -> &[Vec<f64>] {
        &self.inputs
    }

    /// Copy of the run with [smoothed](smoothing::input) inputs (`noise`: standard deviations, in their order).
    pub fn smoothed(&self, noise: &[f64]) -> Drive {
        let smooth = |(column, sigma): (&Vec<f64>, &f64)| smoothing::input(column, *sigma);
        self.with_inputs(self.inputs.iter().zip(noise).map(smooth).collect())
    }

    /// Copy with other inputs.
    pub fn with_inputs(&self, inputs: Vec<Vec<f64>>) -> Drive {
        Drive { inputs, ..self.clone() }
    }

    /// Sets the inputs of a row in a model.
    pub fn hold(&self, model: &mut dyn Model, slots: &[Slot], row: usize) {
        for (input, slot) in self.inputs.iter().zip(slots) {
            model.set(*slot, input[row]);
        }
    }
}

/// Column with blanks interpolated linearly and held constant at the ends; `None` if all values are blank.
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

    /// Bench of two rows, with a run as specified by the text.
    fn bench(run: &str, rows: &str) -> (Experiment, Bench) {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.csv"), rows).unwrap();
        let text = format!(
            "[experiment]\nname = \"a\"\nmodel = \"AnnulusCooledMotor\"\npreset = \"maxon-305015\"\n\
             inputs = [\"electrical_power_W\", \"ambient_temperature_degC\"]\n\
             outputs = [\"winding_temperature_degC\", \"housing_temperature_degC\"]\n\
             [set]\ncooling_mode = \"conductance\"\n\"conductance.G_still\" = 0.2\n\
             [[run]]\nfile = \"a.csv\"\nrole = \"fit\"\n{run}"
        );
        let path = folder.path().join("EXPERIMENT.toml");
        std::fs::write(&path, text).unwrap();
        let experiment = Experiment::read(&path).unwrap();
        let bench = Bench::new(&experiment, &[]).unwrap();
        (experiment, bench)
    }

    const ROWS: &str = "time_s,electrical_power_W,ambient_temperature_degC,winding_temperature_degC,\
                        housing_temperature_degC\n0,0,20,,45\n10,0,20,60,44\n7200,0,20,20,20\n";

    #[test]
    fn a_run_starts_where_it_was_measured_whatever_its_sensors_are_off() {
        let (experiment, bench) = bench("start = \"measured\"\n", ROWS);
        let drive = Drive::new(&experiment, &experiment.runs[0]).unwrap();
        let slot = |name: &str| bench.declaration().by_name(name).unwrap().slot;
        let off = |k: f64| Override {
            values: vec![
                (slot("effect.winding_sensor_offset.offset"), 3.0 * k),
                (slot("effect.housing_sensor_stem_loss.k"), 0.2 * k),
            ],
            terms: Vec::new(),
        };
        let shown = [0.0, 1.0].map(|k| bench.run(&drive, &off(k)).unwrap());
        for columns in &shown {
            // The winding's first reading is at a later row; it is used as the initial value.
            assert!((columns[0][0] - 333.15).abs() < 1e-6 && (columns[1][0] - 318.15).abs() < 1e-6);
        }
        // The same readings give different node temperatures; after hours only the sensor offset remains.
        assert!((shown[1][0][2] - shown[0][0][2] - 3.0).abs() < 0.01);
        let (experiment, bench) = self::bench("", ROWS);
        let cold = bench.run(&Drive::new(&experiment, &experiment.runs[0]).unwrap(), &off(0.0)).unwrap();
        assert_eq!(cold[0][0], 293.15);
    }

    #[test]
    fn what_a_run_sets_holds_in_it_alone() {
        let rows = ROWS.replace(",0,20,", ",10,20,");
        let (experiment, bench) = bench(
            "[run.set]\n\"conductance.G_still\" = 0.4\n[[run]]\nfile = \"a.csv\"\nrole = \"test\"\n",
            &rows,
        );
        let rise = |run: usize, change: &Override| {
            let drive = Drive::new(&experiment, &experiment.runs[run]).unwrap();
            bench.run(&drive, change).unwrap()[1][2] - 293.15
        };
        // 10 W through the conductance, after six time constants.
        assert!((rise(0, &Override::default()) - 25.0).abs() < 0.1);
        assert!((rise(1, &Override::default()) - 50.0).abs() < 0.2);
        let slot = bench.declaration().by_name("conductance.G_still").unwrap().slot;
        let tried = Override { values: vec![(slot, 0.8)], terms: Vec::new() };
        assert!((rise(0, &tried) - 25.0).abs() < 0.1 && (rise(1, &tried) - 12.5).abs() < 0.1);
    }
}
