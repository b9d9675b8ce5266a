//! A hypothesis: the declared parameters with their values, and the additions to the model.

use crate::outcome::Follows;
use crate::overrides::Override;
use nalgebra::{DMatrix, DVector};
use physics::components::sensor::lagged;
use physics::model::Slot;
use physics::terms::{Driver, Drivers, Factor, GenericTerm, Grid, Lag, Law, Port, Product, Table};

/// A parameter of an addition.
#[derive(Clone, Debug)]
pub struct Number {
    /// Its symbol.
    pub symbol: String,
    /// Its value.
    pub value: f64,
    /// Lower and upper limit.
    pub limits: (f64, f64),
    /// Its unit.
    pub unit: &'static str,
    /// A change with a detectable effect on the outputs; unit of the fit.
    pub scale: f64,
    /// Whether it is estimated by linearization; otherwise it is found by trial.
    pub sloped: bool,
}

impl Number {
    /// Whether it is at a limit, beyond which nothing is plausible: 0 is a value as any other.
    pub fn is_at_limit(&self) -> bool {
        let (least, most) = self.limits;
        (self.value <= least && least != 0.0) || self.value >= most
    }
}

/// Form in which an addition changes the model.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Parameters of a listed effect, with further parameters held constant.
    Listed {
        /// One slot for each number.
        slots: Vec<Slot>,
        /// Parameters held constant.
        with: Vec<(Slot, f64)>,
        /// Whether the effect adds a state, such as the temperature of a new node.
        stores: bool,
    },
    /// A power law of a driver: coefficient, and exponent if there is a second number.
    Power {
        /// The driver with offset and reference value; the exponent, unless it is a number of the addition.
        factor: Factor,
    },
    /// Proportional to a driver: the coefficient.
    Linear {
        /// The driver with its reference value.
        factor: Factor,
    },
    /// A table over one or two drivers, with one number for each point; those of the last driver follow each other.
    Table {
        /// The drivers with their points.
        axes: Vec<Axis>,
        /// Inverse of the prior covariance of the values: the data do not determine those that they do not contain.
        precision: DMatrix<f64>,
    },
}

/// A driver of a table with its points.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The driver.
    pub driver: Driver,
    /// The points, ascending.
    pub knots: Vec<f64>,
    /// Whether the table is one of the driver's magnitude: the same on both sides of zero.
    pub is_even: bool,
}

impl Axis {
    /// The place on the axis of a value of the driver.
    pub fn at(&self, x: f64) -> f64 {
        if self.is_even { x.abs() } else { x }
    }

    /// The points of the table as data, and the value of the axis that belongs to each.
    fn points(&self) -> (Vec<f64>, Vec<usize>) {
        let own = self.knots.iter().copied().enumerate();
        let mirrored = own.clone().rev().filter(|(_, x)| self.is_even && *x > 0.0).map(|(k, x)| (k, -x));
        let (places, points) = mirrored.chain(own).unzip();
        (points, places)
    }
}

/// Number of values of a table.
pub fn values(axes: &[Axis]) -> usize {
    axes.iter().map(|axis| axis.knots.len()).product()
}

/// The point of each axis at which the `k`-th value of a table stands.
pub fn place(axes: &[Axis], k: usize) -> impl Iterator<Item = (&Axis, usize)> {
    axes.iter().enumerate().map(move |(n, axis)| (axis, k / values(&axes[n + 1..]) % axis.knots.len()))
}

/// Weight of the `k`-th value of a table at the values of its drivers.
pub fn weight(axes: &[Axis], k: usize, of: impl Fn(Driver) -> f64) -> f64 {
    place(axes, k).map(|(axis, own)| hat(&axis.knots, own, axis.at(of(axis.driver)))).product()
}

/// An addition to a model.
#[derive(Clone, Debug)]
pub struct Addition {
    /// Id of a listed effect, or `generic_term`.
    pub id: String,
    /// Port at which it acts.
    pub port: Port,
    /// The quantity that it depends on.
    pub follows: Follows,
    /// Form of the addition.
    pub shape: Shape,
    /// Its parameters.
    pub numbers: Vec<Number>,
    /// Whether it is active, for each run.
    pub active: Vec<bool>,
}

/// Parameters of a table in the complexity penalty, for each point of a driver. Tuned: values of neighbouring points are correlated.
const POINT_PRICE: f64 = 0.5;
/// Exponents of losses. Limit: from 0.5 (brush drop) over 2/3 (lubricated bearings), 1 (hysteresis) and 2 (eddy currents) to 3 (windage).
const POWERS_OF_LOSSES: (f64, f64) = (0.5, 3.0);
/// Relative change of a time constant for its finite-difference sensitivity. Numerical: the error of the sensitivity is 0.1 %.
const WAY: f64 = 1e-3;

