//! Minimum over the declared parameters of the deviation of data and model, with structure error as noise.

use super::super::signals::SENSOR_ERROR;
use super::super::{all_runs, structure, structured};
use super::{Judge, Predicted, STRAINED, blanked};
use crate::CalibrateError;
use crate::experiment::{Deviation, Experiment, Prior, Role};
use crate::fit::Fitted;
use crate::levels::{DECISIVE, FACTOR, PART, SAMPLES, SMALL};
use crate::linearization::Linearization;
use crate::selection::LEAST;
use crate::setup::{Setup, Shown};
use crate::undeclared;
use physics::declare::{Causality, Kind};

/// Minimum of the cost over the declared parameters: by output, and of the priors.
pub(super) struct Cost {
    outputs: Vec<f64>,
    /// The part of the outputs that no zero of a thermometer explains ([`squares`]).
    shapes: Vec<f64>,
    /// ln sigma of each output as it was fitted.
    widths: Vec<f64>,
    /// Sum of ln |dx/dy| over the outputs, y the readings as recorded and x those that were fitted.
    stretch: f64,
    /// Number of fitted runs.
    fitted: usize,
    pub(super) prior: f64,
    /// Cost of each run of the experiment, fitted or not.
    runs: Vec<f64>,
    /// Whether the time limit ended the fit before convergence.
    pub(super) is_cut: bool,
    /// The minimum; `None` if the model cannot be run.
    pub(super) best: Option<Fitted>,
}

impl Cost {
    /// Of a fit; the outputs are counted in `runs`.
    fn new(setup: &Setup, fitted: Fitted, runs: &[usize]) -> Result<Cost, CalibrateError> {
        let all = all_runs(setup.experiment);
        let shown = setup.show(&fitted.hypothesis, &all)?;
        let picked: Vec<Shown> = runs.iter().map(|run| shown[*run].clone()).collect();
        let own: Vec<Vec<f64>> = runs.iter().map(|run| squares(setup, *run, &shown[*run])).collect();
        let shape = |k: usize| own.iter().map(|run| run[k]).sum::<f64>();
        Ok(Cost {
            outputs: setup.chi_squares(runs, &picked),
            shapes: (0..setup.outputs()).map(|k| shape(k) / setup.sigma(k).powi(2)).collect(),
            widths: (0..setup.outputs()).map(|k| setup.sigma(k).ln()).collect(),
            stretch: 0.0,
            fitted: runs.len(),
            prior: fitted.cost - fitted.chi_square,
            runs: all.iter().map(|r| of_run(setup, runs, *r, &shown[*r])).collect(),
            is_cut: setup.deadline().is_near(),
            best: Some(fitted),
        })
    }

    /// The same cost of outputs that are enlarged by mistakes: those of another cost, and one with this stretch.
    pub(super) fn stretched(self, by: &Cost, and: f64) -> Cost {
        Cost { stretch: by.stretch + and, ..self }
    }

    pub(super) fn whole(&self) -> f64 {
        self.outputs.iter().sum::<f64>() + self.prior
    }

    /// Of these runs, fitted or not.
    pub(super) fn of(&self, runs: &[usize]) -> f64 {
        runs.iter().map(|run| self.runs[*run]).sum()
    }

    /// Difference of -2 ln p of the readings as recorded to that with another change of them, apart from the costs: a change that enlarges an
    /// output enlarges its structure error as well, and explains with it what it does not predict.
    pub(super) fn wider_than(&self, other: &Cost) -> f64 {
        self.wider(other, None)
    }

    /// The same without an output, which one of the two may lack.
    fn wider(&self, other: &Cost, except: Option<usize>) -> f64 {
        let widths = |cost: &Cost| -> f64 {
            let all = cost.widths.iter().enumerate();
            all.filter(|(k, _)| Some(*k) != except).map(|(_, width)| width).sum()
        };
        let own = |cost: &Cost| widths(cost) - cost.stretch;
        let wider = 2.0 * SAMPLES * self.fitted as f64 * (own(self) - own(other));
        if wider.is_finite() { wider } else { 0.0 }
    }

    /// Whether the outputs agree with the model to within their structure errors, those of the data with a mistake where these are smaller.
    pub(super) fn agrees(&self, with_mistake: &Cost) -> bool {
        let readings = SAMPLES * (self.fitted * self.outputs.len()) as f64;
        self.whole() + self.wider_than(with_mistake).max(0.0) <= readings
    }

    /// Whether the cost is worse by this factor in those outputs in which the two differ, `except` for one. The other outputs may lack an
    /// unrelated effect.
    pub(super) fn is_worse_than(&self, other: &Cost, factor: f64, except: Option<usize>) -> bool {
        let pairs = self.outputs.iter().zip(&other.outputs).enumerate().filter(|(k, _)| Some(*k) != except);
        self.is_worse(other, factor, except, pairs.map(|(_, pair)| pair))
    }

