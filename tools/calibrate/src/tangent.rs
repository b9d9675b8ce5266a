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

mod adapted;
mod influence;
#[cfg(test)]
mod tests;

use crate::CalibrateError;
use crate::initial::Started;
use crate::overrides::Override;
use crate::simulate::{Bench, Drive};
use adapted::Adapted;
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DMatrix, DefaultAllocator, Dim, Dyn, OMatrix};
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
/// Power at which the Taylor series of phi2 of a matrix of norm 1 ends. Numerical: the next term is below the rounding of 1/2.
const TERMS: usize = 16;

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
    /// An input, by its index in the experiment, and the standard deviation of its noise: the least perturbation, because near a bend (of a
    /// bridge at a duty of 0) a model follows noise by less or more than by its slope. Near 0 it is perturbed in both directions: a model that
    /// switches there (a bridge that coasts at a duty of 0) has another output for any other reading, but not in proportion to it. At the first
    /// row it also perturbs initial temperatures that depend on it. Source: statistical linearization, Gelb (ed.), Applied Optimal Estimation
    /// (1974), sec. 6.2.
    Input(usize, f64),
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
    /// States and rates at every row: rows times states.
    at: Vec<f64>,
    rates: Vec<f64>,
    /// C of (1): rows times outputs times states.
    seen: Vec<f64>,
    /// The three matrices of (2) by rows, for each interval between rows.
    passes: Vec<f64>,
    /// [Unknowns](Started::unknowns) of the run's start.
    unknowns: Vec<f64>,
    /// What the lag of a term, by its place, exceeds its driver by at the start, in the unit of the driver.
    lags: Vec<(usize, f64)>,
    /// Adaptation of the initial temperatures; `None` if the run starts at the ambient temperature.
    starts: Option<Adapted>,
}

/// Model at the states of one row.
#[derive(Default)]
struct Instant {
    rates: Vec<f64>,
    outputs: Vec<f64>,
}

impl Instant {
    /// The memory is used again at every row.
    fn read(&mut self, model: &mut dyn Model, outputs: &[Slot]) {
        self.rates.clear();
        model.rates(&mut self.rates);
        self.outputs.clear();
        self.outputs.extend(outputs.iter().map(|slot| model.get(*slot)));
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
        let Started { mut model, unknowns, .. } = bench.started(drive, change)?;
        let mut base = bench.begin_at(drive, change, &unknowns)?.model;
        let beside = |probe| Moved::new(bench, drive, change, probe, &unknowns, model.as_ref());
        let mut moved: Vec<Option<Moved>> = probes.iter().map(beside).collect();
        let rows = drive.time.len();
        let outputs = bench.outputs();
        let mut first = Vec::new();
        model.states(&mut first);
        let (n, m) = (first.len(), outputs.len());
        let mut shown = Vec::with_capacity(rows * m);
        let mut drivers = Vec::with_capacity(rows);
        let mut seen = Vec::with_capacity(rows * m * n);
        let mut slopes: Vec<f64> = Vec::with_capacity(rows * n * n);
        let (mut at, mut rates) = (Vec::with_capacity(rows * n), Vec::with_capacity(rows * n));
        let mut states: Vec<f64> = Vec::with_capacity(n);
        let (mut here, mut there) = (Instant::default(), Instant::default());
        bench.along(drive, model.as_mut(), |model, row| {
            let time = drive.time[row];
            states.clear();
            model.states(&mut states);
            drivers.push(model.drivers());
            drive.hold(base.as_mut(), bench.inputs(), row);
            base.set_states(time, &states);
            here.read(base.as_mut(), outputs);
            shown.extend(&here.outputs);
            at.extend(&states);
            rates.extend(&here.rates);
            // Before the states: the heat paths at these temperatures are known.
            for probe in moved.iter_mut().flatten() {
                probe.look(bench, drive, row, &states, &here);
            }
            seen.resize((row + 1) * m * n, 0.0);
            let seen_here = &mut seen[row * m * n..];
            for k in 0..n {
                let (from, way) = (states[k], WAY * states[k].abs().max(1.0));
                states[k] += way;
                base.set_states(time, &states);
                states[k] = from;
                there.read(base.as_mut(), outputs);
                slopes.extend(there.rates.iter().zip(&here.rates).map(|(there, here)| (there - here) / way));
                for j in 0..m {
                    seen_here[j * n + k] = (there.outputs[j] - here.outputs[j]) / way;
                }
            }
        })?;
        // Two nodes are the most common case; a constant size needs no memory for each matrix.
        let passes = match n {
            2 => passes(&drive.time, &slopes, Const::<2>),
            n => passes(&drive.time, &slopes, Dyn(n)),
        };
        let directions = moved.into_iter().map(|m| m.map(|m| m.direction)).collect();
        let lags = change.lags().zip(&unknowns[drive.warm.len()..]);
        let lags = lags.map(|((place, lag), above)| (place, above * lag.driver.nominal())).collect();
        let mut tangent = Tangent {
            shown,
            time: drive.time.clone(),
            drivers,
            directions,
            states: n,
            outputs: m,
            at,
            rates,
            seen,
            passes,
            unknowns,
            lags,
            starts: None,
        };
        tangent.starts = Adapted::new(bench, drive, change, &tangent);
        Ok(tangent)
    }

