//! Latent states: laws over a first-order lag of a driver or of a heat flow.
//!
//! A node that the model lacks (magnets, bearing) follows the adjacent temperature or heat flow with a lag. Its time constant is profiled:
//! for each time constant of a series, the linearised model gives the response to the lagged driver, and a law linear in it is scored, as well
//! as a smooth function of it, which may rise and fall. The fit by simulation then estimates all parameters, including the time constant.
//!
//! Q = G (z - T),   C dz/dt = G (T - z)
//!
//! is the heat of a mass of capacity C that is attached to a node of temperature T by the conductance G. Since heat conduction is linear, it
//! continues beyond the data; two parameters are enough, and both are positive. A mass that also gives off heat to ambient differs from this
//! one by a conductance between T and ambient.
//! *Source*: profiling of a nonlinear parameter, Golub, Pereyra, SIAM J. Numer. Anal. 10 (1973) 413-432.

use super::lag_starts::Decays;
use super::laws::{
    LEAST_REFERENCE, acts, alike, coefficient, exponent, is_known, kernel, knots, number, scale,
    table_values, term, varies,
};
use super::{Scored, choice, scored};
use crate::evidence::Gain;
use crate::hypothesis::{Axis, Number, Shape, followed, hat, power};
use crate::levels::NEARLY;
use crate::linearization::Linearization;
use crate::numbers::{ends, range};
use crate::outcome::Follows;
use crate::parallel;
use nalgebra::DMatrix;
use physics::terms::{Driver, Factor, Lag, Port};

/// Shortest time constant that is tried, in rows. Numerical: a shorter lag cannot be distinguished from the driver itself.
const ROWS: f64 = 5.0;
/// Ratio of successive time constants. Derivation: first-order responses to neighbours correlate by 0.94, 2 sqrt(2) / 3.
const APART: f64 = 2.0;
/// Exponents that are tried at the best time constant. Numerical: the fit determines the exponent.
const EXPONENTS: [f64; 4] = [0.5, 1.0, 2.0, 3.0];
/// Limits of a time constant, relative to the shortest and the longest one tried. Numerical: at a limit the candidate is refused.
const LIMITS: (f64, f64) = (0.5, 4.0);
/// Unit of a time constant in the fit, relative to its value. Numerical: scale of a variable.
const SCALE: f64 = 0.2;
/// Points of a table over a lagged driver. Numerical: its prior correlates neighbouring points by 0.78, exp(-1/4).
const POINTS: usize = 5;

/// Lagged driver, run by run.
pub(super) struct Late {
    pub(super) lag: Lag,
    reached: Vec<Vec<f64>>,
    factor: Factor,
    /// Least and greatest value that it may have.
    range: (f64, f64),
}

impl Late {
    fn new(point: &Linearization, lag: Lag) -> Late {
        let tangents = || point.slopes.tangents.iter();
        let reached: Vec<Vec<f64>> = tangents().map(|t| followed(&t.time, &t.drivers, lag, 0.0)).collect();
        // A run that starts warm may have begun anywhere in the range of the driver.
        let is_warm = !lag.difference && point.warm_runs().next().is_some();
        let before = tangents().flat_map(|t| &t.drivers).filter(|_| is_warm).map(|d| d.of(lag.driver));
        let values = || reached.iter().flatten().copied().chain(before.clone());
        let (factor, range) = (scale(lag.driver, values()), ends(values()));
        Late { lag, reached, factor, range }
    }

    /// Without limits: of a mass.
    fn unlimited(point: &Linearization, driver: Driver, tau: f64) -> Late {
        let late = Late::new(point, Lag { driver, tau, difference: true });
        let reference = late.reached.iter().flatten().fold(LEAST_REFERENCE, |most, x| most.max(x.abs()));
        let factor = Factor { offset: 0.0, reference, range: Factor::UNLIMITED, ..late.factor };
        Late { factor, ..late }
    }

    /// Points of a table over it, at equal distances; `None` if it is constant.
    fn knots(&self) -> Option<Vec<f64>> {
        let (least, most) = self.range;
        let at = |k: usize| least + (most - least) * k as f64 / (POINTS - 1) as f64;
        let knots: Vec<f64> = (0..POINTS).map(at).collect();
        knots.windows(2).all(|pair| pair[0] < pair[1]).then_some(knots)
    }

    fn value(&self, r: usize, row: usize, exponent: f64) -> f64 {
        power(&self.factor, self.reached[r][row], exponent)
    }

    /// Greatest less least value of a power of the driver, in which the state of the lag has been.
    fn span(&self, point: &Linearization, exponent: f64) -> f64 {
        let values = point.drivers().map(|d| d.of(self.lag.driver));
        range(values.map(|x| power(&self.factor, x, exponent)))
    }
}

