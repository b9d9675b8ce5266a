//! Terms that are data: effects found in measurements that the list of effects does not cover.
//!
//! y = c prod_i b_i^p_i,   b_i = (x_i - offset_i) / reference_i,   up to three drivers x_i, constant outside the range of x_i   (1)
//! y = a table in one driver: linear between its points, constant outside                   (2)
//! y = a grid over two drivers: bilinear between its points, constant outside its edges     (3)
//! tau dz/dt = x - z                                                                        (4)
//!
//! With a lag, z of eq. (4) replaces the driver x in the law; z starts at the initial x, so that a motor at rest at
//! ambient temperature stays at rest. The driver of a lag may also be a heat flow, which requires a lag: a missing node
//! (magnets, a bearing) is a first-order lag of a neighbouring temperature or heat flow.
//!
//! A term is a port and one of these laws. The effect that evaluates terms, `effects/generic_term.rs`, describes the action of the value
//! at the port; the crate `terms` reads the file with the terms of an FMU.
//! Speed, current and load torque enter by their magnitude, |b|^p, since drag and voltage drops are equal in both directions. Temperatures,
//! fan command and time are signed: below their offset the power is -|b|^p, so that p = 1 is a straight line.
//! *Assumes* nothing: (1) to (4) are fits. *Range*: |p| up to [`GREATEST_EXPONENT`]; where p < 0, a base is at least
//! [`LEAST_BASE`]. *Neglects* history other than eq. (4).

mod driver;

