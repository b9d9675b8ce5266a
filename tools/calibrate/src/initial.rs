//! Initial temperatures of a run that starts at measured temperatures: the parameters `initial.*` of a model. An FMU can start in the
//! same state.
//!
//! One reading has the noise of its sensor, and a sensor with a lag indicates the past. Both would be an error of the whole run. The
//! temperatures b that the sensors indicate at the start are therefore estimated from the first rows, by least squares:
//!
//! min over b of sum (y - f(b))^2 + e^2 |b - y0|^2,   f(b) = f(y0) + S (b - y0)                                    (1)
//!
//! y: readings, y0: the first of each sensor, f: model, S: its response to a start that is 1 K warmer. One step is sufficient, because
//! temperatures are almost linear in their initial values. The errors of a run count all rows, those of (1) included.
//!
//! Winding and housing without a reading in the run are unknown as well: in a motor that cools down, one differs from the other by many
//! kelvin, and shows in its readings. Their y0 is the temperature of the nearest node with readings. With a small e, b stays near y0 only
//! where the readings do not determine it: a node that has forgotten its start before the first reading.
//!
//! The lag of a term, such as the temperature of a mass that the model lacked, does not start at its driver's value either: a motor that
//! ran before has warm magnets. It is one more unknown of such a run, in units of a typical change of its driver, and y0 = 0. A law may
//! act on a voltage or a torque alone; then y are all outputs, each in units of its noise.
//! *Sources*: Ljung, System Identification, 2nd ed. (1999), section 10.1 (initial conditions as unknowns of a record); Hoerl, Kennard,
//! Technometrics 12 (1970) 55-67 (e: ridge regression).

pub mod columns;
pub mod lags;
#[cfg(test)]
mod tests;

use crate::CalibrateError;
use crate::experiment::{Channel, Experiment, Run};
use crate::levels::STRUCTURE;
use crate::overrides::Override;
use crate::simulate::{Bench, Drive, refused};
use columns::{Column, product, rows};
use nalgebra::{Cholesky, DMatrix, DVector};
use physics::model::{Declaration, Entry, Model, Slot};
use physics::terms::Driver;

/// Tolerance between a sensor's indicated initial temperature and the one required, K. Numerical: no thermometer resolves it.
const SHOWN: f64 = 1e-9;
/// Iteration limit for the initial temperatures. Numerical: with a stem loss of one half, 50 iterations leave 1e-15 of the error.
const TRIES: usize = 50;
/// The rows of (1) have the first one of so many readings of each sensor. Derivation: two unknowns estimated from a twentieth of n readings
/// increase the error of the run by the square root of 1 + 40/n, which is 2 % for 1000 readings, and 95 % of the readings are free of them.
pub const PART: usize = 20;
/// e of (1). Derivation: the noise of a thermometer, 0.05 K, in a difference between nodes of 50 K.
const RIDGE: f64 = 1e-3;
/// Difference of the initial temperatures for S, K. Numerical: a temperature difference over which conductances hardly change.
const WARMER: f64 = 1.0;

/// A node that does not start at the ambient temperature, and its sensor.
#[derive(Clone, Debug)]
pub struct Warm {
    /// The output of its temperature.
    pub node: &'static str,
    /// The index of the sensor among the outputs of the experiment; `None` without one.
    pub output: Option<usize>,
    /// y0 of (1), K.
    first: f64,
    /// Readings of the rows of (1), K; NaN where there is none. Empty without a sensor.
    readings: Vec<f64>,
}

/// Initial values of the fast states of a run, current and speed, in SI units: the readings in its first row. A motor that is already running
/// there would otherwise start at rest. Values in `[set]` replace them, and readings that are missing leave the model's start value.
pub fn measured<'a>(experiment: &'a Experiment, run: &'a Run) -> impl Iterator<Item = (Slot, f64)> + 'a {
    let declaration = physics::models::by_name(&experiment.model).map(|model| (model.declaration)());
    let first = run.table.columns.iter().skip(experiment.inputs.len()).map(|column| column[0]);
    let fast = experiment.outputs.iter().zip(first);
    fast.filter(|(channel, reading)| !channel.is_temperature() && reading.is_finite()).filter_map(
        move |(channel, reading)| {
            let entry = declaration?.by_name(&format!("initial.{}", channel.output?))?;
            let is_set = experiment.set.iter().any(|(name, _)| *name == entry.name);
            (!is_set).then(|| (entry.slot, reading.clamp(entry.row.min, entry.row.max)))
        },
    )
}

