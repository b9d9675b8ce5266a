//! Candidates for the missing effect, ranked by evidence: effects of the list, and latent inputs at every port.
//!
//! | candidate | parameters |
//! |---|---|
//! | an effect of the list, in all runs or in some | size |
//! | at every port a smooth function of every driver | as many as the evidence supports, [`Evidence::shape`](crate::evidence) |
//! | at every port a power law of every driver | coefficient, exponent |
//! | at every port a latent input (unconstrained in time) | as many as the evidence supports |
//! | at the ports selected by these: laws over a first-order lag of a driver or of a heat flow | as for a power or a shape, time constant
//! |
//! | at the ports selected by these: latching, hysteresis switching, intermittent action | size and threshold, width or period |
//!
//! Candidates are compared by the reduction of the evidence's cost minus ln n for each parameter (BIC, Schwarz), n the number of blocks.

mod hidden;
mod memory_terms;
mod structure;
#[cfg(test)]
mod tests;

use crate::catalogue::{LISTED, Listed, Way};
use crate::evidence::Gain;
use crate::experiment::Channel;
use crate::hypothesis::{Addition, Number, Shape, hat, power};
use crate::levels::{NEARLY, SURE};
use crate::linearization::Linearization;
use crate::outcome::Follows;
use crate::selection::NEAR;
use memory_terms::{FREE, histories, latent_inputs};
pub use memory_terms::{best_memory_term, latent_input, latent_input_at, needs_memory};
use nalgebra::DMatrix;
use physics::terms::{Driver, Drivers, Factor, Port};
use rayon::prelude::*;
pub use structure::structure;

/// Knots of a smooth function of a driver. Numerical: its prior correlates neighbouring knots by 0.85, exp(-1/6).
const KNOTS: usize = 7;
/// Times per run at which a step change is tried. Numerical: every row near the best one follows.
const TIMES: usize = 60;
/// Number of times for which the gains are computed together. Numerical: a block of columns that fits into the cache.
const TOGETHER: usize = 32;
/// A driver whose variation is less than this fraction of its size cannot determine a shape. Numerical: excludes constant drivers.
const STILL: f64 = 0.01;
/// Number of best shapes for which power laws are tried. Numerical: a power law is also a smooth shape, so those of further shapes
/// explain less.
const LIKELY: usize = 16;
/// Size of a temperature driver, K, relative to which its variation counts. Numerical: as for `STILL`.
const TEMPERATURES: f64 = 20.0;
/// Least distance of two knots as a fraction of the span. Numerical: the hat functions of closer knots are nearly collinear.
const KNOT_APART: f64 = 0.02;
/// Least reference value of a driver, in its unit. Numerical: avoids a division by zero.
const LEAST_REFERENCE: f64 = 1e-9;
/// Limits of an exponent. Limit: losses and drops of motors grow with powers from 0.5 (brush drop) to 3 (windage); beyond these limits
/// a power is a step.
const EXPONENT_LIMITS: (f64, f64) = (0.1, 5.0);
/// Unit of an exponent in the fit. Numerical: scale of a variable.
const EXPONENT_SCALE: f64 = 0.05;
/// Exponents that are tried. Numerical: the fit determines the exponent.
const EXPONENTS: [f64; 9] = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0];
/// Time constants of a sensor, s, that are tried. Numerical: starts of a fit.
const LAGS: [f64; 3] = [10.0, 30.0, 90.0];
/// Capacity and resistance of a new node that are tried, as fractions of those of housing and winding. Numerical: starts of a fit.
const NODES: [(f64, f64); 4] = [(0.15, 0.5), (0.15, 1.5), (0.4, 0.5), (0.4, 1.5)];
/// Least size of an effect relative to its trial. Numerical: for a smaller one the trial is no linearization.
const LEAST_TRIAL: f64 = 0.1;

