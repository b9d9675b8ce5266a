//! Fitted model linearised along its runs, with its residual: the base point of a search for further effects.

use crate::CalibrateError;
use crate::catalogue::{LISTED, Listed, Way};
use crate::evidence::{Evidence, Prior, Series};
use crate::experiment::Channel;
use crate::fit::{Fitted, Slopes};
use crate::hypothesis::{Addition, Shape, hat};
use crate::levels::{CALIBRATED, CERTAIN};
use crate::parallel;
use crate::search::{latent_input, structure};
use crate::setup::{Setup, Shown};
use crate::tangent::{Direction, Probe};
use nalgebra::{DMatrix, DVector};
use physics::terms::{Driver, Drivers, Port};

/// Shortest distance between the knots of a sensor's drift, s. Derivation: about half of the shortest correlation time of a drift, 2000
/// s.
const KNOT: f64 = 900.0;
/// Perturbation of a listed effect as a fraction of its nominal size. Numerical: half of the digits remain in the difference.
const WAY: f64 = 1e-3;
/// Greatest number of such knots over all runs. Numerical: longer experiments resolve slower drifts only.
const MOST_KNOTS: usize = 24;

/// Error message if the parameters cannot be estimated.
const INSEPARABLE: &str = "the parameters cannot be told apart by these runs";

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
    /// Effects with a usable derivative, with the index of their direction after those of the model.
    listed: Vec<(&'static Listed, Addition)>,
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
            .filter_map(|l| Some((l, l.addition(setup, &all)?)))
            .filter(|(l, a)| !known(l, a))
            .collect();
        let mut further: Vec<Probe> = ports.iter().map(|port| Probe::Port(*port)).collect();
        let inputs = setup.experiment.inputs.len();
        further.extend((0..inputs).map(Probe::Input));
        for (_, addition) in &listed {
            let Shape::Listed { slots, with, .. } = &addition.shape else { continue };
            let way = WAY * addition.numbers[0].scale;
            further.push(Probe::Parameter { slot: slots[0], with: with.clone(), way });
        }
        let slopes = Slopes::new(setup, &fitted.hypothesis, runs, &further)?;
        let evidence = evidence(setup, &fitted, runs, &slopes, further.len(), ports.len())?;
        let mut point =
            Linearization { setup, fitted, runs: runs.to_vec(), slopes, evidence, ports, listed, inputs };
        // The first linearization with all ports determines the structure error.
        if ports.len() == Port::ALL.len() {
            setup.structure.get_or_init(|| structure(&point));
        }
        if let Some(columns) = setup.structure.get() {
            let with = point.evidence.with_structure(columns);
            point.evidence = with.ok_or_else(|| CalibrateError(INSEPARABLE.to_string()))?;
        }
        point.evidence.add_memory().ok_or_else(|| CalibrateError(INSEPARABLE.to_string()))?;
        // No further search from here; the memory is released, because many linearizations are kept.
        if ports.is_empty() {
            point.evidence.settle();
        }
        Ok(point)
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

    /// Effects with a usable derivative that the model does not include.
    pub fn listed(&self) -> impl Iterator<Item = &(&'static Listed, Addition)> {
        self.listed.iter()
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

    /// Column of the `k`-th effect of [`listed`](Self::listed), in the runs selected by `active` (by index among the runs evaluated).
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

/// Residual of a fitted model with the columns that may already explain it: its own parameters, drifting sensors, and the error of
/// the first ambient reading, at which all nodes start.
fn evidence(
    setup: &Setup,
    fitted: &Fitted,
    runs: &[usize],
    slopes: &Slopes,
    further: usize,
    before_inputs: usize,
) -> Result<Evidence, CalibrateError> {
    let blocks: usize = runs.iter().map(|r| setup.blocks[*r].len()).sum();
    let mut residual = Vec::with_capacity(blocks);
    for (r, run) in runs.iter().enumerate() {
        setup.residual(*run, &fitted.shown[r], &mut residual);
    }
    let gather = |answer: &(dyn Fn(usize) -> Option<Vec<f64>> + Sync)| -> Vec<f64> {
        let mut all = Vec::with_capacity(blocks);
        for (r, run) in runs.iter().enumerate() {
            match answer(r) {
                Some(values) => setup.means(*run, &values, &mut all),
                None => all.extend(setup.blocks[*run].iter().map(|_| 0.0)),
            }
        }
        all
    };
    // Parameters of the model.
    let mut apart: Vec<f64> = setup
        .declared
        .iter()
        .zip(&fitted.hypothesis.declared)
        .map(|(d, value)| (value - d.prior) / d.deviation)
        .collect();
    let added = fitted.hypothesis.additions.iter().flat_map(|a| a.numbers.iter().filter(|n| n.sloped));
    let scales: Vec<f64> = setup.declared.iter().map(|d| d.deviation).chain(added.map(|n| n.scale)).collect();
    let mut columns = parallel::indices(slopes.count(), |k| {
        let mut column = gather(&|r| slopes.answer(&fitted.hypothesis, r, k));
        column.iter_mut().for_each(|x| *x *= scales[k]);
        column
    });
    apart.resize(columns.len(), f64::NAN);
    // Initial temperatures, run by run.
    let ambient = setup.experiment.inputs.iter().position(|c| c.is_temperature());
    if let Some(ambient) = ambient {
        for own in 0..runs.len() {
            let noise = setup.noise[ambient];
            let column = gather(&|r| {
                let direction = slopes.further(r, further)[before_inputs + ambient].as_ref()?;
                let first = |row: usize| if row == 0 { noise } else { 0.0 };
                (r == own).then(|| slopes.tangents[r].response(direction, first))
            });
            columns.push(column);
            apart.push(0.0);
        }
    }
    let clock = |r: usize| &setup.drives[runs[r]].time;
    let (from, to) = (0..runs.len()).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), r| {
        let t = clock(r);
        (a.min(t[0]), b.max(t[t.len() - 1]))
    });
    let count = (((to - from) / KNOT).ceil() as usize).clamp(1, MOST_KNOTS) + 1;
    let points: Vec<f64> = (0..count).map(|k| from + (to - from) * k as f64 / (count - 1) as f64).collect();
    // Zero offsets of sensors of outputs and inputs; those of thermometers at the motor differ from run to run.
    let m = setup.outputs();
    let inputs = setup.experiment.inputs.len();
    let all = || setup.experiment.inputs.iter().chain(&setup.experiment.outputs).enumerate();
    for (channel, _) in all().filter(|(k, c)| setup.noise[*k] > 0.0 && (!c.is_temperature() || *k >= inputs))
    {
        let size = CALIBRATED * setup.noise[channel];
        let moves = channel >= inputs && setup.experiment.outputs[channel - inputs].is_temperature();
        for own in if moves { (0..runs.len()).map(Some).collect() } else { vec![None] } {
            let column = gather(&|r| {
                if channel < inputs {
                    let direction = slopes.further(r, further)[before_inputs + channel].as_ref()?;
                    return Some(slopes.tangents[r].response(direction, |_| size));
                }
                own.is_none_or(|own| own == r).then(|| {
                    let mut values = vec![0.0; clock(r).len() * m];
                    values.iter_mut().skip(channel - inputs).step_by(m).for_each(|v| *v = size);
                    values
                })
            });
            columns.push(column);
            apart.push(0.0);
        }
    }
    // Input noise stored in heat capacities: white noise, combined between knots.
    for input in &setup.remembered {
        for (k, point) in points.iter().enumerate() {
            let column = gather(&|r| {
                let direction = slopes.further(r, further)[before_inputs + input].as_ref()?;
                let time = clock(r);
                let row = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
                let apart = (to - from) / (count - 1) as f64;
                let size = setup.noise[*input] * (row / apart.max(row)).sqrt();
                let reached = time[0] < point + apart && time[time.len() - 1] > point - apart;
                reached
                    .then(|| slopes.tangents[r].response(direction, |row| size * hat(&points, k, time[row])))
            });
            if column.iter().any(|x| *x != 0.0) {
                columns.push(column);
                apart.push(0.0);
            }
        }
    }
    let known = columns.len();
    // Responses to drifting sensors of the outputs and of the ambient temperature: thermometers are of the same kind and have the same
    // drift, up to the noise of the noisiest one.
    let thermometers = all().filter(|(k, c)| c.is_temperature() && *k >= inputs).map(|(k, _)| setup.noise[k]);
    let loudest = thermometers.fold(0.0, f64::max);
    let mut knots = Vec::new();
    let drifts = |k: usize, c: &Channel| setup.noise[k] > 0.0 && (k >= inputs || c.is_temperature());
    for (sensor, channel) in all().filter(|(k, c)| drifts(*k, c)) {
        let size = if channel.is_temperature() { loudest } else { setup.noise[sensor] };
        for (k, point) in points.iter().enumerate() {
            let column = gather(&|r| {
                let time = clock(r);
                if sensor < inputs {
                    let direction = slopes.further(r, further)[before_inputs + sensor].as_ref()?;
                    return Some(
                        slopes.tangents[r].response(direction, |row| size * hat(&points, k, time[row])),
                    );
                }
                let mut values = vec![0.0; time.len() * m];
                for (row, t) in time.iter().enumerate() {
                    values[row * m + sensor - inputs] = size * hat(&points, k, *t);
                }
                Some(values)
            });
            if column.iter().any(|x| *x != 0.0) {
                columns.push(column);
                knots.push((*point, sensor));
            }
        }
    }
    let matrix = |columns: &[Vec<f64>]| {
        DMatrix::from_iterator(blocks, columns.len(), columns.iter().flatten().copied())
    };
    let (slopes, drift) = (matrix(&columns[..known]), matrix(&columns[known..]));
    // Neighbours in time of one output in one run.
    let mut series: Vec<Series> = Vec::new();
    let mut last = None;
    for (k, (run, block)) in
        runs.iter().flat_map(|r| setup.blocks[*r].iter().map(move |b| (r, b))).enumerate()
    {
        match series.last_mut().filter(|_| last == Some((run, block.output))) {
            Some(own) => own.values.end = k + 1,
            None => series.push(Series { output: block.output, values: k..k + 1 }),
        }
        last = Some((run, block.output));
    }
    let mut prior = Prior::new(&apart);
    for (place, values, precision) in fitted.hypothesis.priors() {
        prior.table(place, &values, precision, &scales[place..]);
    }
    Evidence::new(DVector::from_vec(residual), &slopes, prior, &drift, &knots, series)
        .ok_or_else(|| CalibrateError(INSEPARABLE.to_string()))
}
