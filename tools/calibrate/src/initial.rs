//! Initial temperatures of a run that starts at measured temperatures: the parameters `initial.*` of a model. An FMU can start in the
//! same state.
//!
//! One reading has the noise of its sensor, and a sensor with a lag indicates the past. Both would be an error of the whole run. The
//! temperatures b that the sensors indicate at the start are therefore estimated from the first rows, by least squares:
//!
//! min over b of sum (y - f(b))^2,   f(b) = f(y0) + S (b - y0)                                                     (1)
//!
//! y: readings, y0: the first of each sensor, f: model, S: its response to a start that is 1 K warmer. One step is sufficient, because
//! temperatures are almost linear in their initial values. The errors of a run count all rows, those of (1) included.
//! *Source*: Ljung, System Identification, 2nd ed. (1999), section 10.1 (initial conditions as unknowns of a record).

use crate::CalibrateError;
use crate::experiment::{Experiment, Run};
use crate::overrides::Override;
use crate::simulate::{Bench, Drive, refused};
use nalgebra::{Cholesky, DMatrix, DVector};
use physics::model::{Declaration, Entry, Model, Slot};

/// Tolerance between a sensor's indicated initial temperature and the one required, K. Numerical: no thermometer resolves it.
const SHOWN: f64 = 1e-9;
/// Iteration limit for the initial temperatures. Numerical: with a stem loss of one half, 50 iterations leave 1e-15 of the error.
const TRIES: usize = 50;
/// The rows of (1) are one of so many. Derivation: two unknowns estimated from a twentieth of n rows increase the error of the run by the
/// square root of 1 + 40/n, which is 2 % for 1000 rows, and 95 % of the rows are free of them.
const PART: usize = 20;
/// Difference of the initial temperatures for S, K. Numerical: a temperature difference over which conductances hardly change.
pub const WARMER: f64 = 1.0;

/// A sensor of a node that does not start at the ambient temperature.
#[derive(Clone, Debug)]
pub struct Warm {
    /// The output it measures.
    pub node: &'static str,
    /// Its index among the outputs of the experiment.
    pub output: usize,
    /// The first reading, K.
    first: f64,
    /// Readings of the rows of (1), K; NaN where there is none.
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

/// The sensors of a run that starts at measured temperatures. If a node has several sensors, the first applies.
pub fn sensors(experiment: &Experiment, run: &Run) -> Vec<Warm> {
    let mut all: Vec<Warm> = Vec::new();
    for (output, channel) in experiment.outputs.iter().enumerate() {
        let column = &run.table.columns[experiment.inputs.len() + output];
        let first = column.iter().copied().find(|v| v.is_finite());
        let node = channel.node().filter(|node| all.iter().all(|known| known.node != *node));
        let readings = column[..column.len() / PART].to_vec();
        all.extend(node.zip(first).map(|(node, first)| Warm { node, output, first, readings }));
    }
    all
}

/// Normal equations of (1): the rows with readings, and the responses to a warmer start.
#[derive(Clone, Debug)]
pub struct Starts {
    warm: Vec<Warm>,
    /// Response of these sensors at the rows of (1), by sensor that starts warmer, sensor and row.
    responses: Vec<Vec<Vec<f64>>>,
    normal: Cholesky<f64, nalgebra::Dyn>,
}

impl Starts {
    /// `None` if the readings do not determine the start.
    pub fn new(warm: &[Warm], responses: Vec<Vec<Vec<f64>>>) -> Option<Starts> {
        let k = warm.len();
        let normal = DMatrix::from_fn(k, k, |a, b| product(warm, &responses[a], &responses[b]));
        Some(Starts { normal: normal.cholesky()?, warm: warm.to_vec(), responses })
    }

    /// The sensors.
    pub fn warm(&self) -> &[Warm] {
        &self.warm
    }

