//! Quantities that are recorded at the supply of the drive instead of at the motor.
//!
//! i_s = v i / B + i_q                                                                             (1)
//! i_s = v (i* + a sgn v + b w) / B + i_q                                                          (2)
//!
//! i_s is the current of the supply, v the voltage and i the current of the motor, B the product of the efficiency and the voltage of the
//! supply (bus voltage), i_q the quiescent current. What the model implies, i*, is the prediction of a measured current that is an output,
//! or the current with which another output is predicted as it was read (Newton's method, one step; repeated with the current by (1), since
//! the winding's resistance follows its temperature). It deviates from i by a drag, or by an error of the torque constant: a with the sign
//! of v, and b w with the speed w. B and i_q follow from (2) by least squares; B is then the one with the least cost of a fit. (2) has to
//! leave less than a current of the motor with any gain and offset,
//!
//! i_s = c i* + d + e w + f v                                                                      (3)
//!
//! Where v is small, (1) does not determine i. An input is estimated by B (i_s - i_q) v / (v^2 + v_0^2), with v_0 the voltage at which the
//! noise of i_s is that of the whole current; an output is left out there.
//!
//! A voltage of the supply hardly varies. The motor's is about k_t w + R i; Newton's method gives the values that an output implies
//! (`unmeasured.rs`).
//!
//! *Source*: power balance of a DC-DC converter: Erickson and Maksimovic, Fundamentals of Power Electronics (3rd ed., 2020), ch. 3; ridge
//! estimator with the ratio of noise to signal: Hoerl and Kennard, Technometrics 12 (1970) 55.

use super::cost::fitted;
use super::search::Changed;
use super::unmeasured::{implied, slopes};
use super::wrapped::{Row, least_squares};
use super::{Judge, Mistake, Predicted, ROUNDING};
use crate::experiment::{Channel, Experiment};
use crate::intake::response::{ENOUGH, spread};
use crate::intake::{ends, median};
use crate::levels::{FACTOR, PART, SMALL, STRUCTURE};
use crate::noise;
use crate::simulate::Bench;
use physics::declare::Unit;

/// Least efficiency of a drive. Limit: its losses are then a sixth of the power of the motor; a motor that is loaded has a better one.
const EFFICIENCY: f64 = 0.85;
/// Rounds of Newton's method and (2). Numerical: the second one has the temperatures of the corrected current.
const ROUNDS: usize = 2;

/// First change of B by which a smaller cost is looked for. Numerical: it is halved until B is known to the accuracy of the model.
const FIRST: f64 = 0.04;

/// A current of the supply.
#[derive(Clone, Debug, PartialEq)]
pub struct Supply {
    /// The column of the current.
    pub current: usize,
    /// The column of the voltage.
    pub voltage: usize,
    /// The column of the duty, of which the motor's voltage is that fraction.
    pub duty: Option<usize>,
    /// B, V.
    pub product: f64,
    /// i_q, A.
    pub quiescent: f64,
    /// v_0, V.
    pub least: f64,
    /// Mean of ln |di/di_s|.
    pub stretch: f64,
}

impl Supply {
    /// Replaces the readings by the current of the motor.
    pub fn apply(&self, columns: &mut [Vec<f64>], inputs: usize) {
        let volts = volts(columns, self.voltage, self.duty);
        for (i, v) in columns[self.current].iter_mut().zip(volts) {
            let power = self.product * (*i - self.quiescent);
            *i = if self.current < inputs {
                power * v / (v * v + self.least * self.least)
            } else if v.abs() * SMALL > self.least {
                power / v
            } else {
                f64::NAN
            };
        }
    }

    /// Faulty channel, reason and suggested correction; `name` gives that of a column.
    pub fn words(&self, name: &dyn Fn(usize) -> String, files: &str) -> (String, String, String) {
        let (current, voltage) = (name(self.current), name(self.voltage));
        let quiescent = if self.quiescent > 0.0 {
            format!(" and a quiescent current of {:.3} A", self.quiescent)
        } else {
            String::new()
        };
        let reason = format!(
            "{current} in {files} contradicts the model; as the current of the drive's supply (DC link), with {voltage}, a product of bus \
             voltage and efficiency of {:.1} V{quiescent}, it would agree",
            self.product
        );
        (current, reason, "record the current of the motor instead of that of the drive's supply".to_string())
    }
}

/// Columns of the quantities of a motor.
#[derive(Clone, Copy)]
struct Places {
    current: usize,
    voltage: usize,
    /// With it, the column of the voltage is rightly that of the supply.
    duty: Option<usize>,
    speed: Option<usize>,
}