use crate::number::Number;
pub use driver::{Driver, Drivers, Port};

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
            base.powf(self.exponent)
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
                let live = live.filter(|(driver, _)| *driver != lag.driver);
                self.along(&drivers.with(lag.driver, drivers.lagged[k]), live)
            }
        }
    }

    /// Whether it depends on the present value of this driver.
    pub fn follows(&self, driver: Driver) -> bool {
        self.lag.is_none_or(|lag| lag.driver != driver) && self.law.drivers().any(|d| d == driver)
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

    /// Whether its drivers are consistent: no heat flow without a lag, and a lag of a driver of the law.
    pub fn is_whole(&self) -> bool {
        let lagged = |driver: Driver| self.lag.is_some_and(|lag| lag.driver == driver);
        self.law.drivers().all(|d| !d.is_heat() || lagged(d))
            && self.lag.is_none_or(|lag| {
                self.law.drivers().any(|d| d == lag.driver)
                    && (TIME_CONSTANT.0..=TIME_CONSTANT.1).contains(&lag.tau)
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual64;

    fn factor(driver: Driver, reference: f64, offset: f64, exponent: f64) -> Option<Factor> {
        Some(Factor { driver, offset, reference, exponent, range: Factor::UNLIMITED })
    }

    fn product(coefficient: f64, factors: [Option<Factor>; 3]) -> GenericTerm {
        GenericTerm::new(Port::DragTorque, Law::Product(Product { coefficient, factors }))
    }

    const AT: Drivers = Drivers {
        speed: -400.0,
        current: 5.0,
        load_torque: 0.1,
        winding_temperature: 400.0,
        housing_temperature: 350.0,
        ambient_temperature: 300.0,
        fan_command: 0.25,
        time: 60.0,
        copper_loss: 12.0,
        friction_loss: 3.0,
        lagged: [320.0, 0.0, 0.0],
    };

    /// 2 |-400/100|^0.5 ((350 - 300)/10)^2 (0.25/1)^-1 = 2 * 2 * 25 * 4 = 400.
    #[test]
    fn a_product_by_hand() {
        let term = product(
            2.0,
            [
                factor(Driver::Speed, 100.0, 0.0, 0.5),
                factor(Driver::HousingTemperature, 10.0, 300.0, 2.0),
                factor(Driver::FanCommand, 1.0, 0.0, -1.0),
            ],
        );
        assert!((term.value(&AT) - 400.0).abs() < 1e-12);
        assert!(!term.is_held(&AT));
        assert_eq!(product(-3.0, [None; 3]).value(&AT), -3.0);
    }

    /// 3 K below its offset a straight line is negative, and so is a root; a speed enters by its magnitude.
    #[test]
    fn temperatures_have_sides() {
        let at = Drivers { ambient_temperature: 290.0, speed: -4.0, ..AT };
        let line = product(2.0, [factor(Driver::AmbientTemperature, 1.0, 293.0, 1.0), None, None]);
        assert_eq!(line.value(&at), -6.0);
        let root = product(2.0, [factor(Driver::AmbientTemperature, 3.0, 293.0, 0.5), None, None]);
        assert_eq!(root.value(&at), -2.0);
        let dual = line.along(&at, Some((Driver::AmbientTemperature, Dual64::from(290.0).derivative())));
        assert_eq!((dual.re, dual.eps), (-6.0, 2.0));
        assert_eq!(product(1.0, [factor(Driver::Speed, 1.0, 0.0, 1.0), None, None]).value(&at), 4.0);
    }

    /// A power keeps the value at the end of its range, without a derivative; the range of a speed is that of its magnitude.
    #[test]
    fn a_power_is_held_outside_its_range() {
        let square = Factor { range: (0.0, 300.0), ..factor(Driver::Speed, 100.0, 0.0, 2.0).unwrap() };
        let term = product(2.0, [Some(square), None, None]);
        for (speed, value, held) in
            [(-400.0, 18.0, true), (300.0, 18.0, false), (-200.0, 8.0, false), (0.0, 0.0, false)]
        {
            let at = Drivers { speed, ..AT };
            assert_eq!((term.value(&at), term.is_held(&at)), (value, held), "{speed}");
            let dual = term.along(&at, Some((Driver::Speed, Dual64::from(speed).derivative())));
            assert_eq!(dual.eps, if held { 0.0 } else { 4.0 * speed / 1e4 }, "{speed}");
        }
        let line =
            Factor { range: (280.0, 360.0), ..factor(Driver::HousingTemperature, 10.0, 300.0, 1.0).unwrap() };
        for (housing_temperature, value) in [(250.0, -2.0), (290.0, -1.0), (350.0, 5.0), (400.0, 6.0)] {
            let at = Drivers { housing_temperature, ..AT };
            assert_eq!(product(1.0, [Some(line), None, None]).value(&at), value, "{housing_temperature}");
        }
    }

    #[test]
    fn at_zero_roots_vanish_and_reciprocals_are_bounded() {
        let still = Drivers { speed: 0.0, ..AT };
        assert_eq!(product(2.0, [factor(Driver::Speed, 100.0, 0.0, 0.5), None, None]).value(&still), 0.0);
        let reciprocal = product(2.0, [factor(Driver::Speed, 100.0, 0.0, -1.0), None, None]);
        assert!((reciprocal.value(&still) - 2000.0).abs() < 1e-9);
        let dual = reciprocal.along(&AT, Some((Driver::Speed, Dual64::from(0.0).derivative())));
        assert!(dual.re.is_finite() && dual.eps.is_finite());
    }

    #[test]
    fn a_table_is_linear_inside_and_held_outside() {
        let table =
            Table::new(Driver::WindingTemperature, &[300.0, 320.0, 400.0], &[1.0, 3.0, -1.0]).unwrap();
        for (at, value, held) in [
            (250.0, 1.0, true),
            (300.0, 1.0, false),
            (310.0, 2.0, false),
            (320.0, 3.0, false),
            (360.0, 1.0, false),
            (400.0, -1.0, false),
            (400.1, -1.0, true),
        ] {
            assert_eq!(table.at(at), (value, held), "at {at}");
        }
        let term = GenericTerm::new(Port::WindingHeat, Law::Table(table));
        assert_eq!((term.value(&AT), term.is_held(&AT)), (-1.0, false));
        assert!(term.is_held(&Drivers { winding_temperature: 401.0, ..AT }));
        let dual = term.along(&AT, Some((Driver::WindingTemperature, Dual64::from(350.0).derivative())));
        assert_eq!((dual.re, dual.eps), (1.5, -0.05));
    }

    #[test]
    fn a_table_needs_two_to_thirty_two_ascending_finite_points() {
        let many: Vec<f64> = (0..40).map(f64::from).collect();
        let new = |x: &[f64], y: &[f64]| Table::new(Driver::Time, x, y);
        assert!(new(&many[..32], &many[..32]).is_some());
        assert!(new(&many[..33], &many[..33]).is_none());
        assert!(new(&[1.0], &[1.0]).is_none());
        assert!(new(&[1.0, 1.0], &[1.0, 2.0]).is_none());
        assert!(new(&[1.0, 2.0], &[1.0]).is_none());
        assert!(new(&[1.0, 2.0], &[1.0, f64::NAN]).is_none());
    }

    /// Rows over speed 0 and 100 rad/s, columns over 300 and 400 K: (1, 2), (3, 8). In the middle 3.5; outside an edge the edge value.
    #[test]
    fn a_grid_is_bilinear_inside_and_held_outside() {
        let drivers = [Driver::Speed, Driver::WindingTemperature];
        let new = |points: [&[f64]; 2], rows: &[Vec<f64>]| Grid::new(drivers, points, rows);
        let rows = [vec![1.0, 2.0], vec![3.0, 8.0]];
        let grid = new([&[0.0, 100.0], &[300.0, 400.0]], &rows).unwrap();
        for (x, y, value, held) in [
            (50.0, 350.0, 3.5, false),
            (100.0, 400.0, 8.0, false),
            (100.0, 350.0, 5.5, false),
            (200.0, 350.0, 5.5, true),
            (50.0, 290.0, 2.0, true),
        ] {
            assert_eq!(grid.at(x, y), (value, held), "{x} {y}");
        }
        let term = GenericTerm::new(Port::WindingHeat, Law::Grid(grid));
        let at = Drivers { speed: 50.0, winding_temperature: 350.0, ..AT };
        let dual = term.along(&at, Some((Driver::WindingTemperature, Dual64::from(350.0).derivative())));
        assert_eq!((dual.re, dual.eps), (3.5, 0.03));
        assert!(term.follows(Driver::Speed) && !term.is_held(&at) && term.is_held(&AT));
        assert!(new([&[0.0], &[300.0, 400.0]], &rows[..1]).is_none());
        assert!(new([&[0.0, 100.0], &[400.0, 300.0]], &rows).is_none());
        assert!(new([&[0.0, 100.0], &[300.0, 400.0]], &[vec![1.0, 2.0], vec![3.0, f64::NAN]]).is_none());
        assert!(Grid::new([Driver::Speed; 2], [&[0.0, 1.0], &[0.0, 1.0]], &rows).is_none());
    }

    /// The state of a lag replaces its driver, without a derivative with respect to it.
    #[test]
    fn a_lagged_driver_is_the_state_of_its_lag() {
        let law = product(2.0, [factor(Driver::WindingTemperature, 10.0, 300.0, 1.0), None, None]).law;
        let lag = Some(Lag { driver: Driver::WindingTemperature, tau: 60.0 });
        let term = GenericTerm { port: Port::TorqueConstant, law, lag };
        let live = Some((Driver::WindingTemperature, Dual64::from(400.0).derivative()));
        let late = term.along_as(0, &AT, live);
        assert_eq!((late.re, late.eps), (4.0, 0.0));
        assert!(!term.follows(Driver::WindingTemperature) && term.is_whole());
        let heat = product(1.0, [factor(Driver::CopperLoss, 1.0, 0.0, 1.0), None, None]);
        let lag = |driver, tau| GenericTerm { lag: Some(Lag { driver, tau }), ..heat };
        assert!(!heat.is_whole() && lag(Driver::CopperLoss, 60.0).is_whole());
        assert!(!lag(Driver::Speed, 60.0).is_whole() && !lag(Driver::CopperLoss, 0.0).is_whole());
    }

    #[test]
    fn names_lead_back() {
        assert!(Port::ALL.iter().all(|port| Port::by_name(port.name()) == Some(*port)));
        assert!(Driver::ALL.iter().all(|driver| Driver::by_name(driver.name()) == Some(*driver)));
        assert_eq!((Port::ALL.len(), Port::by_name("nothing")), (14, None));
    }
}
