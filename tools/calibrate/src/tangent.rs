//! Model linearised along a run: response of the outputs to a small perturbation at any port.
//!
//! x' = F x + b u,   y = C x + d u                                                          (1)
//! x_{k+1} = exp(F h) x_k + h (phi1 - phi2)(F h) b_k u_k + h phi2(F h) b_{k+1} u_{k+1}      (2)
//!
//! F, C, b and d are finite differences of the native model's rates and outputs at the states of each row, so that the equations are not
//! duplicated. Over a row F is the mean of both ends and u is linear, as are the inputs. With (2) the response to another u costs a few
//! additions per row, about a thousand times less than a simulation.
//! *Assumes* small perturbations; large ones require simulation. *Source*: Hochbruck, Ostermann, Acta Numerica 19
//! (2010), for the phi functions.

use crate::CalibrateError;
use crate::overrides::Override;
use crate::simulate::{Bench, Drive};
use nalgebra::DMatrix;
use physics::model::{Model, Slot};
use physics::terms::{Drivers, GenericTerm, Law, Port, Product};

/// Relative perturbation of the states for the finite differences. Numerical: half of the digits remain in the difference.
const WAY: f64 = 1e-5;
/// Relative difference of two matrices F below which (2) is not computed again. Numerical: error of the response.
const SAME: f64 = 1e-4;
/// Perturbations at a port, in its unit, and of an input, relative to its greatest value. Numerical: as for [`WAY`].
const AT_PORT: (f64, f64) = (1e-3, 1e-4);
/// Logarithm of the growth of a state within a row above which the linearization is meaningless. Derivation: all digits of a number, ln
/// 2^52.
const GROWN: f64 = 36.0;

/// Perturbed quantity.
#[derive(Clone, Debug)]
pub enum Probe {
    /// A parameter, from its value in the change.
    Parameter {
        /// Its slot.
        slot: Slot,
        /// Other parameters that are set and held constant.
        with: Vec<(Slot, f64)>,
        /// Size of the perturbation.
        way: f64,
    },
    /// A port, perturbed by a constant term.
    Port(Port),
    /// An input, by its index in the experiment. At the first row it also perturbs initial temperatures that depend on it.
    Input(usize),
}

/// Effect of a unit perturbation at every row.
#[derive(Clone, Debug)]
pub struct Direction {
    /// On the initial states: one for each state.
    start: Vec<f64>,
    /// On the rates: rows times states.
    rates: Vec<f64>,
    /// Direct effect on the outputs: rows times outputs.
    outputs: Vec<f64>,
}

/// A model linearised along one run.
#[derive(Clone, Debug)]
pub struct Tangent {
    /// Outputs at every row, rows times outputs, in SI units.
    pub shown: Vec<f64>,
    /// Time of each row, s.
    pub time: Vec<f64>,
    /// Drivers of terms, at every row.
    pub drivers: Vec<Drivers>,
    /// One for each probe; `None` if the model rejects the perturbation.
    pub directions: Vec<Option<Direction>>,
    states: usize,
    outputs: usize,
    /// C of (1): rows times outputs times states.
    seen: Vec<f64>,
    /// The three matrices of (2) by rows, for each interval between rows.
    passes: Vec<f64>,
}

/// Model at the states of one row.
struct Instant {
    rates: Vec<f64>,
    outputs: Vec<f64>,
}

impl Instant {
    fn of(model: &mut dyn Model, outputs: &[Slot]) -> Instant {
        let mut rates = Vec::new();
        model.rates(&mut rates);
        Instant { rates, outputs: outputs.iter().map(|slot| model.get(*slot)).collect() }
    }
}

