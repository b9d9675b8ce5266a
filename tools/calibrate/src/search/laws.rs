//! Laws at a port: smooth functions of one driver or of two, and power laws.
//!
//! f(x) ~ N(0, q^2 K),   K_ab = exp(-|x_a - x_b| / span)                         a function of one driver            (1)
//! f(x, y) ~ N(0, q^2 (K_x + K_y + K_x K_y) / 3)                                a function of two                   (2)
//!
//! x_a knots, between which values are linear or bilinear. (2) is the sum of a function of each driver and a further function of both:
//! where the data hold no pair of values, the sum of the first two continues. q is estimated with the evidence (`evidence.rs`).
//! A rig that runs in both directions shows drags and losses twice: at a driver that enters laws by its magnitude (speed, current, torque) a
//! function of the magnitude is tried beside (1), and is the only one in (2).
//! Functions of two drivers are found by beam search: at the ports that explain most, the drivers with the best functions of their own are
//! combined with every other one.
//! *Sources*: Rasmussen, Williams, Gaussian Processes for Machine Learning (2006), sec. 4.2.4 (sums and products of covariances), ch. 5
//! (hyperparameters); Duvenaud, Nickisch, Rasmussen, Advances in Neural Information Processing Systems 24 (2011) 226-234 (additive
//! processes); Duvenaud et al., Int. Conf. Machine Learning 28 (2013) 1166-1174 (search).

use super::{Scored, choice, is_inside, scored, temperatures};
use crate::evidence::Gain;
use crate::experiment::Channel;
use crate::hypothesis::{Addition, Axis, Number, Shape, place, power, values, weight};
use crate::levels::{NEARLY, PART};
use crate::linearization::Linearization;
use crate::outcome::Follows;
use crate::parallel;
use crate::selection::LEAST;
use nalgebra::DMatrix;
use physics::terms::{Driver, Drivers, Factor, Port};

/// Knots of a smooth function of a driver. Numerical: its prior correlates neighbouring knots by 0.85, exp(-1/6).
const KNOTS: usize = 7;
/// Knots of a function of two drivers, for each. Numerical: its prior correlates neighbouring knots by 0.78, exp(-1/4).
const KNOTS_OF_TWO: usize = 5;
/// The same for a magnitude, which has them on both sides. Limit: half of the lines of a grid ([`physics::terms::MOST_LINES`]).
const KNOTS_OF_MAGNITUDE: usize = physics::terms::MOST_LINES / 2;
/// Drivers at a port that are combined with every other one. Numerical: a limit of effort; the best functions of one driver come first.
const BEAM: usize = 4;
/// A driver whose variation is less than this fraction of its size cannot determine a shape. Numerical: excludes constant drivers.
const STILL: f64 = 0.01;
/// Change of temperature in which a property changes by a factor e, K. Limit: of steep ones; Arrhenius' law with 40 kJ/mol has it at 50 degC,
/// and greases are near. Over less than [`PART`] of it a law changes by less than structure error may.
const STEEP: f64 = 20.0;
/// Least distance of two knots as a fraction of the span. Numerical: the hat functions of closer knots are nearly collinear.
const KNOT_APART: f64 = 0.02;
/// Least reference value of a driver, in its unit. Numerical: avoids a division by zero.
pub(super) const LEAST_REFERENCE: f64 = 1e-9;
/// Limits of an exponent. Limit: beyond them a power is a step.
const EXPONENT_LIMITS: (f64, f64) = (0.1, 5.0);
/// Unit of an exponent in the fit. Numerical: scale of a variable.
const EXPONENT_SCALE: f64 = 0.05;
/// Exponents that are tried. Numerical: the fit determines the exponent.
const EXPONENTS: [f64; 9] = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0];
/// No limits.
const UNLIMITED: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// Knots over a driver's values in the runs: least, greatest, and points between; `None` if it hardly varies.
pub(super) fn knots(point: &Linearization, driver: Driver) -> Option<Vec<f64>> {
    knots_of(point, driver, KNOTS)
}

fn is_temperature(driver: Driver) -> bool {
    is_inside(driver) || driver == Driver::AmbientTemperature
}

/// Whether a driver varies so much in the runs that a law can follow it: a temperature by [`PART`] of [`STEEP`].
pub(super) fn varies(point: &Linearization, driver: Driver) -> bool {
    let ends = |(a, b): (f64, f64), x: f64| (a.min(x), b.max(x));
    let (least, most) = point.drivers().map(|d| d.of(driver)).fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    !is_temperature(driver) || most - least > PART * STEEP
}

