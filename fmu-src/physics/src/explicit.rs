//! Models that are a right-hand side and nothing more: a [`Law`] says what holds, [`Explicit`] makes a model of it.
//!
//! The motors have integrators of their own, because they are stiff. What stands around them, an actuator's transmission
//! or a person's gait, is not: there a law writes its rates and outputs down, and everything else (values by slot,
//! steps, slopes of inputs, events, saving and restoring, Model Exchange) is the same for all and stands here.

use crate::exchange::{Exchange, Update};
use crate::groups::Grouped;
use crate::load_table::LoadTable;
use crate::model::{Declaration, Fault, GroupAt, Model, Slot};
use crate::solver::explicit::{Tried, advance, dormand_prince};
use crate::terms::Drivers;
use declare::{Group, State};
use std::fmt::Debug;

/// A struct of variables that a model can own.
pub trait Table: Group + Copy + Debug + Default + PartialEq + Send + Sync + 'static {}
impl<T: Group + Copy + Debug + Default + PartialEq + Send + Sync + 'static> Table for T {}

/// What the law is asked about: the present inputs and states, and what the start has left.
#[derive(Clone, Copy, Debug)]
pub struct Now<'a, I, const N: usize, const M: usize> {
    /// Time, s.
    pub time: f64,
    /// Inputs at this time.
    pub inputs: &'a I,
    /// States, in the order of the declaration.
    pub states: &'a [f64; N],
    /// What the start has fixed.
    pub opening: &'a [f64; M],
}

/// What the law is asked about along a step: inputs on their lines.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a, I, const M: usize> {
    /// Time at the beginning of the communication step, s.
    pub time: f64,
    /// Inputs there.
    pub inputs: &'a I,
    /// Their slopes, per second; `None` where all of them are held.
    pub slopes: Option<&'a I>,
    /// What the start has fixed.
    pub opening: &'a [f64; M],
}

impl<I: Table, const M: usize> Line<'_, I, M> {
    /// The inputs `t` seconds into the step.
    #[inline(always)]
    pub fn inputs(&self, t: f64) -> I {
        self.slopes.map_or(*self.inputs, |slopes| self.inputs.after(t, slopes))
    }
}

