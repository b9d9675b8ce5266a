//! Mistakes in the columns of an experiment: units, signs, exchanged columns.

use super::super::ambient;
use super::conversions::{OTHER_SIDE, SIGN, type_mistakes, unit_mistakes};
use super::filters::{without_coupling, without_lag};
use super::supply::Supply;
use crate::experiment::{CELSIUS, Channel, Experiment, LONGEST_RUN, Start};
use crate::levels::{FACTOR, PART};
use physics::declare::Unit;

/// Hypothetical mistake: a change of the data.
#[derive(Clone, Debug, PartialEq)]
pub enum Mistake {
    /// Columns are converted by factor * x + offset, in SI units.
    Affine { columns: Vec<usize>, factor: f64, offset: f64, words: String },
    /// Two columns are exchanged.
    Swap(usize, usize),
    /// Temperature columns contain rises over ambient.
    Rise(Vec<usize>),
    /// Thermocouples with reversed wires: their rise over ambient, where the logger is, has the opposite sign.
    Reversed(Vec<usize>),
    /// Thermocouples at an input that is set to another type: their rise over ambient, where the logger is, is divided by this ratio.
    WrongType { columns: Vec<usize>, ratio: f64, words: String },
    /// The ambient sensor is heated by the motor; the first reading of a run is used as the ambient temperature.
    Heated(usize),
    /// An input was not measured: its column is constant. Its values are implied by an output, which is then no longer evidence.
    Unmeasured {
        /// The column of the input.
        column: usize,
        /// The column of the output.
        by: usize,
    },
    /// The current is that of the drive's supply.
    Supply(Supply),
    /// The voltage is that of the drive's supply, and varies little. The motor's is implied by an output, which is then no longer evidence.
    Bus {
        /// The column of the voltage, an input.
        voltage: usize,
        /// The column of the output.
        by: usize,
    },
    /// An input or an output was recorded without its sign.
    Magnitude(usize),
    /// An input was recorded behind a first-order lag with this time constant, s.
    Slow(usize, f64),
    /// A load was recorded behind AC coupling: what is left of it without a first-order lag with this time constant, s.
    Coupled(usize, f64),
    /// Times are multiplied by a factor: the unit, or none if the interval between the rows is another one.
    Time(f64, Option<&'static str>),
}

impl Mistake {
    /// The columns that it changes, inputs first.
    pub fn touches(&self) -> Vec<usize> {
        match self {
            Mistake::Affine { columns, .. }
            | Mistake::WrongType { columns, .. }
            | Mistake::Rise(columns)
            | Mistake::Reversed(columns) => columns.clone(),
            Mistake::Swap(a, b) => vec![*a, *b],
            Mistake::Heated(k) => vec![*k],
            Mistake::Unmeasured { column, by } | Mistake::Bus { voltage: column, by } => vec![*column, *by],
            Mistake::Supply(supply) => vec![supply.current],
            Mistake::Magnitude(k) | Mistake::Slow(k, _) | Mistake::Coupled(k, _) => vec![*k],
            Mistake::Time(..) => Vec::new(),
        }
    }

    /// Whether it changes the prediction, so that a simulation is needed: a mistake in an input, or in a thermometer from which a run starts.
    pub fn is_simulated(&self, experiment: &Experiment) -> bool {
        let is_warm = experiment.runs.iter().any(|run| run.start == Start::Measured);
        let is_start = |output: usize| is_warm && experiment.outputs[output].node().is_some();
        let changes = |k: &usize| k.checked_sub(experiment.inputs.len()).is_none_or(is_start);
        matches!(self, Mistake::Time(..)) || self.touches().iter().any(changes)
    }

    /// The output that implies an input, and is then no longer evidence.
    pub fn implied_by(&self) -> Option<usize> {
        match self {
            Mistake::Unmeasured { by, .. } | Mistake::Bus { by, .. } => Some(*by),
            _ => None,
        }
    }

    /// Whether it contradicts only the rows after changes of the load, so that the outputs agree in part: the fit decides.
    pub fn is_partial(&self) -> bool {
        matches!(self, Mistake::Slow(..))
    }