fn knots_of(point: &Linearization, driver: Driver, count: usize) -> Option<Vec<f64>> {
    let values = point.drivers().map(|d| d.of(driver)).collect();
    spread(values, count, is_temperature(driver).then_some(STEEP))
}

/// Whether laws take the magnitude of a driver that has been on both sides of zero by more than the distance of two knots.
fn has_turned(point: &Linearization, driver: Driver) -> bool {
    let ends = |(a, b): (f64, f64), x: f64| (a.min(x), b.max(x));
    let (least, most) = point.drivers().map(|d| d.of(driver)).fold((0.0, 0.0), ends);
    !driver.has_sides() && most.min(-least) > KNOT_APART * (most - least)
}

/// Points over the magnitude of a driver.
fn even(point: &Linearization, driver: Driver, count: usize) -> Option<Axis> {
    let values = point.drivers().map(|d| d.of(driver).abs()).collect();
    Some(Axis { driver, knots: spread(values, count, None)?, is_even: true })
}

/// Knots over values: least, greatest, and points between; `None` if they hardly vary relative to a size, that of the values if there is
/// none.
pub fn spread(mut values: Vec<f64>, count: usize, size: Option<f64>) -> Option<Vec<f64>> {
    values.sort_by(f64::total_cmp);
    let (least, most) = (*values.first()?, *values.last()?);
    let span = most - least;
    if span.is_nan() || span <= STILL * size.unwrap_or(most.abs().max(least.abs())) {
        return None;
    }
    let mut all: Vec<f64> = Vec::new();
    for k in 0..count {
        let share = k as f64 / (count - 1) as f64;
        // Half by rows, half by span: knots where data is dense, without coincident knots.
        let by_rows = values[((values.len() - 1) as f64 * share) as usize];
        let x = 0.5 * by_rows + 0.5 * (least + span * share);
        if all.last().is_none_or(|last| x - last > KNOT_APART * span) {
            all.push(x);
        }
    }
    Some(all)
}

/// K of (1).
pub fn alike(knots: &[f64]) -> DMatrix<f64> {
    let span = knots[knots.len() - 1] - knots[0];
    DMatrix::from_fn(knots.len(), knots.len(), |a, b| (-(knots[a] - knots[b]).abs() / span).exp())
}

/// Covariance of (1) or (2).
pub fn kernel(axes: &[Axis]) -> DMatrix<f64> {
    let own: Vec<DMatrix<f64>> = axes.iter().map(|axis| alike(&axis.knots)).collect();
    let [first, second] = &own[..] else { return own.into_iter().next().unwrap_or_default() };
    let constant = |k: &DMatrix<f64>| DMatrix::from_element(k.nrows(), k.ncols(), 1.0);
    let parts =
        [first.kronecker(&constant(second)), constant(first).kronecker(second), first.kronecker(second)];
    let count = parts.len() as f64;
    parts.into_iter().sum::<DMatrix<f64>>() / count
}

/// A table whose values have the covariance q^2 `kernel`, with the variance q^2 that the data give.
///
/// q^2 = [v' K^-1 v + tr(K^-1 S)] / n,   v and S: mean and covariance of the n values given the data                   (3)
///
/// *Source*: MacKay, Neural Computation 4 (1992) 415-447: at the most probable q.
pub fn table(axes: Vec<Axis>, kernel: DMatrix<f64>, gain: &Gain) -> Shape {
    let n = kernel.nrows();
    let values = gain.size.rows(0, n);
    let precision = kernel.cholesky().map_or_else(|| DMatrix::zeros(n, n), |factor| factor.inverse());
    let spread = (&precision * gain.covariance.view((0, 0), (n, n))).trace();
    let q = (values.dot(&(&precision * values)) + spread) / n as f64;
    Shape::Table { axes, precision: precision / q }
}

/// Offset, reference value and range of a driver with these values in the fit runs.
pub(super) fn scale(driver: Driver, values: impl Iterator<Item = f64>) -> Factor {
    let offset = match driver {
        Driver::WindingTemperature | Driver::HousingTemperature => 298.15,
        Driver::AmbientTemperature => 293.15,
        _ => 0.0,
    };
    let has_sides = driver.has_sides();
    // A magnitude below its least value is between this value and 0, where the power is 0.
    let (least, most) =
        values.fold((if has_sides { f64::INFINITY } else { 0.0 }, f64::NEG_INFINITY), |(a, b), x| {
            let x = if has_sides { x } else { x.abs() };
            (a.min(x), b.max(x))
        });
    let reference = (most - offset).abs().max((least - offset).abs()).max(LEAST_REFERENCE);
    Factor { driver, offset, reference, exponent: 1.0, range: (least, most) }
}