    /// Change of the initial temperatures that explains a deviation of the sensors (by sensor and row) best.
    pub fn explaining(&self, deviation: &[Vec<f64>]) -> DVector<f64> {
        let right = self.responses.iter().map(|response| product(&self.warm, response, deviation));
        self.normal.solve(&DVector::from_iterator(self.warm.len(), right))
    }
}

/// Sum of products over the rows of (1) that have a reading.
fn product(warm: &[Warm], a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let of_sensor = |((sensor, a), b): ((&Warm, &Vec<f64>), &Vec<f64>)| -> f64 {
        let rows = sensor.readings.iter().zip(a.iter().zip(b));
        rows.filter(|(reading, _)| reading.is_finite()).map(|(_, (a, b))| a * b).sum()
    };
    warm.iter().zip(a).zip(b).map(of_sensor).sum()
}

impl Warm {
    /// Number of rows of (1).
    pub fn rows(&self) -> usize {
        self.readings.len()
    }
}

impl Drive {
    /// Whether the run has enough rows for (1).
    pub fn estimates_start(&self) -> bool {
        self.warm.iter().any(|sensor| sensor.rows() > 1)
    }
}

impl Bench {
    /// Temperatures that the sensors of [`Drive::warm`] indicate at the start by (1), K; the first readings where (1) has no solution.
    ///
    /// # Errors
    /// The message of the model if it cannot start.
    pub fn first_readings(&self, drive: &Drive, change: &Override) -> Result<Vec<f64>, CalibrateError> {
        let warm = &drive.warm;
        let first: Vec<f64> = warm.iter().map(|sensor| sensor.first).collect();
        if !drive.estimates_start() {
            return Ok(first);
        }
        let Some(base) = self.shown_at(drive, change, &first)? else { return Ok(first) };
        let mut responses = Vec::with_capacity(warm.len());
        for k in 0..warm.len() {
            let mut warmer = first.clone();
            warmer[k] += WARMER;
            let Some(shown) = self.shown_at(drive, change, &warmer)? else { return Ok(first) };
            responses.push(differences(&shown, &base, WARMER));
        }
        let readings: Vec<Vec<f64>> = warm.iter().map(|sensor| sensor.readings.clone()).collect();
        let Some(starts) = Starts::new(warm, responses) else { return Ok(first) };
        let step = starts.explaining(&differences(&readings, &base, 1.0));
        Ok(first.iter().zip(step.iter()).map(|(first, step)| first + step).collect())
    }

    /// Outputs of the sensors of [`Drive::warm`] at the rows of (1), by sensor and row; `None` if the model ends within them.
    fn shown_at(
        &self,
        drive: &Drive,
        change: &Override,
        indicated: &[f64],
    ) -> Result<Option<Vec<Vec<f64>>>, CalibrateError> {
        let mut model = self.begin_at(drive, change, indicated)?;
        // The start of a run is the same for every accuracy of its simulation.
        model.ease(1.0);
        let rows = drive.warm.iter().map(Warm::rows).max().unwrap_or(0);
        let mut shown = vec![Vec::with_capacity(rows); drive.warm.len()];
        let ending = self.along_rows(drive, rows, model.as_mut(), |model, _| {
            for (column, sensor) in shown.iter_mut().zip(&drive.warm) {
                column.push(model.get(self.outputs()[sensor.output]));
            }
        })?;
        Ok(ending.is_none().then_some(shown))
    }

