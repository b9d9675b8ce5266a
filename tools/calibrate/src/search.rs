//! Candidates for the missing effect, ranked by evidence: effects of the list, and latent inputs at every port.
//!
//! | candidate | parameters |
//! |---|---|
//! | an effect of the list, in all runs or in some | size |
//! | at every port a smooth function of every driver | as many as the evidence supports, [`Evidence::shape`](crate::evidence) |
//! | at every port a power law of every driver | coefficient, exponent |
//! | at the ports selected by latent inputs a smooth function of two drivers | as many as the evidence supports |
//! | at every port a latent input (unconstrained in time) | as many as the evidence supports |
//! | at the same ports: laws over a first-order lag of a driver or of a heat flow | as for a power or a shape, time constant
//! |
//! | at winding and housing: a mass that is attached there | conductance, time constant |
//! | at the same ports as a lag: latching, hysteresis switching, intermittent action | size and threshold, width or period |
//!
//! Candidates are compared by the reduction of the evidence's cost minus ln n for each parameter (BIC, Schwarz), n the number of blocks.

mod hidden;
mod lag_starts;
mod laws;
mod memory_terms;
mod structure;
#[cfg(test)]
mod tests;

use crate::catalogue::{LISTED, Listed, Way};
use crate::evidence::Gain;
use crate::hypothesis::{Addition, Shape, place, values};
use crate::levels::{NEARLY, SURE};
use crate::linearization::Linearization;
use crate::outcome::Follows;
use crate::parallel;
use crate::selection::NEAR;
use laws::{acts, of_two, powers, smooth, varies};
pub use laws::{alike, kernel, spread, table, table_values};
use memory_terms::{FREE, histories, latent_inputs};
pub use memory_terms::{best_memory_term, latent_input, latent_input_at, needs_memory};
use physics::terms::{Driver, Port};
use std::collections::HashSet;
pub use structure::structure;

/// Times per run at which a step change is tried. Numerical: every row near the best one follows.
const TIMES: usize = 60;
/// Number of times for which the gains are computed together. Numerical: a block of columns that fits into the cache.
const TOGETHER: usize = 32;
/// Number of best shapes for which power laws are tried. Numerical: a power law is also a smooth shape, so those of further shapes
/// explain less.
const LIKELY: usize = 16;
/// Number of quantities for which further laws are tried: those whose latent inputs explain most. Numerical: a limit of effort.
const QUANTITIES: usize = 4;
/// Time constants of a sensor, s, that are tried. Numerical: starts of a fit.
const LAGS: [f64; 3] = [10.0, 30.0, 90.0];
/// Capacity and resistance of a new node that are tried, as fractions of those of housing and winding. Numerical: starts of a fit.
const NODES: [(f64, f64); 4] = [(0.15, 0.5), (0.15, 1.5), (0.4, 0.5), (0.4, 1.5)];
/// Least size of an effect relative to its trial. Numerical: for a smaller one the trial is no linearization.
const LEAST_TRIAL: f64 = 0.1;

/// In the name of an effect that does not act in all runs, before their files. Definition: of the name.
pub const IN_SOME_RUNS: &str = " in some runs";