impl Places {
    /// `None` without current or voltage.
    fn of(experiment: &Experiment) -> Option<Places> {
        let all: Vec<&Channel> = experiment.inputs.iter().chain(&experiment.outputs).copied().collect();
        let is_motor = |one: &Channel| one.input != Some("supply_voltage");
        let place = |unit: Unit| all.iter().position(|one| one.unit == unit && is_motor(one));
        let voltage = place(Unit::Volt)?;
        let duty = experiment.inputs.iter().position(|one| one.input == Some("duty"));
        let duty = duty.filter(|_| voltage < experiment.inputs.len());
        Some(Places { current: place(Unit::Ampere)?, voltage, duty, speed: place(Unit::RadianPerSecond) })
    }
}

/// The voltage of the motor by row.
fn volts(columns: &[Vec<f64>], voltage: usize, duty: Option<usize>) -> Vec<f64> {
    let share = |row: usize| duty.map_or(1.0, |duty| columns[duty][row]);
    columns[voltage].iter().enumerate().map(|(row, v)| share(row) * v).collect()
}

/// The readings of the judge's runs as those of the motor, if they may be of the supply; with the predictions by the preset and by the fit
/// of the other outputs.
pub(super) fn of(
    judge: &Judge,
    experiment: &Experiment,
    predicted: &Predicted,
    crossed: &Predicted,
) -> Vec<Changed> {
    let Some(places) = Places::of(experiment) else { return Vec::new() };
    let mut found = bus(judge, experiment, &places);
    let inputs = experiment.inputs.len();
    let supplies = match places.current.checked_sub(inputs) {
        Some(output) => {
            let implied: Vec<Vec<f64>> = crossed.iter().filter_map(|run| run.get(output).cloned()).collect();
            estimated(judge, experiment, &places, &implied).into_iter().collect()
        }
        None => of_input(judge, experiment, predicted, &places),
    };
    found.extend(refined(judge, experiment, supplies).map(|supply| {
        let (mistake, data) = (Mistake::Supply(supply.clone()), corrected(judge, experiment, &supply));
        let shown = if places.current < inputs { judge.predicted(&data) } else { predicted.clone() };
        Changed { score: 0.0, mistake, data, shown }
    }));
    found
}

fn corrected(judge: &Judge, experiment: &Experiment, supply: &Supply) -> Experiment {
    let (mut data, inputs) = (experiment.clone(), experiment.inputs.len());
    judge.runs.iter().for_each(|run| supply.apply(&mut data.runs[*run].table.columns, inputs));
    data
}

/// The best of several estimates, with the B of the least cost: the specimen's torque constant and resistance differ from the preset's.
fn refined(judge: &Judge, experiment: &Experiment, supplies: Vec<Supply>) -> Option<Supply> {
    let cost = |supply: Supply| {
        let cost = fitted(judge, &corrected(judge, experiment, &supply)).ok()?.whole();
        Some((cost, supply))
    };
    let all = supplies.into_iter().filter_map(cost);
    let mut best = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut step = FIRST;
    while step > STRUCTURE / FACTOR && !judge.deadline.is_near() {
        let with = |by: f64| {
            let product = best.1.product * by;
            cost(Supply {
                product,
                least: best.1.least * by,
                stretch: best.1.stretch + by.ln(),
                ..best.1.clone()
            })
        };
        match [with(1.0 + step), with(1.0 / (1.0 + step))].into_iter().flatten().find(|one| one.0 < best.0) {
            Some(better) => best = better,
            None => step *= 0.5,
        }
    }
    Some(best.1)
}

/// B and i_q of a current that is an input, as each output that follows it at once implies.
fn of_input(judge: &Judge, experiment: &Experiment, predicted: &Predicted, places: &Places) -> Vec<Supply> {
    let direct = (0..experiment.outputs.len()).filter(|k| !experiment.outputs[*k].is_temperature());
    let of = |output: usize| {
        let (mut data, mut shown, mut found) = (experiment.clone(), predicted.clone(), None);
        for _ in 0..ROUNDS {
            let slopes = slopes(judge, &data, (&shown, &|data| judge.predicted(data)), places.current)?;
            let implied = judge.runs.iter().enumerate().map(|(n, run)| {
                let (i, y) = (&data.runs[*run].table.columns[places.current], data.readings(*run, output));
                let rows = i.iter().zip(y).zip(shown[n].get(output)?.iter().zip(&slopes[n][output]));
                Some(rows.map(|((i, y), (p, s))| i + (y - p) / s).collect())
            });
            let implied: Vec<Vec<f64>> = implied.collect::<Option<_>>()?;
            let supply = estimated(judge, experiment, places, &implied)?;
            data = corrected(judge, experiment, &supply);
            shown = judge.predicted(&data);
            found = Some(supply);
        }
        found
    };
    direct.filter_map(of).collect()
}

