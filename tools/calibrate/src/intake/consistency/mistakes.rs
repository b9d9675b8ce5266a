//! Mistakes in the columns of an experiment: units, signs, exchanged columns.

use super::super::ambient;
use crate::experiment::units::{names, units};
use crate::experiment::{CELSIUS, Channel, Experiment};
use crate::levels::{FACTOR, PART};
use physics::declare::Unit;

/// Hypothetical mistake: a change of the data.
#[derive(Clone, Debug)]
pub enum Mistake {
    /// Columns are converted by factor * x + offset, in SI units.
    Affine { columns: Vec<usize>, factor: f64, offset: f64, words: String },
    /// Two columns are exchanged.
    Swap(usize, usize),
    /// A temperature column contains rises over ambient.
    Rise(usize),
    /// The ambient sensor is heated by the motor; the first reading of a run is used as the ambient temperature.
    Heated(usize),
    /// An input was not measured: its column is constant. Its values are implied by an output, which is then no longer evidence.
    Unmeasured {
        /// The column of the input.
        column: usize,
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
            Mistake::Affine { columns, .. } => columns.clone(),
            Mistake::Swap(a, b) => vec![*a, *b],
            Mistake::Rise(k) | Mistake::Heated(k) => vec![*k],
            Mistake::Unmeasured { column, by } => vec![*column, *by],
            Mistake::Magnitude(k) | Mistake::Slow(k, _) | Mistake::Coupled(k, _) => vec![*k],
            Mistake::Time(..) => Vec::new(),
        }
    }

    /// Whether it changes the prediction, so that a simulation is needed.
    pub fn is_simulated(&self, inputs: usize) -> bool {
        matches!(self, Mistake::Time(..)) || self.touches().iter().any(|k| *k < inputs)
    }

    /// Whether it contradicts only the rows after changes of the load, so that the outputs agree in part: the fit decides.
    pub fn is_partial(&self) -> bool {
        matches!(self, Mistake::Slow(..))
    }

    /// Factor by which the data as they are have to deviate more. No effect makes an output respond before its cause, so that a lag of an
    /// input only has to account for more than it leaves.
    pub fn factor(&self) -> f64 {
        if self.is_partial() { 2.0 } else { FACTOR }
    }

    /// Whether it hardly changes the shapes: two thermometers of the motor exchanged, all temperatures in another unit, or an ambient
    /// temperature that rises with the motor.
    pub fn is_alike(&self, experiment: &Experiment) -> bool {
        let all = channels(experiment);
        let inputs = experiment.inputs.len();
        let is_warm = |k: &usize| all[*k].is_temperature();
        match self {
            Mistake::Swap(a, b) => *a >= inputs && *b >= inputs && is_warm(a) && is_warm(b),
            Mistake::Affine { columns, words, .. } => {
                columns.len() > 1 && columns.iter().all(is_warm) && words.starts_with("readings in ")
            }
            Mistake::Heated(_) => true,
            _ => false,
        }
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
                Mistake::Rise(k) => {
                    let of = table.columns[*k].iter_mut().zip(ambient);
                    of.for_each(|(x, t)| *x += t - CELSIUS);
                }
                Mistake::Heated(k) => {
                    let column = &mut table.columns[*k];
                    let first = column.iter().copied().find(|x| x.is_finite()).unwrap_or(f64::NAN);
                    column.fill(first);
                }
                // The values require the model: `super::unmeasured`.
                Mistake::Unmeasured { .. } | Mistake::Magnitude(_) => {}
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
            Mistake::Affine { words, .. } => Some(words),
            _ => None,
        }
    }

    /// Faulty channel, reason and suggested correction.
    pub fn words(&self, experiment: &Experiment, files: &str) -> (String, String, String) {
        let name = |k: usize| channels(experiment)[k].column.to_string();
        match self {
            Mistake::Affine { columns, words, .. } => {
                let names: Vec<String> = columns.iter().map(|k| name(*k)).collect();
                let all = names.join(", ");
                let first = names.into_iter().next().unwrap_or_default();
                (
                    first,
                    format!("{all} in {files} contradict the model, which {words} would agree with"),
                    format!("check unit and sign of {all}; [columns] states the unit of a column"),
                )
            }
            Mistake::Swap(a, b) => {
                let (a, b) = (name(*a), name(*b));
                let reason = format!(
                    "{a} and {b} in {files} contradict the model, which the two columns exchanged would agree with"
                );
                (a.clone(), reason, format!("exchange the columns {a} and {b}"))
            }
            Mistake::Rise(k) => {
                let reason = format!(
                    "{} in {files} contradicts the model, which rises over ambient would agree with",
                    name(*k)
                );
                (name(*k), reason, "add the ambient temperature to the column".to_string())
            }
            Mistake::Heated(k) => {
                let reason = format!(
                    "{} in {files} rises with the motor and contradicts the model, which the first reading of each run would agree with",
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
            Mistake::Magnitude(k) => {
                let reason = format!(
                    "{} in {files} is never negative and contradicts the model, which the same magnitude with both signs would agree with",
                    name(*k)
                );
                (name(*k), reason, format!("record {} with its sign", name(*k)))
            }
            Mistake::Slow(k, tau) => {
                let reason = format!(
                    "{} in {files} contradicts the model, which it would agree with if it had passed a first-order lag of about {tau:.1} s",
                    name(*k)
                );
                (name(*k), reason, format!("record {} without averaging", name(*k)))
            }
            Mistake::Coupled(k, tau) => {
                let reason = format!(
                    "{} in {files} contradicts the model, which it would agree with if a high-pass filter (AC coupling) of about {tau:.1} s had \
                     removed its mean",
                    name(*k)
                );
                (name(*k), reason, format!("record {} with DC coupling", name(*k)))
            }
            Mistake::Time(factor, None) => {
                let reason = format!(
                    "time_s in {files} contradicts the model and the other runs, which times multiplied by {factor:.3} would agree with"
                );
                ("time_s".to_string(), reason, "check the sampling interval of the file".to_string())
            }
            Mistake::Time(_, Some(unit)) => {
                let reason = format!(
                    "time_s in {files} contradicts the model, which times in {unit} would agree with"
                );
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

fn channels(experiment: &Experiment) -> Vec<&'static Channel> {
    experiment.inputs.iter().chain(&experiment.outputs).copied().collect()
}

/// Two units with factors or offsets that differ by less are the same. Numerical: rounding of the factors.
const SAME: f64 = 1e-3;

/// Longest lag of an input, and time constant of the AC coupling of an output, that is tried, as a fraction of the run. Limit: the readings
/// behind a longer lag are nearly constant, and the time constant of a housing is not much shorter than a run: an effect that follows its
/// temperature looks like a slower high-pass filter of an output.
const SLOWEST: f64 = 0.1;

/// Least time constant of AC coupling that is tried, in rows. Numerical: a shorter one leaves a reading or none of a change.
const SHORTEST: f64 = 0.25;

/// Ratio of two time constants of AC coupling that are tried. Numerical: what is added to the readings is then known to 9 %.
const FINE: f64 = 1.19;

/// Minutes in a radian per second. Definition: 60 s / 2 pi.
const TURNS: f64 = 30.0 / std::f64::consts::PI;

/// Factor and offset in SI units of all unit mistakes for a quantity, with a description of the readings.
fn unit_mistakes(of: Unit) -> Vec<(f64, f64, String)> {
    let mut all: Vec<(f64, f64, String)> = Vec::new();
    let contract = |name: &str| match of {
        Unit::Kelvin => name == "degC",
        _ => names(of).first() == Some(&name),
    };
    let mut add = |factor: f64, offset: f64, words: String| {
        let same =
            |(a, b, _): &&(f64, f64, String)| (a / factor - 1.0).abs() < SAME && (b - offset).abs() < SAME;
        if !((factor - 1.0).abs() < SAME && offset.abs() < SAME) && all.iter().find(same).is_none() {
            all.push((factor, offset, words));
        }
    };
    let known = units(of);
    if known.is_empty() {
        return all;
    }
    add(-1.0, if of == Unit::Kelvin { 2.0 * CELSIUS } else { 0.0 }, "the opposite sign".to_string());
    // Mistakes from the contract's own unit come first: their description is the simplest.
    let pairs = || known.iter().flat_map(|stated| known.iter().map(move |meant| (stated, meant)));
    for plain in [true, false] {
        for ((as_stated, stated), (as_meant, meant)) in pairs().filter(|(s, _)| contract(s.0) == plain) {
            let factor = meant.factor / stated.factor;
            // Two foreign units that differ by less than a sensor's gain or a missing effect are no explanation of their own.
            if !plain && (1.0 / (1.0 + PART)..=1.0 + PART).contains(&factor) && of != Unit::Kelvin {
                continue;
            }
            let words = if plain {
                format!("readings in {as_meant}")
            } else {
                format!("readings times {factor:.4} (as of {as_meant} and {as_stated})")
            };
            add(factor, meant.offset - factor * stated.offset, words);
        }
    }
    if of == Unit::NewtonMetre {
        // P = 2 pi / 60 n M with the speed in 1/min, as in tables of machines.
        for factor in [TURNS, 1.0 / TURNS] {
            add(factor, 0.0, format!("readings times {factor:.4} (the factor 9.549 between N.m and W min)"));
        }
    }
    let powers: &[i32] =
        if of == Unit::Kelvin { &[-1, 1] } else { &[-6, -5, -4, -3, -2, -1, 1, 2, 3, 4, 5, 6] };
    for &power in powers {
        let factor = 10f64.powi(power);
        let offset = if of == Unit::Kelvin { CELSIUS * (1.0 - factor) } else { 0.0 };
        add(factor, offset, format!("readings times 1e{power}"));
    }
    if matches!(of, Unit::Volt | Unit::Ampere) {
        // Amplitude, root mean square and peak to peak; line and phase.
        for factor in [2f64.sqrt(), 3f64.sqrt(), 2.0, 8f64.sqrt(), 1.5, 6f64.sqrt()] {
            for factor in [factor, 1.0 / factor] {
                add(
                    factor,
                    0.0,
                    format!("readings times {factor:.4} (amplitude, root mean square; line, phase)"),
                );
            }
        }
    }
    if of == Unit::RadianPerSecond {
        // Electrical and mechanical speed of a motor with pole pairs.
        (2..=16).for_each(|pairs| add(1.0 / f64::from(pairs), 0.0, format!("speeds of {pairs} pole pairs")));
    }
    all
}

/// What a column was before a first-order lag, if it was constant between the rows: (x_k - a x_{k-1}) / (1 - a), a = exp(-h / tau). Blank
/// readings stay blank.
fn without_lag(time: &[f64], column: &[f64], tau: f64) -> Vec<f64> {
    let of = |k: usize| {
        let Some(before) = k.checked_sub(1).filter(|before| column[*before].is_finite()) else {
            return column[k];
        };
        let kept = ((time[before] - time[k]) / tau).exp();
        (column[k] - kept * column[before]) / (1.0 - kept)
    };
    (0..column.len()).map(of).collect()
}

/// What a column was before AC coupling, if it was at rest before the first row: x = y + z, dz/dt = y / tau. Blank readings stay blank.
fn without_coupling(time: &[f64], column: &[f64], tau: f64) -> Vec<f64> {
    let (mut removed, mut last) = (0.0, None);
    let of = |(t, y): (&f64, &f64)| {
        if y.is_finite() {
            let area = last.map_or(0.0, |(before, from): (f64, f64)| 0.5 * (before + y) * (t - from));
            removed += area / tau;
            last = Some((*y, *t));
        }
        y + removed
    };
    time.iter().zip(column).map(of).collect()
}

/// All mistakes that involve these columns only.
pub fn mistakes(experiment: &Experiment) -> Vec<Mistake> {
    let all = channels(experiment);
    let mut found = Vec::new();
    let mut quantities: Vec<Unit> = Vec::new();
    for (factor, unit) in
        [(1e-3, "ms"), (60.0, "min"), (3600.0, "h"), (1e-6, "us"), (1e3, "ks"), (1.0 / 60.0, "1/60 s")]
    {
        found.push(Mistake::Time(factor, Some(unit)));
    }
    let longest = experiment.runs.iter().map(|run| run.table.time.as_slice());
    let longest = longest.max_by(|a, b| (a[a.len() - 1] - a[0]).total_cmp(&(b[b.len() - 1] - b[0])));
    for (k, channel) in all.iter().enumerate() {
        // Commands and pressures are covered by their limits.
        let units =
            if matches!(channel.unit, Unit::One | Unit::Pascal) { Unit::PerKelvin } else { channel.unit };
        for (factor, offset, words) in unit_mistakes(units) {
            found.push(Mistake::Affine { columns: vec![k], factor, offset, words });
        }
        if channel.is_temperature() {
            found.push(if channel.input.is_some() { Mistake::Heated(k) } else { Mistake::Rise(k) });
        }
        found.extend((0..k).map(|other| Mistake::Swap(other, k)));
        let is_load = !channel.is_temperature() && !matches!(channel.unit, Unit::One | Unit::Pascal);
        if let Some(time) = longest.filter(|_| is_load) {
            let whole = time[time.len() - 1] - time[0];
            let row = whole / time.len() as f64;
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
    // Columns of one quantity usually come from one logger.
    for unit in quantities {
        let columns: Vec<usize> = (0..all.len()).filter(|k| all[*k].unit == unit).collect();
        if columns.len() > 1 {
            for (factor, offset, words) in unit_mistakes(unit) {
                found.push(Mistake::Affine { columns: columns.clone(), factor, offset, words });
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