/// Whether a law at this port may follow this driver. If the speed is imposed, the torque is that of the current, and what follows it follows
/// the current, except for friction: bearings and gears carry a torque.
pub(super) fn acts(point: &Linearization, port: Port, driver: Driver) -> bool {
    driver != Driver::LoadTorque || port == Port::DragTorque || point.setup.has_load()
}

/// Whether the driver is measured: a temperature of a node that has a sensor.
pub(super) fn is_known(point: &Linearization, driver: Driver) -> bool {
    let has_sensor = || Channel::reading(driver).is_none_or(|c| point.is_read(c));
    match driver {
        Driver::WindingTemperature | Driver::HousingTemperature => has_sensor(),
        _ => true,
    }
}

/// Number of a law that is found by linearization.
pub(super) fn number(
    symbol: String,
    value: f64,
    limits: (f64, f64),
    unit: &'static str,
    scale: f64,
) -> Number {
    Number { symbol, value, limits, unit, scale, sloped: true }
}

/// The coefficient of a power law, estimated to first order.
pub(super) fn coefficient(port: Port, gain: &Gain) -> Number {
    let spread = gain.covariance[(0, 0)].sqrt();
    number("coefficient".to_string(), gain.size[0], UNLIMITED, port.unit().name(), spread)
}

/// The exponent of a power law.
pub(super) fn exponent(value: f64) -> Number {
    number("exponent".to_string(), value, EXPONENT_LIMITS, "1", EXPONENT_SCALE)
}

/// The values of a table, estimated to first order; `late` comes before the name of a driver with a lag.
pub fn table_values(port: Port, axes: &[Axis], late: &str, gain: &Gain) -> Vec<Number> {
    let point_of = |(axis, k): (&Axis, usize)| {
        let (name, x) = (axis.driver.name(), axis.knots[k]);
        if axis.is_even { format!("|{name}| = {x:.4}") } else { format!("{late}{name} = {x:.4}") }
    };
    let own = |k: usize| {
        let at = place(axes, k).map(point_of).collect::<Vec<_>>().join(", ");
        let spread = gain.covariance[(k, k)].sqrt();
        number(format!("value at {at}"), gain.size[k], UNLIMITED, port.unit().name(), spread)
    };
    (0..values(axes)).map(own).collect()
}

/// A law as an addition in all runs.
pub(super) fn term(
    point: &Linearization,
    (port, follows): (Port, Follows),
    shape: Shape,
    numbers: Vec<Number>,
) -> Addition {
    Addition {
        id: "generic_term".to_string(),
        port,
        follows,
        shape,
        numbers,
        active: vec![true; point.setup.experiment.runs.len()],
    }
}

/// Smooth function of a driver at a port.
pub(super) fn smooth(point: &Linearization, port: Port, driver: Driver, per_number: f64) -> Option<Scored> {
    let axis = Axis { driver, knots: knots(point, driver)?, is_even: false };
    let even = has_turned(point, driver).then(|| even(point, driver, KNOTS)).flatten();
    let found = [Some(axis), even].into_iter().flatten();
    let found = found.filter_map(|axis| over(point, port, vec![axis], per_number));
    let mut found = found.max_by(|a, b| a.sure().total_cmp(&b.sure()))?;
    // A law over time in these runs does not carry over to other runs, so it cannot be added.
    found.addition = found.addition.filter(|_| driver != Driver::Time);
    Some(found)
}

/// (1) or (2) at a port.
fn over(point: &Linearization, port: Port, axes: Vec<Axis>, per_number: f64) -> Option<Scored> {
    let count = values(&axes);
    let columns = point.port_columns(port, count, |k, _, _, d| weight(&axes, k, |driver| d.of(driver)))?;
    let kernel = kernel(&axes);
    let gain = point.evidence.shape(&columns, &kernel)?;
    let drivers: Vec<&str> = axes.iter().map(|axis| axis.driver.name()).collect();
    let name = format!("{} over {}", port.name(), drivers.join(" and "));
    let follows = match axes[..] {
        [ref first, ref second] => Follows::Both(first.driver, second.driver),
        _ => Follows::Driver(axes[0].driver),
    };
    // One for the size, and one for each driver.
    let cost = (1.0 + axes.len() as f64) * per_number + choice(port, follows);
    let mut found = Scored { shape: profile(&axes, &gain), ..scored(name, port, follows, &gain, cost, &[]) };
    let numbers = table_values(port, &axes, "", &gain);
    found.addition = Some(term(point, (port, follows), table(axes, kernel, &gain), numbers));
    Some(found)
}

