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
use crate::hypothesis::{Addition, Axis, Shape, weight};
use crate::linearization::Linearization;
use crate::numbers::ends;
use crate::outcome::Follows;
use crate::search::{kernel, spread, table, table_values};
use crate::selection::NEAR;
use crate::tangent::Tangent;
use nalgebra::DMatrix;
use physics::terms::Port;

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
                None => self.narrowed(k)?,
                refined => refined,
            };
            if let Some(point) = better {
                let round = self.rounds.remove(last);
                self.rounds.insert(last, round.with_point(point));
            }
        }
        Ok(())
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
        let (least, most) = ends(Self::reached(point, k).into_iter().flatten());
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

    /// Values of the first driver of the `k`-th addition in the runs, as it takes them; none where it does not act.
    fn reached(point: &Linearization, k: usize) -> Vec<Vec<f64>> {
        let hypothesis = &point.fitted.hypothesis;
        let own = &hypothesis.additions[k];
        let of_run = |(run, tangent): (&usize, &Tangent)| {
            let (place, driver) = (hypothesis.place(k, *run)?, own.follows.drivers().next()?);
            Some(beyond::values(&own.term()?, place, driver, &tangent.drivers))
        };
        let tangents = point.runs.iter().zip(&point.slopes.tangents);
        tangents.map(|own| of_run(own).unwrap_or_default()).collect()
    }

    /// Whether the errors of the validation runs are larger than those of the present model.
    fn is_worse(&self, fitted: &Fitted) -> bool {
        let is_worse = |known: f64| self.validation_errors(fitted).is_none_or(|own| own > known);
        self.validation_errors(&self.point().fitted).is_some_and(is_worse)
    }

    /// The model with its `k`-th addition refined; `None` if that is not a function of one driver, or no better refined.
    fn refined(&self, k: usize) -> Result<Option<Linearization<'a>>, CalibrateError> {
        let (setup, point) = (self.setup, self.point());
        let mut without = point.fitted.hypothesis.clone();
        let own = without.additions.remove(k);
        let Shape::Table { axes, .. } = &own.shape else { return Ok(None) };
        let ([axis], Some(port)) = (&axes[..], Port::ALL.iter().find(|port| **port == own.port)) else {
            return Ok(None);
        };
        let base = Linearization::beside(setup, setup.judged(without, &point.runs)?, &point.runs, port)?;
        let Some(term) = own.term() else { return Ok(None) };
        let reached = Self::reached(point, k);
        let values = reached.iter().flatten().map(|x| axis.at(*x)).collect();
        let Some(knots) = spread(values, POINTS, None) else { return Ok(None) };
        let finer = Axis { knots, ..axis.clone() };
        let columns = |axis: &Axis| {
            let axes = std::slice::from_ref(axis);
            base.port_columns(*port, axis.knots.len(), |n, r, row, _| {
                let is_on = own.active[base.runs[r]];
                if is_on { weight(axes, n, |_| reached[r][row]) } else { 0.0 }
            })
        };
        let present = columns(axis).and_then(|columns| base.evidence.shape(&columns, &kernel(axes)));
        let (Some(present), Some(columns)) = (present, columns(&finer)) else { return Ok(None) };
        let range = axis.knots[axis.knots.len() - 1] - axis.knots[0];
        let tried = COVARIANCES.iter().flat_map(|of| LENGTHS.map(|length| (*of, length * range)));
        let found = tried.filter_map(|(of, length)| {
            let covariance = covariance(&finer.knots, of, length);
            Some((base.evidence.shape(&columns, &covariance)?, covariance))
        });
        let best = found.max_by(|a, b| a.0.whitened.total_cmp(&b.0.whitened));
        let is_more = |(gain, _): &(Gain, _)| gain.whitened > present.whitened + NEAR;
        let Some((gain, covariance)) = best.filter(is_more) else { return Ok(None) };
        let mut hypothesis = point.fitted.hypothesis.clone();
        let finer = vec![finer];
        let mut numbers =
            table_values(own.port, &finer, if term.lag.is_some() { "lagged " } else { "" }, &gain);
        numbers.extend(own.numbers[own.sizes()..].iter().cloned());
        hypothesis.additions[k] = Addition { shape: table(finer, covariance, &gain), numbers, ..own };
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
