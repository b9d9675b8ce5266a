//! Terms found in data that no effect of the list covers: evaluation of `terms.rs` at the motor's ports.
//!
//! With y the sum of `gain` times the values of the terms at a port:
//!
//! | port | effect of y | drivers evaluated within a step |
//! |---|---|---|
//! | drag_torque | y tanh(w / w_small), N.m: y > 0 brakes in both directions and heats the nodes that friction heats | all |
//! | terminal_voltage | y tanh(I / 0.05 A), V: y > 0 is a loss for both signs of I and heats the winding | all |
//! | series_voltage | y, V, against a positive I for both signs of I: a thermoelectric voltage, the zero of an amplifier; y I heats the winding | all |
//! | winding_resistance, torque_constant | multiplied by 1 + y | all |
//! | winding_housing_resistance | multiplied by 1 + y | winding_temperature |
//! | winding_heat | y, W, heats the winding; part of the energy input, as heat_power (gearmotor: taken from ambient) | |
//! | housing_heat | y, W, heats the housing; taken from ambient (heat_to_ambient is reduced by y) | housing_temperature |
//! | housing_ambient_conductance | y (T_h - T_a), W, leaves the housing (gearmotor: T_a is the temperature of the box) | housing_temperature |
//! | heat_capacity | capacities of winding and housing (network: winding and stator) times 1 + y; the energy balance starts there | |
//! | fan_flow | the command multiplied by 1 + y, at least 0 | fan_command |
//! | ambient_sensor | the true ambient temperature is y, K, above the indicated one | |
//! | winding_sensor, housing_sensor | the reading is y, K, too high | |
//! | torque_sensor | the indicated torque is y, N.m, too high | |
//!
//! All: current and speed follow these ports within milliseconds, and would otherwise belong to drivers half a step earlier. A lag is
//! linear over the step there.
//! *Assumes* that the other drivers are constant over a step, at their mean; such a term is of second order in the step, and of first
//! order where it acts on its own driver and this driver changes within the step (winding_heat as a function of winding_temperature).
//! A step in which a term changes by more than a small part of its span is divided. The energy balance closes with it. The state of a
//! lag is integrated with its driver a parabola over the step: second order.
//! *Sign*: see the table. *Range*: a factor 1 + y is at least 0.05.
//! *Source*: the data in which the terms were found.

use super::prelude::*;
use crate::terms::{GenericTerm, Lag, MOST_TERMS};

/// Current below which a voltage drop changes sign smoothly, A.
const I_SMALL: f64 = 0.05;
/// Smallest factor on a parameter of the motor.
const LEAST_FACTOR: f64 = 0.05;

variables! {
    /// What of the terms can be tuned.
    pub struct Tuning {
        /// Factor on all terms of resources/effects.json; 0 switches them off
        gain: f64 = Variable::tunable(0, 1.0, Unit::One, -10.0, 10.0)
            .source("neutral: terms as stored"),
        /// Speed below which the drag of a term changes sign smoothly
        w_small: f64 = Variable::tunable(1, 1.0, Unit::RadianPerSecond, 1e-3, 1e3).log()
            .source("regularisation width, chosen"),
    }
}

/// The terms of a motor, with their latest drivers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GenericTerms {
    tuning: Tuning,
    terms: [Option<GenericTerm>; MOST_TERMS],
    drivers: Drivers,
}

parameters_of!(GenericTerms: tuning: Tuning);

impl GenericTerms {
    /// The sum at a port, with `x` for the driver that is evaluated within a step. Not inlined, so that a motor without terms only
    /// checks whether there are any.
    #[inline(never)]
    fn along<D: Number>(&self, port: Port, x: D) -> D {
        let all = self.terms.iter().flatten().enumerate();
        let live = Some((port.live().unwrap_or(Driver::Speed), x));
        let here = all.filter(|(_, term)| term.port == port);
        here.fold(D::from(0.0), |sum, (k, term)| sum + term.along_as(k, &self.drivers, live))
            * self.tuning.gain
    }

    /// The sum at a port.
    #[inline(always)]
    fn sum(&self, port: Port) -> f64 {
        self.along(port, self.drivers.of(port.live().unwrap_or(Driver::Speed)))
    }

    /// The sum at a fast port with these drivers and `x` in place of the driver `live`.
    #[inline(never)]
    fn driven<D: Number>(&self, port: Port, x: D, live: Driver, drivers: &Drivers) -> D {
        let here = self.terms.iter().flatten().enumerate().filter(|(_, term)| term.port == port);
        here.fold(D::from(0.0), |sum, (k, term)| sum + term.along_as(k, drivers, Some((live, x))))
            * self.tuning.gain
    }

