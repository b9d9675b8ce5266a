//! Directional and adjoint derivatives: allowed modes, unknowns and knowns (`physics/src/slopes.rs` evaluates the derivatives).

use super::{Instance, Interface, Mode, Type};
use crate::refusal::{Outcome, Refused};
use physics::declare::{Causality, Kind, Unit, Variability};
use physics::model::{Entry, Slot, TIME, TOLERANCE};
use physics::slopes::{Known, Move, Reached, Slope, Slopes, Unknown};

/// Modes in which derivatives may be requested.
const READABLE: &[Mode] =
    &[Mode::Initialization, Mode::Step, Mode::Event, Mode::Continuous, Mode::Terminated, Mode::Error];
/// Largest relative error estimate of a returned derivative.
const RELATIVE: f64 = 1e-6;
/// Alternative limit: change of the unknown by the error, relative to its nominal value, for a nominal change of the known.
const OF_NOMINAL: f64 = 1e-7;
/// Relative error estimate above which an accepted derivative is rounding error and zero is returned.
const ROUNDING: f64 = 1e-3;

/// Checks that two numbers of elements are equal.
fn same_number(what: &str, there: usize, wanted: usize) -> Outcome {
    if there == wanted {
        return Ok(());
    }
    Err(Refused::error(format!("the number of {what} is {there}, but {wanted} values are given.")))
}

/// The energy balance residual. Powers cancel in its derivative, which is zero below [`RELATIVE`] times the largest power.
const RESIDUAL: &str = "energy_balance_error";

impl Instance {
    /// Directional derivatives of `unknowns` for the seeds of `knowns`.
    pub fn directional(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        n: usize,
    ) -> Outcome<Vec<f64>> {
        self.ready(seed)?;
        let (unknowns, knowns) = (self.unknowns(unknowns)?, self.knowns(knowns)?);
        same_number("seeds", seed.len(), knowns.len())?;
        same_number("places for derivatives", n, unknowns.len())?;
        let moves: Outcome<Vec<Move>> =
            knowns.iter().zip(seed).map(|(known, &seed)| self.known(*known, seed)).collect();
        self.slopes(&moves?, &unknowns)
    }

    /// Adjoint derivatives: for each of `knowns` the sum of seed times derivative over `unknowns`.
    pub fn adjoint(&mut self, unknowns: &[u32], knowns: &[u32], seed: &[f64], n: usize) -> Outcome<Vec<f64>> {
        self.ready(seed)?;
        let (unknowns, knowns) = (self.unknowns(unknowns)?, self.knowns(knowns)?);
        same_number("seeds", seed.len(), unknowns.len())?;
        same_number("places for derivatives", n, knowns.len())?;
        let moves: Outcome<Vec<Move>> = knowns.iter().map(|&known| self.known(known, 1.0)).collect();
        // Only these contribute: usually one of many.
        let seeded = unknowns.into_iter().zip(seed).filter(|(_, seed)| **seed != 0.0);
        let (unknowns, seed): (Vec<&'static Entry>, Vec<f64>) = seeded.unzip();
        let mut sums = Vec::with_capacity(n);
        for one in moves? {
            let slopes = self.slopes(&[one], &unknowns)?;
            sums.push(slopes.iter().zip(&seed).map(|(slope, seed)| slope * seed).sum());
        }
        Ok(sums)
    }

    /// Time derivatives of outputs at the end of a step, with constant inputs.
    pub fn output_derivatives(&mut self, references: &[u32], orders: &[i32], n: usize) -> Outcome<Vec<f64>> {
        self.require_interface(Interface::CoSimulation)?;
        self.require(&[Mode::Step, Mode::Intermediate, Mode::Terminated, Mode::Error])?;
        let mut unknowns = Vec::with_capacity(references.len());
        for (&reference, &order) in references.iter().zip(orders) {
            let entry = self.entry(reference, Type::Real)?;
            let shown =
                entry.row.causality == Causality::Output || entry.is_intermediate() && !entry.is_settable();
            if !shown {
                return Err(Refused::error(format!("{} is not an output.", entry.name)));
            }
            self.require_to_read(entry)?;
            if order != 1 {
                return Err(Refused::error(format!(
                    "the derivative of order {order} of {} is not provided; order 1 is.",
                    entry.name
                )));
            }
            unknowns.extend(self.elements_of(entry));
        }
        same_number("places for derivatives", n, unknowns.len())?;
        let declaration = self.model.declaration();
        let mut rates = vec![0.0; declaration.states.len()];
        self.model.derivatives(&mut rates).map_err(|fault| Refused::discard(fault.0))?;
        let mut moves = vec![Move::of_time(self.model.time(), 1.0)];
        let states: Vec<Reached> = (declaration.states.iter().zip(&rates))
            .map(|(&[state, _], &rate)| (&declaration.entries[state], rate))
            .map(|(entry, rate)| Reached { at: self.model.get(entry.slot), size: entry.row.nominal, rate })
            .collect();
        if self.last_step > 0.0 {
            let (h, tolerance) = (self.last_step, self.tolerance * TOLERANCE);
            rates = self.with_slopes(|slopes| slopes.settled(&states, h, tolerance));
        }
        let pairs = states.iter().zip(&rates).enumerate();
        moves.extend(pairs.map(|(k, (state, &rate))| Move::of_state(k, state.at, rate, state.size)));
        let mut out = self.slopes(&moves, &unknowns)?;
        let powers = declaration.states.iter().zip(&rates);
        let powers = powers.filter(|(state, _)| declaration.entries[state[0]].row.unit == Unit::Joule);
        let largest = powers.fold(0.0_f64, |largest, (_, power)| largest.max(power.abs()));
        for (entry, place) in unknowns.iter().zip(&mut out) {
            if entry.name == RESIDUAL && place.abs() <= RELATIVE * largest {
                *place = 0.0;
            }
        }
        Ok(out)
    }

    fn ready(&mut self, seed: &[f64]) -> Outcome {
        self.require(READABLE)?;
        self.settle()?;
        match seed.iter().find(|s| !s.is_finite()) {
            Some(seed) => Err(Refused::discard(format!("the seed {seed} is not a finite number."))),
            None => Ok(()),
        }
    }

    fn unknowns(&self, references: &[u32]) -> Outcome<Vec<&'static Entry>> {
        let mut all = Vec::with_capacity(references.len());
        for &reference in references {
            let entry = self.entry(reference, Type::Real)?;
            if entry.is_settable() {
                return Err(Refused::error(format!("{} is set and has no derivative.", entry.name)));
            }
            all.extend(self.elements_of(entry));
        }
        Ok(all)
    }

