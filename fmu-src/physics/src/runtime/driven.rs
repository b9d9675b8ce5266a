//! Terms from data in a model: their drivers over a step, the states of their lags, and the heat capacities that they change.
//!
//! At the ports of current and speed the equations evaluate the drivers at every stage of a step. Elsewhere the drivers are constant
//! over a step, at their mean; where they follow states, a trial step gives it. A step in which a term changes much is divided.

use super::{Equations, Halt, Runtime};
use crate::components::sensor::{lagged, mean_lagged};
use crate::effects::{EffectPort, Effects};
use crate::line::Line;
use crate::saved;
use crate::terms::{Drivers, Lag, LagStarts, MOST_TERMS};
use declare::{Group, index_of};

/// Number of parts of a step in which a law of the terms changes by its span. The midpoint rule of a law that rises by its
/// span and falls again is exact to 2 / (8 x 32^2) of the span over the step, 2e-4.
const PARTS: f64 = 32.0;
/// Largest number of parts: a law far outside the data may change by many of its spans.
const MOST_PARTS: f64 = 128.0;

/// States of the terms of a model.
#[derive(Clone, Copy, Debug)]
pub struct TermStates {
    /// Factor on the heat capacities.
    pub capacity_factor: f64,
    /// Whether effects depend on drivers that follow the states of the model and are constant over a step; it follows from the parameters.
    pub holds_states: bool,
    /// State of each term's lag, in the unit of its driver.
    lags: [f64; MOST_TERMS],
    /// The same over the present step, as lines from this time on; none between the steps.
    over_step: Option<([Line; MOST_TERMS], f64)>,
    /// Mean of each over the last step; the next step does not depend on it.
    mean: [f64; MOST_TERMS],
}

saved!(TermStates { capacity_factor, lags });

impl Default for TermStates {
    fn default() -> Self {
        let none = [0.0; MOST_TERMS];
        TermStates { capacity_factor: 1.0, holds_states: false, lags: none, over_step: None, mean: none }
    }
}

impl TermStates {
    /// The lags from `time` on: lines within a step, constant between the steps.
    pub fn lags_after(&self, time: f64) -> [Line; MOST_TERMS] {
        match &self.over_step {
            Some((lines, since)) => lines.map(|line| Line { start: line.at(time - since), ..line }),
            None => self.lags.map(|start| Line { start, slope: 0.0 }),
        }
    }
}

/// A model at whose ports terms from data act.
pub trait Driven<const N: usize>: Equations<N> {
    /// The states at one instant that drivers and heat flows follow.
    type Instant: Copy;
    /// The model before a step that may be undone.
    type Checkpoint;

    /// The effects, which evaluate the terms.
    fn effects(parameters: &Self::Parameters) -> &Effects;
    /// The starts of the lags.
    fn lag_starts(parameters: &Self::Parameters) -> &LagStarts;
    /// The states of the terms.
    fn terms(&self) -> &TermStates;
    /// The states of the terms, to change them.
    fn terms_mut(&mut self) -> &mut TermStates;
    /// Energy stored at the start, J: reference of the energy balance.
    fn stored_at_start(&mut self) -> &mut f64;

    /// The present states.
    fn instant(run: &Runtime<Self, N>) -> Self::Instant;
    /// Replaces the present states.
    fn put_instant(run: &mut Runtime<Self, N>, at: Self::Instant);
    /// The states in the middle of the last step, which began `h` seconds ago in the state `from`.
    fn middle(run: &Runtime<Self, N>, from: &Self::Instant, h: f64) -> Self::Instant;
    /// The drivers at `time` with these inputs and states; heat flows and lags are zero.
    fn drivers_of(run: &Runtime<Self, N>, time: f64, inputs: &Self::Inputs, at: &Self::Instant) -> Drivers;
    /// Integrals over the last step of current, speed, and temperatures of winding and housing, if the integrator has them all.
    fn integrals(run: &Runtime<Self, N>) -> Option<[f64; 4]>;
    /// Present copper loss and friction loss, W.
    fn heat_flows(run: &Runtime<Self, N>) -> [f64; 2];
    /// Sets the drivers that effects hold constant.
    fn hold(run: &mut Runtime<Self, N>, drivers: &Drivers);
    /// Applies changed parameters.
    fn follow_parameters(run: &mut Runtime<Self, N>);
    /// Heat stored in the nodes, J, with this factor on the heat capacities.
    fn heat(run: &Runtime<Self, N>, capacity_factor: f64) -> f64;
    /// A step with the drivers already set.
    ///
    /// # Errors
    /// As [`Equations::advance`].
    fn take(run: &mut Runtime<Self, N>, time: f64, h: f64) -> Result<(), Halt>;
    /// The present state, for [`return_to`](Driven::return_to).
    fn checkpoint(run: &mut Runtime<Self, N>) -> Self::Checkpoint;
    /// Undoes what happened since.
    fn return_to(run: &mut Runtime<Self, N>, before: Self::Checkpoint);
}