impl Tangent {
    /// Linearises the model with a change along a run.
    ///
    /// # Errors
    /// The message of the model if it cannot be run.
    pub fn new(
        bench: &Bench,
        drive: &Drive,
        change: &Override,
        probes: &[Probe],
    ) -> Result<Tangent, CalibrateError> {
        let mut model = bench.begin(drive, change)?;
        let mut base = bench.begin(drive, change)?;
        let mut moved: Vec<Option<Moved>> =
            probes.iter().map(|probe| Moved::new(bench, drive, change, probe, model.as_ref())).collect();
        let rows = drive.time.len();
        let outputs = bench.outputs();
        let mut first = Vec::new();
        model.states(&mut first);
        let (n, m) = (first.len(), outputs.len());
        let mut shown = Vec::with_capacity(rows * m);
        let mut drivers = Vec::with_capacity(rows);
        let mut seen = Vec::with_capacity(rows * m * n);
        let mut slopes: Vec<DMatrix<f64>> = Vec::with_capacity(rows);
        let mut states = Vec::with_capacity(n);
        bench.along(drive, model.as_mut(), |model, row| {
            let time = drive.time[row];
            states.clear();
            model.states(&mut states);
            drivers.push(model.drivers());
            drive.hold(base.as_mut(), bench.inputs(), row);
            base.set_states(time, &states);
            let here = Instant::of(base.as_mut(), outputs);
            shown.extend(&here.outputs);
            let mut by_state = DMatrix::zeros(n, n);
            let mut seen_here = vec![0.0; m * n];
            for k in 0..n {
                let way = WAY * states[k].abs().max(1.0);
                let mut aside = states.clone();
                aside[k] += way;
                base.set_states(time, &aside);
                let there = Instant::of(base.as_mut(), outputs);
                for j in 0..n {
                    by_state[(j, k)] = (there.rates[j] - here.rates[j]) / way;
                }
                for j in 0..m {
                    seen_here[j * n + k] = (there.outputs[j] - here.outputs[j]) / way;
                }
            }
            slopes.push(by_state);
            seen.extend(seen_here);
            for probe in moved.iter_mut().flatten() {
                probe.look(bench, drive, row, &states, &here);
            }
        })?;
        let passes = passes(&drive.time, &slopes);
        let directions = moved.into_iter().map(|m| m.map(|m| m.direction)).collect();
        Ok(Tangent {
            shown,
            time: drive.time.clone(),
            drivers,
            directions,
            states: n,
            outputs: m,
            seen,
            passes,
        })
    }

    /// Variances of the outputs due to white noise on inputs, rows times outputs: due to the same row's reading, and in total. A current
    /// follows its voltage within a row and takes over its noise. Each direction is that of an input, with the standard deviation of its
    /// noise.
    pub fn variance(&self, noises: &[(&Direction, f64)]) -> (Vec<f64>, Vec<f64>) {
        let (n, m, rows) = (self.states, self.outputs, self.drivers.len());
        let (mut direct, mut whole) = (vec![0.0; rows * m], vec![0.0; rows * m]);
        let mut p = DMatrix::<f64>::zeros(n, n);
        let mut latest: Vec<DMatrix<f64>> = Vec::new();
        for (direction, sigma) in noises {
            let start = DMatrix::from_column_slice(n, 1, &direction.start) * *sigma;
            p += &start * start.transpose();
        }
        for row in 0..rows {
            for j in 0..m {
                let seen =
                    DMatrix::from_row_slice(1, n, &self.seen[(row * m + j) * n..(row * m + j + 1) * n]);
                let at_once: f64 = noises.iter().map(|(d, s)| (d.outputs[row * m + j] * s).powi(2)).sum();
                let just: f64 = latest.iter().map(|g| (&seen * g)[(0, 0)].powi(2)).sum();
                direct[row * m + j] = at_once + just;
                whole[row * m + j] = at_once + (&seen * &p * seen.transpose())[(0, 0)];
            }
            if row + 1 == rows {
                break;
            }
            let of = |place: usize| {
                let from = (3 * row + place) * n * n;
                DMatrix::from_row_slice(n, n, &self.passes[from..from + n * n])
            };
            let (keeps, force) = (of(0), of(1) + of(2));
            p = &keeps * &p * keeps.transpose();
            latest.clear();
            for (direction, sigma) in noises {
                // A reading acts in the interval before it and in the one after it; both contributions are added.
                let b = DMatrix::from_column_slice(n, 1, &direction.rates[(row + 1) * n..(row + 2) * n]);
                let g = &force * b * *sigma;
                p += &g * g.transpose();
                latest.push(g);
            }
        }
        (direct, whole)
    }

    /// Response of the outputs, rows times outputs, to a direction multiplied by `shape` at each row.
    pub fn response(&self, direction: &Direction, shape: impl Fn(usize) -> f64) -> Vec<f64> {
        // Two nodes are the most common case; a constant size lets the compiler unroll the loops.
        match self.states {
            2 => self.answer::<2>(direction, shape),
            n => self.answer_of(n, direction, shape),
        }
    }

    fn answer<const N: usize>(&self, direction: &Direction, shape: impl Fn(usize) -> f64) -> Vec<f64> {
        self.answer_of(N, direction, shape)
    }

