//! Preferences between candidates that explain about the same: which of them is tested first, and which is accepted.

use super::{AHEAD, ALIKE, Candidate};
use crate::hypothesis::Addition;
use crate::levels::{NEARLY, STRUCTURE};
use crate::linearization::Linearization;
use crate::outcome::Follows;
use crate::search::temperatures;
use physics::terms::{Driver, Port};

/// Of two unlisted laws that explain the data equally well, the more probable comes first: an effect in the motor is more probable than a
/// sensor error that depends on the motor, an effect at a node depends on the temperature of that node, and a driver that is measured is
/// preferred to a heat flow that the model computes from it.
pub fn order_by_likelihood(candidates: &[Candidate], order: &mut Vec<usize>, near: f64) {
    let unnamed = |k: &usize| !candidates[*k].addition().is_listed();
    for strange in ODDITIES {
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

/// Reasons for which a law is less probable before any data.
const ODDITIES: [fn(&Addition) -> bool; 3] = [is_at_a_sensor, follows_another_node, follows_a_heat];

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

/// Of the laws that explain nearly as much as the `k`-th candidate, and of its parts, the one that the validation runs prefer: the evidence of
/// the fit runs cannot separate them, because the errors of the model are not noise.
pub fn best_predicting(point: &Linearization, candidates: &mut [Candidate], k: usize, near: f64) -> usize {
    if let Some(law) = law_ahead(point, candidates, k) {
        return best_predicting(point, candidates, law, near);
    }
    if candidates[k].addition().is_listed() {
        return k;
    }
    let (sure, parts) = (candidates[k].sure(), parts(candidates[k].addition()));
    let mut best = k;
    for other in 0..candidates.len() {
        let own = &candidates[other];
        let is_rival = !own.addition().is_listed()
            && own.refused.is_none()
            && (own.sure() > NEARLY * sure || is_part(own.addition(), candidates[k].addition()))
            && self::parts(own.addition()) <= parts;
        if other == k || !is_rival || !candidates[other].judge(point) {
            continue;
        }
        let [own, known] = [other, best].map(|k| &candidates[k]).map(Rival::of);
        if own.is_better(&known, near) {
            best = other;
        }
    }
    best
}

/// A law that explains about as much as another one.
struct Rival<'a> {
    addition: &'a Addition,
    sure: f64,
    /// Ratio of validation errors with and without it.
    foretold: f64,
}

impl Rival<'_> {
    fn of<'a>(candidate: &'a Candidate) -> Rival<'a> {
        let foretold = candidate.validation.unwrap_or(1.0);
        Rival { addition: candidate.addition(), sure: candidate.sure(), foretold }
    }

    /// Whether the validation runs prefer it to another one: the same law in a form that predicts better (a power law has fewer numbers, so a
    /// table has to be clearly better), a plainer law at the same port that predicts as well, a law at the same port that explains as
    /// much (up to `near`) and predicts better (by more than structure error if it is less probable), or any law that predicts far better.
    fn is_better(&self, other: &Rival, near: f64) -> bool {
        let (a, b) = (self.addition, other.addition);
        if self.foretold < AHEAD * other.foretold {
            return true;
        }
        if a.port != b.port {
            return false;
        }
        let worth = |own: &Rival| own.foretold * if own.addition.is_table() { 1.0 + STRUCTURE } else { 1.0 };
        if a.follows == b.follows {
            return worth(self) < worth(other);
        }
        let (mine, its) = ((parts(a), oddity(a)), (parts(b), oddity(b)));
        let is_plainer = mine < its;
        let odd = if mine.1 > its.1 { 1.0 + STRUCTURE } else { 1.0 };
        (is_plainer && self.foretold < other.foretold * (1.0 + STRUCTURE))
            || (mine.0 == its.0
                && (self.sure - other.sure).abs() < near
                && odd * self.foretold < other.foretold)
    }
}

/// Whether a law of one driver is a part of a law of two. The second driver is a further addition, which has to lower the validation error as
/// any other: it may explain the fit runs by what differs between them.
pub fn is_part(own: &Addition, whole: &Addition) -> bool {
    matches!(whole.follows, Follows::Both(..))
        && matches!(own.follows, Follows::Driver(driver) if whole.follows.drivers().any(|d| d == driver))
        && own.port == whole.port
}