/// What stands for a driver with a lag at the rows of a run, linear between rows; the initial state is `above` the driver's initial value.
pub fn followed(time: &[f64], drivers: &[Drivers], lag: Lag, above: f64) -> Vec<f64> {
    let x = |row: usize| drivers[row].of(lag.driver);
    let mut all = Vec::with_capacity(time.len());
    let mut reached = x(0) + above;
    all.push(lag.seen(reached, x(0)));
    for row in 1..time.len() {
        let (from, to) = (x(row - 1), x(row));
        let along = [from, 0.5 * (from + to), to];
        reached = lagged(reached, lag.tau, along, time[row] - time[row - 1]);
        all.push(lag.seen(reached, to));
    }
    all
}

impl Addition {
    /// Index of its kind: listed effect, power law, table, law with a lag, table over two drivers, mass.
    pub fn kind(&self) -> usize {
        match &self.shape {
            Shape::Linear { .. } => 5,
            _ if self.lag().is_some() => 3,
            Shape::Listed { .. } => 0,
            Shape::Power { .. } => 1,
            Shape::Table { axes, .. } => {
                if axes.len() > 1 {
                    4
                } else {
                    2
                }
            }
        }
    }

    /// The lag of its driver; the last number is then the time constant.
    pub fn lag(&self) -> Option<Lag> {
        self.follows.lag(self.numbers.last()?.value)
    }

    /// Number of coefficients in which the term is linear: exponents, time constants and further parameters of a new node are not counted.
    pub fn sizes(&self) -> usize {
        match &self.shape {
            Shape::Listed { .. } | Shape::Power { .. } | Shape::Linear { .. } => 1,
            Shape::Table { axes, .. } => values(axes),
        }
    }

    /// Derivative of the value with respect to one number, at each row of a run; a lag starts `above` its driver.
    pub fn slopes(&self, number: usize, time: &[f64], drivers: &[Drivers], above: f64) -> Vec<f64> {
        let Some(lag) = self.lag() else {
            return drivers.iter().map(|d| self.slope(number, d)).collect();
        };
        let late = |lag: Lag| -> Vec<Drivers> {
            let reached = followed(time, drivers, lag, above);
            drivers.iter().zip(reached).map(|(d, z)| d.with(lag.driver, z)).collect()
        };
        let here = late(lag);
        match self.term() {
            Some(term) if number + 1 == self.numbers.len() => {
                let longer = late(Lag { tau: lag.tau * (1.0 + WAY), ..lag });
                let grows = |(a, b): (&Drivers, &Drivers)| (term.value(b) - term.value(a)) / (WAY * lag.tau);
                here.iter().zip(&longer).map(grows).collect()
            }
            _ => here.iter().map(|d| self.slope(number, d)).collect(),
        }
    }

    /// Whether it acts in every run.
    pub fn is_in_every_run(&self) -> bool {
        self.active.iter().all(|on| *on)
    }

    /// Whether it is a listed effect.
    pub fn is_listed(&self) -> bool {
        matches!(self.shape, Shape::Listed { .. })
    }

    /// Whether it is a physical element: a listed effect or a mass.
    pub fn is_element(&self) -> bool {
        self.is_listed() || matches!(self.follows, Follows::Mass(_))
    }

    /// Whether it is a table.
    pub fn is_table(&self) -> bool {
        self.axes().is_some()
    }

    /// The drivers of a table.
    pub fn axes(&self) -> Option<&[Axis]> {
        if let Shape::Table { axes, .. } = &self.shape { Some(axes) } else { None }
    }

    /// Number of parameters in the complexity penalty: half for each driver of a table, since neighbouring values are correlated.
    pub fn price(&self) -> f64 {
        let drivers = self.axes().map_or(0, <[Axis]>::len) as i32;
        POINT_PRICE.powi(drivers) * self.numbers.len() as f64
    }

    /// Driver of a power law with its exponent, and without a range if the law is of a known kind: a loss that is a power of speed,
    /// current or torque.
    fn factor(&self, factor: &Factor) -> Factor {
        let exponent = self.numbers.get(1).map_or(factor.exponent, |n| n.value);
        let is_loss = matches!(
            self.port,
            Port::DragTorque | Port::TerminalVoltage | Port::WindingHeat | Port::HousingHeat
        ) && matches!(factor.driver, Driver::Speed | Driver::Current | Driver::LoadTorque)
            && self.lag().is_none();
        let is_known = is_loss && (POWERS_OF_LOSSES.0..=POWERS_OF_LOSSES.1).contains(&exponent);
        Factor { exponent, range: if is_known { Factor::UNLIMITED } else { factor.range }, ..*factor }
    }

