//! Preferences between candidates that explain about the same: which of them is tested first, and which is accepted.

use super::{AHEAD, Candidate};
use crate::hypothesis::Addition;
use crate::levels::{LEAD, NEARLY, STRUCTURE};
use crate::linearization::Linearization;
use crate::outcome::Follows;
use crate::search::temperatures;
use physics::terms::{Driver, Port};

/// Of two unlisted laws that explain the data equally well, the more probable comes first: an effect in the motor is more probable than a
/// sensor error that depends on the motor, an effect at a node depends on the temperature of that node, and a driver that is measured is
/// preferred to a heat flow that the model computes from it.
pub fn order_by_likelihood(candidates: &[Candidate], order: &mut Vec<usize>, near: f64) {
    let unnamed = |k: &usize| !candidates[*k].addition().is_listed();
    for strange in [is_at_a_sensor as fn(&Addition) -> bool, follows_another_node, follows_a_heat] {
        let Some(first) = order.iter().position(unnamed) else { return };
        let best = &candidates[order[first]];
        if !strange(best.addition()) {
            continue;
        }
        let as_well = |k: &usize| {
            let other = &candidates[*k];
            unnamed(k)
                && !strange(other.addition())
                && (is_sensor(best.addition().port) || other.addition().port == best.addition().port)
                && best.sure() - other.sure() < near
        };
        if let Some(other) = order.iter().position(as_well) {
            let other = order.remove(other);
            order.insert(first, other);
        }
    }
}

fn is_at_a_sensor(addition: &Addition) -> bool {
    is_sensor(addition.port)
}

fn follows_another_node(addition: &Addition) -> bool {
    let of_other = |(_, other): (Driver, Driver)| addition.follows == Follows::Driver(other);
    temperatures(addition.port).is_some_and(of_other)
}

fn follows_a_heat(addition: &Addition) -> bool {
    matches!(addition.follows, Follows::Late(driver) if driver.is_heat())
}

pub fn is_sensor(port: Port) -> bool {
    matches!(port, Port::AmbientSensor | Port::WindingSensor | Port::HousingSensor | Port::TorqueSensor)
}

/// Among laws with the port and driver of the `k`-th candidate, the one with the smallest validation error. A power law has fewer numbers: a
/// table has to be clearly better.
pub fn best_predicting(point: &Linearization, candidates: &mut [Candidate], k: usize) -> usize {
    let place = |c: &Candidate| (c.addition().port, c.addition().follows);
    if let Some(law) = law_ahead(point, candidates, k) {
        return best_predicting(point, candidates, law);
    }
    if candidates[k].addition().is_listed() {
        return k;
    }
    let worth = |c: &Candidate| {
        c.validation.unwrap_or(1.0) * if c.addition().is_table() { 1.0 + STRUCTURE } else { 1.0 }
    };
    let mut best = k;
    for other in 0..candidates.len() {
        let apart = candidates[k].sure() - candidates[other].sure();
        let near = apart.abs() <= LEAD.max(STRUCTURE * candidates[k].sure().abs());
        let same = place(&candidates[other]) == place(&candidates[k]);
        let own = &candidates[other];
        if other == k || !same || !near || own.refused.is_some() || own.addition().is_listed() {
            continue;
        }
        if candidates[other].judge(point) && worth(&candidates[other]) < worth(&candidates[best]) {
            best = other;
        }
    }
    best
}

/// A listed effect at the port of a law that is accepted: it explains nearly as much (or as much up to `near`), and is predicted as well up to
/// structure error, even if its own validation error is not below that without it by more than structure error.
pub fn listed_instead(
    point: &Linearization,
    candidates: &mut [Candidate],
    k: usize,
    near: f64,
) -> Option<usize> {
    let law = &candidates[k];
    let (port, foretold) = (law.addition().port, law.validation?);
    let least = law.sure() - near.max((1.0 - NEARLY) * law.sure());
    if law.addition().is_listed() {
        return None;
    }
    candidates.iter_mut().position(|c| {
        let is_equal = c.addition().is_listed() && c.addition().port == port && c.sure() > least;
        if is_equal && c.validation.is_none() && c.refused.is_none() {
            c.judge(point);
        }
        let predicts = c.validation.is_some_and(|own| own < foretold * (1.0 + STRUCTURE));
        is_equal && predicts && (c.is_hardly_better || c.refused.is_none())
    })
}

/// A listed effect is preferred to a law that explains little more, and a law of one driver to one of two, unless the other law, at the same
/// port, also has a far smaller validation error.
fn law_ahead(point: &Linearization, candidates: &mut [Candidate], k: usize) -> Option<usize> {
    let own = &candidates[k];
    let (port, sure, foretold) = (own.addition().port, own.sure(), own.validation?);
    let drivers = |c: &Candidate| match c.addition().follows {
        _ if c.addition().is_listed() => 0,
        Follows::Both(..) => 2,
        _ => 1,
    };
    let explains_more = |c: &Candidate| {
        c.refused.is_none() && drivers(c) > drivers(own) && c.addition().port == port && c.sure() > sure
    };
    let law = candidates.iter().position(explains_more)?;
    let ahead = candidates[law].judge(point) && candidates[law].validation? < AHEAD * foretold;
    ahead.then_some(law)
}
