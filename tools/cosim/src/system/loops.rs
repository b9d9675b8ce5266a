//! Algebraic loops: inputs and outputs that depend on each other without a step in between, solved at each communication point.
//!
//! The unknowns are the inputs `u` of the loop. Setting all of them and reading all outputs gives `g(u)`; Newton's method, damped, finds
//! `u = g(u)`. The Jacobian comes from directional derivatives where an FMU provides them, else from difference quotients with one input
//! of each component at a time. It is kept from one communication point to the next as long as it converges fast. Values that are no
//! reals are iterated.
use super::batch::{Batch, Signals};
use super::connections::Connections;
use super::order::Loop;
use super::parts::Parts;
use super::structure::Place;
use super::units::Affine;
use crate::{Error, Kind, number};
use nalgebra::{DMatrix, DVector, Dyn, LU};

/// Difference between `u` and `g(u)`, relative to the largest magnitude of the input so far: at the solution, ...
const EXACT: f64 = 1e-12;
/// ... and where the rounding errors of an FMU allow no better one.
const ROUNDING: f64 = 1e-8;
/// Iterations at one communication point, at most.
const MOST_ITERATIONS: usize = 50;
/// Damping of one iteration, at most.
const LEAST: f64 = 1.0 / 1024.0;
/// Determinant of `1 - dg/du` below which there is no unique solution.
const SINGULAR: f64 = 1e-9;

/// One input of a loop.
#[derive(Clone, Copy, Debug)]
struct Member {
    slot: usize,
    component: usize,
    reference: u32,
    /// The connected output, its component and its reference, and the conversion to the input.
    source: usize,
    from: usize,
    from_reference: u32,
    convert: Affine,
    real: bool,
    /// Its number among the inputs of its component.
    place: usize,
}

/// Solves one loop.
pub(crate) struct LoopSolver {
    /// The round of the exchange in which it is due.
    pub(crate) round: usize,
    members: Vec<Member>,
    sets: Vec<Batch>,
    gets: Vec<Batch>,
    /// Components with directional derivatives.
    directional: Vec<usize>,
    /// The largest magnitude of each input so far.
    sizes: Vec<f64>,
    /// Of `1 - dg/du`.
    jacobian: Option<LU<f64, Dyn, Dyn>>,
    path: String,
    place: Place,
}

impl LoopSolver {
    pub(crate) fn new(parts: Parts, connections: &Connections, found: &Loop) -> Self {
        let (mut sets, mut gets) = (Vec::new(), Vec::new());
        let mut members: Vec<Member> = Vec::new();
        let mut directional = Vec::new();
        for &slot in &found.inputs {
            let input = &connections.inputs[slot];
            let (component, variable) = (input.port.component, parts.variable(input.port));
            let output = connections.outputs[input.source];
            let from = parts.variable(output);
            Batch::add(&mut sets, component, variable, slot);
            let provides = |i: &crate::Interface| i.provides_directional_derivatives;
            if parts.description(component).co_simulation().is_some_and(provides)
                && !directional.contains(&component)
            {
                directional.push(component);
            }
            members.push(Member {
                slot,
                component,
                reference: variable.value_reference,
                source: input.source,
                from: output.component,
                from_reference: from.value_reference,
                convert: input.convert,
                real: variable.kind.is_float(),
                place: members.iter().filter(|m| m.component == component).count(),
            });
            // Directional derivatives are those of Float64.
            if [variable.kind, from.kind].contains(&Kind::Float32) {
                directional.retain(|c| *c != component && *c != output.component);
            }
        }
        for &slot in &found.outputs {
            let port = connections.outputs[slot];
            Batch::add(&mut gets, port.component, parts.variable(port), slot);
        }
        let first = connections.inputs[found.inputs[0]].connection;
        Self {
            round: found.round,
            sizes: vec![0.0; members.len()],
            members,
            sets,
            gets,
            directional,
            jacobian: None,
            path: found.path.clone(),
            place: parts.structure.connections[first].place.clone(),
        }
    }

    fn fault(&self, what: impl std::fmt::Display) -> Error {
        self.place.fault(format!("algebraic loop: {}: {what}", self.path))
    }

    /// Sets the inputs of the loop so that they equal the outputs, at time `t` (s).
    ///
    /// # Errors
    /// A failed call; no solution within the iterations; no unique solution.
    pub(crate) fn solve(&mut self, signals: &mut Signals, t: f64) -> Result<(), Error> {
        let found = self.iterate(signals, t);
        found.map_err(|error| match error {
            Error::Call { .. } => self.fault(error),
            other => other,
        })
    }