    /// Sum of ln |dx/dy| over the outputs, y the readings as recorded and x the corrected ones.
    pub fn stretch(&self, inputs: usize) -> f64 {
        let (columns, factor) = match self {
            Mistake::Affine { columns, factor, .. } => (columns, factor.abs()),
            Mistake::WrongType { columns, ratio, .. } => (columns, 1.0 / ratio),
            Mistake::Supply(supply) if supply.current >= inputs => return supply.stretch,
            _ => return 0.0,
        };
        columns.iter().filter(|k| **k >= inputs).count() as f64 * factor.ln()
    }

    /// Whether both are factors that differ by less than a missing effect or a gain does.
    pub fn is_near(&self, other: &Mistake) -> bool {
        match (self, other) {
            (Mistake::Affine { factor: a, .. }, Mistake::Affine { factor: b, .. }) => {
                (1.0 / (1.0 + PART)..=1.0 + PART).contains(&(a / b))
            }
            _ => false,
        }
    }

    /// Factor by which the data as they are have to deviate more. No effect makes an output respond before its cause, so that a lag of an
    /// input only has to account for more than it leaves.
    pub fn factor(&self) -> f64 {
        if self.is_partial() { 2.0 } else { FACTOR }
    }

    /// Whether it hardly changes the shapes: two thermometers of the motor exchanged, an ambient temperature that rises with the motor, or
    /// another level.
    pub fn is_alike(&self, experiment: &Experiment) -> bool {
        let (all, inputs) = (channels(experiment), experiment.inputs.len());
        let is_thermometer = |k: usize| k >= inputs && all[k].is_temperature();
        match self {
            Mistake::Swap(a, b) => is_thermometer(*a) && is_thermometer(*b),
            Mistake::Heated(_) => true,
            _ => self.is_level(experiment),
        }
    }

    /// Whether it changes temperatures only.
    pub fn is_of_temperatures(&self, experiment: &Experiment) -> bool {
        let (all, touches) = (channels(experiment), self.touches());
        !touches.is_empty() && touches.iter().all(|k| all[*k].is_temperature())
    }

    /// Whether it is a unit in which the column may be recorded.
    pub fn is_plain(&self) -> bool {
        self.change().is_some_and(|words| words.starts_with("readings in ") || words.contains(OTHER_SIDE))
    }

    /// Whether it is one of the level: another unit or sign of several temperatures, or of any where a run does not start at the ambient one.
    /// Other factors of all temperatures are hardly different from other heat capacities.
    pub fn is_level(&self, experiment: &Experiment) -> bool {
        let columns = match self {
            Mistake::Affine { columns, words, .. } if self.is_plain() || words == SIGN => columns,
            Mistake::Rise(columns) | Mistake::Reversed(columns) => columns,
            _ => return false,
        };
        let is_warm = || experiment.runs.iter().any(|run| run.start == Start::Measured);
        self.is_of_temperatures(experiment) && (columns.len() > 1 || is_warm())
    }

    /// Whether the readings permit it: those of a heated ambient sensor rise and fall with a temperature of the motor, so that a common
    /// fraction of its change explains more of their change than it leaves.
    pub fn is_permitted(&self, experiment: &Experiment, runs: &[usize]) -> bool {
        let Mistake::Heated(ambient) = self else { return true };
        let inputs = experiment.inputs.len();
        let thermometers = experiment.outputs.iter().enumerate().filter(|(_, one)| one.is_temperature());
        thermometers.map(|(k, _)| inputs + k).any(|motor| {
            let (mut own, mut both, mut heating) = (0.0, 0.0, 0.0);
            for columns in runs.iter().map(|run| &experiment.runs[*run].table.columns) {
                let pairs = || columns[*ambient].iter().zip(&columns[motor]);
                let Some((x0, z0)) = pairs().find(|(x, z)| x.is_finite() && z.is_finite()) else { continue };
                for (x, z) in pairs().map(|(x, z)| (x - x0, z - z0)).filter(|(x, z)| (x + z).is_finite()) {
                    own += x * x;
                    both += x * z;
                    heating += z * z;
                }
            }
            both > 0.0 && 2.0 * both * both > own * heating
        })
    }

