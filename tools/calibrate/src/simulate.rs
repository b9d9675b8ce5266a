//! The model over a run: inputs as measured, outputs at the rows.
//!
//! Inputs run along lines between rows; a blank input runs on a line between its neighbours. The model is the native
//! one, at the rows' own steps, which its integrator cuts where it must.

use crate::CalibrateError;
use crate::deadline::Deadline;
use crate::experiment::{Channel, Experiment, Role, Run, Start};
use crate::initial::{self, Node};
use crate::overrides::Override;
use physics::model::{Declaration, Model, ModelType, Slot};

/// A model with the start values of an experiment, ready to be run with other parameters.
#[derive(Clone)]
pub struct Bench {
    /// By how much more than by default the model's steps may err: 1 where every digit counts.
    pub ease: f64,
    /// Whether a run goes on beyond the limits of validity: a fit that starts far off would see nothing behind them.
    pub lenient: bool,
    /// When simulations are given up.
    pub deadline: Deadline,
    kind: &'static ModelType,
    /// Slots with the values that the preset and the experiment give.
    starts: Vec<(Slot, f64)>,
    inputs: Vec<Slot>,
    outputs: Vec<Slot>,
}

/// One run as the simulation takes it: every input known at every row.
#[derive(Clone)]
pub struct Drive {
    /// Time of each row, s.
    pub time: Vec<f64>,
    /// Inputs by row, in SI units.
    inputs: Vec<Vec<f64>>,
    /// Start values that hold in this run alone.
    set: Vec<(Slot, f64)>,
    /// Where the nodes start, if not at the ambient temperature: node, its place among the outputs, and its first
    /// reading, K.
    warm: Vec<(Node, usize, f64)>,
}