    fn iterate(&mut self, signals: &mut Signals, t: f64) -> Result<(), Error> {
        let mut u: Vec<f64> = self.members.iter().map(|m| signals.inputs[m.slot]).collect();
        if u.iter().any(|value| value.is_nan()) {
            // Nothing is set yet: the FMUs have their start values.
            u = self.read(signals)?;
        }
        let mut g = self.evaluate(signals, &u)?;
        for _ in 0..MOST_ITERATIONS {
            let (error, same) = self.distance(&u, &g);
            if error <= EXACT && same {
                self.sizes.iter_mut().zip(&u).for_each(|(size, u)| *size = size.max(u.abs()));
                return Ok(());
            }
            let is_new = self.jacobian.is_none();
            if is_new {
                let matrix = self.linearize(signals, &u, &g, true)?;
                self.keep(matrix, t)?;
            }
            let step = self.step(&u, &g);
            let mut length = 1.0;
            loop {
                let trial = self.members.iter().zip(u.iter().zip(&g)).zip(&step);
                let trial = trial.map(|((m, (u, g)), step)| if m.real { u + length * step } else { *g });
                let trial: Vec<f64> = trial.collect();
                let trial_g = self.evaluate(signals, &trial)?;
                let (trial_error, _) = self.distance(&trial, &trial_g);
                if trial_error < error || trial_error <= EXACT || !same {
                    if trial_error > 0.1 * error || !same {
                        self.jacobian = None;
                    }
                    (u, g) = (trial, trial_g);
                    break;
                }
                if !is_new {
                    self.jacobian = None;
                    break;
                }
                if error <= ROUNDING {
                    self.evaluate(signals, &u)?;
                    return Ok(());
                }
                length *= 0.5;
                if length < LEAST {
                    return Err(self.unsolved(&u, &g, t));
                }
            }
        }
        Err(self.unsolved(&u, &g, t))
    }

    #[cold]
    fn unsolved(&self, u: &[f64], g: &[f64], t: f64) -> Error {
        let worst = u.iter().zip(g).map(|(u, g)| (g - u).abs()).fold(0.0, f64::max);
        let (worst, t) = (number(worst), number(t));
        self.fault(format!("no solution at t = {t} s; inputs and outputs differ by {worst} at best"))
    }

    /// What the outputs make of the inputs.
    fn read(&mut self, signals: &mut Signals) -> Result<Vec<f64>, Error> {
        self.gets.iter_mut().try_for_each(|batch| batch.read(signals))?;
        Ok(self.members.iter().map(|m| m.convert.of(signals.outputs[m.source])).collect())
    }

    /// `g(u)`
    fn evaluate(&mut self, signals: &mut Signals, u: &[f64]) -> Result<Vec<f64>, Error> {
        for (member, u) in self.members.iter().zip(u) {
            signals.inputs[member.slot] = *u;
        }
        self.sets.iter_mut().try_for_each(|batch| batch.set(signals))?;
        self.read(signals)
    }

    /// The largest relative difference of reals, and whether all other values are equal.
    fn distance(&self, u: &[f64], g: &[f64]) -> (f64, bool) {
        let (mut worst, mut same) = (0.0_f64, true);
        for ((member, size), (u, g)) in self.members.iter().zip(&self.sizes).zip(u.iter().zip(g)) {
            if !member.real {
                same &= u == g;
                continue;
            }
            let difference = (g - u).abs();
            if difference.is_nan() {
                return (f64::INFINITY, same);
            }
            if difference > 0.0 {
                worst = worst.max(difference / size.max(u.abs()).max(g.abs()));
            }
        }
        (worst, same)
    }

    /// The Newton step; without a Jacobian that of the fixed point.
    fn step(&self, u: &[f64], g: &[f64]) -> Vec<f64> {
        let residual = self.members.iter().zip(u.iter().zip(g));
        let residual = residual.map(|(m, (u, g))| if m.real { g - u } else { 0.0 });
        let residual = DVector::from_iterator(u.len(), residual);
        let solved = self.jacobian.as_ref().and_then(|jacobian| jacobian.solve(&residual));
        solved.unwrap_or(residual).as_slice().to_vec()
    }