    /// Corrects it in some runs.
    pub fn apply(&self, experiment: &mut Experiment, runs: &[usize]) {
        let ambients: Vec<Vec<f64>> =
            runs.iter().map(|r| ambient(experiment, &experiment.runs[*r])).collect();
        for (run, ambient) in runs.iter().zip(ambients) {
            let table = &mut experiment.runs[*run].table;
            match self {
                Mistake::Affine { columns, factor, offset, .. } => columns
                    .iter()
                    .for_each(|k| table.columns[*k].iter_mut().for_each(|x| *x = factor * *x + offset)),
                Mistake::Swap(a, b) => table.columns.swap(*a, *b),
                Mistake::Rise(columns) => columns.iter().for_each(|k| {
                    table.columns[*k].iter_mut().zip(&ambient).for_each(|(x, t)| *x += t - CELSIUS);
                }),
                Mistake::Reversed(columns) => columns.iter().for_each(|k| {
                    table.columns[*k].iter_mut().zip(&ambient).for_each(|(x, t)| *x = 2.0 * t - *x);
                }),
                Mistake::WrongType { columns, ratio, .. } => columns.iter().for_each(|k| {
                    table.columns[*k].iter_mut().zip(&ambient).for_each(|(x, t)| *x = t + (*x - t) / ratio);
                }),
                Mistake::Heated(k) => {
                    let column = &mut table.columns[*k];
                    let first = column.iter().copied().find(|x| x.is_finite()).unwrap_or(f64::NAN);
                    column.fill(first);
                }
                // The values require the model: `super::unmeasured`.
                Mistake::Unmeasured { .. } | Mistake::Bus { .. } | Mistake::Magnitude(_) => {}
                Mistake::Supply(supply) => supply.apply(&mut table.columns, experiment.inputs.len()),
                Mistake::Slow(k, tau) => {
                    table.columns[*k] = without_lag(&table.time, &table.columns[*k], *tau)
                }
                Mistake::Coupled(k, tau) => {
                    table.columns[*k] = without_coupling(&table.time, &table.columns[*k], *tau)
                }
                Mistake::Time(factor, _) => {
                    let first = table.time[0];
                    table.time.iter_mut().for_each(|t| *t = first + factor * (*t - first));
                }
            }
        }
    }

    /// Change of the readings in words, if it is one of a unit, a factor or a sign.
    pub fn change(&self) -> Option<&str> {
        match self {
            Mistake::Affine { words, .. } | Mistake::WrongType { words, .. } => Some(words),
            _ => None,
        }
    }

    /// Faulty channel, reason and suggested correction.
    pub fn words(&self, experiment: &Experiment, files: &str) -> (String, String, String) {
        let name = |k: usize| channels(experiment)[k].column.to_string();
        let names = |columns: &[usize]| {
            let all: Vec<String> = columns.iter().map(|k| name(*k)).collect();
            (all.first().cloned().unwrap_or_default(), all.join(", "))
        };
        match self {
            Mistake::Affine { columns, words, .. } => {
                let (first, all) = names(columns);
                (
                    first,
                    format!("{all} in {files} {} the model; {words} would agree", contradict(columns)),
                    format!("check unit and sign of {all}; [columns] states the unit of a column"),
                )
            }
            Mistake::WrongType { columns, words, .. } => {
                let (first, all) = names(columns);
                (
                    first,
                    format!("{all} in {files} {} the model; {words} would agree", contradict(columns)),
                    format!("check the thermocouple type that the input of {all} is set to"),
                )
            }
            Mistake::Swap(a, b) => {
                let (a, b) = (name(*a), name(*b));
                let reason = format!(
                    "{a} and {b} in {files} contradict the model; with the two columns exchanged they would agree"
                );
                (a.clone(), reason, format!("exchange the columns {a} and {b}"))
            }
            Mistake::Rise(columns) => {
                let (first, all) = names(columns);
                let reason = format!(
                    "{all} in {files} {} the model; as temperature rises over ambient the readings would agree",
                    contradict(columns)
                );
                (first, reason, format!("add the ambient temperature to {all}"))
            }
            Mistake::Reversed(columns) => {
                let (first, all) = names(columns);
                let reason = format!(
                    "{all} in {files} {} the model; with the opposite sign of the rise over ambient the readings would agree",
                    contradict(columns)
                );
                (first, reason, format!("exchange the wires of the thermocouple of {all}"))
            }
            Mistake::Heated(k) => {
                let reason = format!(
                    "{} in {files} rises with the motor and contradicts the model; the first reading of each run, held constant, would agree",
                    name(*k)
                );
                let suggestion = "measure the ambient temperature where the motor does not heat the sensor";
                (name(*k), reason, suggestion.to_string())
            }
            Mistake::Unmeasured { column, by } => {
                let reason = format!(
                    "{} in {files} is constant and contradicts {}; all other outputs agree better with the values that {1} implies",
                    name(*column),
                    name(*by)
                );
                (name(*column), reason, format!("check whether {} was measured", name(*column)))
            }
            Mistake::Supply(supply) => supply.words(&name, files),
            Mistake::Bus { voltage, by } => {
                let (voltage, by) = (name(*voltage), name(*by));
                let reason = format!(
                    "{voltage} in {files} hardly varies, as the voltage of the drive's supply (bus voltage) does; all outputs but {by} agree \
                     better with the voltage of the motor that {by} implies"
                );
                (voltage, reason, "record the voltage at the terminals of the motor".to_string())
            }
            Mistake::Magnitude(k) => {
                let reason = format!(
                    "{} in {files} is never negative, but for noise, and contradicts the model; the same magnitude with both signs would agree",
                    name(*k)
                );
                (name(*k), reason, format!("record {} with its sign", name(*k)))
            }
            Mistake::Slow(k, tau) => {
                let reason = format!(
                    "{} in {files} contradicts the model; without a first-order lag of about {tau:.1} s (averaging) it would agree",
                    name(*k)
                );
                (name(*k), reason, format!("record {} without averaging", name(*k)))
            }
            Mistake::Coupled(k, tau) => {
                let reason = format!(
                    "{} in {files} contradicts the model; without a high-pass filter (AC coupling) of about {tau:.1} s it would agree",
                    name(*k)
                );
                (name(*k), reason, format!("record {} with DC coupling", name(*k)))
            }
            Mistake::Time(factor, None) => {
                let reason = format!(
                    "time_s in {files} contradicts the model and the other runs; times multiplied by {factor:.3} would agree"
                );
                ("time_s".to_string(), reason, "check the sampling interval of the file".to_string())
            }
            Mistake::Time(_, Some(unit)) => {
                let reason = format!("time_s in {files} contradicts the model; times in {unit} would agree");
                (
                    "time_s".to_string(),
                    reason,
                    format!(
                        "[columns] states the unit of the time: {{ name = \"time\", unit = \"{unit}\" }}"
                    ),
                )
            }
        }
    }
}

fn contradict(columns: &[usize]) -> &'static str {
    if columns.len() == 1 { "contradicts" } else { "contradict" }
}

