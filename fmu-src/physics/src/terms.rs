//! Terms that are data: effects found in measurements that the list of effects does not cover.
//!
//! y = c prod_i b_i^p_i,   b_i = (x_i - offset_i) / reference_i,   up to three drivers x_i, constant outside the range of x_i   (1)
//! y = a table in one driver: linear between its points, constant outside                   (2)
//! y = a grid over two drivers: bilinear between its points, constant outside its edges     (3)
//! tau dz/dt = x - z                                                                        (4)
//!
//! With a lag, z of eq. (4) replaces the driver x in the law, or z - x does ([`Lag::difference`]); z starts at the initial x, so that a motor
//! at rest at ambient temperature stays at rest. The driver of a lag may also be a heat flow, which requires a lag: a missing node (magnets,
//! a bearing) is a first-order lag of a neighbouring temperature or heat flow. A mass with the heat capacity C that is attached to a node
//! of the temperature x by the conductance G has the temperature z with tau = C / G, and gives the heat flow G (z - x) to the node.
//!
//! A term is a port and one of these laws. The effect that evaluates terms, `effects/generic_term.rs`, describes the action of the value
//! at the port; the crate `terms` reads the file with the terms of an FMU.
//! Speed, current and load torque enter by their magnitude, |b|^p, since drag and voltage drops are equal in both directions. Temperatures,
//! fan command and time are signed: below their offset the power is -|b|^p, so that p = 1 is a straight line.
//! *Assumes* nothing: (1) to (4) are fits. *Range*: |p| up to [`GREATEST_EXPONENT`]; where p < 0, a base is at least
//! [`LEAST_BASE`]. *Neglects* history other than eq. (4).

mod driver;
mod lag_starts;

use crate::number::Number;
pub use driver::{Driver, Drivers, Port};
pub use lag_starts::LagStarts;

/// Largest number of terms of a model.
pub const MOST_TERMS: usize = 3;
/// Largest number of drivers of a product.
pub const MOST_DRIVERS: usize = 3;
/// Largest number of points of a table.
pub const MOST_POINTS: usize = 32;
/// Largest number of points of a grid along each of its drivers.
pub const MOST_LINES: usize = 8;
/// Limits of the time constant of a lag, s.
pub const TIME_CONSTANT: (f64, f64) = (1e-3, 1e6);
/// Largest magnitude of an exponent.
pub const GREATEST_EXPONENT: f64 = 6.0;
/// Lower limit of a base with a negative exponent.
pub const LEAST_BASE: f64 = 1e-3;

/// One driver of eq. (1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factor {
    /// The driver.
    pub driver: Driver,
    /// Offset, subtracted first.
    pub offset: f64,
    /// Divisor of the difference, positive: the base of the power is dimensionless.
    pub reference: f64,
    /// The exponent.
    pub exponent: f64,
    /// Least and greatest value of the driver, or of its magnitude unless it [has sides](Driver::has_sides); beyond them the power is
    /// constant.
    pub range: (f64, f64),
}

impl Factor {
    /// Range without limits.
    pub const UNLIMITED: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

    /// The power at `x`.
    pub fn of<D: Number>(&self, x: D) -> D {
        let (x, _) = self.held(x);
        let signed = (x - self.offset) / self.reference;
        let base = signed.abs();
        let power = self.power(base);
        if signed.re() < 0.0 && self.driver.has_sides() { -power } else { power }
    }

    /// `x`, or the end of the range that it is beyond; and whether it is beyond.
    pub fn held<D: Number>(&self, x: D) -> (D, bool) {
        let own = if self.driver.has_sides() { x.re() } else { x.re().abs() };
        let end = own.max(self.range.0).min(self.range.1);
        if end == own {
            (x, false)
        } else {
            (D::from(if self.driver.has_sides() { end } else { end.copysign(x.re()) }), true)
        }
    }