/// The unknown starts of a run that starts at measured temperatures. If a node has several sensors, the first applies.
pub fn sensors(experiment: &Experiment, run: &Run) -> Vec<Warm> {
    let mut all: Vec<Warm> = Vec::new();
    for (output, channel) in experiment.outputs.iter().enumerate() {
        let column = &run.table.columns[experiment.place_of(output)];
        let first = column.iter().copied().find(|v| v.is_finite());
        let node = channel.node().filter(|node| all.iter().all(|known| known.node != *node));
        let readings = column[..rows(column)].to_vec();
        let output = Some(output);
        all.extend(node.zip(first).map(|(node, first)| Warm { node, output, first, readings }));
    }
    let known: Vec<(&str, f64)> = all.iter().map(|sensor| (sensor.node, sensor.first)).collect();
    let Some(model) = physics::models::by_name(&experiment.model) else { return all };
    let nodes = nodes((model.declaration)());
    let starts = temperatures(&nodes, &known);
    for node in Driver::ALL.iter().filter_map(|driver| Channel::reading(*driver)?.node()) {
        let entry = nodes.iter().find(|entry| entry.row.name == node);
        let start = entry.and_then(|entry| starts.iter().find(|(slot, _)| *slot == entry.slot));
        if let Some((_, first)) = start.filter(|_| known.iter().all(|(measured, _)| *measured != node)) {
            all.push(Warm { node, output: None, first: *first, readings: Vec::new() });
        }
    }
    all
}

/// Readings by output and row, with their standard deviations.
pub type Foretold = Vec<(usize, Vec<(f64, f64)>)>;

/// Values at the rows of (1), by column and row.
type Shown = Vec<Vec<f64>>;

/// A solution of (1).
struct Estimate {
    /// Unknowns about which the temperatures are linear, with the lags of the solution.
    at: Vec<f64>,
    /// Step of the temperatures from there.
    step: DVector<f64>,
    /// What the sensors show without it.
    shown: Shown,
    starts: Starts,
    readings: Shown,
}

impl Estimate {
    /// The unknowns.
    fn solved(&self) -> Vec<f64> {
        let steps = self.step.iter().copied().chain(std::iter::repeat(0.0));
        self.at.iter().zip(steps).map(|(at, step)| at + step).collect()
    }
}

/// Normal equations of (1): the rows with readings, and the responses to a warmer start.
#[derive(Clone, Debug)]
pub struct Starts {
    columns: Vec<Column>,
    /// Response of these columns at the rows of (1), by unknown (the nodes, then the lags), column and row.
    responses: Vec<Vec<Vec<f64>>>,
    normal: Cholesky<f64, nalgebra::Dyn>,
}

impl Starts {
    /// With e of (1) for the lags, if they are among the unknowns; `None` if the readings do not determine the start.
    pub fn new(columns: &[Column], responses: Vec<Shown>, of_lags: &[f64]) -> Option<Starts> {
        let (nodes, k) = (responses.len() - of_lags.len(), responses.len());
        let mut normal = DMatrix::from_fn(k, k, |a, b| product(columns, &responses[a], &responses[b]));
        // A thermometer whose start shows nowhere is of a node that the model has in another mode: the first readings stand.
        if (0..nodes).any(|node| columns[node].output.is_some() && normal[(node, node)] == 0.0) {
            return None;
        }
        for unknown in 0..k {
            let ridge = unknown.checked_sub(nodes).map_or(RIDGE, |lag| of_lags[lag]);
            normal[(unknown, unknown)] += ridge * ridge;
        }
        Some(Starts { normal: normal.cholesky()?, columns: columns.to_vec(), responses })
    }

    /// The columns.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Standard deviation of the prediction for a sensor and a row of (1), relative to the differences between the nodes: of a start that the
    /// readings determine within the structure error, and of the model.
    fn deviation(&self, sensor: usize, row: usize) -> f64 {
        let response =
            DVector::from_iterator(self.responses.len(), self.responses.iter().map(|of| of[sensor][row]));
        STRUCTURE * (1.0 + response.dot(&self.normal.solve(&response))).sqrt()
    }

    /// What such a deviation leaves of (1).
    fn left(&self, deviation: &[Vec<f64>]) -> f64 {
        let right = self.right(deviation);
        product(&self.columns, deviation, deviation) - right.dot(&self.normal.solve(&right))
    }

    /// Change of the unknowns that explains a deviation of the sensors (by sensor and row) best.
    pub fn explaining(&self, deviation: &[Vec<f64>]) -> DVector<f64> {
        self.normal.solve(&self.right(deviation))
    }

