//! Models with the explicit integrator: a [`Law`] is a right-hand side with outputs; [`Explicit`] implements [`Equations`] with it.
//!
//! The equations of an actuator's transmission or of a person's gait are not stiff; the method of Dormand and Prince is sufficient.

use crate::groups::Grouped;
use crate::load_table::LoadTable;
use crate::model::{Declaration, Fault};
use crate::runtime::{Equations, Halt, Runtime, Saved, Table};
use crate::solver::explicit::{Tried, advance, dormand_prince};
use crate::terms::Drivers;
use declare::State;
use std::fmt::Debug;
use std::marker::PhantomData;

/// Arguments of the law: present inputs and states, and the values fixed at the start.
#[derive(Clone, Copy, Debug)]
pub struct Now<'a, I, const N: usize, const M: usize> {
    /// Time, s.
    pub time: f64,
    /// Inputs at this time.
    pub inputs: &'a I,
    /// States, in the order of the declaration.
    pub states: &'a [f64; N],
    /// Values fixed at the start.
    pub initial: &'a [f64; M],
}

/// Arguments of the law along a step: inputs with their derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a, I, const M: usize> {
    /// Time at the start of the communication step, s.
    pub time: f64,
    /// Inputs there.
    pub inputs: &'a I,
    /// Input derivatives, per second; `None` if all inputs are constant.
    pub slopes: Option<&'a I>,
    /// Values fixed at the start.
    pub initial: &'a [f64; M],
}

impl<I: Table, const M: usize> Line<'_, I, M> {
    /// The inputs `t` seconds after the start of the step.
    #[inline(always)]
    pub fn inputs(&self, t: f64) -> I {
        self.slopes.map_or(*self.inputs, |slopes| self.inputs.after(t, slopes))
    }
}