/// Rows on either side over which an input is smoothed.
const REACH: usize = 6;
/// Readings within this many deviations of the noise are alike.
const ALIKE: f64 = 4.0;
/// Rows on either side over which the means of such rows are.
const FAR: usize = 48;
/// A sensor indicates its first reading to this, K.
const SHOWN: f64 = 1e-9;
/// Parameters that end a run; the lowest temperature is a lower limit.
const VALIDITY: &str = "validity.";
const LOWEST: &str = "validity.lowest_temperature";
/// Rows from one look at the clock to the next.
const ROWS_A_LOOK: usize = 16;
/// Greatest number of starts until it does.
const TRIES: usize = 50;

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
        // Where it is said how narrowly friction turns round, all friction does of which nothing else is said.
        let said = |slot: Slot| starts.iter().rev().find(|(s, _)| *s == slot).map(|(_, value)| *value);
        let narrow = declaration.by_name("effect.coulomb_friction.w_small").and_then(|e| said(e.slot));
        let others =
            declaration.entries.iter().filter(|e| e.name.ends_with(".w_small") && said(e.slot).is_none());
        let others: Vec<Slot> = others.map(|e| e.slot).collect();
        starts.extend(narrow.into_iter().flat_map(|w| others.iter().map(move |slot| (*slot, w))));
        let of = |channels: &[&'static Channel], role: fn(&Channel) -> Option<&'static str>| {
            channels.iter().filter_map(|c| role(c)).map(slot).collect::<Result<Vec<_>, _>>()
        };
        Ok(Bench {
            ease: 1.0,
            lenient: false,
            deadline: Deadline::default(),
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

    /// The initial temperatures of a run with a change, where it starts at measured ones, by full name.
    ///
    /// # Errors
    /// What the model says where it cannot start.
    pub fn initial(&self, drive: &Drive, change: &Override) -> Result<Vec<(String, f64)>, CalibrateError> {
        if drive.warm.is_empty() {
            return Ok(Vec::new());
        }
        let mut model = self.set_up(drive, change)?;
        Ok(self.named(&self.start(model.as_mut(), drive)?))
    }

    /// Every start value with a change and what a run says of itself, by full name; of several the last.
    pub fn values(&self, drive: &Drive, change: &Override) -> Vec<(String, f64)> {
        self.named(self.starts.iter().chain(&change.values).chain(&drive.set))
    }

    /// Values by full name, within their limits; of several of one name the last.
    fn named<'a>(&self, all: impl IntoIterator<Item = &'a (Slot, f64)>) -> Vec<(String, f64)> {
        let mut values: Vec<(String, f64)> = Vec::new();
        for (slot, value) in all {
            let entry = self.declaration().entries.iter().find(|e| e.slot == *slot);
            let Some(entry) = entry else { continue };
            // An FMU takes nothing beyond the limits.
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

    /// The model changed, and started as the run starts.
    ///
    /// # Errors
    /// What the model says where it cannot start.
    pub fn begin(&self, drive: &Drive, change: &Override) -> Result<Box<dyn Model>, CalibrateError> {
        let mut model = self.set_up(drive, change)?;
        self.start(model.as_mut(), drive)?;
        model.ease(self.ease);
        Ok(model)
    }

    /// The model changed, with the inputs of the first row.
    fn set_up(&self, drive: &Drive, change: &Override) -> Result<Box<dyn Model>, CalibrateError> {
        let mut model = (self.kind.new)();
        // What a run says of itself holds in it, whatever is tried elsewhere.
        for (slot, value) in self.starts.iter().chain(&change.values).chain(&drive.set) {
            model.set(*slot, *value);
        }
        let limits =
            self.declaration().entries.iter().filter(|e| self.lenient && e.name.starts_with(VALIDITY));
        for entry in limits {
            model.set(entry.slot, if entry.name == LOWEST { entry.row.min } else { entry.row.max });
        }
        if !change.terms.is_empty() && !model.set_terms(&change.terms) {
            return Err(CalibrateError(format!("{} carries no such terms", model.declaration().name)));
        }
        drive.hold(model.as_mut(), &self.inputs, 0);
        Ok(model)
    }

    /// Outputs at every row, with the model changed: one column for each output, in SI units.
    ///
    /// # Errors
    /// What the model says where it cannot start or step.
    pub fn run(&self, drive: &Drive, change: &Override) -> Result<Vec<Vec<f64>>, CalibrateError> {
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

    /// Drives a started model along a run and shows it at every row. A model that reaches a limit of validity stays there for
    /// the rows that are left, so that a candidate with such parameters fails by its residuals; the reason is given back.
    ///
    /// # Errors
    /// What the model says where it cannot step.
    pub fn along(
        &self,
        drive: &Drive,
        model: &mut dyn Model,
        mut see: impl FnMut(&mut dyn Model, usize),
    ) -> Result<Option<String>, CalibrateError> {
        let mut ending = None;
        for k in 0..drive.time.len() {
            see(model, k);
            let Some(next) = drive.time.get(k + 1) else { break };
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
            // To the last bit what was measured, whatever the slopes have added up to.
            drive.hold(model, &self.inputs, k + 1);
        }
        Ok(ending)
    }

    /// Why a run ends before its last row, with the model changed; `None` where it does not.
    ///
    /// # Errors
    /// As [`run`](Bench::run).
    pub fn ending(&self, drive: &Drive, change: &Override) -> Result<Option<String>, CalibrateError> {
        let mut model = self.begin(drive, change)?;
        self.along(drive, model.as_mut(), |_, _| {})
    }

    /// The outputs' places in the model, in the experiment's order.
    pub fn outputs(&self) -> &[Slot] {
        &self.outputs
    }

    /// The inputs' places in the model, in the experiment's order.
    pub fn inputs(&self) -> &[Slot] {
        &self.inputs
    }

    /// Starts a model where a run starts. The nodes whose first readings are known get the initial temperatures with which their
    /// sensors indicate these: a sensor with an offset or a stem loss does not indicate its node's temperature, so that each is moved
    /// by the deviation of its sensor until there is none. Returns the initial temperatures.
    fn start(&self, model: &mut dyn Model, drive: &Drive) -> Result<Vec<(Slot, f64)>, CalibrateError> {
        let mut known: Vec<(Node, f64)> =
            drive.warm.iter().map(|(node, _, reading)| (*node, *reading)).collect();
        let mut tries = 0;
        loop {
            let initial = initial::temperatures(model.declaration(), &known);
            for (slot, value) in &initial {
                model.set(*slot, *value);
            }
            model.start(drive.time[0]).map_err(refused)?;
            let mut worst = 0.0f64;
            for ((_, at), (_, output, reading)) in known.iter_mut().zip(&drive.warm) {
                let off = reading - model.get(self.outputs[*output]);
                *at += off;
                worst = worst.max(off.abs());
            }
            tries += 1;
            if worst <= SHOWN || tries == TRIES {
                return Ok(initial);
            }
        }
    }
}

fn refused(fault: physics::model::Fault) -> CalibrateError {
    CalibrateError(fault.to_string())
}

impl Drive {
    /// The inputs of a run, and where it starts.
    ///
    /// # Errors
    /// An input without a single reading.
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
        // What is unknown in this run is no fixed value of it.
        let same = || experiment.runs.iter().filter(|r| r.file == run.file);
        let is_unknown = |name: &String| {
            same().any(|r| r.role == Role::Fit) && same().any(|r| r.priors.iter().any(|p| p.name == *name))
        };
        let set = run.set.iter().filter(|(name, _)| !is_unknown(name));
        let set = set.filter_map(|(name, value)| Some((slot(name)?, *value))).collect();
        let mut warm: Vec<(Node, usize, f64)> = Vec::new();
        if run.start == Start::Measured {
            for (k, channel) in experiment.outputs.iter().enumerate() {
                let first = run.table.columns[experiment.inputs.len() + k].iter().find(|v| v.is_finite());
                // Of several sensors on a node the first.
                let node = channel.node().filter(|node| warm.iter().all(|(known, ..)| known != node));
                warm.extend(node.zip(first).map(|(node, first)| (node, k, *first)));
            }
        }
        // Noise around a limit, as of a power of zero, stays within: an FMU takes nothing beyond.
        for (column, channel) in inputs.iter_mut().zip(&experiment.inputs) {
            let entry = channel.input.and_then(|name| (model?.declaration)().by_name(name));
            if let Some(entry) = entry {
                column.iter_mut().for_each(|x| *x = x.clamp(entry.row.min, entry.row.max));
            }
        }
        Ok(Drive { time, inputs, set, warm })
    }

    /// A run that was never driven: inputs by row, in SI units.
    pub fn of(time: Vec<f64>, inputs: Vec<Vec<f64>>) -> Drive {
        Drive { time, inputs, set: Vec::new(), warm: Vec::new() }
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
        Drive { inputs, ..self.clone() }
    }

    /// Inputs by row, in the experiment's order, in SI units: every one known at every row.
    pub fn inputs(&self) -> &[Vec<f64>] {
        &self.inputs
    }

    /// The same run with the noise of its inputs (standard deviations, in their order) smoothed out: each reading is the mean
    /// of the readings near it in time that its noise does not tell from it, so that steps stay steps. Of these means the same is
    /// taken once more over a longer reach, where they stand still: at rest noise would else be all that there is.
    pub fn smoothed(&self, noise: &[f64]) -> Drive {
        let smooth = |(column, sigma): (&Vec<f64>, &f64)| -> Vec<f64> {
            let once = means_of_alike(column, REACH, ALIKE * sigma);
            let left = sigma / ((2 * REACH + 1) as f64).sqrt();
            means_of_alike(&once, FAR, ALIKE * left)
        };
        Drive { inputs: self.inputs.iter().zip(noise).map(smooth).collect(), ..self.clone() }
    }

    /// Gives the inputs of a row to a model.
    pub fn hold(&self, model: &mut dyn Model, slots: &[Slot], row: usize) {
        for (input, slot) in self.inputs.iter().zip(slots) {
            model.set(*slot, input[row]);
        }
    }
}

/// The mean of each value and of its neighbours within `reach` rows, as far as they and all between are within `size` of it; as far on
/// one side as on the other, so that a ramp stays where it is.
fn means_of_alike(column: &[f64], reach: usize, size: f64) -> Vec<f64> {
    let mean = |row: usize| {
        let alike = |k: usize| (column[k] - column[row]).abs() <= size;
        let before = (1..=reach.min(row)).take_while(|k| alike(row - k)).count();
        let after = (1..=reach.min(column.len() - 1 - row)).take_while(|k| alike(row + k)).count();
        let both = before.min(after);
        let (from, to) = if both > 0 { (both, both) } else { (before, after) };
        let near = &column[row - from..=row + to];
        near.iter().sum::<f64>() / near.len() as f64
    };
    (0..column.len()).map(mean).collect()
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

    /// A bench of two rows, and a run as the text says it.
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
            // The winding's first reading comes later; it stands for the start.
            assert!((columns[0][0] - 333.15).abs() < 1e-6 && (columns[1][0] - 318.15).abs() < 1e-6);
        }
        // The nodes behind the same readings are others, and after hours an offset is what is left.
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
        // 10 W through the conductance, six time constants on.
        assert!((rise(0, &Override::default()) - 25.0).abs() < 0.1);
        assert!((rise(1, &Override::default()) - 50.0).abs() < 0.2);
        let slot = bench.declaration().by_name("conductance.G_still").unwrap().slot;
        let tried = Override { values: vec![(slot, 0.8)], terms: Vec::new() };
        assert!((rise(0, &tried) - 25.0).abs() < 0.1 && (rise(1, &tried) - 12.5).abs() < 0.1);
    }
}
