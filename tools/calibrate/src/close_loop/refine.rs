//! Refinement of an accepted function of one driver.
//!
//! k(d) = 1 + exp(-d / l)
//! k(d) = 1 + (1 + a) exp(-a),              a = sqrt(3) d / l                                                 (1)
//! k(d) = 1 + (1 + a + a^2 / 3) exp(-a),    a = sqrt(5) d / l
//!
//! The search compares hundreds of functions, each as a table of few points with the roughest of these covariances (`search/laws.rs`). Which
//! driver acts at which port is then known. The function itself is estimated with more points, and with the smoothness and the length l that
//! explain the fit runs best; d is the distance of two points. The refined function is kept if its evidence is larger and its errors in the
//! validation runs are not.
//! *Source*: Rasmussen, Williams, Gaussian Processes for Machine Learning (2006), sec. 4.2.1 (Matern), 5.4.1 (marginal likelihood).

use super::Search;
use crate::CalibrateError;
use crate::acting::acting;
use crate::beyond;
use crate::evidence::Gain;
use crate::experiment::Role;
use crate::fit::Fitted;
use crate::hypothesis::{Addition, Axis, Hypothesis, Shape, values as count_of, weight};
use crate::linearization::Linearization;
use crate::numbers::ends;
use crate::outcome::Follows;
use crate::search::{kernel, spread, table, table_values};
use crate::selection::NEAR;
use crate::tangent::Tangent;
use nalgebra::DMatrix;
use physics::terms::{Driver, Factor, Port};

/// Points of a refined function. Numerical: a sine of two periods deviates by a tenth of its amplitude between two of them.
const POINTS: usize = 13;
/// Lengths that are tried, as a fraction of the range of the data. Numerical: neighbours differ by a factor of two.
const LENGTHS: [f64; 4] = [0.25, 0.5, 1.0, 2.0];
/// Variance of the value of a point by itself, relative to that of the function. Numerical: makes the covariance invertible.
const ALONE: f64 = 1e-6;

/// The last terms of (1) by d / l. Definition: covariances of Matern for functions without, with one and with two derivatives.
const COVARIANCES: [fn(f64) -> f64; 3] = [
    |d| (-d).exp(),
    |d| {
        let a = 3f64.sqrt() * d;
        (1.0 + a) * (-a).exp()
    },
    |d| {
        let a = 5f64.sqrt() * d;
        (1.0 + a + a * a / 3.0) * (-a).exp()
    },
];

/// Covariance (1) of the values at these points.
fn covariance(points: &[f64], of: fn(f64) -> f64, length: f64) -> DMatrix<f64> {
    let n = points.len();
    let own = DMatrix::from_fn(n, n, |a, b| 1.0 + of((points[a] - points[b]).abs() / length));
    own + DMatrix::identity(n, n) * ALONE
}

impl<'a> Search<'a> {
    /// Refines the accepted functions of one driver.
    pub(super) fn refine(&mut self) -> Result<(), CalibrateError> {
        let Some(last) = self.rounds.iter().rposition(|round| round.taken.is_some()) else { return Ok(()) };
        for k in 0..self.point().fitted.hypothesis.additions.len() {
            if self.setup.deadline().is_near() {
                break;
            }
            let better = match self.refined(k)? {
                None => match self.proportional(k)? {
                    None => self.narrowed(k)?,
                    linear => linear,
                },
                refined => refined,
            };
            if let Some(point) = better {
                let round = self.rounds.remove(last);
                self.rounds.insert(last, round.with_point(point));
            }
        }
        Ok(())
    }