/// Candidate for a missing effect, with its evidence.
#[derive(Clone, Debug)]
pub struct Scored {
    /// Addition to the model, its parameters estimated to first order; `None` if it cannot be added (latent input, law over time).
    pub addition: Option<Addition>,
    /// Description.
    pub name: String,
    /// Port at which it acts.
    pub port: Port,
    /// Driver on which it depends.
    pub follows: Follows,
    /// Whether it is an effect of the list.
    pub listed: bool,
    /// Reduction of the cost minus ln n for each parameter, allowing for autocorrelated noise.
    pub evidence: f64,
    /// The same for white noise.
    pub raw: f64,
    /// Estimated shape: driver, value, standard deviation.
    pub shape: Vec<(f64, f64, f64)>,
}

impl Scored {
    /// Whether it is a latent input.
    pub fn is_free(&self) -> bool {
        self.name.ends_with(FREE)
    }

    /// Whether its shape decreases with its driver overall; for a power law, whether its coefficient is negative.
    fn falls(&self) -> bool {
        let middle = self.shape.iter().map(|(x, ..)| x).sum::<f64>() / self.shape.len() as f64;
        match self.shape[..] {
            [(_, coefficient, _)] => coefficient < 0.0,
            _ => self.shape.iter().map(|(x, value, _)| (x - middle) * value).sum::<f64>() < 0.0,
        }
    }

    /// Evidence under the less favourable of the two noise models.
    pub fn sure(&self) -> f64 {
        self.evidence.min(self.raw)
    }
}

/// Penalty for the choice among all ports and drivers: -2 ln p with equal probabilities. A law by which the fan or the ambient temperature
/// acts inside the motor has to explain more, by strong evidence: they reach the motor and its sensors through the air only.
pub fn choice(port: Port, follows: Follows) -> f64 {
    let equal = 2.0 * ((Port::ALL.len() * Driver::ALL.iter().filter(|d| !d.is_heat()).count()) as f64).ln();
    let of_the_air = [Driver::FanCommand, Driver::AmbientTemperature];
    let is_outside = matches!(
        port,
        Port::FanFlow
            | Port::HousingAmbientConductance
            | Port::AmbientSensor
            | Port::WindingSensor
            | Port::HousingSensor
            | Port::TorqueSensor
    );
    let is_odd = of_the_air.iter().any(|d| [Follows::Driver(*d), Follows::Late(*d)].contains(&follows));
    equal + if is_odd && !is_outside { NEAR } else { 0.0 }
}

/// Knots over a driver's values in the runs: least, greatest, and points between.
fn knots(point: &Linearization, driver: Driver) -> Option<Vec<f64>> {
    let mut values: Vec<f64> = point.drivers().map(|d| d.of(driver)).collect();
    values.sort_by(f64::total_cmp);
    let (least, most) = (values[0], values[values.len() - 1]);
    let span = most - least;
    let size = match driver {
        Driver::WindingTemperature | Driver::HousingTemperature | Driver::AmbientTemperature => TEMPERATURES,
        _ => most.abs().max(least.abs()),
    };
    if span.is_nan() || span <= STILL * size {
        return None;
    }
    let mut all: Vec<f64> = Vec::new();
    for k in 0..KNOTS {
        let share = k as f64 / (KNOTS - 1) as f64;
        // Half by rows, half by span: knots where data is dense, without coincident knots.
        let by_rows = values[((values.len() - 1) as f64 * share) as usize];
        let x = 0.5 * by_rows + 0.5 * (least + span * share);
        if all.last().is_none_or(|last| x - last > KNOT_APART * span) {
            all.push(x);
        }
    }
    Some(all)
}

/// Prior covariance of a shape's values: those of neighbouring knots are correlated.
fn alike(knots: &[f64]) -> DMatrix<f64> {
    let span = knots[knots.len() - 1] - knots[0];
    DMatrix::from_fn(knots.len(), knots.len(), |a, b| (-(knots[a] - knots[b]).abs() / span).exp())
}

