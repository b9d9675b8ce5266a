//! Axial fan: characteristic curve, jet, power.
//!
//! curve, affinity and stall: `correlations/fan_curve.rs`; jet: `correlations/jet.rs`
//! P = n^3 rho/rho_ref P_rated                                                              (1)
//!
//! *Assumes* speed proportional to the command; all electrical power is given to the air flow.
//! *Neglects* the run-up time of the fan, heat from its bearings.
//! *Sign*: a positive flow leaves the fan. *Range*: n from 0 to 1.
//! *Source*: Aavid PSAD14010BH, data sheet in the thesis (`seeds`, appendix 4): 0.28 m3/min, 7.24 mm H2O, 1.2 W,
//! 14.4 g. The curve between its end points is unknown (a straight line is the default); bore and hub of a
//! 40 x 40 x 10 mm fan are typical values; reference density of data sheets: 1.2 kg/m3.

use crate::correlations::fan_curve::{CurveError, FanCurve, Shape, Stall};
use crate::correlations::jet::{FanJet, TAN_SPREAD_ROUND_JET};
use declare::{Unit, Variable, variables};

variables! {
    /// Data of the fan.
    pub struct Fan {
        /// Free volume flow rate at full speed
        flow_max: f64 = Variable::tunable(0, 0.28 / 60.0, Unit::CubicMetrePerSecond, 1e-6, 10.0).log()
            .source("datasheet Aavid PSAD14010BH: 0.28 m3/min"),
        /// Static pressure without flow at full speed
        pressure_max: f64 = Variable::tunable(1, 71.0, Unit::Pascal, 1e-2, 1e5).log()
            .source("datasheet Aavid PSAD14010BH: 7.24 mm of water"),
        /// Electrical power at full speed
        power: f64 = Variable::tunable(2, 1.2, Unit::Watt, 0.0, 1e4)
            .source("datasheet Aavid PSAD14010BH"),
        /// Mass of the fan
        mass: f64 = Variable::tunable(3, 0.0144, Unit::Kilogram, 0.0, 100.0)
            .source("thesis, table 1"),
        /// Diameter of the fan's opening
        bore: f64 = Variable::tunable(4, 0.038, Unit::Metre, 1e-3, 2.0).log()
            .source("estimate: typical of 40 x 40 x 10 mm fans"),
        /// Diameter of the fan's hub
        hub: f64 = Variable::tunable(5, 0.024, Unit::Metre, 0.0, 2.0)
            .source("estimate: typical of 40 x 40 x 10 mm fans"),
        /// Distance from the fan to the motor's surface (cooling_mode fan_crossflow)
        distance: f64 = Variable::tunable(6, 0.005, Unit::Metre, 0.0, 10.0)
            .source("thesis, table 1: smallest distance"),
        /// Tangent of the jet's half-angle of spread
        tan_spread: f64 = Variable::tunable(7, TAN_SPREAD_ROUND_JET, Unit::One, 0.0, 2.0)
            .source("Pope, Turbulent Flows, table 5.1: round jet"),
        /// Factor on the forced heat transfer in the jet for its turbulence
        turbulence_factor: f64 = Variable::tunable(8, 1.0, Unit::One, 0.1, 10.0).log()
            .source("neutral"),
        /// Fraction of the pressure lost in the middle of the stall; 0 for none
        stall_depth: f64 = Variable::tunable(9, 0.0, Unit::One, 0.0, 0.95),
        /// Flow rate at the centre of the stall region, divided by flow_max
        stall_centre: f64 = Variable::tunable(10, 0.4, Unit::One, 0.0, 1.0)
            .source("estimate; without effect while stall_depth is 0"),
        /// Half-width of the stall region, divided by flow_max
        stall_width: f64 = Variable::tunable(11, 0.1, Unit::One, 1e-3, 1.0)
            .source("estimate; without effect while stall_depth is 0"),
        /// Air density at which the fan's data hold
        density_ref: f64 = Variable::tunable(12, 1.2, Unit::KilogramPerCubicMetre, 0.1, 10.0)
            .source("usual density of fan datasheets"),
        /// Exponent of the jet's decay with its cross section: 0.5 conserves momentum, 1 volume flow (swirl)
        decay: f64 = Variable::tunable(13, 0.5, Unit::One, 0.5, 1.0)
            .source("momentum of a free jet"),
        /// Pressure divided by pressure_max at 20 % of flow_max
        p_20: f64 = Variable::tunable(20, 0.8, Unit::One, 0.0, 1.0)
            .source("assumption: straight fan curve"),
        /// Pressure divided by pressure_max at 40 % of flow_max
        p_40: f64 = Variable::tunable(21, 0.6, Unit::One, 0.0, 1.0)
            .source("assumption: straight fan curve"),
        /// Pressure divided by pressure_max at 60 % of flow_max
        p_60: f64 = Variable::tunable(22, 0.4, Unit::One, 0.0, 1.0)
            .source("assumption: straight fan curve"),
        /// Pressure divided by pressure_max at 80 % of flow_max
        p_80: f64 = Variable::tunable(23, 0.2, Unit::One, 0.0, 1.0)
            .source("assumption: straight fan curve"),
    }
}