    /// The law as data, unless it is a listed effect.
    pub fn term(&self) -> Option<GenericTerm> {
        let law = match &self.shape {
            Shape::Listed { .. } => return None,
            Shape::Power { factor } => {
                let factor = self.factor(factor);
                let coefficient = self.numbers[0].value;
                let factors = [(factor.exponent != 0.0).then_some(factor), None, None];
                Law::Product(Product { coefficient, factors })
            }
            Shape::Linear { factor } => Law::Product(Product {
                coefficient: self.numbers[0].value,
                factors: [Some(*factor), None, None],
            }),
            Shape::Table { axes, .. } => {
                let values = self.values();
                match &axes[..] {
                    [own] => {
                        let (points, places) = own.points();
                        let values: Vec<f64> = places.iter().map(|k| values[*k]).collect();
                        Law::Table(Table::new(own.driver, &points, &values)?)
                    }
                    [rows, columns] => {
                        let (lines, count) = ([rows, columns].map(Axis::points), columns.knots.len());
                        let [(_, places), (_, others)] = &lines;
                        let row = |k: &usize| others.iter().map(|n| values[k * count + n]).collect();
                        let values: Vec<Vec<f64>> = places.iter().map(row).collect();
                        let drivers = [rows.driver, columns.driver];
                        Law::Grid(Grid::new(drivers, [&lines[0].0, &lines[1].0], &values)?)
                    }
                    _ => return None,
                }
            }
        };
        Some(GenericTerm { port: self.port, law, lag: self.lag() })
    }

    /// The values of a table and the inverse of their prior covariance; their prior mean is zero.
    fn prior(&self) -> Option<(DVector<f64>, &DMatrix<f64>)> {
        let Shape::Table { precision, .. } = &self.shape else { return None };
        Some((DVector::from_vec(self.values()), precision))
    }

    /// The values of a table, without its time constant.
    fn values(&self) -> Vec<f64> {
        self.numbers[..self.sizes()].iter().map(|n| n.value).collect()
    }

    /// Adds this addition to the overrides of a model.
    pub fn apply(&self, change: &mut Override) {
        if let Shape::Listed { slots, with, .. } = &self.shape {
            change.values.extend(with);
            change.values.extend(slots.iter().zip(&self.numbers).map(|(slot, number)| (*slot, number.value)));
        } else {
            change.terms.extend(self.term());
        }
    }

    /// Derivative of a term's value with respect to one of its numbers, at the values of the drivers.
    pub fn slope(&self, number: usize, drivers: &Drivers) -> f64 {
        match &self.shape {
            Shape::Listed { .. } => 1.0,
            Shape::Power { factor } => {
                let factor = self.factor(factor);
                let x = drivers.of(factor.driver);
                let base = ((factor.held(x).0 - factor.offset) / factor.reference).abs();
                let power = factor.of(x);
                if number == 0 {
                    power
                } else if base > 0.0 {
                    self.numbers[0].value * power * base.ln()
                } else {
                    0.0
                }
            }
            Shape::Linear { factor } => factor.of(drivers.of(factor.driver)),
            Shape::Table { axes, .. } => weight(axes, number, |driver| drivers.of(driver)),
        }
    }
}

/// Power law of a driver at `x`, with the sign convention of terms.
pub fn power(factor: &Factor, x: f64, exponent: f64) -> f64 {
    Factor { exponent, ..*factor }.of(x)
}

/// Hat function of point `k` of a table at `x`: 1 at the point, 0 at its neighbours, constant outside the table.
pub fn hat(knots: &[f64], k: usize, x: f64) -> f64 {
    let last = knots.len() - 1;
    let x = x.clamp(knots[0], knots[last]);
    if k > 0 && x < knots[k] {
        ((x - knots[k - 1]) / (knots[k] - knots[k - 1])).max(0.0)
    } else if k < last && x > knots[k] {
        ((knots[k + 1] - x) / (knots[k + 1] - knots[k])).max(0.0)
    } else {
        1.0
    }
}

/// A candidate model.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// The declared parameters, in the order of the experiment's priors.
    pub declared: Vec<f64>,
    /// The additions.
    pub additions: Vec<Addition>,
}

impl Hypothesis {
    /// All numbers found by linearization: the declared ones, then those of the additions.
    pub fn numbers(&self) -> Vec<f64> {
        let added = self.additions.iter().flat_map(|a| a.numbers.iter().filter(|n| n.sloped));
        self.declared.iter().copied().chain(added.map(|n| n.value)).collect()
    }

    /// The tables: place of the first value in [`numbers`](Hypothesis::numbers), values, inverse of their prior covariance.
    pub fn priors(&self) -> Vec<(usize, DVector<f64>, &DMatrix<f64>)> {
        let mut place = self.declared.len();
        let mut all = Vec::new();
        for addition in &self.additions {
            all.extend(addition.prior().map(|(values, precision)| (place, values, precision)));
            place += addition.numbers.iter().filter(|n| n.sloped).count();
        }
        all
    }

    /// Place of an addition, by its index, among the terms of the model of a run; `None` if it does not act there, or is no term.
    pub fn place(&self, addition: usize, run: usize) -> Option<usize> {
        let is_term = |a: &Addition| a.active[run] && !a.is_listed();
        let before = || self.additions[..addition].iter().filter(|a| is_term(a)).count();
        is_term(&self.additions[addition]).then(before)
    }

    /// Sets the values of [`numbers`](Hypothesis::numbers).
    pub fn take(&mut self, numbers: &[f64]) {
        let places = self.additions.iter_mut().flat_map(|a| a.numbers.iter_mut().filter(|n| n.sloped));
        let all = self.declared.iter_mut().chain(places.map(|n| &mut n.value));
        all.zip(numbers).for_each(|(place, value)| *place = *value);
    }
}

#[cfg(test)]
mod tests;