/// Time constants that are tried: from a few rows to the longest run.
fn time_constants(point: &Linearization) -> Vec<f64> {
    let runs = point.slopes.tangents.iter().map(|t| (t.time[t.time.len() - 1] - t.time[0], t.time.len()));
    let longest = runs.clone().map(|(span, _)| span).fold(0.0, f64::max);
    let row = runs.map(|(span, rows)| span / rows as f64).fold(f64::INFINITY, f64::min);
    std::iter::successors(Some(ROWS * row), |tau| Some(APART * tau))
        .take_while(|tau| *tau <= longest)
        .collect()
}

/// Best laws over a lag of each driver, at these ports; those that explain less than a function of its `present` values are left out: they
/// have the shortest lag, and the same to say.
pub(super) fn lagging(
    point: &Linearization,
    ports: &[Port],
    present: &[Scored],
    per_number: f64,
) -> Vec<Scored> {
    let taus = time_constants(point);
    let moves = |driver: Driver| {
        let values = || point.drivers().map(|d| d.of(driver));
        let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
        if driver.is_heat() { most > least } else { knots(point, driver).is_some() }
    };
    let drivers: Vec<Driver> = Driver::ALL
        .iter()
        .copied()
        .filter(|d| *d != Driver::Time && is_known(point, *d) && varies(point, *d) && moves(*d))
        .collect();
    let tried: Vec<(Driver, f64)> = drivers.iter().flat_map(|d| taus.iter().map(|tau| (*d, *tau))).collect();
    let late = parallel::map(&tried, |(driver, tau)| {
        Late::new(point, Lag { driver: *driver, tau: *tau, difference: false })
    });
    let decays = parallel::map(ports, |port| Decays::new(point, *port, &taus));
    let places: Vec<(Port, &Decays, Driver)> = ports
        .iter()
        .zip(&decays)
        .filter_map(|(port, decays)| Some((*port, decays.as_ref()?)))
        .flat_map(|(port, decays)| drivers.iter().map(move |d| (port, decays, *d)))
        .filter(|(port, _, driver)| acts(point, *port, *driver))
        .collect();
    let find = |(port, decays, driver): &(Port, &Decays, Driver)| {
        let own: Vec<&Late> = late.iter().filter(|l| l.lag.driver == *driver).collect();
        let columns = point.port_columns(*port, own.len(), |k, r, row, _| own[k].value(r, row, 1.0))?;
        let line = best(own.iter().copied().zip(lines(point, decays, &columns, &linear(&own))));
        // A function that rises and falls is no line at any time constant.
        let laws = [
            line.and_then(|(late, _)| powers(point, *port, decays, late, &taus, per_number)),
            Table::best(point, *port, decays, &own)
                .map(|table| table.scored(point, *port, &taus, per_number)),
        ];
        Some(laws.into_iter().flatten())
    };
    let mut found: Vec<Scored> = parallel::flat_map(&places, find).into_iter().flatten().collect();
    let without_lag = |s: &Scored| {
        let same = |p: &&Scored| p.port == s.port && p.follows.drivers().eq(s.follows.drivers());
        present.iter().find(same).map_or(0.0, Scored::sure)
    };
    found.retain(|s| s.sure() > without_lag(s));
    let measured: Vec<(Port, f64)> =
        found.iter().filter(|s| !is_of_heat(s)).map(|s| (s.port, s.sure())).collect();
    // The model computes a heat flow from measured drivers: it has to explain more than they do.
    let as_well =
        |s: &Scored| measured.iter().any(|(port, sure)| *port == s.port && *sure > NEARLY * s.sure());
    found.retain(|s| !is_of_heat(s) || !as_well(s));
    found
}

/// A mass attached to a node, for each node with a thermometer: the time constant that explains most, with a positive conductance.
pub(super) fn masses(point: &Linearization, per_number: f64) -> Vec<Scored> {
    let taus = time_constants(point);
    let of = |(port, driver): &(Port, Driver)| {
        if !is_known(point, *driver) || !varies(point, *driver) {
            return None;
        }
        let late: Vec<Late> = taus.iter().map(|tau| Late::unlimited(point, *driver, *tau)).collect();
        let columns = point.port_columns(*port, late.len(), |k, r, row, _| late[k].value(r, row, 1.0))?;
        let decays = Decays::new(point, *port, &taus)?;
        let gains = lines(point, &decays, &columns, &linear(&late.iter().collect::<Vec<_>>()));
        let gains = late.iter().zip(gains);
        let (best, gain) = best(gains.map(|(late, gain)| (late, gain.filter(|gain| gain.size[0] > 0.0))))?;
        let follows = Follows::Mass(*driver);
        let name = format!("{} of a mass", port.name());
        let cost = 2.0 * per_number + choice(*port, follows);
        let mut found = scored(name, *port, follows, &gain, cost, &[0.0]);
        let size = Number { limits: (0.0, f64::INFINITY), ..coefficient(*port, &gain) };
        let numbers = vec![size, time_constant(best, &taus)];
        found.addition = Some(term(point, (*port, follows), Shape::Linear { factor: best.factor }, numbers));
        Some(found)
    };
    let nodes =
        [(Port::HousingHeat, Driver::HousingTemperature), (Port::WindingHeat, Driver::WindingTemperature)];
    parallel::flat_map(&nodes, of)
}