    #[inline(always)]
    fn answer_of(&self, n: usize, direction: &Direction, shape: impl Fn(usize) -> f64) -> Vec<f64> {
        let (m, rows) = (self.outputs, self.drivers.len());
        let mut answer = vec![0.0; rows * m];
        let mut now = shape(0);
        let mut x: Vec<f64> = direction.start.iter().map(|s| s * now).collect();
        let mut next = vec![0.0; n];
        for row in 0..rows {
            let seen = &self.seen[row * m * n..(row + 1) * m * n];
            let at_once = &direction.outputs[row * m..(row + 1) * m];
            let out = &mut answer[row * m..(row + 1) * m];
            for ((out, seen), at_once) in out.iter_mut().zip(seen.chunks_exact(n)).zip(at_once) {
                let through: f64 = seen.iter().zip(&x).map(|(c, x)| c * x).sum();
                *out = through + at_once * now;
            }
            if row + 1 == rows {
                break;
            }
            let then = shape(row + 1);
            let pass = &self.passes[3 * n * n * row..3 * n * n * (row + 1)];
            let (keeps, force) = pass.split_at(n * n);
            let (first, second) = force.split_at(n * n);
            let b0 = &direction.rates[row * n..(row + 1) * n];
            let b1 = &direction.rates[(row + 1) * n..(row + 2) * n];
            for (j, next) in next.iter_mut().enumerate() {
                let (keeps, first, second) =
                    (&keeps[j * n..(j + 1) * n], &first[j * n..(j + 1) * n], &second[j * n..(j + 1) * n]);
                *next = (0..n)
                    .map(|k| keeps[k] * x[k] + first[k] * (b0[k] * now) + second[k] * (b1[k] * then))
                    .sum();
            }
            std::mem::swap(&mut x, &mut next);
            now = then;
        }
        answer
    }
}

/// Matrices of (2) for each interval, by rows.
fn passes(time: &[f64], slopes: &[DMatrix<f64>]) -> Vec<f64> {
    let n = slopes[0].nrows();
    let mut all: Vec<f64> = Vec::with_capacity(slopes.len() * 3 * n * n);
    let mut last: Option<(DMatrix<f64>, f64, [DMatrix<f64>; 3])> = None;
    for (pair, ends) in slopes.windows(2).zip(time.windows(2)) {
        let h = ends[1] - ends[0];
        let mean = (&pair[0] + &pair[1]) * 0.5;
        // The matrices are reused while F and h are unchanged.
        let serves = last.as_ref().is_some_and(|(matrix, step, _)| *step == h && close(matrix, &mean));
        if !serves {
            let three = pass(&mean, h);
            last = Some((mean, h, three));
        }
        if let Some((.., three)) = &last {
            three.iter().for_each(|matrix| all.extend(matrix.transpose().iter()));
        }
    }
    all
}

fn close(a: &DMatrix<f64>, b: &DMatrix<f64>) -> bool {
    a.iter().zip(b.iter()).all(|(a, b)| (a - b).abs() <= SAME * a.abs())
}

/// exp(F h), h (phi1 - phi2)(F h) and h phi2(F h), from one exponential of [[F, 1, 0], [0, 0, 1], [0, 0, 0]] h.
fn pass(matrix: &DMatrix<f64>, h: f64) -> [DMatrix<f64>; 3] {
    let n = matrix.nrows();
    let mut block = DMatrix::zeros(3 * n, 3 * n);
    block.view_mut((0, 0), (n, n)).copy_from(&(matrix * h));
    for k in 0..n {
        // A current with an unstable drop (negative resistance) settles as fast once the drop saturates.
        if block[(k, k)] > GROWN {
            block[(k, k)] = -block[(k, k)];
        }
        block[(k, n + k)] = 1.0;
        block[(n + k, 2 * n + k)] = 1.0;
    }
    let full = block.exp();
    let part = |k: usize| full.view((0, k * n), (n, n)).into_owned();
    let (keeps, phi1, phi2) = (part(0), part(1) * h, part(2) * h);
    [keeps, &phi1 - &phi2, phi2]
}

/// Second, perturbed model instance.
struct Moved {
    model: Box<dyn Model>,
    probe: Probe,
    way: f64,
    direction: Direction,
}