/// The equations of a model with `N` states, and its parameters. `M` numbers are fixed when it starts.
pub trait Law<const N: usize, const M: usize>:
    Grouped + Clone + Debug + Default + PartialEq + Send + Sync + Sized + 'static
{
    /// What the importer sets.
    type Inputs: Table;
    /// What the model computes.
    type Outputs: Table;
    /// Residuals that pass through zero at an event.
    type Indicators: Table;

    /// What holds at one instant, from which rates and outputs follow.
    type Point: Clone + Debug + Send + Sync + 'static;
    /// The states, in the order of the rates.
    const LIST: &'static [State];
    /// The first of the outputs that are left to [`complete`](Law::complete).
    const LATE: usize = usize::MAX;

    /// The declaration of the model.
    fn declaration() -> &'static Declaration;
    /// States and opening at the start; checks the parameters together.
    ///
    /// # Errors
    /// Parameters that do not go together.
    fn start(&self, time: f64, inputs: &Self::Inputs) -> Result<([f64; N], [f64; M]), Fault>;
    /// What holds at one instant.
    fn point(&self, now: &Now<'_, Self::Inputs, N, M>) -> Self::Point;
    /// Derivatives of the states with respect to time.
    fn rates(point: &Self::Point) -> [f64; N];
    /// The outputs up to [`LATE`](Law::LATE).
    fn outputs(&self, now: &Now<'_, Self::Inputs, N, M>, point: &Self::Point) -> Self::Outputs;
    /// The other outputs, which are seldom read and cost something.
    fn complete(
        &self,
        _now: &Now<'_, Self::Inputs, N, M>,
        _point: &Self::Point,
        _outputs: &mut Self::Outputs,
    ) {
    }
    /// The event indicators.
    fn indicators(&self, now: &Now<'_, Self::Inputs, N, M>, point: &Self::Point) -> Self::Indicators;
    /// Tries a step of `h` seconds from the states `x`, `t` seconds into the communication step; `first` is what
    /// holds there, where that is known. Laws that know a shorter way than Dormand's and Prince's take it.
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
    /// Dormand's and Prince's step.
    fn general(
        &self,
        line: &Line<'_, Self::Inputs, M>,
        t: f64,
        x: &[f64; N],
        first: Option<&Self::Point>,
        h: f64,
    ) -> Tried<Self::Point, N> {
        let point = |t: f64, states: &[f64; N]| {
            let (inputs, opening) = (&line.inputs(t), line.opening);
            self.point(&Now { time: line.time + t, inputs, states, opening })
        };
        dormand_prince(point, Self::rates, t, x, first, h, &sizes(Self::LIST))
    }
    /// The opening after the parameters have changed under way from those of `before`.
    fn retuned(&self, _before: &Self, now: &Now<'_, Self::Inputs, N, M>) -> [f64; M] {
        *now.opening
    }
    /// Takes a load table; false where the law has no use for one.
    fn set_load(&mut self, _table: &LoadTable) -> bool {
        false
    }
    /// The first event after `time` that is known by its time, s; infinite where there is none.
    fn next_event(&self, _time: f64) -> f64 {
        f64::INFINITY
    }
}

/// The groups of a model that are not its parameters: inputs, outputs, event indicators.
const OWN: usize = 3;
const INPUTS: usize = 0;
const OUTPUTS: usize = 1;
const INDICATORS: usize = 2;

/// A model made of a law.
#[derive(Clone, Debug)]
pub struct Explicit<L: Law<N, M>, const N: usize, const M: usize> {
    /// The equations with their parameters.
    pub law: L,
    /// What the importer sets. After a change made here, [`set_states`](Model::set_states) says that it was made.
    pub inputs: L::Inputs,
    slopes: L::Inputs,
    time: f64,
    /// Factor on the tolerance of the integrator, and steps that it has rejected.
    tolerance: f64,
    rejected: u64,
    states: [f64; N],
    opening: [f64; M],
    /// What holds at this time with these inputs, where that is known.
    point: Option<L::Point>,
    outputs: L::Outputs,
    indicators: L::Indicators,
    /// Which outputs belong to the point: none of them, those before [`Law::LATE`], or all.
    shown: Shown,
}

#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
enum Shown {
    Nothing,
    Most,
    All,
}

/// No slope: a table of zeros.
fn flat<T: Table>() -> T {
    let mut table = T::default();
    (0..T::TABLE.len()).for_each(|row| {
        table.set(row, 0.0);
    });
    table
}

/// What the error of each state is measured by.
#[inline]
pub fn sizes<const N: usize>(list: &[State]) -> [f64; N] {
    std::array::from_fn(|n| list[n].value.nominal)
}

fn rows<T: Table>() -> std::ops::Range<usize> {
    0..T::TABLE.len()
}

impl<L: Law<N, M>, const N: usize, const M: usize> Default for Explicit<L, N, M> {
    fn default() -> Self {
        Explicit {
            law: L::default(),
            inputs: L::Inputs::default(),
            slopes: flat(),
            time: 0.0,
            tolerance: 1.0,
            rejected: 0,
            states: [0.0; N],
            opening: [0.0; M],
            point: None,
            outputs: L::Outputs::default(),
            indicators: L::Indicators::default(),
            shown: Shown::Nothing,
        }
    }
}

/// The present instant of a model, with no claim on its other fields.
macro_rules! now {
    ($model:ident) => {
        Now { time: $model.time, inputs: &$model.inputs, states: &$model.states, opening: &$model.opening }
    };
}

impl<L: Law<N, M>, const N: usize, const M: usize> Explicit<L, N, M> {
    /// The groups of the model: its own, then the law's parameters.
    pub fn groups() -> Vec<GroupAt> {
        let own = |prefix, table| GroupAt { prefix, base: 0, table };
        let mut all =
            vec![own("", L::Inputs::TABLE), own("", L::Outputs::TABLE), own("event.", L::Indicators::TABLE)];
        all.extend(L::groups());
        all
    }

    fn now(&self) -> Now<'_, L::Inputs, N, M> {
        now!(self)
    }

    /// What holds now; it is asked for once.
    #[inline]
    fn look(&mut self) -> &L::Point {
        let now = now!(self);
        self.point.get_or_insert_with(|| self.law.point(&now))
    }

    /// The outputs up to `row` belong to the present time.
    #[inline]
    fn show(&mut self, row: usize) {
        let wanted = if row < L::LATE { Shown::Most } else { Shown::All };
        if self.shown < wanted {
            self.refresh(wanted);
        }
    }

    fn refresh(&mut self, wanted: Shown) {
        let now = now!(self);
        let point = self.point.get_or_insert_with(|| self.law.point(&now));
        if self.shown < Shown::Most {
            self.outputs = self.law.outputs(&now, point);
        }
        if wanted == Shown::All {
            self.law.complete(&now, point, &mut self.outputs);
        }
        self.shown = wanted;
    }

    /// Something has changed: nothing is known any more.
    #[inline]
    fn forget(&mut self) {
        self.point = None;
        self.shown = Shown::Nothing;
    }

    fn value(&self, group: usize, row: usize) -> f64 {
        match group {
            INPUTS => self.inputs.get(row),
            OUTPUTS => self.outputs.get(row),
            INDICATORS => self.indicators.get(row),
            _ => self.law.value(group - OWN, row),
        }
    }

    fn set_value(&mut self, group: usize, row: usize, value: f64) -> bool {
        match group {
            INPUTS => self.inputs.set(row, value),
            OUTPUTS => self.outputs.set(row, value),
            INDICATORS => self.indicators.set(row, value),
            _ => self.law.set_value(group - OWN, row, value),
        }
    }

    /// What is set from outside and stays until it is set again: inputs and parameters.
    fn settable(&self) -> impl Iterator<Item = (usize, usize)> {
        let groups = L::declaration().groups.iter().enumerate();
        groups
            .filter(|&(g, _)| g != OUTPUTS && g != INDICATORS)
            .flat_map(|(g, group)| (0..group.table.len()).map(move |row| (g, row)))
    }
}

impl<L: Law<N, M>, const N: usize, const M: usize> Model for Explicit<L, N, M> {
    fn declaration(&self) -> &'static Declaration {
        L::declaration()
    }

    #[inline]
    fn get(&mut self, slot: Slot) -> f64 {
        match slot.group as usize {
            OUTPUTS => {
                self.show(slot.row as usize);
                return self.outputs.get(slot.row as usize);
            }
            INDICATORS => {
                let now = now!(self);
                let point = self.point.get_or_insert_with(|| self.law.point(&now));
                self.indicators = self.law.indicators(&now, point);
            }
            _ if slot.group == Slot::STATES => return self.states[slot.row as usize],
            _ if slot.group == Slot::RATES => return L::rates(self.look())[slot.row as usize],
            _ => {}
        }
        self.value(slot.group as usize, slot.row as usize)
    }

    #[inline]
    fn set(&mut self, slot: Slot, value: f64) -> bool {
        // What masters set at every step comes first.
        if slot.group as usize == INPUTS {
            self.forget();
            return self.inputs.set(slot.row as usize, value);
        }
        let before = (slot.group as usize >= OWN).then(|| self.law.clone());
        let taken = self.set_value(slot.group as usize, slot.row as usize, value);
        if let Some(before) = before {
            self.opening = self.law.retuned(&before, &self.now());
        }
        self.forget();
        taken
    }

    fn set_slope(&mut self, slot: Slot, slope: f64) {
        debug_assert_eq!(slot.group as usize, INPUTS);
        self.slopes.set(slot.row as usize, slope);
    }

    fn slope(&self, slot: Slot) -> f64 {
        self.slopes.get(slot.row as usize)
    }

    fn set_load(&mut self, table: &LoadTable) -> bool {
        self.forget();
        self.law.set_load(table)
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        (self.states, self.opening) = self.law.start(time, &self.inputs)?;
        self.time = time;
        self.forget();
        Ok(())
    }

    fn step(&mut self, time: f64, h: f64) -> Result<(), Fault> {
        let sloping = rows::<L::Inputs>().any(|row| self.slopes.get(row) != 0.0);
        let slopes = sloping.then_some(&self.slopes);
        let line = Line { time, inputs: &self.inputs, slopes, opening: &self.opening };
        let mut states = self.states;
        // What was found for the outputs is the beginning of the step, unless the caller counts time in another way.
        let first = self.point.as_ref().filter(|_| time == self.time);
        let one =
            |t: f64, x: &[f64; N], first: Option<&L::Point>, h: f64| self.law.one(&line, t, x, first, h);
        let followed = advance(one, &mut states, first, h, self.tolerance);
        self.rejected += followed.map_err(|stuck| {
            Fault(format!(
                "The equations of {} cannot be followed over a step of {h} s: it ends {} s after {time} s.",
                L::declaration().name,
                stuck.t
            ))
        })?;
        self.states = states;
        if sloping {
            self.inputs = self.inputs.after(h, &self.slopes);
            self.slopes = flat();
        }
        self.time = time + h;
        self.forget();
        Ok(())
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn states(&self, out: &mut Vec<f64>) {
        out.extend(self.states);
    }

    fn set_states(&mut self, time: f64, states: &[f64]) -> bool {
        let fits = states.len() == N;
        if fits {
            self.states.copy_from_slice(states);
            self.time = time;
            self.forget();
        }
        fits
    }

    fn rates(&mut self, out: &mut Vec<f64>) {
        out.extend(L::rates(self.look()));
    }

    /// The steps have one accuracy.
    fn ease(&mut self, _factor: f64) {}

    fn scale_tolerances(&mut self, factor: f64) {
        self.tolerance = factor;
    }

    fn rejected_steps(&self) -> u64 {
        self.rejected
    }

    /// Nothing that terms follow.
    fn drivers(&self) -> Drivers {
        Drivers { time: self.time, ..Drivers::default() }
    }

    fn save(&self, out: &mut Vec<f64>) {
        out.extend(self.settable().map(|(group, row)| self.value(group, row)));
        out.extend(self.slopes.values());
        out.push(self.time);
        out.extend(self.states);
        out.extend(self.opening);
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        let mut copy = self.clone();
        let mut rest = saved.iter().copied();
        let mut read = || -> Option<()> {
            for (group, row) in self.settable() {
                copy.set_value(group, row, rest.next()?).then_some(())?;
            }
            copy.slopes.take_values(&mut || rest.next())?;
            copy.time = rest.next()?;
            for number in copy.states.iter_mut().chain(&mut copy.opening) {
                *number = rest.next()?;
            }
            rest.next().is_none().then_some(())
        };
        let complete = read().is_some();
        if complete {
            copy.forget();
            *self = copy;
        }
        complete
    }

    crate::copies!();
}

impl<L: Law<N, M>, const N: usize, const M: usize> Exchange for Explicit<L, N, M> {
    /// Nothing is held: the rates are a function of time, states and inputs as they are.
    fn hand_over(&mut self) {}

    fn read_states(&self, out: &mut [f64]) {
        out.copy_from_slice(&self.states[..out.len()]);
    }

    fn write_states(&mut self, states: &[f64]) {
        self.states[..states.len()].copy_from_slice(states);
        self.forget();
    }

    fn write_time(&mut self, time: f64) {
        if time != self.time {
            self.forget();
        }
        self.time = time;
    }

    fn derivatives(&mut self, out: &mut [f64]) -> Result<(), Fault> {
        out.copy_from_slice(&L::rates(self.look())[..out.len()]);
        Ok(())
    }

    fn accept_step(&mut self) {}

    fn update(&mut self) -> Update {
        Update { states_changed: false, next_event: Exchange::next_event(self) }
    }

    fn next_event(&self) -> f64 {
        self.law.next_event(self.time)
    }
}