    /// Variances of the outputs due to white noise on inputs, rows times outputs: due to the same row's reading
    /// ([`direct_variance`](Self::direct_variance)), and in total. Each direction is that of an input, with the standard deviation of its
    /// noise.
    pub fn variance(&self, noises: &[(&Direction, f64)]) -> (Vec<f64>, Vec<f64>) {
        let (n, m, rows) = (self.states, self.outputs, self.drivers.len());
        let mut whole = vec![0.0; rows * m];
        let mut p = DMatrix::<f64>::zeros(n, n);
        for (direction, sigma) in noises {
            let start = DMatrix::from_column_slice(n, 1, &direction.start) * *sigma;
            p += &start * start.transpose();
        }
        let mut latest = vec![0.0; n];
        for row in 0..rows {
            for j in 0..m {
                let seen = DMatrix::from_row_slice(1, n, self.seen_by(row, j));
                let at_once: f64 = noises.iter().map(|(d, s)| (d.outputs[row * m + j] * s).powi(2)).sum();
                whole[row * m + j] = at_once + (&seen * &p * seen.transpose())[(0, 0)];
            }
            if row + 1 == rows {
                break;
            }
            let from = 3 * row * n * n;
            let keeps = DMatrix::from_row_slice(n, n, &self.passes[from..from + n * n]);
            p = &keeps * &p * keeps.transpose();
            for (direction, sigma) in noises {
                self.latest(direction, row + 1, &mut latest);
                let g = DMatrix::from_column_slice(n, 1, &latest) * *sigma;
                p += &g * g.transpose();
            }
        }
        (self.direct_variance(noises), whole)
    }

    /// The part due to the reading of the same row.
    pub fn direct_variance(&self, noises: &[(&Direction, f64)]) -> Vec<f64> {
        let mut variance = vec![0.0; self.drivers.len() * self.outputs];
        for (direction, sigma) in noises {
            let direct = self.direct(direction);
            variance.iter_mut().zip(direct).for_each(|(sum, change)| *sum += (change * sigma).powi(2));
        }
        variance
    }

    /// Change of the outputs by the reading of an input in the same row, rows times outputs. A current follows its voltage within a row and
    /// takes over its noise.
    pub fn direct(&self, direction: &Direction) -> Vec<f64> {
        let mut direct = direction.outputs.clone();
        let mut latest = vec![0.0; self.states];
        for (row, own) in direct.chunks_exact_mut(self.outputs).enumerate() {
            self.latest(direction, row, &mut latest);
            for (j, own) in own.iter_mut().enumerate() {
                *own += self.seen_by(row, j).iter().zip(&latest).map(|(c, x)| c * x).sum::<f64>();
            }
        }
        direct
    }