impl Moved {
    /// `None` if the model rejects the perturbation or its states differ from those of the reference model.
    fn new(
        bench: &Bench,
        drive: &Drive,
        change: &Override,
        probe: &Probe,
        beside: &dyn Model,
    ) -> Option<Moved> {
        let mut aside = change.clone();
        let way;
        match probe {
            Probe::Parameter { slot, with, way: far } => {
                way = *far;
                aside.values.extend(with);
                let set = change.values.iter().rev().find(|(s, _)| s == slot);
                let from = set.map_or_else(|| bench.start_of(*slot), |(_, value)| *value);
                aside.values.push((*slot, from + way));
            }
            Probe::Port(port) => {
                way = AT_PORT.0;
                let law = Law::Product(Product { coefficient: way, factors: [None; 3] });
                aside.terms.push(GenericTerm::new(*port, law));
            }
            Probe::Input(k) => way = AT_PORT.1 * drive.scale(*k),
        }
        let model = match probe {
            Probe::Input(k) => bench.begin(&drive.with_input_moved(*k, way), &aside).ok()?,
            _ => bench.begin(drive, &aside).ok()?,
        };
        let (mut from, mut to) = (Vec::new(), Vec::new());
        beside.states(&mut from);
        model.states(&mut to);
        if from.len() != to.len() {
            return None;
        }
        let start: Vec<f64> = from.iter().zip(&to).map(|(a, b)| (b - a) / way).collect();
        let direction = Direction { start, rates: Vec::new(), outputs: Vec::new() };
        Some(Moved { model, probe: probe.clone(), way, direction })
    }