/// A table whose values have the prior of (4) in `evidence.rs` with the variance q that the data give.
///
/// q = [v' K^-1 v + tr(K^-1 S)] / n,   v and S: mean and covariance of the n values given the data                     (1)
///
/// *Source*: MacKay, Neural Computation 4 (1992) 415-447: at the most probable q; K correlates neighbouring values ([`alike`]).
fn table(driver: Driver, knots: Vec<f64>, gain: &Gain) -> Shape {
    let n = knots.len();
    let values = gain.size.rows(0, n);
    let precision = alike(&knots).cholesky().map_or_else(|| DMatrix::zeros(n, n), |factor| factor.inverse());
    let spread = (&precision * gain.covariance.view((0, 0), (n, n))).trace();
    let q = (values.dot(&(&precision * values)) + spread) / n as f64;
    Shape::Table { driver, knots, precision: precision / q }
}

/// Offset and reference value of a driver.
fn scale(point: &Linearization, driver: Driver) -> Factor {
    let offset = match driver {
        Driver::WindingTemperature | Driver::HousingTemperature => 298.15,
        Driver::AmbientTemperature => 293.15,
        _ => 0.0,
    };
    let most = point.drivers().map(|d| (d.of(driver) - offset).abs()).fold(0.0, f64::max);
    Factor { driver, offset, reference: most.max(LEAST_REFERENCE), exponent: 1.0 }
}

/// Whether the driver is measured: a load that is imposed, a temperature of a node that has a sensor.
fn is_known(point: &Linearization, driver: Driver) -> bool {
    let has_sensor = || Channel::reading(driver).is_none_or(|c| point.is_read(c));
    match driver {
        Driver::LoadTorque => point.setup.has_load(),
        Driver::WindingTemperature | Driver::HousingTemperature => has_sensor(),
        _ => true,
    }
}

/// All candidates at a point, in order of decreasing evidence.
pub fn search(point: &Linearization) -> Vec<Scored> {
    let per_number = point.per_number();
    let mut all = listed(point, per_number);
    let jobs: Vec<(Port, Driver)> = Port::ALL
        .iter()
        .flat_map(|p| Driver::ALL.iter().map(move |d| (*p, *d)))
        .filter(|(_, driver)| *driver != Driver::LoadTorque || point.setup.has_load())
        // A term can depend on a heat flow only through a lag.
        .filter(|(_, driver)| !driver.is_heat())
        .collect();
    let mut shapes: Vec<(Port, Driver, Scored)> = jobs
        .par_iter()
        .filter_map(|(port, driver)| Some((*port, *driver, smooth(point, *port, *driver, per_number)?)))
        .collect();
    shapes.sort_by(|a, b| b.2.evidence.total_cmp(&a.2.evidence));
    // A power law is also a smooth shape: if no shape explains much, no power law does.
    let likely = &shapes[..shapes.len().min(LIKELY)];
    all.par_extend(
        likely
            .par_iter()
            .filter(|(_, driver, _)| *driver != Driver::Time)
            .flat_map_iter(|(port, driver, _)| powers(point, *port, *driver, per_number)),
    );
    all.extend(shapes.into_iter().map(|(_, _, shape)| shape));
    let mut free: Vec<Scored> =
        Port::ALL.par_iter().filter_map(|port| latent_inputs(point, *port, per_number)).collect();
    free.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let ports: Vec<Port> = free.iter().take(4).map(|s| s.port).collect();
    all.extend(hidden::lagging(point, &ports, per_number));
    all.par_extend(ports.par_iter().flat_map_iter(|port| histories(point, *port, per_number)));
    all.extend(free);
    leave_to_the_air(&mut all);
    all.sort_by(|a, b| b.sure().total_cmp(&a.sure()));
    all
}

/// A heat at the housing that decreases with its temperature is a heat loss: if a conductance to ambient over the same driver explains
/// nearly as much, the conductance is preferred.
fn leave_to_the_air(all: &mut Vec<Scored>) {
    let temperature = [Driver::HousingTemperature, Driver::WindingTemperature].map(Follows::Driver);
    let law = |s: &Scored, port: Port| s.port == port && !s.listed && temperature.contains(&s.follows);
    let shape = |s: &Scored| (s.follows, s.shape.len());
    let air = all.iter().filter(|s| law(s, Port::HousingAmbientConductance));
    let air: Vec<_> = air.map(|s| (shape(s), s.sure())).collect();
    let as_well = |s: &Scored| air.iter().any(|(own, sure)| *own == shape(s) && *sure > NEARLY * s.sure());
    all.retain(|s| !(law(s, Port::HousingHeat) && s.falls() && as_well(s)));
}