    /// What the lag of a term, by its place, exceeds its driver by at the start; 0 without a lag.
    pub fn lag_starts_above(&self, place: usize) -> f64 {
        self.lags.iter().find(|(own, _)| *own == place).map_or(0.0, |(_, above)| *above)
    }

    /// How the `j`-th output follows the states at a row.
    fn seen_by(&self, row: usize, j: usize) -> &[f64] {
        let n = self.states;
        &self.seen[(row * self.outputs + j) * n..(row * self.outputs + j + 1) * n]
    }

    /// Change of the states at a row by a reading of this row: it acts in the interval before it and in the one after it; both are added.
    fn latest(&self, direction: &Direction, row: usize, change: &mut [f64]) {
        change.fill(0.0);
        let Some(before) = row.checked_sub(1) else { return };
        let n = self.states;
        let at = |place: usize| &self.passes[(3 * before + place) * n * n..(3 * before + place + 1) * n * n];
        let rates = &direction.rates[row * n..(row + 1) * n];
        for force in [at(1), at(2)] {
            for (own, line) in change.iter_mut().zip(force.chunks_exact(n)) {
                *own += line.iter().zip(rates).map(|(f, b)| f * b).sum::<f64>();
            }
        }
    }

    /// Response of the outputs, rows times outputs, to a direction multiplied by `shape` at each row.
    pub fn response(&self, direction: &Direction, shape: impl Fn(usize) -> f64) -> Vec<f64> {
        // Two nodes are the most common case; a constant size lets the compiler unroll the loops.
        let mut answer = match self.states {
            2 => self.answer::<2>(direction, shape),
            n => self.answer_of(n, direction, shape),
        };
        if let Some(starts) = &self.starts {
            starts.adapt(&mut answer);
        }
        answer
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

/// Matrices of (2) for each interval, by rows; `slopes` are the matrices F at the rows, by columns.
fn passes<D: Dim>(time: &[f64], slopes: &[f64], states: D) -> Vec<f64>
where
    DefaultAllocator: Allocator<D, D>,
{
    let square = states.value() * states.value();
    let of = |from: &[f64]| OMatrix::from_column_slice_generic(states, states, from);
    let mut all: Vec<f64> = Vec::with_capacity(3 * slopes.len());
    let (mut three, mut last) = (Vec::new(), None::<(OMatrix<f64, D, D>, f64)>);
    for (row, ends) in time.windows(2).enumerate() {
        let h = ends[1] - ends[0];
        let (from, to) = slopes[row * square..(row + 2) * square].split_at(square);
        let mean = (of(from) + of(to)) * 0.5;
        // The matrices are reused while F and h are unchanged.
        if !last.as_ref().is_some_and(|(matrix, step)| *step == h && close(matrix, &mean)) {
            three.clear();
            pass(&mean, h).iter().for_each(|matrix| three.extend(matrix.transpose().iter()));
            last = Some((mean, h));
        }
        all.extend(&three);
    }
    all
}

fn close<D: Dim>(a: &OMatrix<f64, D, D>, b: &OMatrix<f64, D, D>) -> bool
where
    DefaultAllocator: Allocator<D, D>,
{
    a.iter().zip(b.iter()).all(|(a, b)| (a - b).abs() <= SAME * a.abs())
}

/// exp(F h), h (phi1 - phi2)(F h) and h phi2(F h): Taylor series of phi2 at F h / 2^s, the others by phi_k(z) = z phi_(k+1)(z) + 1 / k!,
/// then s doublings (Skaflestad, Wright, Applied Numerical Mathematics 59 (2009)).
fn pass<D: Dim>(matrix: &OMatrix<f64, D, D>, h: f64) -> [OMatrix<f64, D, D>; 3]
where
    DefaultAllocator: Allocator<D, D>,
{
    let (states, _) = matrix.shape_generic();
    let one = OMatrix::identity_generic(states, states);
    let mut z = matrix * h;
    for k in 0..states.value() {
        // A current with an unstable drop (negative resistance) settles as fast once the drop saturates.
        if z[(k, k)] > GROWN {
            z[(k, k)] = -z[(k, k)];
        }
    }
    let doublings = z.norm().max(1.0).log2().ceil() as i32;
    z *= 0.5f64.powi(doublings);
    // 1 / (TERMS + 2)!, and from there those of the lower powers.
    let mut reciprocal: f64 = (1..=TERMS + 2).map(|k| 1.0 / k as f64).product();
    let mut phi2 = &one * reciprocal;
    for k in (0..TERMS).rev() {
        reciprocal *= (k + 3) as f64;
        phi2 = &z * phi2 + &one * reciprocal;
    }
    let mut phi1 = &z * &phi2 + &one;
    let mut keeps = &z * &phi1 + &one;
    for _ in 0..doublings {
        phi2 = (&keeps * &phi2 + &phi1 + &phi2) * 0.5f64.powi(2);
        phi1 = (&keeps * &phi1 + &phi1) * 0.5;
        keeps = &keeps * &keeps;
    }
    [keeps, (&phi1 - &phi2) * h, phi2 * h]
}

/// Second, perturbed model instance.
struct Moved {
    model: Box<dyn Model>,
    probe: Probe,
    way: f64,
    there: Instant,
    /// With the perturbation in the other direction.
    back: Instant,
    direction: Direction,
}

impl Moved {
    /// `None` if the model rejects the perturbation or its states differ from those of the reference model.
    fn new(
        bench: &Bench,
        drive: &Drive,
        change: &Override,
        probe: &Probe,
        unknowns: &[f64],
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
            Probe::Input(k, noise) => way = (AT_PORT.1 * drive.scale(*k)).max(*noise),
        }
        let model = match probe {
            Probe::Input(k, _) => {
                bench.begin_at(&drive.with_input(*k, |_, x| x + way), &aside, unknowns).ok()?.model
            }
            _ => bench.begin_at(drive, &aside, unknowns).ok()?.model,
        };
        let (mut from, mut to) = (Vec::new(), Vec::new());
        beside.states(&mut from);
        model.states(&mut to);
        if from.len() != to.len() {
            return None;
        }
        let start: Vec<f64> = from.iter().zip(&to).map(|(a, b)| (b - a) / way).collect();
        let all = |of_row: usize| Vec::with_capacity(drive.time.len() * of_row);
        let direction = Direction { rates: all(start.len()), outputs: all(bench.outputs().len()), start };
        Some(Moved {
            model,
            probe: probe.clone(),
            way,
            there: Instant::default(),
            back: Instant::default(),
            direction,
        })
    }

    fn look(&mut self, bench: &Bench, drive: &Drive, row: usize, states: &[f64], here: &Instant) {
        let model = self.model.as_mut();
        drive.hold(model, bench.inputs(), row);
        let mut base = (here, self.way);
        if let Probe::Input(k, _) = self.probe {
            let (slot, reading) = (bench.inputs()[k], drive.input(k, row));
            let back = reading - self.way;
            if reading.abs() < self.way && bench.limited(k, back) == back {
                model.set(slot, back);
                model.set_states(drive.time[row], states);
                self.back.read(model, bench.outputs());
                base = (&self.back, 2.0 * self.way);
            }
            model.set(slot, reading + self.way);
        }
        model.set_states(drive.time[row], states);
        self.there.read(model, bench.outputs());
        let (there, (here, way)) = (&self.there, base);
        let slope = |(there, here): (&f64, &f64)| (there - here) / way;
        self.direction.rates.extend(there.rates.iter().zip(&here.rates).map(slope));
        self.direction.outputs.extend(there.outputs.iter().zip(&here.outputs).map(slope));
    }
}