/// Start of a step, for the lags.
struct LagStart<M: Driven<N>, const N: usize> {
    /// Input of each lag.
    sources: [f64; MOST_TERMS],
    /// Inputs of the model in the middle of the step.
    middle: M::Inputs,
    at: M::Instant,
}

impl<M: Driven<N>, const N: usize> Runtime<M, N> {
    /// Whether an effect depends on drivers.
    #[inline(always)]
    pub(crate) fn has_driven_effects(&self) -> bool {
        M::effects(&self.parameters).acts_at(EffectPort::Any)
    }

    /// Whether current or speed is a state in use.
    fn has_fast_states(&self) -> bool {
        let [current, speed] =
            const { [index_of(M::LIST, "state.current"), index_of(M::LIST, "state.shaft_speed")] };
        M::moves(self, current) || M::moves(self, speed)
    }

    /// Sets the drivers of the terms to their values at `time` and updates the heat capacities.
    #[inline]
    pub(crate) fn set_drivers(&mut self, time: f64) {
        if self.has_driven_effects() {
            let drivers = self.drivers_after(time, 0.0);
            M::hold(self, &drivers);
        }
        self.follow_capacity();
    }

    /// Updates the heat capacities to the drivers.
    #[inline]
    fn follow_capacity(&mut self) {
        let factor = M::effects(&self.parameters).capacity_factor();
        if factor != self.own.terms().capacity_factor {
            self.change_capacity(factor);
        }
    }

    /// Not inlined, because hardly any step changes the heat capacities.
    #[inline(never)]
    fn change_capacity(&mut self, factor: f64) {
        let gained = self.heat_gained(factor);
        self.own.terms_mut().capacity_factor = factor;
        M::follow_parameters(self);
        *self.own.stored_at_start() += gained;
    }

    /// Heat that the nodes gain by a change of the factor on the heat capacities to `factor`, J; 0 in Model Exchange, where the energy
    /// balance excludes it only when the importer completes a step ([`Self::book_capacity`]).
    pub(crate) fn heat_gained(&self, factor: f64) -> f64 {
        if self.pre.is_some() { 0.0 } else { self.heat_difference(self.own.terms().capacity_factor, factor) }
    }

    /// Heat that the nodes gain by a change of the factor on the heat capacities, J.
    fn heat_difference(&self, from: f64, to: f64) -> f64 {
        if from == to { 0.0 } else { M::heat(self, to) - M::heat(self, from) }
    }

    /// The importer has completed a step: the energy balance excludes the heat that the nodes have gained since the factor on the heat
    /// capacities was `booked`, a discrete state.
    pub(crate) fn book_capacity(&mut self, booked: impl FnOnce(&mut M::Discrete) -> &mut f64) {
        self.set_drivers(self.time);
        let factor = self.own.terms().capacity_factor;
        if let Some(pre) = &mut self.pre {
            let before = std::mem::replace(booked(&mut pre.discrete), factor);
            *self.own.stored_at_start() += self.heat_difference(before, factor);
            self.outdate();
        }
    }

    /// A step without an event inside.
    #[inline]
    pub(crate) fn advance_driven(&mut self, time: f64, h: f64) -> Result<(), Halt> {
        if !self.has_driven_effects() {
            self.follow_capacity();
            return self.take_step(time, h);
        }
        let along = self.drivers_along(time, h)?;
        let [from, _, to] = &along;
        let parts = (PARTS * M::effects(&self.parameters).change(from, to)).ceil();
        if parts > 1.0 {
            return self.advance_in_parts(time, h, parts.min(MOST_PARTS));
        }
        self.take_estimated(time, h, &along)
    }

    /// A step in which the drivers of the terms change much, in equal parts.
    #[inline(never)]
    fn advance_in_parts(&mut self, time: f64, h: f64, parts: f64) -> Result<(), Halt> {
        let (before, slopes, part) = (M::checkpoint(self), self.slopes, h / parts);
        for k in 0..parts as usize {
            self.put_slopes(slopes);
            let at = time + k as f64 * part;
            let taken = self.drivers_along(at, part).and_then(|along| self.take_estimated(at, part, &along));
            if let Err(halt) = taken {
                M::return_to(self, before);
                return Err(halt);
            }
        }
        self.time = time + h;
        Ok(())
    }