    fn power<D: Number>(&self, base: D) -> D {
        if self.exponent == 0.0 {
            D::from(1.0)
        } else if self.exponent < 0.0 && base.re() < LEAST_BASE {
            D::from(LEAST_BASE.powf(self.exponent))
        } else if base.re() == 0.0 {
            // The derivative of a root is infinite there; its factor at the ports is zero.
            D::from(0.0)
        } else {
            // The derivative from the value: higher ones, which a dual number computes too, overflow at a lag that has decayed.
            let (x, value) = (base.re(), base.re().powf(self.exponent));
            (base - D::from(x)) * (self.exponent * value / x) + value
        }
    }
}

/// Eq. (1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Product {
    /// The value where every base is 1, in the port's unit.
    pub coefficient: f64,
    /// The drivers; none for a constant.
    pub factors: [Option<Factor>; MOST_DRIVERS],
}

/// Eq. (2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    /// The driver.
    pub driver: Driver,
    count: usize,
    x: [f64; MOST_POINTS],
    y: [f64; MOST_POINTS],
}

impl Table {
    /// The table through these points; `None` unless there are 2 to [`MOST_POINTS`] finite points with ascending x.
    pub fn new(driver: Driver, x: &[f64], y: &[f64]) -> Option<Table> {
        let ascending = x.windows(2).all(|pair| pair[0] < pair[1]);
        let finite = x.iter().chain(y).all(|number| number.is_finite());
        if x.len() != y.len() || !(2..=MOST_POINTS).contains(&x.len()) || !ascending || !finite {
            return None;
        }
        let mut table = Table { driver, count: x.len(), x: [0.0; MOST_POINTS], y: [0.0; MOST_POINTS] };
        table.x[..x.len()].copy_from_slice(x);
        table.y[..y.len()].copy_from_slice(y);
        Some(table)
    }

    /// The points: x and y.
    pub fn points(&self) -> (&[f64], &[f64]) {
        (&self.x[..self.count], &self.y[..self.count])
    }

    /// The value at `at`, and whether `at` is outside the points, where the end value is used.
    pub fn at<D: Number>(&self, at: D) -> (D, bool) {
        let (x, y) = self.points();
        let last = self.count - 1;
        if at.re() < x[0] {
            (D::from(y[0]), true)
        } else if at.re() > x[last] {
            (D::from(y[last]), true)
        } else {
            let k = x[1..last].partition_point(|x| *x <= at.re());
            ((at - x[k]) * ((y[k + 1] - y[k]) / (x[k + 1] - x[k])) + y[k], false)
        }
    }
}

/// Eq. (3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The drivers, first that of the rows.
    pub drivers: [Driver; 2],
    counts: [usize; 2],
    points: [[f64; MOST_LINES]; 2],
    values: [[f64; MOST_LINES]; MOST_LINES],
}

impl Grid {
    /// The grid through these values, one row for each point of the first driver; `None` unless there are 2 to [`MOST_LINES`] points of
    /// each of two drivers, finite and ascending, with a value for each pair.
    pub fn new(drivers: [Driver; 2], points: [&[f64]; 2], values: &[Vec<f64>]) -> Option<Grid> {
        let fits = |line: &[f64]| {
            (2..=MOST_LINES).contains(&line.len())
                && line.windows(2).all(|pair| pair[0] < pair[1])
                && line.iter().all(|x| x.is_finite())
        };
        let whole = values.len() == points[0].len()
            && values.iter().all(|row| row.len() == points[1].len() && row.iter().all(|y| y.is_finite()));
        if drivers[0] == drivers[1] || !points.iter().all(|line| fits(line)) || !whole {
            return None;
        }
        let mut grid = Grid {
            drivers,
            counts: points.map(<[f64]>::len),
            points: [[0.0; MOST_LINES]; 2],
            values: [[0.0; MOST_LINES]; MOST_LINES],
        };
        for (own, line) in grid.points.iter_mut().zip(points) {
            own[..line.len()].copy_from_slice(line);
        }
        for (own, row) in grid.values.iter_mut().zip(values) {
            own[..row.len()].copy_from_slice(row);
        }
        Some(grid)
    }

    /// The points of one of the drivers.
    pub fn points(&self, driver: usize) -> &[f64] {
        &self.points[driver][..self.counts[driver]]
    }