/// Points of a fan's table: both ends and four between them.
const POINTS: usize = 6;

/// A fan's curve with its points in absolute values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    flow: [f64; POINTS],
    pressure: [f64; POINTS],
    stall: Option<Stall>,
}

impl Table {
    /// The curve, if it is falling.
    pub fn curve(&self) -> Result<FanCurve<'_>, CurveError> {
        FanCurve::new(Shape::Table { flow: &self.flow, pressure: &self.pressure }, self.stall)
    }
}

impl Fan {
    /// The points of the curve.
    pub fn table(&self) -> Table {
        let share = [1.0, self.p_20, self.p_40, self.p_60, self.p_80, 0.0];
        let stall = Stall { depth: self.stall_depth, centre: self.stall_centre, width: self.stall_width };
        Table {
            flow: std::array::from_fn(|k| self.flow_max * k as f64 / (POINTS - 1) as f64),
            pressure: share.map(|s| self.pressure_max * s),
            stall: (self.stall_depth > 0.0).then_some(stall),
        }
    }

    /// The fan as the source of a jet.
    pub fn jet(&self) -> FanJet {
        FanJet { bore: self.bore, hub: self.hub, tan_spread: self.tan_spread, decay: self.decay }
    }

    /// Area of the opening, m2.
    pub fn opening(&self) -> f64 {
        std::f64::consts::FRAC_PI_4 * self.bore * self.bore
    }

    /// Power given to air of the density `rho` at the speed ratio `n`, eq. (1), W.
    pub fn power_at(&self, n: f64, rho: f64) -> f64 {
        n * n * n * rho / self.density_ref * self.power
    }

    /// Why the data do not fit together, in one sentence.
    pub fn fault(&self) -> Option<String> {
        if self.hub >= self.bore {
            return Some(format!(
                "fan.hub = {} m must be smaller than fan.bore = {} m.",
                self.hub, self.bore
            ));
        }
        self.table().curve().err().map(|e| {
            format!(
                "fan.p_20, fan.p_40, fan.p_60, fan.p_80 = {}, {}, {}, {}: {e}.",
                self.p_20, self.p_40, self.p_60, self.p_80
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_curve_is_the_line_between_its_ends() {
        let table = Fan::default().table();
        let curve = table.curve().unwrap();
        for q in [0.0, 0.001, 0.0027, 0.004] {
            let line = 71.0 * (1.0 - q / (0.28 / 60.0));
            assert!((curve.pressure(q, 1.0, 1.0) - line).abs() < 1e-9);
        }
    }

    #[test]
    fn a_curve_that_does_not_fall_is_named() {
        let fan = Fan { p_40: 0.9, ..Fan::default() };
        let sentence = fan.fault().unwrap();
        assert!(sentence.contains("fan.p_40") && sentence.contains("must fall"), "{sentence}");
        assert!(Fan { hub: 0.04, ..Fan::default() }.fault().unwrap().contains("fan.hub = 0.04"));
        assert_eq!(Fan::default().fault(), None);
    }

    #[test]
    fn half_the_speed_is_an_eighth_of_the_power() {
        assert_eq!(Fan::default().power_at(0.5, 1.2), 0.15);
    }
}