    /// A step with estimated drivers.
    fn take_estimated(&mut self, time: f64, h: f64, along: &[Drivers; 3]) -> Result<(), Halt> {
        self.take_along(time, h, along)?;
        // Current and speed have settled at the end of the lag's line. A lag that differs from it, if only by the error of the estimate,
        // would give them derivatives of this difference over L/R.
        if self.own.terms().holds_states && self.has_fast_states() {
            self.own.terms_mut().lags = along[2].lagged;
        }
        Ok(())
    }

    /// A step with the drivers at its start, on average and at its end.
    fn take_along(&mut self, time: f64, h: f64, [from, mean, to]: &[Drivers; 3]) -> Result<(), Halt> {
        M::hold(self, mean);
        self.follow_capacity();
        let line = |k: usize| Line { start: from.lagged[k], slope: (to.lagged[k] - from.lagged[k]) / h };
        self.own.terms_mut().over_step = Some((std::array::from_fn(line), time));
        let taken = self.take_step(time, h);
        self.own.terms_mut().over_step = None;
        taken
    }

    /// A step with the drivers already set, and of the lags.
    #[inline]
    fn take_step(&mut self, time: f64, h: f64) -> Result<(), Halt> {
        let is_lagging = self.has_driven_effects() && M::effects(&self.parameters).has_lags();
        let start = is_lagging.then(|| self.lag_start(h));
        M::take(self, time, h)?;
        // The following is evaluated at the end of the step, where the inputs have their final values.
        self.clear_slopes();
        if let Some(start) = start {
            self.follow_lags(&start, h);
        }
        Ok(())
    }

    /// The lag of each term, if it has one.
    fn lags_of_terms(&self) -> [Option<Lag>; MOST_TERMS] {
        std::array::from_fn(|k| M::effects(&self.parameters).lag(k))
    }

    /// Drivers of the terms at the start, on average and at the end of a step of `h` seconds. Where they follow states, a trial step gives
    /// the others, so that constant drivers are of second order in the step, also if they follow a current that changes within milliseconds.
    fn drivers_along(&mut self, time: f64, h: f64) -> Result<[Drivers; 3], Halt> {
        let from = self.drivers_after(time, 0.0);
        let mut to = self.drivers_after(time, h);
        let mut mean = from.middle(&to);
        let (lags, holds_states) = (self.lags_of_terms(), self.own.terms().holds_states);
        // First estimate of the lags of states: their drivers stay as they are.
        let present = if holds_states { self.lag_sources() } else { [0.0; MOST_TERMS] };
        for (k, lag) in lags.iter().enumerate() {
            let Some(Lag { driver, tau, .. }) = *lag else { continue };
            let source = match holds_states {
                true => [present[k]; 3],
                false => [&from, &mean, &to].map(|drivers| drivers.of(driver)),
            };
            to.lagged[k] = lagged(from.lagged[k], tau, source, h);
            mean.lagged[k] = mean_lagged([from.lagged[k], to.lagged[k]], tau, source, h);
        }
        if !holds_states {
            return Ok([from, mean, to]);
        }
        let before = M::checkpoint(self);
        let taken = self.take_along(time, h, &[from, mean, to]);
        to = self.drivers_after(time + h, 0.0);
        mean = Drivers { lagged: self.own.terms().mean, ..from.middle(&to) };
        if let Some(integrals) = M::integrals(self) {
            // A current may reach its new value in a small part of the step.
            [mean.current, mean.speed, mean.winding_temperature, mean.housing_temperature] =
                integrals.map(|integral| integral / h);
        }
        M::return_to(self, before);
        taken?;
        Ok([from, mean, to])
    }

    /// Drivers of the terms with the present states and the inputs `h` seconds after `time`.
    pub(crate) fn drivers_after(&self, time: f64, h: f64) -> Drivers {
        let inputs = self.inputs_after(h);
        // Heat flows are available only after the effects have their drivers; lags alone use them ([`Self::lag_sources`]).
        let drivers = M::drivers_of(self, time + h, &inputs, &M::instant(self));
        Drivers { lagged: self.own.terms().lags, ..drivers }
    }

    /// The inputs after `h` seconds.
    fn inputs_after(&self, h: f64) -> M::Inputs {
        if h > 0.0 && self.is_sloping() { self.inputs.after(h, &self.slopes) } else { self.inputs }
    }

    /// Present drivers of the terms, with these heat flows.
    pub(crate) fn drivers_with(&self, [copper_loss, friction_loss]: [f64; 2]) -> Drivers {
        Drivers { copper_loss, friction_loss, ..self.drivers_after(self.time, 0.0) }
    }

