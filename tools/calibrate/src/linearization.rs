//! Fitted model linearised along its runs, with its residual: the base point of a search for further effects.

mod null_model;
#[cfg(test)]
mod tests;

use crate::CalibrateError;
use crate::acting::acting;
use crate::catalogue::{LISTED, Listed, Way};
use crate::evidence::Evidence;
use crate::experiment::{Channel, Role};
use crate::fit::{Fitted, Slopes};
use crate::hypothesis::{Addition, Shape};
use crate::levels::CERTAIN;
use crate::search::{latent_input, structure};
use crate::setup::{Setup, Shown};
use crate::tangent::{Direction, Probe};
use nalgebra::DMatrix;
use null_model::evidence;
use physics::terms::{Driver, Drivers, Port};

/// Perturbation of a listed effect as a fraction of its nominal size. Numerical: half of the digits remain in the difference.
const WAY: f64 = 1e-3;

/// Error message if the parameters cannot be estimated.
const INSEPARABLE: &str =
    "the runs do not determine the parameters: state fewer of them in [prior], or smaller deviations";

/// First-order estimates of the parameters.
pub struct Estimated {
    /// Change of each parameter, in standard deviations of its prior.
    pub moves: Vec<f64>,
    /// Value of each parameter after the change, within its limits.
    pub moved: Vec<f64>,
    /// Covariance, in the same units.
    pub covariance: DMatrix<f64>,
    /// Mean square of the residual: 1 for noise alone.
    pub misfit: f64,
}

/// Linearised fitted model.
pub struct Linearization<'a> {
    /// The experiment.
    pub setup: &'a Setup<'a>,
    /// The model.
    pub fitted: Fitted,
    /// The runs that are evaluated.
    pub runs: Vec<usize>,
    /// The model linearised along these runs.
    pub slopes: Slopes,
    /// The residual with all columns that already explain parts of it.
    pub evidence: Evidence,
    /// See [`validated`](Self::validated).
    with_validation: Option<(f64, f64)>,
    /// Forms of the effects with a usable derivative, in the order of their directions after those of the model.
    listed: Vec<(&'static Listed, Addition)>,
    /// Number of inputs.
    inputs: usize,
    /// Ports at which latent inputs are evaluated.
    ports: &'static [Port],
}