/// Function over the first driver with standard deviations: the mean over the knots of the second.
fn profile(axes: &[Axis], gain: &Gain) -> Vec<(f64, f64, f64)> {
    let first = &axes[0].knots;
    let others = values(&axes[1..]);
    let of = |(k, x): (usize, &f64)| {
        let from = k * others;
        let mean = gain.size.rows(from, others).sum() / others as f64;
        let variance = gain.covariance.view((from, from), (others, others)).sum();
        (*x, mean, variance.sqrt() / others as f64)
    };
    first.iter().enumerate().map(of).collect()
}

/// Functions of two drivers at these ports that explain more than the best function of one driver there, `single`.
pub(super) fn of_two(
    point: &Linearization,
    ports: &[Port],
    single: &[(Port, Driver, Scored)],
    per_number: f64,
) -> Vec<Scored> {
    let axis = |driver: Driver| match has_turned(point, driver) {
        true => even(point, driver, KNOTS_OF_MAGNITUDE),
        false => Some(Axis { driver, knots: knots_of(point, driver, KNOTS_OF_TWO)?, is_even: false }),
    };
    let mut places: Vec<(Port, f64, [Driver; 2])> = Vec::new();
    for port in ports {
        let mut own: Vec<&(Port, Driver, Scored)> = single
            .iter()
            .filter(|(at, driver, _)| at == port && *driver != Driver::Time && is_known(point, *driver))
            .collect();
        own.sort_by(|a, b| b.2.sure().total_cmp(&a.2.sure()));
        let best = own.first().map_or(0.0, |s| s.2.sure());
        for (k, (_, first, _)) in own.iter().take(BEAM).enumerate() {
            places.extend(own[k + 1..].iter().map(|(_, second, _)| (*port, best, [*first, *second])));
        }
    }
    let find = |(port, best, [first, second]): &(Port, f64, [Driver; 2])| {
        let found = over(point, *port, vec![axis(*first)?, axis(*second)?], per_number)?;
        (found.sure() > best.max(0.0) + LEAST).then_some(found)
    };
    let mut all = parallel::flat_map(&places, find);
    // An effect at a node depends on the temperature of that node, if it explains nearly as much as that of the other one.
    let found: Vec<(Port, Follows, f64)> = all.iter().map(|s| (s.port, s.follows, s.sure())).collect();
    all.retain(|s| {
        let Some((own, other)) = temperatures(s.port) else { return true };
        let mut drivers = s.follows.drivers().map(|d| if d == other { own } else { d });
        let (Some(a), Some(b)) = (drivers.next(), drivers.next()) else { return true };
        let same = |follows: Follows| [Follows::Both(a, b), Follows::Both(b, a)].contains(&follows);
        let as_well = |(port, follows, sure): &(Port, Follows, f64)| {
            *port == s.port && *follows != s.follows && same(*follows) && *sure > NEARLY * s.sure()
        };
        !found.iter().any(as_well)
    });
    all
}

/// Power law of a driver at a port.
pub(super) fn powers(point: &Linearization, port: Port, driver: Driver, per_number: f64) -> Option<Scored> {
    knots(point, driver)?;
    let factor = scale(driver, point.drivers().map(|d| d.of(driver)));
    let value = |k: usize, d: &Drivers| power(&factor, d.of(driver), EXPONENTS[k]);
    let columns = point.port_columns(port, EXPONENTS.len(), |k, _, _, d| value(k, d))?;
    let gains = EXPONENTS.into_iter().zip(point.evidence.gains(&columns, 1));
    // A drag or a voltage drop with negative coefficient would be a source and is not physical.
    let is_physical =
        |gain: &Gain| !matches!(port, Port::DragTorque | Port::TerminalVoltage) || gain.size[0] > 0.0;
    let physical = gains.filter_map(|(exponent, gain)| Some((exponent, gain.filter(is_physical)?)));
    let (exponent, gain) = physical.max_by(|a, b| a.1.whitened.total_cmp(&b.1.whitened))?;
    let name = format!("{} ~ {}^{exponent}", port.name(), driver.name());
    let follows = Follows::Driver(driver);
    let mut found = scored(name, port, follows, &gain, 2.0 * per_number + choice(port, follows), &[0.0]);
    let shape = Shape::Power { factor: Factor { exponent, ..factor } };
    let numbers = vec![coefficient(port, &gain), self::exponent(exponent)];
    found.addition = Some(term(point, (port, follows), shape, numbers));
    Some(found)
}