    /// The values, one row for each point of the first driver.
    pub fn values(&self) -> impl Iterator<Item = &[f64]> {
        self.values[..self.counts[0]].iter().map(|row| &row[..self.counts[1]])
    }

    /// The interval of a driver that contains `x`, its weight from 0 to 1, and whether `x` is outside the points.
    fn place<D: Number>(&self, driver: usize, x: D) -> (usize, D, bool) {
        let points = self.points(driver);
        let last = points.len() - 1;
        if x.re() < points[0] {
            (0, D::from(0.0), true)
        } else if x.re() > points[last] {
            (last - 1, D::from(1.0), true)
        } else {
            let k = points[1..last].partition_point(|p| *p <= x.re());
            (k, (x - points[k]) / (points[k + 1] - points[k]), false)
        }
    }

    /// The value, and whether the argument is outside the points.
    pub fn at<D: Number>(&self, x: D, y: D) -> (D, bool) {
        let (a, s, below) = self.place(0, x);
        let (b, t, above) = self.place(1, y);
        let row = |k: usize| t * (self.values[k][b + 1] - self.values[k][b]) + self.values[k][b];
        let (low, high) = (row(a), row(a + 1));
        (low + s * (high - low), below || above)
    }
}

/// Eq. (4): a state that replaces a driver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// The driver that is lagged.
    pub driver: Driver,
    /// Time constant, s.
    pub tau: f64,
    /// Whether the law has z - x in place of the driver x; z otherwise.
    pub difference: bool,
}

impl Lag {
    /// What stands in the law, with the lag at `z` and its driver at `x`.
    #[inline]
    pub fn seen<D: Number>(&self, z: f64, x: D) -> D {
        if self.difference { -x + z } else { D::from(z) }
    }
}

/// Law of a term.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // a box would be an allocation for each copy of a model
pub enum Law {
    /// Eq. (1).
    Product(Product),
    /// Eq. (2).
    Table(Table),
    /// Eq. (3).
    Grid(Grid),
}

impl Law {
    /// The drivers of the law.
    pub fn drivers(&self) -> impl Iterator<Item = Driver> {
        let all: [Option<Driver>; MOST_DRIVERS] = match self {
            Law::Product(product) => product.factors.map(|f| f.map(|f| f.driver)),
            Law::Table(table) => [Some(table.driver), None, None],
            Law::Grid(grid) => [Some(grid.drivers[0]), Some(grid.drivers[1]), None],
        };
        all.into_iter().flatten()
    }

    /// Greatest less least value of a table or a grid; of a product its value where every base is 1.
    pub fn span(&self) -> f64 {
        let between = |values: &mut dyn Iterator<Item = f64>| {
            let (low, high) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
            high - low
        };
        match self {
            Law::Product(product) => product.coefficient.abs(),
            Law::Table(table) => between(&mut table.points().1.iter().copied()),
            Law::Grid(grid) => between(&mut grid.values().flatten().copied()),
        }
    }

    /// Least and greatest value of each driver between which the law is not constant; those of a [`Factor`] as there.
    pub fn ranges(&self) -> impl Iterator<Item = (Driver, (f64, f64))> {
        let ends = |points: &[f64]| (points[0], points[points.len() - 1]);
        let all: [Option<(Driver, (f64, f64))>; MOST_DRIVERS] = match self {
            Law::Product(product) => product.factors.map(|f| f.map(|f| (f.driver, f.range))),
            Law::Table(table) => [Some((table.driver, ends(table.points().0))), None, None],
            Law::Grid(grid) => {
                let [rows, columns] = [0, 1].map(|k| Some((grid.drivers[k], ends(grid.points(k)))));
                [rows, columns, None]
            }
        };
        all.into_iter().flatten()
    }
}

/// A term: port and law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GenericTerm {
    /// The port.
    pub port: Port,
    /// The law.
    pub law: Law,
    /// Lag of one of the law's drivers, if any.
    pub lag: Option<Lag>,
}