    /// The terms that act in the motor, with their number: those that change a reading only hold nothing over a step.
    fn acting(&self) -> impl Iterator<Item = (usize, &GenericTerm)> {
        self.terms.iter().flatten().enumerate().filter(|(_, term)| !term.port.is_reading())
    }

    fn factor<D: Number>(sum: D) -> D {
        if sum.re() < LEAST_FACTOR - 1.0 { D::from(LEAST_FACTOR) } else { sum + 1.0 }
    }
}

impl Effect for GenericTerms {
    // Laws that no effect covers are found by other methods (calibrate).
    const CANDIDATES: &'static [Candidate] = &[];
    const EXAMPLE: &'static [f64] = &[];

    #[inline]
    fn is_on(&self) -> bool {
        self.terms[0].is_some() && self.tuning.gain != 0.0
    }

    fn take_terms(&mut self, terms: &[GenericTerm]) -> bool {
        let fit = terms.len() <= MOST_TERMS && terms.iter().all(GenericTerm::is_whole);
        if fit {
            self.terms = std::array::from_fn(|k| terms.get(k).copied());
        }
        fit
    }

    #[inline]
    fn set_drivers(&mut self, drivers: &Drivers) -> bool {
        self.drivers = *drivers;
        let cooling =
            |term: &GenericTerm| matches!(term.port, Port::FanFlow | Port::HousingAmbientConductance);
        self.terms.iter().flatten().any(cooling)
    }

    fn holds(&self, driver: Driver) -> bool {
        let held = |term: &GenericTerm| {
            !term.port.is_fast() && term.port.live() != Some(driver) && term.follows(driver)
        };
        let lagged = |term: &GenericTerm| term.lag.is_some_and(|lag| lag.driver == driver);
        self.is_on() && self.acting().any(|(_, term)| held(term) || lagged(term))
    }

    /// Sum of the rises and falls of a term that acts in the motor, over quarters of the way.
    fn change(&self, from: &Drivers, to: &Drivers) -> f64 {
        let of_term = |(k, term): (usize, &GenericTerm)| {
            // What is evaluated within a step does not count.
            let live = term.port.live();
            let is_held = |driver: Driver| Some(driver) != live && from.of(driver) != to.of(driver);
            if term.lag.is_none() && !term.law.drivers().any(is_held) {
                return 0.0;
            }
            let live = live.map(|driver| (driver, from.middle(to).of(driver)));
            let y: [f64; 5] =
                std::array::from_fn(|n| term.along_as(k, &from.toward(to, 0.25 * n as f64), live));
            let change: f64 = y.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
            if change > 0.0 { change / term.law.span() } else { 0.0 }
        };
        self.acting().map(of_term).fold(0.0, f64::max)
    }

    #[inline]
    fn lag(&self, k: usize) -> Option<Lag> {
        self.terms[k].and_then(|term| term.lag)
    }

    #[inline]
    fn driven_drag<D: Number>(&self, x: D, live: Driver, drivers: &Drivers) -> D {
        let w = if live == Driver::Speed { x } else { D::from(drivers.speed) };
        self.driven(Port::DragTorque, x, live, drivers) * smooth_sign(w, self.tuning.w_small)
    }

    #[inline]
    fn driven_voltage<D: Number>(&self, x: D, live: Driver, drivers: &Drivers) -> D {
        let i = if live == Driver::Current { x } else { D::from(drivers.current) };
        self.driven(Port::TerminalVoltage, x, live, drivers) * smooth_sign(i, I_SMALL)
    }

    #[inline]
    fn series_voltage<D: Number>(&self, x: D, live: Driver, drivers: &Drivers) -> D {
        self.driven(Port::SeriesVoltage, x, live, drivers)
    }

    #[inline]
    fn winding_resistance<D: Number>(&self, x: D, live: Driver, drivers: &Drivers) -> D {
        Self::factor(self.driven(Port::WindingResistance, x, live, drivers))
    }

    #[inline]
    fn driven_torque_constant<D: Number>(&self, x: D, live: Driver, drivers: &Drivers) -> D {
        Self::factor(self.driven(Port::TorqueConstant, x, live, drivers))
    }

    #[inline]
    fn winding_heat(&self) -> f64 {
        self.sum(Port::WindingHeat)
    }

    #[inline]
    fn winding_housing_resistance<D: Number>(&self, t_w: D) -> D {
        Self::factor(self.along(Port::WindingHousingResistance, t_w))
    }

    #[inline]
    fn housing_to_ambient<D: Number>(&self, t_h: D, t_a: f64) -> D {
        self.along(Port::HousingAmbientConductance, t_h) * (t_h - t_a)
    }

    #[inline]
    fn housing_heat<D: Number>(&self, t_h: D) -> D {
        self.along(Port::HousingHeat, t_h)
    }