    /// The same whatever the zeros of the thermometers.
    pub(super) fn is_worse_in_shape(&self, other: &Cost, factor: f64) -> bool {
        self.is_worse(other, factor, None, self.shapes.iter().zip(&other.shapes))
    }

    fn is_worse<'a>(
        &self,
        other: &Cost,
        factor: f64,
        except: Option<usize>,
        pairs: impl Iterator<Item = (&'a f64, &'a f64)>,
    ) -> bool {
        let pairs = pairs.filter(|(own, other)| (*own - *other).abs() > LEAST);
        let (own, meant) = pairs.fold((self.prior, other.prior), |(a, b), (own, other)| (a + own, b + other));
        let (own, meant) =
            (own + self.wider(other, except).max(0.0), meant + other.wider(self, except).max(0.0));
        own > factor * meant && own > meant + DECISIVE
    }

    /// (3), with respect to a fit with one parameter more.
    pub(super) fn evidence(&self, other: &Cost) -> f64 {
        let readings = SAMPLES * (self.fitted * self.outputs.len()) as f64;
        let (own, other) = (self.whole(), other.whole());
        (own - other).min(readings * (own / other).ln()) - readings.ln()
    }

    /// The runs that deviate by more than the structure error; all runs if parameters are strained.
    pub(super) fn bad_runs(&self) -> Vec<usize> {
        let all = 0..self.runs.len();
        if self.prior > STRAINED { all.collect() } else { all.filter(|run| self.deviates(*run)).collect() }
    }

    /// Whether no run deviates by more than the structure error, strained parameters or not.
    pub(super) fn follows_all(&self) -> bool {
        !(0..self.runs.len()).any(|run| self.deviates(run))
    }

    fn deviates(&self, run: usize) -> bool {
        self.runs[run] > FACTOR * FACTOR * SAMPLES * self.outputs.len() as f64
    }
}

/// Cost of one run. The structure error of a quantity that follows the inputs at once has the size that the quantity has in this run, and
/// at least the fraction [`SMALL`] of that in the fitted ones.
fn of_run(setup: &Setup, fitted: &[usize], run: usize, shown: &Shown) -> f64 {
    let all = setup.squares(&[run], std::slice::from_ref(shown)).into_iter().enumerate();
    all.map(|(output, (square, _))| {
        let (mut variance, of_all) =
            (setup.sigma(output).powi(2), structure(setup.experiment, fitted, output));
        if !setup.experiment.outputs[output].is_temperature() {
            let own = structure(setup.experiment, &[run], output).clamp(SMALL * of_all, of_all);
            variance += own * own - of_all * of_all;
        }
        square / variance.max(f64::MIN_POSITIVE)
    })
    .sum()
}

/// Sum of the squared residuals of a run, output by output. A thermometer may have another zero in each run, within its error: where nothing
/// is heated, that is all that differs.
fn squares(setup: &Setup, run: usize, shown: &Shown) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0, 0.0); setup.outputs()];
    setup.each(run, shown, |_, output, off| {
        let (count, sum, square) = &mut sums[output];
        (*count, *sum, *square) = (*count + 1.0, *sum + off, *square + off * off);
    });
    let of = |(output, (count, sum, square)): (usize, (f64, f64, f64))| {
        let is_thermometer = setup.experiment.outputs[output].is_temperature() && count > 0.0;
        let zero = if is_thermometer { (sum / count).clamp(-SENSOR_ERROR, SENSOR_ERROR) } else { 0.0 };
        square - 2.0 * zero * sum + count * zero * zero
    };
    sums.into_iter().enumerate().map(of).collect()
}

/// The experiment with structure errors as noise, and its runs that are fitted.
struct Prepared<'a> {
    setup: Setup<'a>,
    /// The fit runs of the judge, all its runs if none has that role, and those beside them.
    fitted: Vec<usize>,
    /// Those of them that are not beside.
    own: Vec<usize>,
}