impl GenericTerm {
    /// A term that depends on the present values of its drivers.
    pub const fn new(port: Port, law: Law) -> GenericTerm {
        GenericTerm { port, law, lag: None }
    }

    /// The value, in the port's unit; a lagged driver must already be in `drivers`.
    pub fn value(&self, drivers: &Drivers) -> f64 {
        self.along(drivers, None)
    }

    /// The value with `Number` type for one driver, which carries the derivative.
    #[inline]
    pub fn along<D: Number>(&self, drivers: &Drivers, live: Option<(Driver, D)>) -> D {
        let of = |driver: Driver| match live {
            Some((alive, x)) if alive == driver => x,
            _ => D::from(drivers.of(driver)),
        };
        match &self.law {
            Law::Product(product) => {
                let factors = product.factors.iter().flatten();
                factors
                    .fold(D::from(product.coefficient), |value, factor| value * factor.of(of(factor.driver)))
            }
            Law::Table(table) => table.at(of(table.driver)).0,
            Law::Grid(grid) => grid.at(of(grid.drivers[0]), of(grid.drivers[1])).0,
        }
    }

    /// The value of the `k`-th term of a model, with its lagged driver from its state.
    #[inline]
    pub fn along_as<D: Number>(&self, k: usize, drivers: &Drivers, live: Option<(Driver, D)>) -> D {
        match self.lag {
            None => self.along(drivers, live),
            Some(lag) => {
                let (own, z) = (drivers.of(lag.driver), drivers.lagged[k]);
                let live = live
                    .filter(|(driver, _)| *driver != lag.driver || lag.difference)
                    .map(|(driver, x)| (driver, if driver == lag.driver { lag.seen(z, x) } else { x }));
                self.along(&drivers.with(lag.driver, lag.seen(z, own)), live)
            }
        }
    }

    /// Conductance, W/K, and heat capacity, J/K, if it is a mass at the node that its port heats.
    pub fn mass(&self) -> Option<[f64; 2]> {
        let lag = self.lag.filter(|lag| lag.difference)?;
        let Law::Product(Product { coefficient, factors: [Some(factor), None, None] }) = self.law else {
            return None;
        };
        let is_at_node = matches!(
            (self.port, factor.driver),
            (Port::WindingHeat, Driver::WindingTemperature) | (Port::HousingHeat, Driver::HousingTemperature)
        );
        let is_linear = factor.exponent == 1.0 && factor.offset == 0.0 && factor.range == Factor::UNLIMITED;
        let conductance = coefficient / factor.reference;
        (is_at_node && is_linear && lag.driver == factor.driver)
            .then_some([conductance, conductance * lag.tau])
    }

    /// Whether it depends on the present value of this driver.
    pub fn follows(&self, driver: Driver) -> bool {
        self.lag.is_none_or(|lag| lag.driver != driver || lag.difference)
            && self.law.drivers().any(|d| d == driver)
    }

    /// Whether a driver is outside the range of a power, or outside the points of a table or a grid; a lagged driver must already be in
    /// `drivers`.
    pub fn is_held(&self, drivers: &Drivers) -> bool {
        match &self.law {
            Law::Product(product) => {
                product.factors.iter().flatten().any(|factor| factor.held(drivers.of(factor.driver)).1)
            }
            Law::Table(table) => table.at(drivers.of(table.driver)).1,
            Law::Grid(grid) => grid.at(drivers.of(grid.drivers[0]), drivers.of(grid.drivers[1])).1,
        }
    }

    /// Whether its drivers are consistent: no present heat flow, and a lag of a driver of the law.
    pub fn is_whole(&self) -> bool {
        let lagged = |driver: Driver| self.lag.is_some_and(|lag| lag.driver == driver && !lag.difference);
        self.law.drivers().all(|d| !d.is_heat() || lagged(d))
            && self.lag.is_none_or(|lag| {
                self.law.drivers().any(|d| d == lag.driver)
                    && (TIME_CONSTANT.0..=TIME_CONSTANT.1).contains(&lag.tau)
            })
    }
}

#[cfg(test)]
mod tests;