/// Size of an effect by its change to first order; `None` if it has the wrong sign. A large effect is beyond its limit to first order:
/// half way to it is then the start of the fit.
fn possible(base: f64, change: f64, limits: (f64, f64)) -> Option<f64> {
    let size = base + change;
    let (least, most) = limits;
    if within(size, limits) {
        Some(size)
    } else if size > most && most > base {
        Some(0.5 * (base + most))
    } else {
        (size < least && least < base).then_some(0.5 * (base + least))
    }
}

fn within(value: f64, limits: (f64, f64)) -> bool {
    (limits.0..=limits.1).contains(&value)
}

fn listed(point: &Linearization, per_number: f64) -> Vec<Scored> {
    let runs = point.runs.len();
    let known: Vec<_> = point.listed().collect();
    let mut all: Vec<Scored> = (0..known.len())
        .into_par_iter()
        .flat_map_iter(|k| {
            let (listed, addition) = known[k];
            let patterns: Vec<Vec<bool>> = if listed.may_vary && runs <= 6 {
                (1..1usize << runs).map(|bits| (0..runs).map(|r| bits >> r & 1 == 1).collect()).collect()
            } else {
                vec![vec![true; runs]]
            };
            let everywhere = patterns.len();
            patterns
                .into_iter()
                .filter_map(|pattern| {
                    let gain = point.evidence.gain(&point.listed_column(k, &pattern)?)?;
                    let partly = pattern.iter().any(|on| !on);
                    let base = point.base(addition);
                    let size = possible(base, gain.size[0], addition.numbers[0].limits)?;
                    // An effect that is declared to act everywhere may have another size in some runs.
                    if base != 0.0 && !partly {
                        return None;
                    }
                    let mut addition = addition.clone();
                    addition.numbers[0].value = size;
                    if partly {
                        // The effect is inactive in runs outside the fit until they are evaluated.
                        addition.active.fill(false);
                        point.runs.iter().zip(&pattern).for_each(|(run, on)| addition.active[*run] = *on);
                    }
                    // Penalty for the choice of runs: 2 ln of the number of choices.
                    let choice = if partly { 2.0 * (everywhere as f64).ln() } else { 0.0 };
                    let name =
                        if partly { format!("{} in some runs", listed.id) } else { listed.id.to_string() };
                    Some(named(listed, name, addition, &gain, per_number + choice))
                })
                .collect::<Vec<_>>()
        })
        .collect();
    let everywhere = vec![true; point.setup.experiment.runs.len()];
    for listed in LISTED.iter().filter(|l| l.way != Way::Slope) {
        if point.fitted.hypothesis.additions.iter().any(|a| a.id == listed.id) {
            continue;
        }
        let Some(addition) = listed.addition(point.setup, &everywhere) else { continue };
        let found = match listed.way {
            Way::Step => step(point, addition),
            _ => store(point, addition),
        };
        if let Some((addition, gain)) = found {
            let cost = per_number * addition.numbers.len() as f64;
            all.push(named(listed, listed.id.to_string(), addition, &gain, cost));
        }
    }
    all
}

/// Candidate of the list, with its estimated size.
fn named(listed: &Listed, name: String, addition: Addition, gain: &Gain, cost: f64) -> Scored {
    let found = scored(name, listed.port, listed.follows, gain, cost, &[0.0]);
    Scored { addition: Some(addition), listed: true, ..found }
}