/// What the names of variants of one effect in different runs have in common.
pub fn variants(name: &str) -> &str {
    name.split_once(" (").map_or(name, |(common, _)| common)
}

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

    /// Whether its shape decreases with its driver overall, of two drivers with the temperature; for a power law, whether its coefficient is
    /// negative.
    fn falls(&self) -> bool {
        let points: Vec<(f64, f64)> = match self.addition.as_ref().map(|a| (&a.shape, &a.numbers)) {
            Some((Shape::Table { axes, .. }, numbers)) if axes.len() > 1 => {
                let at = |k: usize| {
                    let (axis, own) = place(axes, k).find(|(axis, _)| is_inside(axis.driver))?;
                    Some((axis.knots[own], numbers[k].value))
                };
                (0..values(axes)).filter_map(at).collect()
            }
            _ => self.shape.iter().map(|(x, value, _)| (*x, *value)).collect(),
        };
        let middle = points.iter().map(|(x, _)| x).sum::<f64>() / points.len() as f64;
        match points[..] {
            [(_, coefficient)] => coefficient < 0.0,
            _ => points.iter().map(|(x, value)| (x - middle) * value).sum::<f64>() < 0.0,
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
    let drivers = Driver::ALL.iter().filter(|d| !d.is_heat()).count();
    let laws = if matches!(follows, Follows::Both(..)) { drivers * (drivers - 1) / 2 } else { drivers };
    let equal = 2.0 * ((Port::ALL.len() * laws) as f64).ln();
    equal + if bypasses_the_air(port, follows) { NEAR } else { 0.0 }
}

/// Whether the fan or the ambient temperature acts inside the motor by a law.
pub fn bypasses_the_air(port: Port, follows: Follows) -> bool {
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
    !is_outside && follows.drivers().any(|driver| of_the_air.contains(&driver))
}

/// The temperature of the node at which a port acts, and that of the other node.
pub fn temperatures(port: Port) -> Option<(Driver, Driver)> {
    let (winding, housing) = (Driver::WindingTemperature, Driver::HousingTemperature);
    match port {
        Port::HousingHeat | Port::HousingAmbientConductance | Port::HeatCapacity | Port::HousingSensor => {
            Some((housing, winding))
        }
        Port::WindingHeat | Port::WindingResistance | Port::WindingSensor => Some((winding, housing)),
        _ => None,
    }
}

/// All candidates at a point, in order of decreasing evidence.
pub fn search(point: &Linearization) -> Vec<Scored> {
    let per_number = point.per_number();
    let mut all = listed(point, per_number);
    let drivers: Vec<Driver> = Driver::ALL
        .iter()
        .copied()
        // A term can depend on a heat flow only through a lag.
        .filter(|driver| !driver.is_heat() && varies(point, *driver))
        .collect();
    let jobs: Vec<(Port, Driver)> =
        Port::ALL.iter().flat_map(|p| drivers.iter().map(move |d| (*p, *d))).collect();
    let jobs: Vec<_> = jobs.into_iter().filter(|(port, driver)| acts(point, *port, *driver)).collect();
    let shape_of =
        |(port, driver): &(Port, Driver)| Some((*port, *driver, smooth(point, *port, *driver, per_number)?));
    let mut shapes = parallel::flat_map(&jobs, shape_of);
    shapes.sort_by(|a, b| b.2.evidence.total_cmp(&a.2.evidence));
    // A power law is also a smooth shape: if no shape explains much, no power law does.
    let likely = &shapes[..shapes.len().min(LIKELY)];
    let powers_of = |(port, driver, _): &(Port, Driver, Scored)| {
        if *driver == Driver::Time { None } else { powers(point, *port, *driver, per_number) }
    };
    all.extend(parallel::flat_map(likely, powers_of));
    let mut free = parallel::flat_map(Port::ALL, |port| latent_inputs(point, *port, per_number));
    free.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let ports = most_likely(&free);
    all.extend(of_two(point, &ports, &shapes, per_number));
    let shapes: Vec<Scored> = shapes.into_iter().map(|(_, _, shape)| shape).collect();
    all.extend(hidden::lagging(point, &ports, &shapes, per_number));
    all.extend(shapes);
    all.extend(hidden::masses(point, per_number));
    all.extend(parallel::flat_map(&ports, |port| histories(point, *port, per_number)));
    all.extend(free);
    leave_to_the_air(&mut all);
    all.sort_by(|a, b| b.sure().total_cmp(&a.sure()));
    all
}

/// The ports of the first few quantities of these latent inputs.
fn most_likely(free: &[Scored]) -> Vec<Port> {
    let mut quantities: Vec<&str> = free.iter().map(|s| s.port.quantity()).collect();
    let mut known = HashSet::new();
    quantities.retain(|one| known.insert(*one));
    quantities.truncate(QUANTITIES);
    free.iter().map(|s| s.port).filter(|port| quantities.contains(&port.quantity())).collect()
}

/// A heat at the housing that decreases with its temperature is a heat loss: if a conductance to ambient over the same drivers explains
/// nearly as much, the conductance is preferred.
fn leave_to_the_air(all: &mut Vec<Scored>) {
    // Present values of one or two drivers, one of them a temperature of the motor.
    let law = |s: &Scored, port: Port| {
        let is_present = matches!(s.follows, Follows::Driver(_) | Follows::Both(..));
        s.port == port && !s.listed && is_present && s.follows.drivers().any(is_inside)
    };
    let same = |a: Follows, b: Follows| {
        a.drivers().count() == b.drivers().count() && a.drivers().all(|own| b.drivers().any(|d| d == own))
    };
    let air = all.iter().filter(|s| law(s, Port::HousingAmbientConductance));
    let air: Vec<_> = air.map(|s| (s.follows, s.shape.len(), s.sure())).collect();
    let as_well = |s: &Scored| {
        air.iter().any(|(follows, length, sure)| {
            same(*follows, s.follows) && *length == s.shape.len() && *sure > NEARLY * s.sure()
        })
    };
    all.retain(|s| !(law(s, Port::HousingHeat) && s.falls() && as_well(s)));
}

/// Whether a driver is the temperature of a node of the motor.
fn is_inside(driver: Driver) -> bool {
    matches!(driver, Driver::HousingTemperature | Driver::WindingTemperature)
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
    let effects: Vec<_> = point.listed().collect();
    let of = |effect: usize| -> Vec<Scored> {
        let (first, forms) = effects[effect];
        let (listed, _) = &forms[0];
        let patterns: Vec<Vec<bool>> = if listed.may_vary && runs <= 6 {
            (1..1usize << runs).map(|bits| (0..runs).map(|r| bits >> r & 1 == 1).collect()).collect()
        } else {
            vec![vec![true; runs]]
        };
        let everywhere = patterns.len();
        let with = |pattern: &[bool], k: usize| {
            let addition = &forms[k].1;
            let gain = point.evidence.gain(&point.listed_column(first + k, pattern)?)?;
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
                point.runs.iter().zip(pattern).for_each(|(run, on)| addition.active[*run] = *on);
            }
            // Penalty for the choice of runs: 2 ln of the number of choices.
            let choice = if partly { 2.0 * (everywhere as f64).ln() } else { 0.0 };
            let mut files: Vec<&str> = (point.runs.iter().zip(pattern))
                .filter(|(_, on)| **on)
                .map(|(run, _)| point.setup.experiment.runs[*run].file.as_str())
                .collect();
            files.dedup();
            let name = match partly {
                true => format!("{}{IN_SOME_RUNS} ({})", listed.id, files.join(", ")),
                false => listed.id.to_string(),
            };
            let cost = per_number * addition.numbers.len() as f64 + choice;
            Some(named(listed, name, addition, &gain, cost))
        };
        let best = |pattern: &Vec<bool>| {
            let all = (0..forms.len()).filter_map(|k| with(pattern, k));
            all.max_by(|a, b| a.sure().total_cmp(&b.sure()))
        };
        patterns.iter().filter_map(best).collect()
    };
    let mut all: Vec<Scored> = parallel::indices(effects.len(), of).into_iter().flatten().collect();
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
    let best = |times: Vec<f64>| -> Vec<(f64, Gain)> {
        let part = |times: &[f64]| -> Vec<(f64, Gain)> {
            let columns = point.step_columns(addition.port, times);
            let gains = columns.map_or_else(Vec::new, |columns| point.evidence.gains(&columns, 1));
            let known = times.iter().zip(gains).filter_map(|(at, gain)| Some((*at, gain?)));
            known.filter(|(_, gain)| within(gain.size[0], addition.numbers[0].limits)).collect()
        };
        let parts: Vec<&[f64]> = times.chunks(TOGETHER).collect();
        let mut gains = parallel::flat_map(&parts, |times| part(times));
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
    let tried = parallel::flat_map(&trials, |values| {
        let mut trial = addition.clone();
        trial.numbers.iter_mut().zip(values).for_each(|(n, v)| n.value = *v);
        let gain = point.evidence.gain(&point.simulated_column(&trial)?)?;
        // The estimated size is relative to the trial.
        (gain.size[0] > LEAST_TRIAL).then_some((trial, gain))
    });
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