    /// Present input of each term's lag; 0 without a lag.
    fn lag_sources(&self) -> [f64; MOST_TERMS] {
        sources_of(&self.lags_of_terms(), self.drivers_after(self.time, 0.0), || M::heat_flows(self))
    }

    /// Initialises each lag at the value of its driver and what `initial.term_lag_*` add to it.
    pub(crate) fn start_lags(&mut self) {
        if !M::effects(&self.parameters).has_lags() {
            return;
        }
        self.own.terms_mut().lags = [0.0; MOST_TERMS];
        self.set_drivers(self.time);
        // Two passes: heat flows may depend on the drivers.
        let above = M::lag_starts(&self.parameters).of_terms();
        for _ in 0..2 {
            let sources = self.lag_sources();
            self.own.terms_mut().lags = std::array::from_fn(|k| sources[k] + above[k] * self.lag_size(k));
            self.set_drivers(self.time);
        }
    }

    /// What the lags need of the start of a step of `h` seconds.
    fn lag_start(&self, h: f64) -> LagStart<M, N> {
        LagStart { sources: self.lag_sources(), middle: self.inputs_after(0.5 * h), at: M::instant(self) }
    }

    /// Advances the lags over a step of `h` seconds that began there.
    fn follow_lags(&mut self, start: &LagStart<M, N>, h: f64) {
        let at = M::middle(self, &start.at, h);
        let time = self.time - 0.5 * h;
        let (lags, drivers) = (self.lags_of_terms(), M::drivers_of(self, time, &start.middle, &at));
        let middle = sources_of(&lags, drivers, || self.heat_flows_at(time, start.middle, at));
        let after = self.lag_sources();
        for (k, lag) in lags.iter().enumerate() {
            if let Some(lag) = lag {
                let source = [start.sources[k], middle[k], after[k]];
                let terms = self.own.terms_mut();
                let before = terms.lags[k];
                terms.lags[k] = lagged(before, lag.tau, source, h);
                terms.mean[k] = mean_lagged([before, terms.lags[k]], lag.tau, source, h);
            }
        }
    }

    /// Heat flows at another time with other inputs and states.
    fn heat_flows_at(&mut self, time: f64, inputs: M::Inputs, at: M::Instant) -> [f64; 2] {
        let present = (self.time, self.inputs, M::instant(self));
        (self.time, self.inputs) = (time, inputs);
        M::put_instant(self, at);
        M::follow_inputs(self);
        let heat_flows = M::heat_flows(self);
        (self.time, self.inputs) = (present.0, present.1);
        M::put_instant(self, present.2);
        heat_flows
    }

    /// Scale of a lag state.
    fn lag_size(&self, k: usize) -> f64 {
        M::effects(&self.parameters).lag(k).map_or(1.0, |lag| lag.driver.nominal())
    }

    /// Whether the `k`-th term has a lag.
    pub(crate) fn has_lag(&self, k: usize) -> bool {
        M::effects(&self.parameters).lag(k).is_some()
    }

    /// State of the `k`-th term's lag, divided by a typical value of its driver; 0 without one.
    pub(crate) fn lag_state(&self, k: usize) -> f64 {
        if self.has_lag(k) { self.own.terms().lags[k] / self.lag_size(k) } else { 0.0 }
    }

    /// Sets the state of the `k`-th term's lag.
    pub(crate) fn put_lag_state(&mut self, k: usize, value: f64) {
        self.own.terms_mut().lags[k] = value * self.lag_size(k);
    }

    /// Derivatives of the lag states, with the heat flows from elsewhere.
    pub(crate) fn lag_rates(&self, heat_flows: impl FnOnce() -> [f64; 2]) -> [f64; MOST_TERMS] {
        if !M::effects(&self.parameters).has_lags() {
            return [0.0; MOST_TERMS];
        }
        let (lags, now) = (self.lags_of_terms(), self.own.terms().lags);
        let sources = sources_of(&lags, self.drivers_after(self.time, 0.0), heat_flows);
        std::array::from_fn(|k| {
            lags[k].map_or(0.0, |lag| (sources[k] - now[k]) / (lag.tau * lag.driver.nominal()))
        })
    }
}

/// Input of each term's lag with these drivers; the heat flows are evaluated only for a lag that needs them.
fn sources_of(
    lags: &[Option<Lag>; MOST_TERMS],
    mut drivers: Drivers,
    heat_flows: impl FnOnce() -> [f64; 2],
) -> [f64; MOST_TERMS] {
    if lags.iter().flatten().any(|lag| lag.driver.is_heat()) {
        [drivers.copper_loss, drivers.friction_loss] = heat_flows();
    }
    lags.map(|lag| lag.map_or(0.0, |lag| drivers.of(lag.driver)))
}