impl<'a> Linearization<'a> {
    /// Linearises a fitted model along the runs of the fit, for a search for further effects.
    ///
    /// # Errors
    /// The message of the model if it cannot be run.
    pub fn new(
        setup: &'a Setup<'a>,
        fitted: Fitted,
        runs: &[usize],
    ) -> Result<Linearization<'a>, CalibrateError> {
        Linearization::of(setup, fitted, runs, &LISTED, Port::ALL)
    }

    /// The same without a search: residual and uncertainty of the parameters only.
    ///
    /// # Errors
    /// The message of the model if it cannot be run.
    pub fn judged(
        setup: &'a Setup<'a>,
        fitted: Fitted,
        runs: &[usize],
    ) -> Result<Linearization<'a>, CalibrateError> {
        Linearization::of(setup, fitted, runs, &[], &[])
    }

    /// The same for a latent input at one port.
    ///
    /// # Errors
    /// The message of the model if it cannot be run.
    pub fn beside(
        setup: &'a Setup<'a>,
        fitted: Fitted,
        runs: &[usize],
        port: &'static Port,
    ) -> Result<Linearization<'a>, CalibrateError> {
        Linearization::of(setup, fitted, runs, &[], std::slice::from_ref(port))
    }

    /// Columns of the correction of an input in these runs by `count` numbers, of which the input has the derivative `weight` (number, run,
    /// row): to first order, the response to an error of its instrument.
    pub fn input_columns(
        &self,
        input: usize,
        runs: &[usize],
        count: usize,
        weight: impl Fn(usize, usize, usize) -> f64,
    ) -> Option<DMatrix<f64>> {
        let place = self.ports.len() + input;
        self.columns(count, |r, k| {
            let run = self.runs[r];
            if !runs.contains(&run) {
                return Some(None);
            }
            let direction = self.further(r)[place].as_ref()?;
            Some(Some(self.slopes.tangents[r].response(direction, |row| weight(k, run, row))))
        })
    }

    fn of(
        setup: &'a Setup<'a>,
        fitted: Fitted,
        runs: &[usize],
        effects: &'static [Listed],
        ports: &'static [Port],
    ) -> Result<Linearization<'a>, CalibrateError> {
        let all = vec![true; setup.experiment.runs.len()];
        let known = |listed: &Listed, addition: &Addition| {
            let Shape::Listed { slots, .. } = &addition.shape else { return true };
            let taken = fitted.hypothesis.additions.iter().any(|a| a.id == listed.id);
            let set = setup.bench.start_of(slots[0]) != 0.0
                || setup.declared.iter().any(|d| slots.contains(&d.slot));
            // A declared effect may have another size in some runs.
            taken || (set && !listed.may_vary)
        };
        let listed: Vec<(&'static Listed, Addition)> = effects
            .iter()
            .filter(|l| l.way == Way::Slope)
            .flat_map(|l| l.forms(setup, &all).into_iter().map(move |form| (l, form)))
            .filter(|(l, a)| !known(l, a))
            .collect();
        let mut further: Vec<Probe> = ports.iter().map(|port| Probe::Port(*port)).collect();
        let inputs = setup.experiment.inputs.len();
        further.extend(setup.input_probes());
        for (_, addition) in &listed {
            let Shape::Listed { slots, with, .. } = &addition.shape else { continue };
            let way = WAY * addition.numbers[0].scale;
            let shape =
                slots.iter().zip(&addition.numbers).skip(1).map(|(slot, number)| (*slot, number.value));
            let with = with.iter().copied().chain(shape).collect();
            further.push(Probe::Parameter { slot: slots[0], with, way });
        }
        let slopes = Slopes::new(setup, &fitted.hypothesis, runs, &further)?;
        let evidence = evidence(setup, &fitted, runs, &slopes, further.len(), ports.len())?;
        let mut point = Linearization {
            setup,
            fitted,
            runs: runs.to_vec(),
            slopes,
            evidence,
            with_validation: None,
            ports,
            listed,
            inputs,
        };
        // The first linearization with all ports determines the structure error.
        let is_first = ports.len() == Port::ALL.len() && setup.structure.get().is_none();
        if is_first || ports.is_empty() {
            point.with_validation = point.validated(&further);
        }
        if is_first {
            setup.structure.get_or_init(|| structure(&point));
        }
        point.complete()?;
        // No further search from here; the memory is released, because many linearizations are kept.
        if ports.is_empty() {
            point.evidence.settle();
        }
        Ok(point)
    }

    /// Adds structure error and the memory of the noise to the null model.
    fn complete(&mut self) -> Result<(), CalibrateError> {
        let inseparable = || CalibrateError(INSEPARABLE.to_string());
        let values = self.evidence.values();
        if let Some(columns) = self.setup.structure.get().filter(|columns| columns.nrows() >= values) {
            let with = self.evidence.with_structure(&columns.rows(0, values).into_owned());
            self.evidence = with.ok_or_else(inseparable)?;
        }
        self.evidence.add_memory().ok_or_else(inseparable)
    }

    /// -2 log p of the fit runs and the validation runs; `None` without validation runs, and if the model cannot be run there.
    fn validated(&mut self, further: &[Probe]) -> Option<(f64, f64)> {
        let (setup, fit) = (self.setup, self.runs.len());
        let validation = setup.runs(Role::Validate);
        if validation.is_empty() || self.runs != setup.runs(Role::Fit) {
            return None;
        }
        let hypothesis = acting(setup, &self.fitted.hypothesis, &validation).ok()?;
        let fitted = setup.judged(hypothesis, &validation).ok()?;
        let slopes = Slopes::new(setup, &fitted.hypothesis, &validation, further).ok()?;
        let own = std::mem::replace(&mut self.fitted.hypothesis, fitted.hypothesis);
        self.runs.extend(&validation);
        self.fitted.shown.extend(fitted.shown);
        self.slopes.extend(slopes);
        let cost = self.cost_of_all(further.len()).ok();
        self.fitted.hypothesis = own;
        self.runs.truncate(fit);
        self.fitted.shown.truncate(fit);
        self.slopes.truncate(fit);
        cost
    }

    /// -2 log p of all runs of the linearization. The first one with all ports determines the structure error along all of them.
    fn cost_of_all(&mut self, further: usize) -> Result<(f64, f64), CalibrateError> {
        let whole = evidence(self.setup, &self.fitted, &self.runs, &self.slopes, further, self.ports.len())?;
        let own = std::mem::replace(&mut self.evidence, whole);
        if self.ports.len() == Port::ALL.len() {
            self.setup.structure.get_or_init(|| structure(self));
        }
        let cost = self.complete().map(|()| self.evidence.cost());
        self.evidence = own;
        cost
    }

    /// Decrease of -2 log p from `before` to this model, for autocorrelated and for white noise, over the fit runs and the validation runs:
    /// parameters are those of the fit, and all these runs change them to first order.
    pub fn explains(&self, before: &Linearization) -> (f64, f64) {
        let pair = before.with_validation.zip(self.with_validation);
        let (before, own) = pair.unwrap_or_else(|| (before.evidence.cost(), self.evidence.cost()));
        (before.0 - own.0, before.1 - own.1)
    }

    /// The part of [`explains`](Self::explains) beyond that of the fit runs alone: twice the logarithm of the ratio of the predictive densities
    /// of the validation runs, with their own zero offsets, drift and structure error. `None` without validation runs.
    ///
    /// *Source*: Geisser, Eddy, J. Am. Stat. Assoc. 74 (1979) 153-160 (predictive densities select models).
    pub fn delta_validation(&self, before: &Linearization) -> Option<f64> {
        let known = before.with_validation?.0 - before.evidence.cost().0;
        let own = self.with_validation.map(|cost| cost.0 - self.evidence.cost().0);
        Some(known - own.unwrap_or(f64::INFINITY))
    }

    /// Releases all memory except parameters, their uncertainties and cost.
    pub fn release(&mut self) {
        self.slopes.tangents = Vec::new();
        self.evidence.release();
    }

    /// Parameter changes to first order, with uncertainty; optionally estimated jointly with a latent input at a port, which must be among
    /// the ports of the linearization.
    pub fn estimated(&self, beside: Option<Port>) -> Estimated {
        let free = beside.and_then(|port| latent_input(self, port));
        let gain = free.as_ref().and_then(|f| self.evidence.shape(&f.columns, &f.kernel));
        let beside = free.as_ref().zip(gain.as_ref()).map(|(f, gain)| (&f.columns, gain));
        let scales = self.setup.scales(&self.fitted.hypothesis);
        let (moves, covariance) = self.evidence.estimate(scales.len(), beside);
        let numbers = self.fitted.hypothesis.numbers().into_iter().zip(&scales).zip(&moves);
        let moved = numbers
            .map(|((x, (scale, (least, most), _)), way)| (x + way * scale).clamp(*least, *most))
            .collect();
        Estimated { moves, moved, covariance, misfit: self.evidence.misfit(beside) }
    }

    /// Penalty for each parameter: ln n, n the number of blocks.
    pub fn per_number(&self) -> f64 {
        (self.evidence.values() as f64).ln()
    }

    fn further(&self, r: usize) -> &[Option<Direction>] {
        self.slopes.further(r, self.ports.len() + self.inputs + self.listed.len())
    }

    /// The effects with a usable derivative that the model does not include: the index of the first form of each, and its forms, that with the
    /// preset's shape first.
    pub fn listed(&self) -> impl Iterator<Item = (usize, &[(&'static Listed, Addition)])> {
        let effects = self.listed.chunk_by(|(a, _), (b, _)| std::ptr::eq(*a, *b));
        effects.scan(0, |next, forms| {
            *next += forms.len();
            Some((*next - forms.len(), forms))
        })
    }

    /// Size of a listed effect in the fitted model, before the search.
    pub fn base(&self, addition: &Addition) -> f64 {
        match &addition.shape {
            Shape::Listed { slots, .. } => {
                let declared =
                    self.setup.declared.iter().position(|d| d.slot == slots[0] && d.runs.is_none());
                declared.map_or_else(
                    || self.setup.bench.start_of(slots[0]),
                    |k| self.fitted.hypothesis.declared[k],
                )
            }
            _ => 0.0,
        }
    }

    /// Column of the `k`-th of the [numbers](crate::hypothesis::Hypothesis::numbers) in these runs alone.
    pub fn parameter_column(&self, k: usize, runs: &[usize]) -> Option<DMatrix<f64>> {
        self.columns(1, |r, _| {
            let is_own = runs.contains(&self.runs[r]);
            Some(is_own.then(|| self.slopes.answer(&self.fitted.hypothesis, r, k)).flatten())
        })
    }

    /// Column of the `k`-th form of [`listed`](Self::listed), in the runs selected by `active` (by index among the runs evaluated).
    pub fn listed_column(&self, k: usize, active: &[bool]) -> Option<DMatrix<f64>> {
        let place = self.ports.len() + self.inputs + k;
        let hidden = self.hidden_at(self.listed[k].0.port);
        self.columns(1, |r, _| {
            if !active[r] {
                return Some(None);
            }
            let (direction, tangent) = (self.further(r)[place].as_ref()?, &self.slopes.tangents[r]);
            Some(Some(
                tangent.response(direction, |row| if hidden(&tangent.drivers[row]) { 0.0 } else { 1.0 }),
            ))
        })
    }

    /// The runs whose start is estimated, by index among the runs evaluated.
    pub fn warm_runs(&self) -> impl Iterator<Item = usize> {
        let is_warm = |(_, run): &(usize, &usize)| self.setup.drives[**run].estimates_start();
        self.runs.iter().enumerate().filter(is_warm).map(|(r, _)| r)
    }

    /// Whether a channel has a reading in a run that is evaluated.
    pub fn is_read(&self, channel: &Channel) -> bool {
        let experiment = self.setup.experiment;
        let all = experiment.inputs.iter().chain(&experiment.outputs);
        let Some(place) = all.clone().position(|c| c.column == channel.column) else { return false };
        self.runs.iter().any(|r| experiment.runs[*r].table.columns[place].iter().any(|x| x.is_finite()))
    }

    /// Rows at which noise hides the sign of a latent input at a port that reverses with the current or the speed.
    fn hidden_at(&self, port: Port) -> impl Fn(&Drivers) -> bool {
        self.hidden(match port {
            Port::TerminalVoltage => Some(Driver::Current),
            Port::DragTorque => Some(Driver::Speed),
            _ => None,
        })
    }

    /// Rows at which a current or speed is indistinguishable from zero. A candidate that acts there would explain the noise by making the
    /// motor insensitive to its inputs.
    pub fn hidden(&self, driver: Option<Driver>) -> impl Fn(&Drivers) -> bool {
        let driver = driver.filter(|d| matches!(d, Driver::Current | Driver::Speed));
        let least = driver.and_then(|d| Some((d, CERTAIN * self.setup.noise_of(Channel::reading(d)?)?)));
        move |drivers| least.is_some_and(|(driver, least)| drivers.of(driver).abs() < least)
    }

    /// Columns of latent inputs at a port, one for each of `count` shapes; a shape is a function of run, row and drivers.
    pub fn port_columns(
        &self,
        port: Port,
        count: usize,
        shape: impl Fn(usize, usize, usize, &Drivers) -> f64,
    ) -> Option<DMatrix<f64>> {
        let place = self.ports.iter().position(|p| *p == port)?;
        let hidden = self.hidden_at(port);
        self.columns(count, |r, k| {
            let direction = self.further(r)[place].as_ref()?;
            let tangent = &self.slopes.tangents[r];
            let drivers = tangent.drivers.iter().enumerate();
            let felt = drivers.map(|(row, d)| if hidden(d) { 0.0 } else { shape(k, r, row, d) });
            let values: Vec<f64> = felt.collect();
            Some(values.iter().any(|v| *v != 0.0).then(|| tangent.response(direction, |row| values[row])))
        })
    }

    /// Columns of an effect of the list that changes a quantity in a step at each of these times.
    pub fn step_columns(&self, port: Port, times: &[f64]) -> Option<DMatrix<f64>> {
        let clock = |r: usize| &self.setup.drives[self.runs[r]].time;
        let after = |at: f64, r: usize, row: usize| if clock(r)[row] >= at { -1.0 } else { 0.0 };
        self.port_columns(port, times.len(), |k, r, row, _| after(times[k], r, row))
    }

    /// Greatest change of each output by the last addition, to first order, in SI units.
    pub fn reach(&self) -> Vec<f64> {
        let mut most = vec![0.0f64; self.setup.outputs()];
        for own in 0..self.runs.len() {
            for (k, x) in self.amplitude(own, own).flatten().into_iter().flatten().enumerate() {
                let output = k % most.len();
                most[output] = most[output].max(x.abs());
            }
        }
        most
    }

    /// Sensitivity to the amplitude of the last addition in one run only (by index): derivative with respect to its relative change.
    pub fn amplitude_column(&self, own: usize) -> Option<DMatrix<f64>> {
        self.columns(1, |r, _| self.amplitude(r, own))
    }

    /// Response of the `r`-th run to a relative change of the last addition; zero for all runs except `own`.
    fn amplitude(&self, r: usize, own: usize) -> Option<Option<Vec<f64>>> {
        let hypothesis = &self.fitted.hypothesis;
        let addition = hypothesis.additions.last()?;
        if r != own {
            return Some(None);
        }
        let sloped: Vec<f64> = addition.numbers.iter().filter(|n| n.sloped).map(|n| n.value).collect();
        let sizes = addition.sizes();
        let first = self.slopes.count() - sloped.len();
        let mut sum: Option<Vec<f64>> = None;
        for (k, value) in sloped[..sizes].iter().enumerate() {
            let answer = self.slopes.answer(hypothesis, r, first + k)?;
            let sum = sum.get_or_insert_with(|| vec![0.0; answer.len()]);
            sum.iter_mut().zip(&answer).for_each(|(s, a)| *s += value * a);
        }
        Some(sum)
    }

    /// Column of the difference between simulations with an addition of given size and the fitted model.
    pub fn simulated_column(&self, addition: &Addition) -> Option<DMatrix<f64>> {
        let mut larger = self.fitted.hypothesis.clone();
        larger.additions.push(addition.clone());
        self.difference_column(&self.setup.show(&larger, &self.runs).ok()?)
    }

    /// Column of the difference between outputs simulated in these runs and those of the fitted model.
    pub fn difference_column(&self, shown: &[Shown]) -> Option<DMatrix<f64>> {
        self.columns(1, |r, _| {
            Some(Some(shown[r].iter().zip(&self.fitted.shown[r]).map(|(a, b)| a - b).collect()))
        })
    }

    /// Columns over the blocks of all runs; `answer` gives rows times outputs for run and column, `Some(None)` for zero.
    fn columns(
        &self,
        count: usize,
        answer: impl Fn(usize, usize) -> Option<Option<Vec<f64>>>,
    ) -> Option<DMatrix<f64>> {
        let mut all = Vec::with_capacity(self.evidence.values() * count);
        for k in 0..count {
            for (r, run) in self.runs.iter().enumerate() {
                match answer(r, k)? {
                    Some(values) => self.setup.means(*run, &values, &mut all),
                    None => all.extend(self.setup.blocks[*run].iter().map(|_| 0.0)),
                }
            }
        }
        Some(DMatrix::from_vec(self.evidence.values(), count, all))
    }

    /// Values of the drivers at the rows of the runs, predicted by the fit without added effects, which is close to the readings. A model
    /// without an effect that was found deviates from them and covers ranges of the drivers in which there are no readings.
    pub fn drivers(&self) -> impl Iterator<Item = &Drivers> {
        let own = if self.setup.reached.is_empty() { &self.slopes.tangents[..] } else { &[] };
        self.setup.reached.iter().chain(own.iter().flat_map(|t| &t.drivers))
    }
}