    /// `1 - dg/du`; with `provided`, directional derivatives where FMUs provide them.
    fn linearize(
        &mut self,
        signals: &mut Signals,
        u: &[f64],
        g: &[f64],
        provided: bool,
    ) -> Result<DMatrix<f64>, Error> {
        let n = self.members.len();
        let mut matrix = DMatrix::identity(n, n);
        let members = self.members.clone();
        let mut done: Vec<usize> = Vec::new();
        for &component in self.directional.iter().filter(|_| provided) {
            if directional(signals, component, &members, &mut matrix)? {
                done.push(component);
            }
        }
        // A component that refuses once is not asked again.
        self.directional.retain(|component| !provided || done.contains(component));
        let open = |m: &Member| m.real && !done.contains(&m.component);
        let most = members.iter().filter(|m| open(m)).map(|m| m.place + 1).max().unwrap_or(0);
        for place in 0..most {
            let mut moved = u.to_vec();
            for (k, member) in members.iter().enumerate().filter(|(_, m)| m.place == place && open(m)) {
                let size = self.sizes[k].max(u[k].abs()).max(g[k].abs());
                moved[k] += f64::EPSILON.sqrt() * if size > 0.0 { size } else { 1.0 };
                debug_assert_eq!(member.place, place);
            }
            let changed = self.evaluate(signals, &moved)?;
            for (row, to) in members.iter().enumerate().filter(|(_, m)| m.real) {
                let column =
                    members.iter().position(|m| m.place == place && m.component == to.from && open(m));
                if let Some(k) = column {
                    matrix[(row, k)] -= (changed[row] - g[row]) / (moved[k] - u[k]);
                }
            }
        }
        Ok(matrix)
    }

    fn keep(&mut self, matrix: DMatrix<f64>, t: f64) -> Result<(), Error> {
        let decomposed = matrix.lu();
        let determinant = decomposed.determinant();
        if determinant.is_nan() || determinant.abs() <= SINGULAR {
            let t = number(t);
            return Err(
                self.fault(format!("no unique solution at t = {t} s, as the gain around the loop is 1"))
            );
        }
        self.jacobian = Some(decomposed);
        Ok(())
    }

    /// Checks the solution at the start: a unique one, and components that evaluate their outputs when inputs are set. Returns the
    /// path of the loop and the first component that does not.
    pub(crate) fn check(&mut self, signals: &mut Signals, t: f64) -> Result<Option<(String, usize)>, Error> {
        let u: Vec<f64> = self.members.iter().map(|m| signals.inputs[m.slot]).collect();
        let g = self.evaluate(signals, &u)?;
        let matrix = self.linearize(signals, &u, &g, false)?;
        self.evaluate(signals, &u)?;
        let reacts = |component: usize| {
            let of_it = |(_, m): &(usize, &Member)| m.from == component && m.real;
            let mut rows = self.members.iter().enumerate().filter(of_it);
            let columns =
                || self.members.iter().enumerate().filter(|(_, m)| m.component == component && m.real);
            columns().count() == 0
                || rows.clone().count() == 0
                || rows.any(|(row, _)| {
                    columns().any(|(column, _)| matrix[(row, column)] != f64::from(u8::from(row == column)))
                })
        };
        let silent = self.members.iter().map(|m| m.component).find(|component| !reacts(*component));
        self.keep(matrix, t)?;
        Ok(silent.map(|component| (self.path.clone(), component)))
    }
}

/// Fills in what the directional derivatives of a component say; `false` if it refuses.
fn directional(
    signals: &mut Signals,
    component: usize,
    members: &[Member],
    matrix: &mut DMatrix<f64>,
) -> Result<bool, Error> {
    let mut unknowns: Vec<u32> = Vec::new();
    for member in members.iter().filter(|m| m.from == component && m.real) {
        if !unknowns.contains(&member.from_reference) {
            unknowns.push(member.from_reference);
        }
    }
    let mut slopes = vec![0.0; unknowns.len()];
    for (k, known) in members.iter().enumerate().filter(|(_, m)| m.component == component && m.real) {
        let instance = &mut signals.instances[component];
        if !instance.directional_derivative(&unknowns, known.reference, &mut slopes)? {
            return Ok(false);
        }
        for (row, to) in members.iter().enumerate().filter(|(_, m)| m.from == component && m.real) {
            let place = unknowns.iter().position(|u| *u == to.from_reference).unwrap_or(0);
            matrix[(row, k)] -= to.convert.factor * slopes[place];
        }
    }
    Ok(true)
}