fn is_of_heat(scored: &Scored) -> bool {
    scored.follows.drivers().any(Driver::is_heat)
}

fn best<T>(gains: impl Iterator<Item = (T, Option<Gain>)>) -> Option<(T, Gain)> {
    let known = gains.filter_map(|(tried, gain)| Some((tried, gain?)));
    known.max_by(|a, b| a.1.whitened.total_cmp(&b.1.whitened))
}

/// Time constant of a lag as a fitted parameter.
fn time_constant(late: &Late, taus: &[f64]) -> Number {
    let (first, last) = (taus[0], taus[taus.len() - 1]);
    let limits = (LIMITS.0 * first, LIMITS.1 * last);
    number("tau".to_string(), late.lag.tau, limits, "s", SCALE * late.lag.tau)
}

/// The lags themselves.
fn linear<'l>(late: &[&'l Late]) -> Vec<(&'l Late, f64)> {
    late.iter().map(|late| (*late, 1.0)).collect()
}

/// Gains of powers of the lags: one column each, with its exponent.
fn lines(
    point: &Linearization,
    decays: &Decays,
    columns: &DMatrix<f64>,
    powers: &[(&Late, f64)],
) -> Vec<Option<Gain>> {
    let late: Vec<&Late> = powers.iter().map(|(late, _)| *late).collect();
    let explain = |s: &DMatrix<f64>, starts: usize| point.evidence.gains(s, 1 + starts);
    let span = |gain: &Gain, k: usize| gain.size[0].abs() * powers[k].0.span(point, powers[k].1);
    decays.gains(columns, &late, explain, span, point.per_number())
}

fn powers(
    point: &Linearization,
    port: Port,
    decays: &Decays,
    late: &Late,
    taus: &[f64],
    per_number: f64,
) -> Option<Scored> {
    let columns =
        point.port_columns(port, EXPONENTS.len(), |k, r, row, _| late.value(r, row, EXPONENTS[k]))?;
    let gains = lines(point, decays, &columns, &EXPONENTS.map(|exponent| (late, exponent)));
    let (exponent, gain) = best(EXPONENTS.into_iter().zip(gains))?;
    let name = format!("{} ~ lag of {}^{exponent}", port.name(), late.lag.driver.name());
    let follows = Follows::Late(late.lag.driver);
    let mut found = scored(name, port, follows, &gain, 3.0 * per_number + choice(port, follows), &[0.0]);
    let numbers = vec![coefficient(port, &gain), self::exponent(exponent), time_constant(late, taus)];
    let shape = Shape::Power { factor: Factor { exponent, ..late.factor } };
    found.addition = Some(term(point, (port, follows), shape, numbers));
    Some(found)
}

/// Smooth function of a lagged driver at a port.
struct Table<'l> {
    late: &'l Late,
    knots: Vec<f64>,
    gain: Gain,
}

impl<'l> Table<'l> {
    /// The best one; `None` if the lagged driver is constant, or its functions have no effect.
    fn best(point: &Linearization, port: Port, decays: &Decays, late: &[&'l Late]) -> Option<Table<'l>> {
        let own: Vec<(&Late, Vec<f64>)> =
            late.iter().filter_map(|late| Some((*late, late.knots()?))).collect();
        let columns = point.port_columns(port, POINTS * own.len(), |k, r, row, _| {
            let (late, knots) = &own[k / POINTS];
            hat(knots, k % POINTS, late.reached[r][row])
        })?;
        // Knots at equal distances have the same covariance at every time constant. A start is as large as the law.
        let kernel = alike(&own.first()?.1);
        let explain = |s: &DMatrix<f64>, starts: usize| {
            let mut with = DMatrix::identity(POINTS + starts, POINTS + starts);
            with.view_mut((0, 0), (POINTS, POINTS)).copy_from(&kernel);
            point.evidence.shapes(s, &with)
        };
        let span = |gain: &Gain, _: usize| range(gain.size.iter().take(POINTS).copied());
        let late: Vec<&Late> = own.iter().map(|(late, _)| *late).collect();
        let gains = decays.gains(&columns, &late, explain, span, point.per_number());
        let ((late, knots), gain) = best(own.into_iter().zip(gains))?;
        Some(Table { late, knots, gain })
    }

    fn scored(self, point: &Linearization, port: Port, taus: &[f64], per_number: f64) -> Scored {
        let Table { late, knots, gain } = self;
        let driver = late.lag.driver;
        let name = format!("{} over lag of {}", port.name(), driver.name());
        let follows = Follows::Late(driver);
        let mut found = scored(name, port, follows, &gain, 3.0 * per_number + choice(port, follows), &knots);
        let axes = vec![Axis { driver, knots, is_even: false }];
        let mut numbers = table_values(port, &axes, "lagged ", &gain);
        numbers.push(time_constant(late, taus));
        let kernel = kernel(&axes);
        let shape = super::laws::table(axes, kernel, &gain);
        found.addition = Some(term(point, (port, follows), shape, numbers));
        found
    }
}