    /// The model with its `k`-th addition, a power of a lag, proportional to the lag, if the exponent explains no more than a number by chance: a
    /// linear system of first order, which has no range.
    fn proportional(&self, k: usize) -> Result<Option<Linearization<'a>>, CalibrateError> {
        let (setup, point) = (self.setup, self.point());
        let mut hypothesis = point.fitted.hypothesis.clone();
        let own = &mut hypothesis.additions[k];
        let (Some(_), Shape::Power { factor }) = (own.lag(), &own.shape) else { return Ok(None) };
        let factor = Factor { exponent: 1.0, range: Factor::UNLIMITED, ..*factor };
        own.shape = Shape::Linear { factor };
        own.numbers.drain(own.sizes()..own.numbers.len() - 1);
        let Ok(fitted) = setup.fit(hypothesis, &point.runs) else { return Ok(None) };
        let linear = Linearization::judged(setup, fitted, &point.runs)?;
        let (white, raw) = point.explains(&linear);
        Ok((white.min(raw) < point.per_number()).then_some(linear))
    }

    /// The model with the range of its `k`-th addition, a power of a lag, as far as the fit runs reach; `None` if it is that already. The search
    /// does not know where the lag of a warm run starts, and has the range of the driver.
    fn narrowed(&self, k: usize) -> Result<Option<Linearization<'a>>, CalibrateError> {
        let (setup, point) = (self.setup, self.point());
        if point.warm_runs().next().is_none() {
            return Ok(None);
        }
        let mut hypothesis = point.fitted.hypothesis.clone();
        let Addition { follows: Follows::Late(driver), shape: Shape::Power { factor }, .. } =
            &mut hypothesis.additions[k]
        else {
            return Ok(None);
        };
        let (least, most) = ends(reached(point, k, *driver).into_iter().flatten());
        // A magnitude is between 0 and its greatest value.
        let range = (if driver.has_sides() { least } else { 0.0 }, most.min(factor.range.1));
        if !most.is_finite() || range == factor.range {
            return Ok(None);
        }
        factor.range = range;
        let Ok(fitted) = setup.judged(hypothesis, &point.runs) else { return Ok(None) };
        if self.is_worse(&fitted) {
            return Ok(None);
        }
        Linearization::judged(setup, fitted, &point.runs).map(Some)
    }

    /// Whether the errors of the validation runs are larger than those of the present model.
    fn is_worse(&self, fitted: &Fitted) -> bool {
        let is_worse = |known: f64| self.validation_errors(fitted).is_none_or(|own| own > known);
        self.validation_errors(&self.point().fitted).is_some_and(is_worse)
    }

    /// The model with its `k`-th addition refined; `None` if that is not a function of one driver, or no better refined.
    fn refined(&self, k: usize) -> Result<Option<Linearization<'a>>, CalibrateError> {
        let (setup, point) = (self.setup, self.point());
        let is_of_one = point.fitted.hypothesis.additions[k].axes().is_some_and(|axes| axes.len() == 1);
        let Some(hypothesis) = is_of_one.then(|| tabulated(point, k)).transpose()?.flatten() else {
            return Ok(None);
        };
        let Ok(fitted) = setup.fit(hypothesis, &point.runs) else { return Ok(None) };
        if fitted.chi_square >= point.fitted.chi_square || self.is_worse(&fitted) {
            return Ok(None);
        }
        Linearization::judged(setup, fitted, &point.runs).map(Some)
    }

    /// Sum of squared errors in the validation runs, in units of the noise; `None` if there are none, or the model cannot be run there.
    fn validation_errors(&self, fitted: &Fitted) -> Option<f64> {
        let runs = self.setup.runs(Role::Validate);
        let hypothesis = acting(self.setup, &fitted.hypothesis, &runs).ok()?;
        let judged = self.setup.judged(hypothesis, &runs).ok()?;
        (judged.readings > 0).then_some(judged.chi_square)
    }
}