    /// The variables of these references; time is `None`.
    fn knowns(&self, references: &[u32]) -> Outcome<Vec<Option<&'static Entry>>> {
        let mut all = Vec::with_capacity(references.len());
        for &reference in references {
            if reference == TIME {
                all.push(None);
            } else {
                all.extend(self.elements_of(self.entry(reference, Type::Real)?).map(Some));
            }
        }
        Ok(all)
    }

    fn known(&mut self, known: Option<&'static Entry>, seed: f64) -> Outcome<Move> {
        let Some(entry) = known else {
            return Ok(Move::of_time(self.model.time(), seed));
        };
        let starting = self.mode == Mode::Initialization;
        let known = match entry.slot.group {
            Slot::STATES if !starting => Known::State(entry.slot.row as usize),
            _ if entry.is_settable() && (starting || entry.row.variability != Variability::Fixed) => {
                Known::Variable(entry.slot)
            }
            _ => {
                return Err(Refused::error(format!(
                    "{} is not a known here: it is not an input, a tunable parameter or a state.",
                    entry.name
                )));
            }
        };
        debug_assert_eq!(entry.row.kind, Kind::Real);
        let at = self.model.get(entry.slot);
        Ok(Move { known, at, seed, size: entry.row.nominal, limits: (entry.row.min, entry.row.max) })
    }

    /// The largest magnitude of the states that are energies, J.
    fn largest_energy(&mut self) -> f64 {
        let declaration = self.model.declaration();
        let energies = declaration.states.iter().map(|state| &declaration.entries[state[0]]);
        let energies = energies.filter(|entry| entry.row.unit == Unit::Joule);
        energies.map(|entry| self.model.get(entry.slot).abs()).fold(0.0, f64::max)
    }

    /// Derivatives at the present point, of the equations of Model Exchange also in Co-Simulation.
    fn with_slopes<T>(&mut self, find: impl FnOnce(&mut Slopes<'_>) -> T) -> T {
        let scratch = self.scratch.get_or_insert_with(|| self.model.boxed_clone());
        let restart = (self.mode == Mode::Initialization).then_some(self.window.0);
        let reached = self.interface == Interface::CoSimulation;
        let mut handed = None;
        if reached {
            let model = handed.insert(self.model.boxed_clone());
            model.enter_model_exchange();
            model.accept_step();
        }
        let base = handed.as_ref().unwrap_or(&self.model).as_ref();
        find(&mut Slopes { base, scratch: scratch.as_mut(), reached, restart })
    }

    fn slopes(&mut self, moves: &[Move], unknowns: &[&'static Entry]) -> Outcome<Vec<f64>> {
        // The energy balance residual is what is left of energies.
        let energy = self.largest_energy();
        let size = |entry: &Entry| if entry.name == RESIDUAL { energy } else { 0.0 }.max(entry.row.nominal);
        let asked: Vec<Unknown> =
            unknowns.iter().map(|entry| Unknown { slot: entry.slot, size: size(entry) }).collect();
        let seeded = moves.iter().filter(|m| m.seed != 0.0);
        let way = seeded.map(|m| m.size.max(m.at.abs()) / m.seed.abs()).fold(f64::INFINITY, f64::min);
        let doubtful = |(entry, slope): &(&&Entry, &Slope)| {
            let settled =
                slope.error <= RELATIVE * slope.value.abs() || slope.error * way <= OF_NOMINAL * size(entry);
            !settled
        };
        let good = |found: &[Slope]| !unknowns.iter().zip(found).any(|pair| doubtful(&pair));
        let found = self.with_slopes(|slopes| {
            let found = slopes.along(moves, &asked);
            if good(&found) {
                return found;
            }
            // At a row of a table the derivative is one-sided; at the end of a period rounding may leave time just before that row.
            let sides = [true, false].map(|is_ahead| slopes.one_sided(moves, &asked, is_ahead));
            sides.into_iter().find(|side| good(side)).unwrap_or(found)
        });
        if let Some((entry, slope)) = unknowns.iter().zip(&found).find(doubtful) {
            return Err(Refused::discard(format!(
                "{} has no derivative in this direction at this point: the difference quotients do not converge; the best is {} (+-{}).",
                entry.name, slope.value, slope.error
            )));
        }
        // The derivative of the energy balance residual, for example, is only rounding error.
        let known =
            |slope: &Slope| if slope.error > ROUNDING * slope.value.abs() { 0.0 } else { slope.value };
        Ok(found.iter().map(known).collect())
    }
}