    #[inline]
    fn heat_capacity(&self) -> f64 {
        Self::factor(self.sum(Port::HeatCapacity))
    }

    #[inline]
    fn fan_flow(&self, n: f64) -> f64 {
        n * (1.0 + self.along(Port::FanFlow, n)).max(0.0)
    }

    #[inline]
    fn ambient_offset(&self) -> f64 {
        self.sum(Port::AmbientSensor)
    }

    #[inline]
    fn winding_sensor(&self, t: f64, _t_a: f64) -> f64 {
        t + self.sum(Port::WindingSensor)
    }

    #[inline]
    fn housing_sensor(&self, t: f64, _t_a: f64) -> f64 {
        t + self.sum(Port::HousingSensor)
    }

    #[inline]
    fn torque_sensor(&self, tau: f64) -> f64 {
        tau + self.sum(Port::TorqueSensor)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::slope_is_derivative;
    use super::*;
    use crate::terms::{Factor, Law, Product, Table};
    use declare::Group;

    fn carrying(port: Port, coefficient: f64, driver: Driver, reference: f64, exponent: f64) -> GenericTerms {
        let factor = Factor { driver, offset: 0.0, reference, exponent, range: Factor::UNLIMITED };
        let law = Law::Product(Product { coefficient, factors: [Some(factor), None, None] });
        let mut terms = GenericTerms::default();
        assert!(terms.take_terms(&[GenericTerm::new(port, law)]));
        terms
    }

    /// The value at `x` of a driver, the others zero.
    fn at(x: f64, live: Driver) -> (f64, Driver, Drivers) {
        (x, live, Drivers::default().with(live, x))
    }

    /// 5 mN.m at 100 rad/s, 10 mN.m at 1600 rad/s (exponent 1/4), against the motion in both directions.
    #[test]
    fn a_drag_brakes_either_way() {
        let terms = carrying(Port::DragTorque, 5e-3, Driver::Speed, 100.0, 0.25);
        let drag = |w: f64| {
            let (w, live, drivers) = at(w, Driver::Speed);
            terms.driven_drag(w, live, &drivers)
        };
        assert!((drag(1600.0) - 10e-3).abs() < 1e-15);
        assert!((drag(-1600.0) + 10e-3).abs() < 1e-15);
        assert_eq!(drag(0.0), 0.0);
        let none = Drivers::default();
        let port = |w| terms.driven_drag(w, Driver::Speed, &none);
        slope_is_derivative(port, &[-900.0, -0.7, 0.3, 50.0], 1e-5, 1e-8);
        assert_eq!(super::super::slope(0.0, port), 0.0);
    }

    /// Each port of current and speed has its derivative with respect to any driver.
    #[test]
    fn volts_and_conductances_have_their_slopes() {
        let volts = carrying(Port::TerminalVoltage, 0.3, Driver::Current, 2.0, 1.5);
        let none = Drivers::default();
        assert!((volts.driven_voltage(-2.0f64, Driver::Current, &none) + 0.3).abs() < 1e-15);
        let port = |i| volts.driven_voltage(i, Driver::Current, &none);
        slope_is_derivative(port, &[-3.0, -0.02, 0.04, 5.0], 1e-6, 1e-6);
        let source = carrying(Port::SeriesVoltage, 0.3, Driver::Current, 2.0, 1.5);
        let series = |i: f64| source.series_voltage(i, Driver::Current, &none);
        assert_eq!([series(-2.0), series(2.0)], [0.3; 2], "the same for both signs");
        slope_is_derivative(
            |i| source.series_voltage(i, Driver::Current, &none),
            &[-3.0, -0.02, 0.04, 5.0],
            1e-6,
            1e-6,
        );
        let ohms = carrying(Port::WindingResistance, 0.3, Driver::Speed, 200.0, 1.5);
        slope_is_derivative(|w| ohms.winding_resistance(w, Driver::Speed, &none), &[-3e2, 5e2], 1e-3, 1e-8);
        let strength = carrying(Port::TorqueConstant, -0.02, Driver::Current, 2.0, 2.0);
        let port = |i| strength.driven_torque_constant(i, Driver::Current, &none);
        slope_is_derivative(port, &[-3.0, 5.0], 1e-4, 1e-8);
        let drag = carrying(Port::DragTorque, 5e-3, Driver::Current, 2.0, 1.0);
        let turning = Drivers { speed: -50.0, ..none };
        let port = |i| drag.driven_drag(i, Driver::Current, &turning);
        slope_is_derivative(port, &[-3.0, 5.0], 1e-4, 1e-8);
        let leak = carrying(Port::HousingAmbientConductance, 0.1, Driver::HousingTemperature, 300.0, 2.0);
        assert!((leak.housing_to_ambient(300.0f64, 280.0) - 2.0).abs() < 1e-13);
        slope_is_derivative(|t| leak.housing_to_ambient(t, 280.0), &[250.0, 340.0], 1e-2, 1e-8);
        let heat = carrying(Port::HousingHeat, 3.0, Driver::FanCommand, 1.0, 0.0);
        assert_eq!(heat.housing_heat(300.0f64), 3.0);
    }

    #[test]
    fn factors_are_relative_and_stay_positive() {
        let change = |port: Port, y: f64| carrying(port, y, Driver::Speed, 1.0, 0.0);
        let (x, live, drivers) = at(1.0, Driver::Speed);
        let strength = |y: f64| change(Port::TorqueConstant, y).driven_torque_constant(x, live, &drivers);
        assert_eq!(change(Port::WindingResistance, 0.25).winding_resistance(x, live, &drivers), 1.25);
        assert_eq!((strength(-0.5), strength(-2.0)), (0.5, LEAST_FACTOR));
        assert_eq!(change(Port::WindingHousingResistance, 0.5).winding_housing_resistance(300.0f64), 1.5);
        assert_eq!(change(Port::HeatCapacity, 1.0).heat_capacity(), 2.0);
        assert_eq!(change(Port::FanFlow, -0.5).fan_flow(0.5), 0.25);
        assert_eq!(change(Port::FanFlow, -3.0).fan_flow(0.5), 0.0);
    }

    /// Film coefficients are expensive; they are evaluated again only for terms that may change them.
    #[test]
    fn the_air_hears_of_those_that_meet_it() {
        for port in [Port::FanFlow, Port::HousingAmbientConductance, Port::DragTorque, Port::HousingHeat] {
            let told = carrying(port, 0.1, Driver::Speed, 1.0, 1.0).set_drivers(&Drivers::default());
            assert_eq!(told, matches!(port, Port::FanFlow | Port::HousingAmbientConductance), "{port:?}");
        }
    }

    /// A step is divided for a driver that it holds, and not for the one that is evaluated within it.
    #[test]
    fn only_drivers_that_a_step_holds_divide_it() {
        let [slow, fast] = [100.0, 400.0].map(|speed| Drivers { speed, ..Drivers::default() });
        let over_speed = |port: Port| carrying(port, 2.0, Driver::Speed, 100.0, 1.0);
        assert_eq!(over_speed(Port::DragTorque).change(&slow, &fast), 0.0);
        let heat = over_speed(Port::WindingHeat);
        assert_eq!(heat.change(&slow, &slow), 0.0);
        // A power rises by its reference value, 2, for each reference of the driver.
        assert!(heat.change(&slow, &fast) > 2.0, "{}", heat.change(&slow, &fast));
        let later = Drivers { time: 5.0, ..slow };
        assert_eq!(heat.change(&slow, &later), 0.0);
    }

    #[test]
    fn the_gain_multiplies_all_and_zero_is_off() {
        let mut heat = carrying(Port::WindingHeat, 4.0, Driver::Current, 5.0, 2.0);
        heat.set_drivers(&Drivers { current: 10.0, ..Drivers::default() });
        assert_eq!((heat.is_on(), heat.winding_heat()), (true, 16.0));
        assert!(heat.set(0, 0.5));
        assert_eq!(heat.winding_heat(), 8.0);
        assert!(heat.set(0, 0.0));
        assert_eq!((heat.is_on(), heat.winding_heat()), (false, 0.0));
        assert!(!GenericTerms::default().is_on(), "no terms");
    }

    /// Terms at one port are added; those at other ports have no influence; a fourth term is rejected and changes nothing.
    #[test]
    fn up_to_three_terms_add_up() {
        let table = |port: Port, y: f64| {
            let table = Table::new(Driver::Time, &[0.0, 1.0], &[y, y]);
            GenericTerm::new(port, Law::Table(table.unwrap_or_else(|| unreachable!())))
        };
        let three =
            [table(Port::WindingHeat, 1.0), table(Port::WindingSensor, 7.0), table(Port::WindingHeat, 2.0)];
        let mut terms = GenericTerms::default();
        assert!(terms.take_terms(&three));
        assert_eq!((terms.winding_heat(), terms.winding_sensor(300.0, 290.0)), (3.0, 307.0));
        assert_eq!((terms.housing_sensor(300.0, 290.0), terms.ambient_offset()), (300.0, 0.0));
        assert_eq!(terms.torque_sensor(0.05), 0.05);
        assert!(!terms.take_terms(&[three[0]; 4]));
        assert_eq!(terms.winding_heat(), 3.0);
    }
}
