//! Preferences between candidates that explain about the same: which of them is tested first, and which is accepted.

use super::{ALIKE, Candidate, NEAR, asked};
use crate::hypothesis::Addition;
use crate::outcome::Follows;
use crate::search::{bypasses_the_air, temperatures};
use physics::terms::{Driver, Port};
use std::mem::discriminant;

/// Of candidates that explain as much as a law, that which predicts the validation runs best comes first, if it predicts them better
/// beyond doubt: their density does not depend on how many shapes could be fitted to the other runs. A listed effect has one shape.
///
/// *Source*: Geisser, Eddy, J. Am. Stat. Assoc. 74 (1979) 153-160.
pub fn best_prediction_first(candidates: &[Candidate], order: &mut [usize]) {
    let Some(best) = order.first().map(|k| &candidates[*k]) else { return };
    if best.addition().is_listed() {
        return;
    }
    let alike = order.iter().take_while(|k| best.sure() - candidates[**k].sure() < ALIKE).count();
    let predicts = |k: &usize| density(&candidates[order[*k]]);
    let first = (0..alike).max_by(|a, b| predicts(a).total_cmp(&predicts(b)));
    if let Some(first) = first.filter(|k| predicts(k) > density(best) + NEAR) {
        precede(order, first, 0);
    }
}

/// A law of two drivers gives way to the best candidate of at most one driver, at any port, that leaves less than an effect of what the
/// law explains, and does not predict the validation runs worse: the second driver is a further addition.
pub fn one_driver_first(candidates: &[Candidate], order: &mut [usize]) {
    let Some(best) = order.first().map(|k| &candidates[*k]) else { return };
    if !matches!(best.addition().follows, Follows::Both(..)) {
        return;
    }
    let is_enough = |k: &usize| {
        let own = &candidates[*k];
        let left = best.sure() - own.sure();
        own.is_simple() && density(own) > density(best) - NEAR && left < asked(&own.point, &best.point)
    };
    if let Some(first) = order.iter().position(is_enough) {
        precede(order, first, 0);
    }
}

/// A law that comes first gives way to a listed effect that explains as much and predicts the validation runs no worse: what it was preferred
/// to may have explained more than the listed effect does.
pub fn listed_first(candidates: &[Candidate], order: &mut [usize]) {
    let Some(best) = order.first().map(|k| &candidates[*k]).filter(|c| !c.addition().is_listed()) else {
        return;
    };
    let is_instead = |k: &usize| {
        let own = &candidates[*k];
        own.addition().is_listed() && is_as_good(own, best)
    };
    if let Some(first) = order.iter().position(is_instead) {
        precede(order, first, 0);
    }
}

/// Whether a candidate cannot be distinguished from a better one, by all runs and by the validation runs.
pub fn is_as_good(own: &Candidate, best: &Candidate) -> bool {
    own.sure() > best.sure() - ALIKE && density(own) > density(best) - ALIKE
}

/// Moves the `k`-th of an order before the one at `place`, which is not behind it.
fn precede(order: &mut [usize], k: usize, place: usize) {
    order[place..=k].rotate_right(1);
}

/// Decrease of -2 ln p of the validation runs.
fn density(candidate: &Candidate) -> f64 {
    candidate.delta_validation.unwrap_or(0.0)
}

/// Of two unlisted laws that explain the data equally well, the more probable comes first: an effect in the motor is more probable than a
/// sensor error that depends on the motor, the fan cools the housing and does not heat the winding, an effect at a node depends on the
/// temperature of that node, friction follows the load that a bearing or a gear carries rather than the current, and a driver that is measured is
/// preferred to a heat flow that the model computes from it.
pub fn order_by_likelihood(candidates: &[Candidate], order: &mut [usize]) {
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
                && may_replace(other.addition(), best.addition())
                && best.sure() - other.sure() < ALIKE
        };
        if let Some(other) = order.iter().position(as_well) {
            precede(order, other, first);
        }
    }
}