/// Step change: its time is tried on a grid over all runs, then at every row near the best.
fn step(point: &Linearization, mut addition: Addition) -> Option<(Addition, Gain)> {
    let clock = |r: usize, row: usize| point.setup.drives[point.runs[r]].time[row];
    let best = |times: Vec<f64>| -> Vec<(f64, Gain)> {
        let part = |times: &[f64]| -> Vec<(f64, Gain)> {
            let after = |at: f64, r: usize, row: usize| if clock(r, row) >= at { -1.0 } else { 0.0 };
            let columns =
                point.port_columns(addition.port, times.len(), |k, r, row, _| after(times[k], r, row));
            let gains = columns.map_or_else(Vec::new, |columns| point.evidence.gains(&columns));
            let known = times.iter().zip(gains).filter_map(|(at, gain)| Some((*at, gain?)));
            known.filter(|(_, gain)| within(gain.size[0], addition.numbers[0].limits)).collect()
        };
        let mut gains: Vec<(f64, Gain)> = times.par_chunks(TOGETHER).flat_map_iter(part).collect();
        gains.sort_by(|a, b| b.1.whitened.total_cmp(&a.1.whitened));
        gains
    };
    let every = |run: &usize| {
        let time = &point.setup.drives[*run].time;
        time.iter().step_by(time.len().div_ceil(TIMES)).copied().collect::<Vec<f64>>()
    };
    let coarse = best(point.runs.iter().flat_map(every).collect());
    let about = coarse.first()?.0;
    let near = |run: &usize| {
        let time = &point.setup.drives[*run].time;
        let reach = (time[time.len() - 1] - time[0]) / TIMES as f64;
        time.iter().filter(|t| (*t - about).abs() <= reach).copied().collect::<Vec<f64>>()
    };
    let mut fine = best(point.runs.iter().flat_map(near).collect());
    let likely: Vec<f64> = fine
        .iter()
        .filter(|(_, g)| fine[0].1.whitened - g.whitened < SURE * SURE)
        .map(|(at, _)| *at)
        .collect();
    let (at, gain) = if fine.is_empty() { coarse.into_iter().next()? } else { fine.swap_remove(0) };
    addition.numbers[0].value = gain.size[0];
    addition.numbers[1].value = at;
    // Half the range of likely times, at least one row: interval of a time, for which there is no derivative.
    let (least, most) = likely.iter().fold((at, at), |(a, b), t| (a.min(*t), b.max(*t)));
    let row =
        point.setup.drives[point.runs[0]].time.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    addition.numbers[1].scale = 0.25 * (most - least) + 0.5 * row;
    Some((addition, gain))
}

/// Effect with a heat capacity of its own: trial sizes; for the response to each, the size to first order.
fn store(point: &Linearization, addition: Addition) -> Option<(Addition, Gain)> {
    let declaration = point.setup.bench.declaration();
    let of = |name: &str| {
        let declared = point.setup.declared.iter().position(|d| d.name == name);
        declared.map_or_else(
            || declaration.by_name(name).map(|e| point.setup.bench.start_of(e.slot)),
            |k| Some(point.fitted.hypothesis.declared[k]),
        )
    };
    let trials: Vec<Vec<f64>> = match addition.numbers.len() {
        1 => LAGS.iter().map(|tau| vec![*tau]).collect(),
        _ => {
            // Fractions of the capacity and resistance on either side of the new node.
            let (capacity, resistance) = (of("thermal.C_h")?, of("thermal.R_wh")?);
            NODES.iter().map(|(c, r)| vec![c * capacity, r * resistance]).collect()
        }
    };
    let tried: Vec<(Addition, Gain)> = trials
        .par_iter()
        .filter_map(|values| {
            let mut trial = addition.clone();
            trial.numbers.iter_mut().zip(values).for_each(|(n, v)| n.value = *v);
            let gain = point.evidence.gain(&point.simulated_column(&trial)?)?;
            // The estimated size is relative to the trial.
            (gain.size[0] > LEAST_TRIAL).then_some((trial, gain))
        })
        .collect();
    tried.into_iter().max_by(|a, b| a.1.whitened.total_cmp(&b.1.whitened))
}