/// The columns of inputs and outputs, in their order.
pub fn channels(experiment: &Experiment) -> Vec<&'static Channel> {
    experiment.inputs.iter().chain(&experiment.outputs).copied().collect()
}

/// Longest lag of an input, and time constant of the AC coupling of an output, that is tried, as a fraction of the run. Limit: the readings
/// behind a longer lag are nearly constant, and the time constant of a housing is not much shorter than a run: an effect that follows its
/// temperature looks like a slower high-pass filter of an output.
const SLOWEST: f64 = 0.1;

/// Least time constant of AC coupling that is tried, in rows. Numerical: a shorter one leaves a reading or none of a change.
const SHORTEST: f64 = 0.25;

/// Ratio of two time constants of AC coupling that are tried. Numerical: what is added to the readings is then known to 9 %.
const FINE: f64 = 1.19;

/// Units of the time, in s. Definition: of the units; loggers count periods of the mains and ticks of tens of milliseconds, too.
const TIMES: [(f64, &str); 8] = [
    (1e-3, "ms"),
    (60.0, "min"),
    (3600.0, "h"),
    (86_400.0, "d"),
    (1e-6, "us"),
    (1e3, "ks"),
    (1e-2, "1/100 s"),
    (1.0 / 60.0, "1/60 s"),
];

/// Mistakes of thermocouples that share a logger. A small factor of a single one is also that of a stem loss of another one.
fn of_thermocouples(columns: &[usize]) -> Vec<Mistake> {
    let least = if columns.len() > 1 { 1.0 } else { 1.0 + PART };
    let types = type_mistakes().into_iter().filter(|(ratio, _)| *ratio > least);
    let of = |(ratio, words)| Mistake::WrongType { columns: columns.to_vec(), ratio, words };
    let mut found: Vec<Mistake> = types.map(of).collect();
    found.extend([Mistake::Rise(columns.to_vec()), Mistake::Reversed(columns.to_vec())]);
    found
}