    /// Initialises a model for a run so that the sensors of [`Drive::warm`] indicate these temperatures. A sensor with an offset or a stem
    /// loss does not indicate its node's temperature, so each initial temperature is corrected iteratively by the deviation of its sensor.
    /// Returns the initial temperatures.
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
        loop {
            let initial = temperatures(&nodes, &known);
            model.start_with(&initial, drive.time[0]).map_err(refused)?;
            let mut worst = 0.0f64;
            for ((_, at), (sensor, value)) in known.iter_mut().zip(drive.warm.iter().zip(indicated)) {
                let off = value - model.get(self.outputs()[sensor.output]);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn named(model: &str, known: &[(&str, f64)]) -> Vec<(String, f64)> {
        let declaration = (physics::models::by_name(model).unwrap().declaration)();
        let name = |slot: Slot| declaration.entries.iter().find(|e| e.slot == slot).unwrap().name.clone();
        temperatures(&nodes(declaration), known)
            .into_iter()
            .map(|(slot, value)| (name(slot), value))
            .collect()
    }

    /// A motor that is running in the first row starts with the current of that row, unless `[set]` states another one.
    #[test]
    fn a_running_motor_does_not_start_at_rest() {
        let mut running = crate::testing::driven_by(("voltage_V", 1.0, 90.0), &["current_A"], "", true);
        let column = running.inputs.len();
        let start = |experiment: &Experiment| {
            let bench = Bench::new(experiment, &[]).unwrap();
            let drive = Drive::new(experiment, &experiment.runs[0]).unwrap();
            bench.run(&drive, &Override::default()).unwrap()[0][0]
        };
        assert_eq!(start(&running), 0.0, "no reading");
        running.runs[0].table.columns[column][0] = 3.0;
        assert_eq!(start(&running), 3.0);
        running.set.push(("initial.current".to_string(), 1.0));
        assert_eq!(start(&running), 1.0);
    }

    /// A motor that starts at 60 and 50 degC, with noise, and with a first reading that is wrong by 2 K.
    #[test]
    fn a_wrong_first_reading_does_not_shift_the_run() {
        let truth = [333.15, 323.15];
        let mut experiment = crate::testing::experiment("\"thermal.C_h\" = 0.1", true);
        experiment.runs[0].start = crate::experiment::Start::Measured;
        let [winding, housing] = [2, 3].map(|output| experiment.inputs.len() + output);
        for (column, value) in [winding, housing].into_iter().zip(truth) {
            experiment.runs[0].table.columns[column].fill(value);
        }
        let bench = Bench::new(&experiment, &[]).unwrap();
        let lag = bench.declaration().by_name("effect.housing_sensor_lag.tau").unwrap().slot;
        let mut rng = crate::testing::rng(1);
        for late in [0.0, 30.0] {
            let change = Override { values: vec![(lag, late)], ..Override::default() };
            let drive = Drive::new(&experiment, &experiment.runs[0]).unwrap();
            let mut model = bench.begin_at(&drive, &change, &truth).unwrap();
            let mut shown = vec![Vec::new(); 4];
            bench
                .along(&drive, model.as_mut(), |model, _| {
                    for (column, slot) in shown.iter_mut().zip(bench.outputs()) {
                        column.push(model.get(*slot) + 0.2 * crate::testing::normal(&mut rng));
                    }
                })
                .unwrap();
            shown[3][0] += 2.0;
            experiment.runs[0].table.columns.splice(experiment.inputs.len().., shown);
            let drive = Drive::new(&experiment, &experiment.runs[0]).unwrap();
            let found = bench.first_readings(&drive, &change).unwrap();
            // 15 rows: 0.2 / sqrt(15) = 0.05 K, and a fifteenth of 2 K; a winding that cools down faster has fewer.
            assert!(
                (found[1] - truth[1]).abs() < 0.25 && (found[0] - truth[0]).abs() < 0.5,
                "{late} {found:?}"
            );
        }
    }

    #[test]
    fn a_node_that_is_not_known_takes_the_nearest() {
        let motor =
            named("AnnulusCooledMotor", &[("winding_temperature", 360.0), ("housing_temperature", 330.0)]);
        let values: Vec<f64> = motor.iter().map(|(_, value)| *value).collect();
        assert_eq!(values, [360.0, 330.0, 330.0, 330.0], "{motor:?}");
        let gearmotor =
            named("BrushedGearmotor", &[("housing_temperature", 320.0), ("box_temperature", 305.0)]);
        let (names, values): (Vec<_>, Vec<_>) = gearmotor.into_iter().unzip();
        assert_eq!(names, ["winding", "housing", "box", "gear"].map(|n| format!("initial.{n}_temperature")));
        assert_eq!(values, [320.0, 320.0, 305.0, 320.0]);
        assert!(named("BrushedGearmotor", &[]).is_empty());
    }
}