/// (2) with the current that the model implies, by run and row, if it leaves less than (3) and is that of a supply.
fn estimated(
    judge: &Judge,
    experiment: &Experiment,
    places: &Places,
    implied: &[Vec<f64>],
) -> Option<Supply> {
    let mut rows: Vec<Row> = Vec::new();
    for (run, implied) in judge.runs.iter().zip(implied) {
        let columns = &experiment.runs[*run].table.columns;
        let volts = volts(columns, places.voltage, places.duty);
        let known = |row: usize| {
            let speed = places.speed.map_or(0.0, |speed| columns[speed][row]);
            (columns[places.current][row], vec![implied[row], volts[row], speed])
        };
        rows.extend(
            (0..implied.len()).map(known).filter(|(i, all)| all.iter().fold(*i, |a, b| a + b).is_finite()),
        );
    }
    if rows.len() < ENOUGH {
        return None;
    }
    let (numbers, left) = least_squares(&rows, |(_, known)| {
        let [i, v, w] = [known[0], known[1], known[2]];
        vec![v * i, 1.0, v.abs(), v * w]
    })?;
    let (_, of_motor) = least_squares(&rows, |(_, known)| vec![known[0], 1.0, known[1], known[2]])?;
    let (low, high) = ends(rows.iter().map(|(_, known)| known[1]));
    let read: Vec<f64> = rows.iter().map(|(i, _)| *i).collect();
    let (product, quiescent) = (1.0 / numbers[0], numbers[1]);
    let most = spread(&read);
    let is_supply = product > EFFICIENCY * high.max(-low) && (-SMALL * most..most).contains(&quiescent);
    if !is_supply || FACTOR * left > of_motor {
        return None;
    }
    let own = judge.runs.iter().map(|run| &experiment.runs[*run].table);
    let own = own.map(|table| (table.time.as_slice(), table.columns[places.current].as_slice()));
    let noise = noise::of_columns(own, false).unwrap_or(0.0);
    let size = (rows.iter().map(|(_, known)| known[0].powi(2)).sum::<f64>() / rows.len() as f64).sqrt();
    let least = (product * noise / size.max(ROUNDING)).max(ROUNDING);
    let clear = rows.iter().map(|(_, known)| known[1].abs()).filter(|v| v * SMALL > least);
    let (sum, count) = clear.fold((0.0, 0.0), |(sum, count), v| (sum + (product / v).ln(), count + 1.0));
    (count >= ENOUGH as f64).then_some(Supply {
        current: places.current,
        voltage: places.voltage,
        duty: places.duty,
        product,
        quiescent: quiescent.max(0.0),
        least,
        stretch: sum / count,
    })
}

/// The motor's voltage in place of an input that hardly varies, as an output implies it. Newton's method starts from k_t w + R i, since the
/// voltage of the supply would overheat a motor at rest.
fn bus(judge: &Judge, experiment: &Experiment, places: &Places) -> Vec<Changed> {
    let (inputs, Places { current, voltage, duty, speed }) = (experiment.inputs.len(), *places);
    let Some(speed) = speed.filter(|_| voltage < inputs && duty.is_none()) else { return Vec::new() };
    let Some((torque_constant, resistance)) = constants(judge, experiment) else { return Vec::new() };
    let mut data = experiment.clone();
    for run in judge.runs {
        let columns = &mut data.runs[*run].table.columns;
        let pairs = columns[current].iter().zip(&columns[speed]);
        let motor: Vec<f64> = pairs.map(|(i, w)| torque_constant * w + resistance * i).collect();
        if !is_bus(&columns[voltage], &motor) {
            return Vec::new();
        }
        columns[voltage] = motor;
    }
    let shown = judge.predicted(&data);
    let by = |place: usize| {
        let output = place.checked_sub(inputs)?;
        let (data, shown) = implied(judge, &data, &shown, (voltage, output))?;
        Some(Changed { score: 0.0, mistake: Mistake::Bus { voltage, by: place }, data, shown })
    };
    [current, speed].into_iter().filter_map(by).collect()
}

/// Torque constant and resistance of the preset or `[set]`, SI units.
fn constants(judge: &Judge, experiment: &Experiment) -> Option<(f64, f64)> {
    let bench = Bench::new(experiment, judge.preset).ok()?;
    let of = |name: &str| Some(bench.start_of(bench.declaration().by_name(name)?.slot));
    Some((of("motor.k_t")?, of("motor.R_ref")?))
}

/// Whether the readings of a voltage may be those of the supply: they hardly vary and are at least the motor's voltage, which varies.
pub fn is_bus(readings: &[f64], motor: &[f64]) -> bool {
    let level = median(readings.iter().copied()).abs();
    let rows = readings.iter().zip(motor).filter(|(y, p)| (*y + *p).is_finite());
    let (read, own): (Vec<f64>, Vec<f64>) = rows.unzip();
    let (low, high) = ends(own.iter().copied());
    let is_alike = own.len() >= ENOUGH && spread(&read) < SMALL * level;
    is_alike && spread(&own) > PART * level.min(high.max(-low)) && high.max(-low) < (1.0 + SMALL) * level
}

#[cfg(test)]
mod tests;