/// All mistakes that involve these columns only.
pub fn mistakes(experiment: &Experiment) -> Vec<Mistake> {
    let all = channels(experiment);
    let mut found = Vec::new();
    let mut quantities: Vec<Unit> = Vec::new();
    let longest = experiment.runs.iter().map(|run| &run.table);
    let longest = longest.max_by(|a, b| a.span().total_cmp(&b.span()));
    for (factor, unit) in TIMES {
        if longest.is_none_or(|table| factor * table.span() < LONGEST_RUN) {
            found.push(Mistake::Time(factor, Some(unit)));
        }
    }
    for (k, channel) in all.iter().enumerate() {
        // Commands and pressures are covered by their limits.
        let units =
            if matches!(channel.unit, Unit::One | Unit::Pascal) { Unit::PerKelvin } else { channel.unit };
        for (factor, offset, words) in unit_mistakes(units) {
            found.push(Mistake::Affine { columns: vec![k], factor, offset, words });
        }
        if channel.is_temperature() {
            match channel.input {
                Some(_) => found.push(Mistake::Heated(k)),
                None => found.extend(of_thermocouples(&[k])),
            }
        }
        if channel.unit == Unit::One {
            let words = "one minus the readings".to_string();
            found.push(Mistake::Affine { columns: vec![k], factor: -1.0, offset: 1.0, words });
        }
        found.extend((0..k).map(|other| Mistake::Swap(other, k)));
        let is_load = !channel.is_temperature() && !matches!(channel.unit, Unit::One | Unit::Pascal);
        if let Some(table) = longest.filter(|_| is_load) {
            let whole = table.span();
            let row = whole / table.time.len() as f64;
            let taus = |from: f64, by: f64, to: f64| {
                std::iter::successors(Some(from), move |tau| Some(by * tau)).take_while(move |tau| *tau < to)
            };
            let is_input = k < experiment.inputs.len();
            if is_input {
                found.extend(taus(row, 2.0, SLOWEST * whole).map(|tau| Mistake::Slow(k, tau)));
            }
            let slowest = if is_input { whole } else { SLOWEST * whole };
            found.extend(taus(SHORTEST * row, FINE, slowest).map(|tau| Mistake::Coupled(k, tau)));
        }
        if !quantities.contains(&channel.unit) {
            quantities.push(channel.unit);
        }
    }
    // Columns of one quantity usually come from one logger; the ambient temperature may come from another one.
    for unit in quantities {
        let columns: Vec<usize> = (0..all.len()).filter(|k| all[*k].unit == unit).collect();
        let of_motor: Vec<usize> = columns.iter().copied().filter(|k| !all[*k].is_ambient()).collect();
        let is_other = unit == Unit::Kelvin && of_motor.len() > 1;
        if is_other {
            found.extend(of_thermocouples(&of_motor));
        }
        for columns in [columns, if is_other { of_motor } else { Vec::new() }] {
            if columns.len() > 1 {
                for (factor, offset, words) in unit_mistakes(unit) {
                    found.push(Mistake::Affine { columns: columns.clone(), factor, offset, words });
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    /// The temperature of a room that follows the motor may be that of a heated sensor; one that falls or returns while the motor warms up
    /// is not.
    #[test]
    fn a_heated_ambient_sensor_follows_the_motor() {
        let rise = |k: usize| 30.0 * (1.0 - (-(k as f64) / 200.0).exp());
        let permitted = |ambient: &dyn Fn(usize) -> f64| {
            let mut experiment = testing::experiment("", true);
            let inputs = experiment.inputs.len();
            let table = &mut experiment.runs[0].table;
            table.time = (0..600).map(|k| k as f64).collect();
            for (k, channel) in experiment.inputs.iter().chain(&experiment.outputs).enumerate() {
                let of = |row: usize| match channel.is_temperature() {
                    true if k < inputs => 296.0 + ambient(row),
                    true => 296.0 + rise(row),
                    false => 1.0,
                };
                table.columns[k] = (0..600).map(of).collect();
            }
            let column = experiment.inputs.iter().position(|c| c.is_temperature()).unwrap();
            Mistake::Heated(column).is_permitted(&experiment, &[0])
        };
        assert!(permitted(&|k| 0.5 * rise(k)));
        assert!(permitted(&|k| 0.5 * rise(k.saturating_sub(100))), "a sensor that lags");
        assert!(!permitted(&|k| -0.1 * rise(k)));
        assert!(!permitted(&|k| 2.0 * (k as f64 / 60.0).sin()));
    }
}