/// Number of parts of a law: drivers, and a lag.
fn parts(addition: &Addition) -> usize {
    match addition.follows {
        Follows::Both(..) | Follows::Late(_) => 2,
        _ => 1,
    }
}

/// Number of [`ODDITIES`] of a law.
fn oddity(addition: &Addition) -> usize {
    ODDITIES.iter().filter(|is_odd| is_odd(addition)).count()
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

/// A law at another port over another driver that cannot be told apart from a listed effect, and is not less probable by itself: the weaker
/// statement is made.
pub fn law_elsewhere(point: &Linearization, candidates: &mut [Candidate], k: usize) -> Option<usize> {
    let own = &candidates[k];
    let (port, follows, sure) = (own.addition().port, own.addition().follows, own.sure());
    if !own.addition().is_listed() {
        return None;
    }
    let is_rival = |c: &Candidate| {
        let addition = c.addition();
        !addition.is_listed()
            && addition.port != port
            && addition.follows != follows
            && oddity(addition) == 0
            && c.refused.is_none()
            && c.sure() > sure - ALIKE
    };
    let law = candidates.iter().position(is_rival)?;
    candidates[law].judge(point).then_some(law)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::law;

    /// Laws with validation errors of these ratios: whether the first one is taken instead of the second.
    fn wins(first: (Port, Follows, f64), second: (Port, Follows, f64), apart: f64) -> bool {
        let (a, b) = (law(first.0, first.1), law(second.0, second.1));
        let first = Rival { addition: &a, sure: 500.0 - apart, foretold: first.2 };
        first.is_better(&Rival { addition: &b, sure: 500.0, foretold: second.2 }, 10.0)
    }

    #[test]
    fn the_validation_runs_decide_between_laws_that_explain_as_much() {
        use Driver::{Current, FrictionLoss, HousingTemperature, Speed, WindingTemperature};
        use Port::{HeatCapacity, TerminalVoltage, WindingResistance, WindingSensor};
        let of = Follows::Driver;
        let both = Follows::Both(HousingTemperature, Current);
        // Another port only if it predicts far better.
        let voltage = (TerminalVoltage, both, 0.52);
        assert!(wins((WindingResistance, of(WindingTemperature), 0.27), voltage, 40.0));
        assert!(!wins((WindingResistance, of(WindingTemperature), 0.40), voltage, 40.0));
        // One driver instead of two, its own node instead of the other one, a measured driver instead of a computed heat: as good is enough.
        let two = (HeatCapacity, Follows::Both(HousingTemperature, Speed), 0.18);
        assert!(wins((HeatCapacity, of(HousingTemperature), 0.183), two, 40.0));
        assert!(!wins((HeatCapacity, of(HousingTemperature), 0.19), two, 40.0));
        let winding = (WindingResistance, of(WindingTemperature), 0.5);
        let housing = (WindingResistance, of(HousingTemperature), 0.5);
        assert!(wins(winding, housing, 40.0) && !wins(housing, winding, 0.0));
        let [heat, speed] = [FrictionLoss, Speed].map(|driver| (WindingSensor, Follows::Late(driver), 0.35));
        assert!(wins(speed, heat, 40.0) && !wins(heat, speed, 0.0));
        let better = |foretold: f64| (WindingSensor, heat.1, foretold);
        assert!(wins(better(0.30), speed, 0.0) && !wins(better(0.349), speed, 0.0));
        // Equally plain: the evidence decides unless it is about the same.
        let lower = (HeatCapacity, Follows::Both(HousingTemperature, Current), 0.17);
        assert!(wins(lower, two, 5.0) && !wins(lower, two, 40.0));
        let [single, pair] = [of(Speed), two.1].map(|follows| law(HeatCapacity, follows));
        assert!(
            is_part(&single, &pair)
                && !is_part(&pair, &pair)
                && !is_part(&law(HeatCapacity, of(Current)), &pair)
        );
    }
}