/// Whether a law at a port may be the usual form of an odd one.
fn may_replace(other: &Addition, odd: &Addition) -> bool {
    let port = other.port;
    let is_in_the_air = matches!(port, Port::HousingAmbientConductance | Port::FanFlow);
    if is_friction_by_current(odd) {
        // The same law, over the load.
        let is_alike = discriminant(&other.follows) == discriminant(&odd.follows);
        return port == odd.port
            && is_alike
            && other.follows.drivers().any(|driver| driver == Driver::LoadTorque);
    }
    port == odd.port || is_sensor(odd.port) || (acts_past_the_air(odd) && is_in_the_air)
}

/// Reasons for which a law is less probable before any data.
const ODDITIES: [fn(&Addition) -> bool; 5] =
    [is_at_a_sensor, acts_past_the_air, follows_another_node, is_friction_by_current, follows_a_heat];

fn is_friction_by_current(addition: &Addition) -> bool {
    addition.port == Port::DragTorque && addition.follows.drivers().any(|driver| driver == Driver::Current)
}

fn acts_past_the_air(addition: &Addition) -> bool {
    bypasses_the_air(addition.port, addition.follows)
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

/// Whether a law of one driver is a part of a law of two. The second driver is a further addition, which has to lower the validation error as
/// any other: it may explain the fit runs by what differs between them.
pub fn is_part(own: &Addition, whole: &Addition) -> bool {
    matches!(whole.follows, Follows::Both(..))
        && matches!(own.follows, Follows::Driver(driver) if whole.follows.drivers().any(|d| d == driver))
        && own.port == whole.port
}

/// Whether a physical element may be a part of a law at its port: a listed effect of a law of two drivers that has its driver, one without a
/// driver of every law, a mass of a law over a lag of its temperature.
pub fn is_element_of(own: &Addition, law: &Addition) -> bool {
    let is_constant = own.follows == Follows::Nothing && own.port == law.port;
    let is_mass = matches!((own.follows, law.follows), (Follows::Mass(a), Follows::Late(b)) if a == b);
    (own.is_listed() && !law.is_listed() && (is_constant || is_part(own, law)))
        || (is_mass && own.port == law.port)
}

/// Number of [`ODDITIES`] of a law.
fn oddity(addition: &Addition) -> usize {
    ODDITIES.iter().filter(|is_odd| is_odd(addition)).count()
}

/// A law at another port over another driver that cannot be distinguished from the `k`-th candidate, a listed effect: the law is the weaker
/// statement. Of several the first one that passes the acceptance tests, `judge`. A law that a listed effect stands for is none: the two
/// effects are then a class, which says as little, with names.
pub fn law_elsewhere<'a>(
    candidates: &mut [Candidate<'a>],
    k: usize,
    judge: impl Fn(&mut Candidate<'a>) -> bool,
) -> Option<usize> {
    let is_named = |law: &Candidate| {
        let place = |c: &Candidate| (c.addition().port, c.addition().follows);
        let is_name =
            |c: &Candidate| c.refused.is_none() && c.addition().is_listed() && place(c) == place(law);
        candidates.iter().any(|c| is_name(c) && is_as_good(c, law))
    };
    let is_law = |c: &Candidate| c.refused.is_none() && states_less(c, &candidates[k]) && !is_named(c);
    let laws: Vec<usize> = (0..candidates.len()).filter(|law| is_law(&candidates[*law])).collect();
    laws.into_iter().find(|law| judge(&mut candidates[*law]))
}

/// Whether a law of at most one present driver explains as much as a listed effect elsewhere, and is not less probable by itself.
fn states_less(law: &Candidate, own: &Candidate) -> bool {
    let (a, b) = (law.addition(), own.addition());
    let shares_a_driver = a.follows.drivers().any(|driver| b.follows.drivers().any(|own| own == driver));
    let is_elsewhere = a.port != b.port && !shares_a_driver;
    let is_usual = law.is_simple() && oddity(a) == 0;
    is_elsewhere && b.is_listed() && !a.is_listed() && is_usual && law.sure() > own.sure() - ALIKE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::Setup;
    use crate::testing::{self, candidate, law};

    #[test]
    fn a_law_of_one_driver_is_a_part_of_one_of_two() {
        use Driver::{Current, HousingTemperature, Speed};
        let of = |follows: Follows| law(Port::HeatCapacity, follows);
        let (single, pair) = (of(Follows::Driver(Speed)), of(Follows::Both(HousingTemperature, Speed)));
        assert!(is_part(&single, &pair) && !is_part(&pair, &pair));
        assert!(!is_part(&of(Follows::Driver(Current)), &pair));
        assert!(!is_part(&law(Port::WindingHeat, single.follows), &pair));
    }

    #[test]
    fn a_law_elsewhere_states_less_than_a_name() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let of = |addition, sure| candidate(&setup, addition, sure);
        let named = of(testing::addition(&setup, "windage", 1e-8), 200.0);
        let heat = |follows, sure| of(law(Port::WindingHeat, follows), sure);
        let over = |driver, sure| heat(Follows::Driver(driver), sure);
        assert!(states_less(&over(Driver::Current, 160.0), &named));
        // It explains less; it has the same driver, also beside another one; it is odd; it is at the same port.
        assert!(!states_less(&over(Driver::Current, 150.0), &named));
        assert!(!states_less(&over(Driver::Speed, 250.0), &named));
        assert!(!states_less(&heat(Follows::Both(Driver::Current, Driver::Speed), 250.0), &named));
        assert!(!states_less(&heat(Follows::Late(Driver::CopperLoss), 250.0), &named));
        // An additional state is no weaker statement.
        assert!(!states_less(&heat(Follows::Late(Driver::Current), 160.0), &named));
        assert!(!states_less(&of(law(Port::DragTorque, Follows::Driver(Driver::Current)), 250.0), &named));
        assert!(!states_less(&named, &over(Driver::Current, 160.0)));
    }

    /// Of friction over the current or the load that explains about the same, that over the load comes first; a law of two drivers says more.
    #[test]
    fn friction_follows_the_load() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let drag = |follows, sure| candidate(&setup, law(Port::DragTorque, follows), sure);
        let load = Follows::Driver(Driver::LoadTorque);
        let both = Follows::Both(Driver::LoadTorque, Driver::Speed);
        for (other, sure, is_first) in [
            (load, 190.0, true),
            (load, 200.0 - ALIKE, false),
            (both, 199.0, false),
            (Follows::Late(Driver::LoadTorque), 199.0, false),
        ] {
            let all = [drag(Follows::Driver(Driver::Current), 200.0), drag(other, sure)];
            let mut order = vec![0, 1];
            order_by_likelihood(&all, &mut order);
            assert_eq!(order[0] == 1, is_first, "{other:?} {sure}");
        }
    }

    /// A law that is refused says nothing of the next one.
    #[test]
    fn every_law_elsewhere_is_tested() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let heat = |sure| candidate(&setup, law(Port::WindingHeat, Follows::Driver(Driver::Current)), sure);
        let named = candidate(&setup, testing::addition(&setup, "windage", 1e-8), 200.0);
        let mut all = [heat(230.0), heat(220.0), named, heat(190.0), heat(200.0 - ALIKE)];
        let below = |most: f64| move |c: &mut Candidate| c.sure() < most;
        assert_eq!(law_elsewhere(&mut all, 2, below(1e3)), Some(0));
        assert_eq!(law_elsewhere(&mut all, 2, below(225.0)), Some(1));
        assert_eq!(law_elsewhere(&mut all, 2, below(195.0)), Some(3));
        assert_eq!(law_elsewhere(&mut all, 2, below(190.0)), None);
    }

    /// A conductance by the speed has a name, unless that explains less.
    #[test]
    fn a_law_with_a_name_is_no_weaker_statement() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let law = law(Port::HousingAmbientConductance, Follows::Driver(Driver::Speed));
        let named = |id: &str, sure| candidate(&setup, testing::addition(&setup, id, 0.01), sure);
        for (other, is_law) in [(230.0, false), (230.0 - ALIKE, true)] {
            let mut all = [
                candidate(&setup, law.clone(), 230.0),
                named("speed_convection", other),
                named("lubricant_friction", 250.0),
            ];
            assert_eq!(law_elsewhere(&mut all, 2, |_| true), is_law.then_some(0));
        }
    }

    #[test]
    fn of_equal_candidates_the_best_prediction_comes_first() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let of = |sure, density| {
            let mut own = candidate(&setup, law(Port::WindingHeat, Follows::Driver(Driver::Speed)), sure);
            own.delta_validation = density;
            own
        };
        let ordered = |all: &[Candidate]| {
            let mut order: Vec<usize> = (0..all.len()).collect();
            best_prediction_first(all, &mut order);
            order
        };
        // The last one explains less.
        let apart = 400.0 - 1.5 * ALIKE;
        let all = |density| {
            [of(400.0, Some(50.0)), of(399.0, Some(40.0)), of(398.0, density), of(apart, Some(900.0))]
        };
        assert_eq!(ordered(&all(Some(51.0 + NEAR))), [2, 0, 1, 3]);
        // A difference that means nothing; no validation runs.
        assert_eq!(ordered(&all(Some(49.0 + NEAR))), [0, 1, 2, 3]);
        assert_eq!(ordered(&[of(400.0, None), of(399.0, None)]), [0, 1]);
        assert!(ordered(&[]).is_empty());
        // A listed effect that explains most stays where it is.
        let listed = candidate(&setup, testing::addition(&setup, "windage", 1e-8), 401.0);
        assert_eq!(ordered(&[listed, of(400.0, Some(900.0))]), [0, 1]);
    }

    #[test]
    fn a_preferred_law_gives_way_to_a_listed_effect_that_is_as_good() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let both = Follows::Both(Driver::FanCommand, Driver::HousingTemperature);
        let of = |addition, sure, density| {
            let mut own = candidate(&setup, addition, sure);
            own.delta_validation = Some(density);
            own
        };
        let conductance =
            |follows, sure, density| of(law(Port::HousingAmbientConductance, follows), sure, density);
        let ordered = |sure, density| {
            let all = [
                conductance(both, 797.0, 213.0),
                of(testing::addition(&setup, "fan_back_pressure", 0.1), sure, density),
                conductance(Follows::Driver(Driver::FanCommand), 718.0, 194.0),
            ];
            // The law of one driver was preferred.
            let mut order = vec![2, 0, 1];
            listed_first(&all, &mut order);
            order
        };
        assert_eq!(ordered(727.0, 193.0), [1, 2, 0]);
        // It explains less, or predicts worse.
        assert_eq!(ordered(718.0 - ALIKE, 193.0), [2, 0, 1]);
        assert_eq!(ordered(727.0, 194.0 - ALIKE), [2, 0, 1]);
        listed_first(&[], &mut []);
    }

    /// The fan acts through the air: a heat that follows it gives way to a conductance to the air that explains as much, at any node.
    #[test]
    fn a_heat_by_the_fan_gives_way_to_a_conductance() {
        use Driver::{AmbientTemperature, Current, FanCommand, HousingTemperature, WindingTemperature};
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let of = |port, follows, sure| candidate(&setup, law(port, follows), sure);
        let ordered = |all: &[Candidate]| {
            let mut order: Vec<usize> = (0..all.len()).collect();
            order_by_likelihood(all, &mut order);
            order[0]
        };
        let air =
            |sure| of(Port::HousingAmbientConductance, Follows::Both(FanCommand, HousingTemperature), sure);
        let winding = of(Port::WindingHeat, Follows::Both(WindingTemperature, FanCommand), 500.0);
        assert_eq!(ordered(&[winding, air(470.0)]), 1);
        let ambient = |sure| of(Port::HousingHeat, Follows::Driver(AmbientTemperature), sure);
        assert_eq!(ordered(&[ambient(500.0), of(Port::FanFlow, Follows::Driver(FanCommand), 460.0)]), 1);
        // It explains less; a heat by the current; a conductance inside the motor.
        assert_eq!(ordered(&[ambient(500.0), air(500.0 - 1.1 * ALIKE)]), 0);
        assert_eq!(ordered(&[of(Port::WindingHeat, Follows::Driver(Current), 500.0), air(490.0)]), 0);
        let inside = of(Port::WindingHousingResistance, Follows::Driver(HousingTemperature), 490.0);
        assert_eq!(ordered(&[ambient(500.0), inside]), 0);
    }

    #[test]
    fn a_law_of_two_drivers_gives_way_to_one_of_one() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let of = |port, follows, sure, density| {
            let mut own = candidate(&setup, law(port, follows), sure);
            own.delta_validation = Some(density);
            own
        };
        let both =
            |sure| of(Port::AmbientSensor, Follows::Both(Driver::FanCommand, Driver::Speed), sure, 90.0);
        let one = |sure, density| of(Port::FanFlow, Follows::Driver(Driver::FanCommand), sure, density);
        let ordered = |all: &[Candidate]| {
            let mut order: Vec<usize> = (0..all.len()).collect();
            one_driver_first(all, &mut order);
            order
        };
        assert_eq!(ordered(&[both(480.0), both(470.0), one(400.0, 88.0)]), [2, 0, 1]);
        // It explains less by an effect; it predicts worse; nothing gives way to it.
        assert_eq!(ordered(&[both(520.0), one(400.0, 88.0)]), [0, 1]);
        assert_eq!(ordered(&[both(480.0), one(400.0, 80.0)]), [0, 1]);
        assert_eq!(ordered(&[one(480.0, 0.0), one(470.0, 88.0)]), [0, 1]);
    }

    #[test]
    fn listed_effects_may_be_parts_of_laws() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let windage = testing::addition(&setup, "windage", 1e-8);
        let both = |port| law(port, Follows::Both(Driver::HousingTemperature, Driver::Speed));
        assert!(is_element_of(&windage, &both(Port::DragTorque)));
        assert!(!is_element_of(&windage, &both(Port::HousingHeat)));
        // A law of its driver alone is another form of the same effect, and no second one.
        let single = law(Port::DragTorque, Follows::Driver(Driver::Speed));
        assert!(!is_element_of(&windage, &single) && !is_element_of(&single, &both(Port::DragTorque)));
        let offset = testing::addition(&setup, "winding_sensor_offset", 1.0);
        assert!(is_element_of(&offset, &law(Port::WindingSensor, Follows::Driver(Driver::Current))));
    }

    #[test]
    fn a_mass_may_be_a_part_of_a_law_over_the_lag_of_its_temperature() {
        use Driver::{HousingTemperature, WindingTemperature};
        let of = |port: Port, follows: Follows| law(port, follows);
        let mass = of(Port::HousingHeat, Follows::Mass(HousingTemperature));
        let late = |port, driver| of(port, Follows::Late(driver));
        assert!(mass.is_element() && is_element_of(&mass, &late(Port::HousingHeat, HousingTemperature)));
        assert!(!is_element_of(&mass, &late(Port::HousingHeat, WindingTemperature)));
        assert!(!is_element_of(&mass, &late(Port::HousingAmbientConductance, HousingTemperature)));
        assert!(!is_element_of(&mass, &of(Port::HousingHeat, Follows::Driver(HousingTemperature))));
        assert!(!is_element_of(&mass, &mass));
    }

    /// A law that is less probable before any data: at a sensor, over the temperature of the other node, over a heat that the model computes.
    #[test]
    fn odd_laws_are_known() {
        let odd = |port, follows| oddity(&law(port, follows));
        assert_eq!(odd(Port::WindingHeat, Follows::Driver(Driver::WindingTemperature)), 0);
        assert_eq!(odd(Port::WindingHeat, Follows::Driver(Driver::HousingTemperature)), 1);
        assert_eq!(odd(Port::WindingHeat, Follows::Late(Driver::CopperLoss)), 1);
        assert_eq!(odd(Port::WindingSensor, Follows::Driver(Driver::Speed)), 1);
        assert_eq!(odd(Port::WindingSensor, Follows::Late(Driver::FrictionLoss)), 2);
    }
}