/// Values of a driver of the `k`-th addition in the runs of a linearization, as the addition takes them; none where it does not act, and where
/// no reading depends on it.
pub(super) fn reached(point: &Linearization, k: usize, driver: Driver) -> Vec<Vec<f64>> {
    let hypothesis = &point.fitted.hypothesis;
    let sloped = |own: &Addition| own.numbers.iter().filter(|n| n.sloped).count();
    let first = hypothesis.declared.len() + hypothesis.additions[..k].iter().map(sloped).sum::<usize>();
    let own = &hypothesis.additions[k];
    let numbers = first..first + sloped(own);
    let is_read = |run: usize| {
        let is_in = |k| point.parameter_column(k, &[run]).is_some_and(|column| column.amax() > 0.0);
        numbers.clone().any(is_in)
    };
    let of_run = |(run, tangent): (&usize, &Tangent)| {
        let place = hypothesis.place(k, *run).filter(|_| is_read(*run))?;
        Some(beyond::values(&own.term()?, place, driver, &tangent.drivers))
    };
    let tangents = point.runs.iter().zip(&point.slopes.tangents);
    tangents.map(|own| of_run(own).unwrap_or_default()).collect()
}

/// The model with the `k`-th addition, a table, estimated with more points in all that the runs of the linearization reach, and the covariance that
/// explains them best; `None` if it is no table, or if that explains no more.
pub(super) fn tabulated(point: &Linearization, k: usize) -> Result<Option<Hypothesis>, CalibrateError> {
    let setup = point.setup;
    let mut without = point.fitted.hypothesis.clone();
    let own = without.additions.remove(k);
    let (Some(axes), Some(port)) = (own.axes(), Port::ALL.iter().find(|port| **port == own.port)) else {
        return Ok(None);
    };
    let base = Linearization::beside(setup, setup.judged(without, &point.runs)?, &point.runs, port)?;
    let values: Vec<Vec<Vec<f64>>> = axes.iter().map(|axis| reached(point, k, axis.driver)).collect();
    let finer = axes.iter().zip(&values).map(|(axis, values)| {
        let values = values.iter().flatten().map(|x| axis.at(*x)).collect();
        let count = if axes.len() == 1 { POINTS } else { axis.knots.len() };
        Some(Axis { knots: spread(values, count, None)?, ..axis.clone() })
    });
    let Some(finer) = finer.collect::<Option<Vec<Axis>>>() else { return Ok(None) };
    let columns = |axes: &[Axis]| {
        base.port_columns(*port, count_of(axes), |n, r, row, _| {
            let place = |driver| axes.iter().position(|axis| axis.driver == driver).unwrap_or(0);
            let at = |driver| values[place(driver)][r][row];
            let is_on = own.active[base.runs[r]] && values.iter().all(|values| !values[r].is_empty());
            if is_on { weight(axes, n, at) } else { 0.0 }
        })
    };
    let present = columns(axes).and_then(|columns| base.evidence.shape(&columns, &kernel(axes)));
    let (Some(present), Some(columns)) = (present, columns(&finer)) else { return Ok(None) };
    let found = covariances(&finer).filter_map(|own| Some((base.evidence.shape(&columns, &own)?, own)));
    let best = found.max_by(|a, b| a.0.whitened.total_cmp(&b.0.whitened));
    let is_more = |(gain, _): &(Gain, _)| gain.whitened > present.whitened + NEAR;
    let Some((gain, covariance)) = best.filter(is_more) else { return Ok(None) };
    let late = if own.lag().is_some() { "lagged " } else { "" };
    let mut numbers = table_values(own.port, &finer, late, &gain);
    numbers.extend(own.numbers[own.sizes()..].iter().cloned());
    let mut hypothesis = point.fitted.hypothesis.clone();
    hypothesis.additions[k] = Addition { shape: table(finer, covariance, &gain), numbers, ..own };
    Ok(Some(hypothesis))
}

/// The covariances that are tried for a table: (1) of one driver, that of the search of two.
fn covariances(axes: &[Axis]) -> impl Iterator<Item = DMatrix<f64>> {
    let of_one = |axis: &Axis| {
        let (knots, range) = (axis.knots.clone(), axis.knots[axis.knots.len() - 1] - axis.knots[0]);
        let tried = COVARIANCES.iter().flat_map(|of| LENGTHS.map(|length| (*of, length)));
        tried.map(|(of, length)| covariance(&knots, of, length * range)).collect()
    };
    let all: Vec<DMatrix<f64>> = if let [axis] = axes { of_one(axis) } else { vec![kernel(axes)] };
    all.into_iter()
}