    /// Right side of the normal equations.
    fn right(&self, deviation: &[Vec<f64>]) -> DVector<f64> {
        let right = self.responses.iter().map(|response| product(&self.columns, response, deviation));
        DVector::from_iterator(self.responses.len(), right)
    }
}

impl Warm {
    /// Number of rows of (1).
    pub fn rows(&self) -> usize {
        self.readings.len()
    }
}

/// A model at the start of a run.
pub struct Started {
    /// The model.
    pub model: Box<dyn Model>,
    /// The unknowns of its start: temperatures that the sensors of [`Drive::warm`] indicate, K, then the lags of the terms that have one.
    pub unknowns: Vec<f64>,
    /// Initial temperatures of its nodes, K, and of its lags.
    pub initial: Vec<(Slot, f64)>,
}

impl Drive {
    /// y0 of (1); the lags start with their drivers in a run whose start is not estimated.
    fn first_unknowns(&self, change: &Override) -> Vec<f64> {
        let lags = change.lags().filter(|_| self.estimates_start());
        self.warm.iter().map(|sensor| sensor.first).chain(lags.map(|_| 0.0)).collect()
    }

    /// Perturbations of the unknowns with a change.
    pub fn ways(&self, change: &Override) -> Vec<f64> {
        self.warm.iter().map(|_| WARMER).chain(lags::ways(change)).collect()
    }

    /// Whether the run has enough rows for (1).
    pub fn estimates_start(&self) -> bool {
        self.warm.iter().any(|sensor| sensor.rows() > 1)
    }
}

impl Bench {
    /// A model at the start of a run: the sensors of [`Drive::warm`] indicate what (1) gives; the first readings where (1) has no solution,
    /// or one that the model refuses.
    ///
    /// # Errors
    /// The message of the model if it cannot start.
    pub fn started(&self, drive: &Drive, change: &Override) -> Result<Started, CalibrateError> {
        let solved = self.estimated_start(drive, change)?;
        let solved = solved.and_then(|estimate| self.begin_at(drive, change, &estimate.solved()).ok());
        solved.map_or_else(|| self.begin_at(drive, change, &drive.first_unknowns(change)), Ok)
    }

    /// Readings of each sensor of [`Drive::warm`] over the rows of (1), K, with the standard deviation relative to the differences between the
    /// nodes, by output; `None` if the start is not estimated.
    ///
    /// # Errors
    /// The message of the model if it cannot start.
    pub fn foretold(&self, drive: &Drive, change: &Override) -> Result<Option<Foretold>, CalibrateError> {
        let Some(Estimate { step, shown, starts, .. }) = self.estimated_start(drive, change)? else {
            return Ok(None);
        };
        let of_row = |sensor: usize, row: usize| {
            let change = starts.responses.iter().zip(step.iter()).map(|(of, size)| of[sensor][row] * size);
            (shown[sensor][row] + change.sum::<f64>(), starts.deviation(sensor, row))
        };
        let of = |(k, sensor): (usize, &Warm)| {
            Some((sensor.output?, (0..shown[k].len()).map(|row| of_row(k, row)).collect()))
        };
        Ok(Some(drive.warm.iter().enumerate().filter_map(of).collect()))
    }

    /// The solution of (1); `None` if the start is not estimated.
    fn estimated_start(&self, drive: &Drive, change: &Override) -> Result<Option<Estimate>, CalibrateError> {
        if !drive.estimates_start() {
            return Ok(None);
        }
        let columns = drive.columns(change);
        let at = drive.first_unknowns(change);
        let Some(shown) = self.shown_at(drive, change, &columns, &at)? else { return Ok(None) };
        let mut responses = Vec::with_capacity(drive.warm.len());
        for k in 0..drive.warm.len() {
            let Some(response) = self.start_response(drive, change, &columns, (&at, &shown), (k, WARMER))?
            else {
                return Ok(None);
            };
            responses.push(response);
        }
        let readings: Shown = columns.iter().map(|column| column.readings.clone()).collect();
        let Some(starts) = Starts::new(&columns, responses, &[]) else { return Ok(None) };
        let step = starts.explaining(&differences(&readings, &shown, 1.0));
        let nodes = Estimate { at, step, shown, starts, readings };
        let has_lags = change.lags().next().is_some();
        Ok(Some(if has_lags { self.with_lags(drive, change, nodes)? } else { nodes }))
    }