/// The equations of a model with `N` states, and its parameters. `M` values are fixed at the start.
pub trait Law<const N: usize, const M: usize>:
    Grouped + Clone + Debug + Default + PartialEq + Send + Sync + Sized + 'static
{
    /// Inputs.
    type Inputs: Table;
    /// Outputs.
    type Outputs: Table;
    /// Outputs of the energy balance, computed on request only.
    type Balance: Table;
    /// Event indicators.
    type Indicators: Table;

    /// Intermediate results at one instant, from which rates and outputs follow.
    type Point: Clone + Debug + Send + Sync + 'static;
    /// The states, in the order of the rates.
    const LIST: &'static [State];

    /// The declaration of the model.
    fn declaration() -> &'static Declaration;
    /// States and reference values at the start; checks the consistency of the parameters.
    ///
    /// # Errors
    /// Inconsistent parameters.
    fn start(&self, time: f64, inputs: &Self::Inputs) -> Result<([f64; N], [f64; M]), Fault>;
    /// Intermediate results at one instant.
    fn point(&self, now: &Now<'_, Self::Inputs, N, M>) -> Self::Point;
    /// Derivatives of the states with respect to time.
    fn rates(point: &Self::Point) -> [f64; N];
    /// The outputs.
    fn outputs(&self, now: &Now<'_, Self::Inputs, N, M>, point: &Self::Point) -> Self::Outputs;
    /// The outputs of the energy balance.
    fn balance(&self, now: &Now<'_, Self::Inputs, N, M>, point: &Self::Point) -> Self::Balance;
    /// The event indicators.
    fn indicators(&self, now: &Now<'_, Self::Inputs, N, M>, point: &Self::Point) -> Self::Indicators;
    /// A trial step of `h` seconds from the states `x`, `t` seconds after the start of the communication step; `first` are the
    /// intermediate results there, if known. A law with a faster method than Dormand and Prince's overrides this.
    #[inline]
    fn one(
        &self,
        line: &Line<'_, Self::Inputs, M>,
        t: f64,
        x: &[f64; N],
        first: Option<&Self::Point>,
        h: f64,
    ) -> Tried<Self::Point, N> {
        self.general(line, t, x, first, h)
    }
    /// Step of Dormand and Prince.
    fn general(
        &self,
        line: &Line<'_, Self::Inputs, M>,
        t: f64,
        x: &[f64; N],
        first: Option<&Self::Point>,
        h: f64,
    ) -> Tried<Self::Point, N> {
        let point = |t: f64, states: &[f64; N]| {
            let (inputs, initial) = (&line.inputs(t), line.initial);
            self.point(&Now { time: line.time + t, inputs, states, initial })
        };
        dormand_prince(point, Self::rates, t, x, first, h, &sizes(Self::LIST))
    }
    /// The reference values after a change of tunable parameters; `before` has the previous ones.
    fn retuned(&self, _before: &Self, now: &Now<'_, Self::Inputs, N, M>) -> [f64; M] {
        *now.initial
    }
    /// Sets a load table; false if the law does not use one.
    fn set_load(&mut self, _table: &LoadTable) -> bool {
        false
    }
    /// The first time event after `time`, s; infinite if there is none.
    fn next_event(&self, _time: f64) -> f64 {
        f64::INFINITY
    }
}

/// Reference size for the error of each state.
#[inline]
pub fn sizes<const N: usize>(list: &[State]) -> [f64; N] {
    std::array::from_fn(|n| list[n].value.nominal)
}

/// States of a model that consists of a law, and the values fixed at its start.
#[derive(Clone, Copy, Debug)]
pub struct Explicit<L, const N: usize, const M: usize> {
    states: [f64; N],
    initial: [f64; M],
    /// Factor on the tolerance of the integrator, and number of rejected steps.
    tolerance: f64,
    rejected: u64,
    law: PhantomData<L>,
}

impl<L, const N: usize, const M: usize> Saved for Explicit<L, N, M> {
    fn save(&self, out: &mut Vec<f64>) {
        self.states.save(out);
        self.initial.save(out);
    }

    fn load(&mut self, next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        self.states.load(next)?;
        self.initial.load(next)
    }
}

/// A model that consists of a law.
type Model<L, const N: usize, const M: usize> = Runtime<Explicit<L, N, M>, N>;

impl<L: Law<N, M>, const N: usize, const M: usize> Model<L, N, M> {
    /// The present instant.
    #[inline]
    fn now(&self) -> Now<'_, L::Inputs, N, M> {
        let Explicit { states, initial, .. } = &self.own;
        Now { time: self.time, inputs: &self.inputs, states, initial }
    }
}

impl<L: Law<N, M>, const N: usize, const M: usize> Equations<N> for Explicit<L, N, M> {
    type Parameters = L;
    type Inputs = L::Inputs;
    type Outputs = L::Outputs;
    type Balance = L::Balance;
    type Indicators = L::Indicators;
    type Point = L::Point;
    type Discrete = [f64; 0];
    const LIST: &'static [State] = L::LIST;

    fn declaration() -> &'static Declaration {
        L::declaration()
    }

    fn new(_: &L) -> Self {
        Explicit { states: [0.0; N], initial: [0.0; M], tolerance: 1.0, rejected: 0, law: PhantomData }
    }

    fn start(run: &mut Model<L, N, M>) -> Result<(), Fault> {
        (run.own.states, run.own.initial) = run.parameters.start(run.time, &run.inputs)?;
        Ok(())
    }

    #[inline]
    fn advance(run: &mut Model<L, N, M>, time: f64, h: f64) -> Result<(), Halt> {
        let law = &run.parameters;
        let slopes = run.is_sloping().then_some(&run.slopes);
        let line = Line { time, inputs: &run.inputs, slopes, initial: &run.own.initial };
        let mut states = run.own.states;
        // Intermediate results of the outputs are reused at the start of the step, unless the caller's time differs.
        let first = run.known_point().filter(|_| time == run.time);
        let one = |t: f64, x: &[f64; N], first: Option<&L::Point>, h: f64| law.one(&line, t, x, first, h);
        let followed = advance(one, &mut states, first, h, run.own.tolerance);
        run.own.rejected += followed.map_err(|step_failure| {
            Fault(format!(
                "The equations of {} cannot be followed over a step of {h} s: it ends {} s after {time} s.",
                L::declaration().name,
                step_failure.t
            ))
        })?;
        run.own.states = states;
        run.arrive(time + h, h);
        Ok(())
    }

    #[inline]
    fn point(run: &Model<L, N, M>) -> L::Point {
        run.parameters.point(&run.now())
    }

    fn outputs(run: &Model<L, N, M>, point: &L::Point) -> L::Outputs {
        run.parameters.outputs(&run.now(), point)
    }

    fn balance(run: &Model<L, N, M>, point: &L::Point) -> L::Balance {
        run.parameters.balance(&run.now(), point)
    }

    fn indicators(run: &Model<L, N, M>, point: &L::Point) -> L::Indicators {
        run.parameters.indicators(&run.now(), point)
    }

    fn set_parameter(run: &mut Model<L, N, M>, set: impl FnOnce(&mut L) -> bool) -> bool {
        let before = run.parameters.clone();
        let taken = set(&mut run.parameters);
        run.own.initial = run.parameters.retuned(&before, &run.now());
        taken
    }

    fn set_load(run: &mut Model<L, N, M>, table: &LoadTable) -> bool {
        run.parameters.set_load(table)
    }

    fn state(run: &Model<L, N, M>, k: usize) -> f64 {
        run.own.states[k]
    }

    fn put_state(run: &mut Model<L, N, M>, k: usize, value: f64) {
        run.own.states[k] = value;
    }

    fn rates(_: &Model<L, N, M>, point: &L::Point) -> Result<[f64; N], Fault> {
        Ok(L::rates(point))
    }

    fn next_event(run: &Model<L, N, M>, time: f64) -> f64 {
        run.parameters.next_event(time)
    }

    /// No discrete states.
    fn discrete(_: &Model<L, N, M>, before: &[f64; 0]) -> [f64; 0] {
        *before
    }

    fn scale_tolerances(run: &mut Model<L, N, M>, factor: f64) {
        run.own.tolerance = factor;
    }

    fn rejected_steps(run: &Model<L, N, M>) -> u64 {
        run.own.rejected
    }

    /// No drivers for terms.
    fn drivers(run: &Model<L, N, M>) -> Drivers {
        Drivers { time: run.time, ..Drivers::default() }
    }
}