    fn look(&mut self, bench: &Bench, drive: &Drive, row: usize, states: &[f64], here: &Instant) {
        let model = self.model.as_mut();
        drive.hold(model, bench.inputs(), row);
        if let Probe::Input(k) = self.probe {
            model.set(bench.inputs()[k], drive.input(k, row) + self.way);
        }
        model.set_states(drive.time[row], states);
        let there = Instant::of(model, bench.outputs());
        let slope = |(there, here): (&f64, &f64)| (there - here) / self.way;
        self.direction.rates.extend(there.rates.iter().zip(&here.rates).map(slope));
        self.direction.outputs.extend(there.outputs.iter().zip(&here.outputs).map(slope));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Experiment;
    use physics::terms::{Driver, Factor};

    const TOML: &str = r#"
[experiment]
name = "t"
model = "AnnulusCooledMotor"
preset = "maxon-305015"
inputs = ["current_A", "speed_rad_per_s", "fan_command_1", "ambient_temperature_degC"]
outputs = ["voltage_V", "shaft_torque_Nm", "winding_temperature_degC", "housing_temperature_degC"]
[set]
cooling_mode = "conductance"
"effect.coulomb_friction.tau_c" = 0.005
[[run]]
file = "run.csv"
role = "fit"
"#;

    /// The linearised response to a small drag that grows with the root of the speed, to a resistance and to a warmer ambient equals the
    /// difference of two simulations.
    #[test]
    fn answers_are_those_of_simulations() {
        let folder = tempfile::tempdir().unwrap();
        let mut csv = String::from(
            "time_s,current_A,speed_rad_per_s,fan_command_1,ambient_temperature_degC,voltage_V,shaft_torque_Nm,\
             winding_temperature_degC,housing_temperature_degC\n",
        );
        for k in 0..400 {
            let t = 5.0 * f64::from(k);
            let (i, w) = (3.0 + 2.0 * (t / 90.0).sin(), 300.0 + 250.0 * (t / 130.0).cos());
            let n = if k > 200 { 0.6 } else { 0.0 };
            csv.push_str(&format!("{t},{i},{w},{n},23,,,,\n"));
        }
        std::fs::write(folder.path().join("run.csv"), csv).unwrap();
        std::fs::write(folder.path().join("experiment.toml"), TOML).unwrap();
        let experiment = Experiment::read(&folder.path().join("experiment.toml")).unwrap();
        let bench = Bench::new(&experiment, &[]).unwrap();
        let drive = Drive::new(&experiment, &experiment.runs[0]).unwrap();
        let slot = bench.declaration().by_name("motor.R_ref").unwrap().slot;
        let resistance = Probe::Parameter { slot, with: Vec::new(), way: 1e-4 };
        let probes = [Probe::Port(Port::DragTorque), resistance, Probe::Input(3)];
        let tangent = Tangent::new(&bench, &drive, &Override::default(), &probes).unwrap();
        let flat = |columns: Vec<Vec<f64>>| -> Vec<f64> {
            (0..drive.time.len())
                .flat_map(|row| columns.iter().map(move |c| c[row]).collect::<Vec<_>>())
                .collect()
        };
        let base = flat(bench.run(&drive, &Override::default()).unwrap());
        assert!(base.iter().zip(&tangent.shown).all(|(a, b)| (a - b).abs() < 1e-9));

        let size = 1e-5;
        let factor = Factor { driver: Driver::Speed, offset: 0.0, reference: 100.0, exponent: 0.5 };
        let law = Law::Product(Product { coefficient: size, factors: [Some(factor), None, None] });
        let dragged =
            Override { terms: vec![GenericTerm::new(Port::DragTorque, law)], ..Override::default() };
        let warmer = drive.with_input_moved(3, 0.01);
        let heavier = Override { values: vec![(slot, bench.start_of(slot) + 1e-4)], ..Override::default() };
        let speed = |row: usize| (tangent.drivers[row].speed / 100.0).sqrt();
        for (probe, size, shape, other) in [
            (0, size, &speed as &dyn Fn(usize) -> f64, bench.run(&drive, &dragged).unwrap()),
            (1, 1e-4, &|_| 1.0, bench.run(&drive, &heavier).unwrap()),
            (2, 0.01, &|_| 1.0, bench.run(&warmer, &Override::default()).unwrap()),
        ] {
            let answer = tangent.response(tangent.directions[probe].as_ref().unwrap(), shape);
            let truth: Vec<f64> = flat(other).iter().zip(&base).map(|(a, b)| (a - b) / size).collect();
            for output in 0..4 {
                let of = |v: &[f64]| v.iter().skip(output).step_by(4).copied().collect::<Vec<f64>>();
                let (found, told) = (of(&answer), of(&truth));
                let most = told.iter().fold(0.0f64, |m, x| m.max(x.abs()));
                let off = found.iter().zip(&told).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
                assert!(off <= 0.01 * most + 1e-9, "probe {probe} output {output}: {off} of {most}");
            }
        }
    }

    /// Noise on the current and on the ambient sensor: linear propagation against a hundred simulations.
    #[test]
    fn variances_are_those_of_simulations() {
        let experiment = crate::testing::experiment("", true);
        let bench = Bench::new(&experiment, &[]).unwrap();
        let drive = Drive::new(&experiment, &experiment.runs[0]).unwrap();
        let probes = [Probe::Input(0), Probe::Input(3)];
        let tangent = Tangent::new(&bench, &drive, &Override::default(), &probes).unwrap();
        let sigmas = [0.05, 0.1];
        let directions = tangent.directions.iter().map(|d| d.as_ref().unwrap());
        let noises: Vec<(&Direction, f64)> = directions.zip(sigmas).collect();
        let (direct, whole) = tangent.variance(&noises);
        let (trials, mut rng) = (120, crate::testing::rng(9));
        let mut sums = [0.0; 4];
        for _ in 0..trials {
            let mut inputs = drive.inputs().to_vec();
            for (k, sigma) in [0, 3].into_iter().zip(sigmas) {
                inputs[k].iter_mut().for_each(|x| *x += sigma * crate::testing::normal(&mut rng));
            }
            let shown = bench.run(&Drive::of(drive.time.clone(), inputs), &Override::default()).unwrap();
            for (output, column) in shown.iter().enumerate() {
                let base = tangent.shown.iter().skip(output).step_by(4);
                sums[output] += column.iter().zip(base).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            }
        }
        for (output, sum) in sums.iter().enumerate() {
            let told: f64 = whole.iter().skip(output).step_by(4).sum();
            let ratio = sum / f64::from(trials) / told;
            assert!((ratio - 1.0).abs() < 0.2, "output {output}: {ratio}");
        }
        // A temperature has no direct feedthrough.
        assert!(direct[2 + 4 * 200] < 0.2 * whole[2 + 4 * 200]);
    }

    /// An unstable state within a row, next to a stable one: its effect is bounded, and the stable one is unaffected.
    #[test]
    fn what_runs_away_within_a_row_is_bounded() {
        let f = DMatrix::from_row_slice(2, 2, &[900.0, 0.0, 0.1, -0.2]);
        let [keeps, first, second] = pass(&f, 2.0);
        assert!(keeps.iter().chain(first.iter()).chain(second.iter()).all(|x| x.abs() <= 2.0));
        let alone = pass(&DMatrix::from_element(1, 1, -0.2), 2.0);
        assert!((keeps[(1, 1)] - alone[0][(0, 0)]).abs() < 1e-12);
    }

    /// First-order storage, x' = -a x + u: analytic solutions for constant and ramp inputs.
    #[test]
    fn one_store_by_hand() {
        let (a, h): (f64, f64) = (0.3, 2.0);
        let [keeps, first, second] = pass(&DMatrix::from_element(1, 1, -a), h);
        let e = (-a * h).exp();
        assert!((keeps[(0, 0)] - e).abs() < 1e-12);
        assert!((first[(0, 0)] + second[(0, 0)] - (1.0 - e) / a).abs() < 1e-12);
        // A ramp from 0 to 1: (h - (1 - e)/a) / (a h).
        assert!((second[(0, 0)] - (h - (1.0 - e) / a) / (a * h)).abs() < 1e-12);
    }
}