    /// Response of the columns to an unknown that is greater by `way` than `at`, where they show `shown`; `None` if the model ends within the
    /// rows of (1).
    fn start_response(
        &self,
        drive: &Drive,
        change: &Override,
        columns: &[Column],
        (at, shown): (&[f64], &Shown),
        (unknown, way): (usize, f64),
    ) -> Result<Option<Shown>, CalibrateError> {
        let mut moved = at.to_vec();
        moved[unknown] += way;
        Ok(self.shown_at(drive, change, columns, &moved)?.map(|there| differences(&there, shown, way)))
    }

    /// The columns of (1) as the model has them; `None` if the model ends within the rows.
    fn shown_at(
        &self,
        drive: &Drive,
        change: &Override,
        columns: &[Column],
        unknowns: &[f64],
    ) -> Result<Option<Shown>, CalibrateError> {
        let mut model = self.begin_at(drive, change, unknowns)?.model;
        // The start of a run is the same for every accuracy of its simulation.
        model.ease([1.0; 2]);
        let rows = columns.iter().map(|column| column.readings.len()).max().unwrap_or(0);
        let mut shown = vec![Vec::with_capacity(rows); columns.len()];
        let ending = self.along_rows(drive, rows, model.as_mut(), |model, _| {
            for (shown, column) in shown.iter_mut().zip(columns) {
                shown.extend(column.output.map(|output| column.of(model.get(self.outputs()[output]))));
            }
        })?;
        Ok(ending.is_none().then_some(shown))
    }

    /// Initialises a model for a run so that the sensors of [`Drive::warm`] indicate these temperatures. A sensor with an offset or a stem
    /// loss does not indicate its node's temperature, so each initial temperature is corrected iteratively by the deviation of its sensor,
    /// as far as the model accepts it: with a steep law of the sensor the iteration may diverge. Returns the initial temperatures.
    ///
    /// # Errors
    /// The message of the model if it cannot start.
    pub fn start(
        &self,
        model: &mut dyn Model,
        drive: &Drive,
        indicated: &[f64],
    ) -> Result<Vec<(Slot, f64)>, CalibrateError> {
        let mut known: Vec<(&str, f64)> =
            drive.warm.iter().zip(indicated).map(|(sensor, value)| (sensor.node, *value)).collect();
        let nodes = nodes(model.declaration());
        let mut tries = 0;
        let mut accepted: Option<Vec<(Slot, f64)>> = None;
        loop {
            let initial = temperatures(&nodes, &known);
            if let Err(fault) = model.start_with(&initial, drive.time[0]) {
                let last = accepted.ok_or_else(|| refused(fault))?;
                model.start_with(&last, drive.time[0]).map_err(refused)?;
                return Ok(last);
            }
            let mut worst = 0.0f64;
            for ((_, at), (sensor, value)) in known.iter_mut().zip(drive.warm.iter().zip(indicated)) {
                let Some(output) = sensor.output else { continue };
                let off = value - model.get(self.outputs()[output]);
                *at += off;
                worst = worst.max(off.abs());
            }
            tries += 1;
            if worst <= SHOWN || tries == TRIES {
                return Ok(initial);
            }
            accepted = Some(initial);
        }
    }
}

/// (a - b) / by, by sensor and row.
fn differences(a: &[Vec<f64>], b: &[Vec<f64>], by: f64) -> Vec<Vec<f64>> {
    let of_sensor = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| (a - b) / by).collect();
    a.iter().zip(b).map(of_sensor).collect()
}

/// The initial temperatures of the nodes of a model.
pub fn nodes(declaration: &Declaration) -> Vec<&Entry> {
    declaration.entries.iter().filter(|entry| !entry.row.near.is_empty()).collect()
}

/// The initial temperatures of these nodes given these measured temperatures by the name of their output, K; empty if none is given. A
/// node starts at its own temperature, else at the nearest one that is measured ([`near`](physics::declare::Variable::near)).
pub fn temperatures(nodes: &[&Entry], known: &[(&str, f64)]) -> Vec<(Slot, f64)> {
    let of = |name: &str| known.iter().find(|(output, _)| *output == name).map(|(_, value)| *value);
    // 0 K is reserved as "ambient temperature".
    let inside = |value: f64, entry: &Entry| value.clamp(f64::MIN_POSITIVE, entry.row.max);
    let start = |entry: &&Entry| {
        let value = of(entry.row.name).or_else(|| entry.row.near.iter().find_map(|name| of(name)))?;
        Some((entry.slot, inside(value, entry)))
    };
    nodes.iter().filter_map(start).collect()
}