fn scored(name: String, port: Port, follows: Follows, gain: &Gain, cost: f64, x: &[f64]) -> Scored {
    let shape =
        x.iter().enumerate().map(|(k, x)| (*x, gain.size[k], gain.covariance[(k, k)].sqrt())).collect();
    Scored {
        addition: None,
        name,
        port,
        follows,
        listed: false,
        evidence: gain.whitened - cost,
        raw: gain.raw - cost,
        shape,
    }
}

fn smooth(point: &Linearization, port: Port, driver: Driver, per_number: f64) -> Option<Scored> {
    let knots = knots(point, driver)?;
    let hidden = point.hidden(Some(driver));
    let value = |k: usize, d: &Drivers| if hidden(d) { 0.0 } else { hat(&knots, k, d.of(driver)) };
    let columns = point.port_columns(port, knots.len(), |k, _, _, d| value(k, d))?;
    let gain = point.evidence.shape(&columns, &alike(&knots))?;
    let name = format!("{} over {}", port.name(), driver.name());
    let follows = Follows::Driver(driver);
    let mut found = scored(name, port, follows, &gain, 2.0 * per_number + choice(port, follows), &knots);
    let number = |(k, x): (usize, &f64)| Number {
        symbol: format!("value at {} = {x:.4}", driver.name()),
        value: gain.size[k],
        limits: (f64::NEG_INFINITY, f64::INFINITY),
        unit: port.unit().name(),
        scale: gain.covariance[(k, k)].sqrt(),
        sloped: true,
    };
    let numbers: Vec<Number> = knots.iter().enumerate().map(number).collect();
    // A law over time in these runs does not carry over to other runs, so it cannot be added.
    found.addition = (driver != Driver::Time).then(|| Addition {
        id: "generic_term".to_string(),
        port,
        follows: Follows::Driver(driver),
        numbers,
        shape: table(driver, knots, &gain),
        active: vec![true; point.setup.experiment.runs.len()],
        late: None,
    });
    Some(found)
}

fn powers(point: &Linearization, port: Port, driver: Driver, per_number: f64) -> Option<Scored> {
    knots(point, driver)?;
    let factor = scale(point, driver);
    let hidden = point.hidden(Some(driver));
    let value = |k: usize, d: &Drivers| {
        if hidden(d) { 0.0 } else { power(&factor, d.of(driver), EXPONENTS[k]) }
    };
    let columns = point.port_columns(port, EXPONENTS.len(), |k, _, _, d| value(k, d))?;
    let gains = EXPONENTS.into_iter().zip(point.evidence.gains(&columns));
    // A drag or a voltage drop with negative coefficient would be a source and is not physical.
    let is_physical =
        |gain: &Gain| !matches!(port, Port::DragTorque | Port::TerminalVoltage) || gain.size[0] > 0.0;
    let physical = gains.filter_map(|(exponent, gain)| Some((exponent, gain.filter(is_physical)?)));
    let (exponent, gain) = physical.max_by(|a, b| a.1.whitened.total_cmp(&b.1.whitened))?;
    let name = format!("{} ~ {}^{exponent}", port.name(), driver.name());
    let follows = Follows::Driver(driver);
    let mut found = scored(name, port, follows, &gain, 2.0 * per_number + choice(port, follows), &[0.0]);
    let number = |symbol: &str, value: f64, limits: (f64, f64), unit: &'static str, scale: f64| Number {
        symbol: symbol.to_string(),
        value,
        limits,
        unit,
        scale,
        sloped: true,
    };
    let spread = gain.covariance[(0, 0)].sqrt();
    found.addition = Some(Addition {
        id: "generic_term".to_string(),
        port,
        follows: Follows::Driver(driver),
        shape: Shape::Power { factor: Factor { exponent, ..factor } },
        numbers: vec![
            number(
                "coefficient",
                gain.size[0],
                (f64::NEG_INFINITY, f64::INFINITY),
                port.unit().name(),
                spread,
            ),
            number("exponent", exponent, EXPONENT_LIMITS, "1", EXPONENT_SCALE),
        ],
        active: vec![true; point.setup.experiment.runs.len()],
        late: None,
    });
    Some(found)
}