impl<'a> Prepared<'a> {
    fn new(judge: &Judge, experiment: &'a Experiment) -> Result<Prepared<'a>, CalibrateError> {
        let is_fit = |run: &usize| experiment.runs[*run].role == Role::Fit;
        let fit: Vec<usize> = judge.runs.iter().copied().filter(is_fit).collect();
        let own = if fit.is_empty() { judge.runs.to_vec() } else { fit };
        let setup = structured(experiment, judge.preset, &own)?.until(judge.deadline.clone());
        let fitted = own.iter().chain(&judge.beside).copied().collect();
        Ok(Prepared { setup, fitted, own })
    }

    fn cost(&self, fitted: Fitted) -> Result<Cost, CalibrateError> {
        Cost::new(&self.setup, fitted, &self.own)
    }
}

/// Cost at the best values of the declared parameters.
pub(super) fn fitted(judge: &Judge, experiment: &Experiment) -> Result<Cost, CalibrateError> {
    let ready = Prepared::new(judge, experiment)?;
    let cost = ready.setup.refit(&ready.fitted).and_then(|fitted| ready.cost(fitted));
    // A model that cannot be simulated explains no data.
    Ok(cost.unwrap_or_else(|_| Cost {
        outputs: vec![f64::MAX; ready.setup.outputs()],
        shapes: vec![f64::MAX; ready.setup.outputs()],
        widths: vec![f64::NAN; ready.setup.outputs()],
        stretch: 0.0,
        fitted: ready.own.len(),
        prior: 0.0,
        runs: vec![f64::INFINITY; experiment.runs.len()],
        is_cut: ready.setup.deadline().is_near(),
        best: None,
    }))
}

/// Prediction of each output by the fit of the others, from `predicted` where that fails.
pub(super) fn crossed(
    judge: &Judge,
    experiment: &Experiment,
    predicted: &Predicted,
) -> Result<Predicted, CalibrateError> {
    let mut all = predicted.clone();
    for output in 0..experiment.outputs.len() {
        let others = blanked(experiment, judge.runs, experiment.place_of(output));
        let Prepared { setup, fitted, .. } = Prepared::new(judge, &others)?;
        let Ok(fitted) = setup.fit(setup.preset(), &fitted) else { continue };
        let Ok(shown) = setup.show(&fitted.hypothesis, judge.runs) else { continue };
        for (run, shown) in all.iter_mut().zip(shown) {
            run[output] = shown.into_iter().skip(output).step_by(setup.outputs()).collect();
        }
    }
    Ok(all)
}

/// Cost if a parameter of `[set]` or `[prior]` has this standard deviation relative to its value, with the value then and the present one; `None`
/// if it is no real number or zero.
pub(super) fn with_free(
    judge: &Judge,
    experiment: &Experiment,
    name: &str,
    deviation: f64,
) -> Result<Option<(Cost, f64, f64)>, CalibrateError> {
    let mut other = experiment.clone();
    other.priors.retain(|p| p.name != name);
    let entry = super::super::declaration(experiment).and_then(|all| all.by_name(name));
    if entry.is_none_or(|e| e.row.causality != Causality::Parameter || !matches!(e.row.kind, Kind::Real)) {
        return Ok(None);
    }
    other.priors.insert(0, Prior { name: name.to_string(), deviation: Deviation::Relative(deviation) });
    let ready = Prepared::new(judge, &other)?;
    let own = ready.setup.declared[0].prior;
    if own == 0.0 {
        return Ok(None);
    }
    let Ok(mut fitted) = ready.setup.fit(ready.setup.preset(), &ready.fitted) else { return Ok(None) };
    if (fitted.hypothesis.declared[0] / own - 1.0).abs() > PART {
        let Ok(settled) = ready.setup.settled(fitted.hypothesis, &ready.fitted) else { return Ok(None) };
        fitted = settled;
    }
    let value = fitted.hypothesis.declared[0];
    // The deadline may pass in its last simulation.
    Ok(ready.cost(fitted).ok().map(|cost| (cost, value, own)))
}

/// The experiment with a prior for the parameter whose value in the preset contradicts the data most, and the cost then; `None` if there is
/// no such parameter. `as_is` is the cost without.
pub(super) fn released(
    judge: &Judge,
    experiment: &Experiment,
    as_is: &Cost,
) -> Result<Option<(Experiment, Cost)>, CalibrateError> {
    // A preset with which the model cannot be run is judged by the checks that follow.
    let Some(best) = &as_is.best else { return Ok(None) };
    let Prepared { setup, fitted: runs, .. } = Prepared::new(judge, experiment)?;
    let point = Linearization::judged(&setup, best.clone(), &runs).ok();
    let Some(own) = point.and_then(|point| undeclared::best(&point, LEAST, undeclared::is_stated)) else {
        return Ok(None);
    };
    let Some(cost) = Cost::new(&own.setup, own.fitted, &runs).ok().filter(|cost| !cost.is_cut) else {
        return Ok(None);
    };
    let mut other = experiment.clone();
    other.released.push(own.name.clone());
    other.priors.push(Prior { name: own.name, deviation: Deviation::Relative(undeclared::DEVIATION) });
    Ok(Some((other, cost)))
}
