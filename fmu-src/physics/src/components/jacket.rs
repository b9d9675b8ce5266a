//! Water jacket: parallel channels along the housing, with water driven by a pump.
//!
//! conductance    G = Nu k/d A_wet,                  Nu by `correlations/tube_flow.rs`          (1)
//! capacity rate  C = m c_p,  m = rho(T_in) Q                                                   (2)
//! effectiveness  e = 1 - exp(-G/C),  T_out = T_in + e (T_h - T_in)                             (3)
//! bulk           T_b = T_in + (T_h - T_in) [1 - e C/G]                                         (4)
//! pressure drop  dp = (f l/d + K) rho u^2/2,  u = Q/(N pi d^2/4),  P = dp Q                    (5)
//!
//! Properties except the density of (2) are those at the bulk temperature, which depends on them: three iterations.
//! *Assumes* even flow distribution to the channels; the wetted surface has the housing's temperature.
//! *Neglects* heat from the jacket's outside to ambient (without water flow the only other path: the calculated temperatures are on
//! the safe side), heat capacity of jacket and water, and the pump's power in the water (1e4 Pa: 0.002 K).
//! *Sign*: heat into the water is positive. *Range*: that of the correlations; liquid water. Without flow (1) is finite and (3)
//! gives zero heat flow.
//! *Source*: (3), (4) Incropera, 7th ed., eqs. 8.41, 8.42; (5) ibid. eq. 8.22 and White, Fluid Mechanics, sec. 6.9.

use crate::correlations::tube_flow;
use crate::media::water::Water;
use declare::{Unit, Variable, variables};
use std::f64::consts::FRAC_PI_4;

variables! {
    /// Data of the water jacket.
    pub struct Jacket {
        /// Hydraulic diameter of a coolant channel
        hydraulic_diameter: f64 = Variable::tunable(0, 0.003, Unit::Metre, 1e-4, 0.1).log()
            .source("estimate"),
        /// Length of a coolant channel
        channel_length: f64 = Variable::tunable(1, 0.064, Unit::Metre, 1e-3, 10.0).log()
            .source("length of the motor"),
        /// Number of coolant channels in parallel
        channels: i32 = Variable::tunable_count(2, 8, 1, 1000)
            .source("estimate"),
        /// Surface of the housing that the coolant wets
        wetted_area: f64 = Variable::tunable(3, 4.8e-3, Unit::SquareMetre, 1e-6, 10.0).log()
            .source("estimate: walls of 8 channels of 3 mm by 64 mm"),
        /// Sum of the loss coefficients of inlet, bends and outlet of a channel
        loss_coefficient: f64 = Variable::tunable(4, 1.5, Unit::One, 0.0, 1e3)
            .source("White, Fluid Mechanics, sec. 6.9: sharp inlet 0.5, outlet 1"),
        /// Mass of the jacket with its coolant
        mass: f64 = Variable::tunable(5, 0.05, Unit::Kilogram, 0.0, 100.0)
            .source("estimate"),
    }
}

/// Water in the jacket at one flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coolant {
    /// Conductance from the housing to the water, eq. (1), W/K.
    pub conductance: f64,
    /// Heat capacity rate of the flow, eq. (2), W/K.
    pub m_flow_cp: f64,
    /// Pressure drop, eq. (5), Pa.
    pub pressure_drop: f64,
    /// Hydraulic power of the pump, eq. (5), W.
    pub pump_power: f64,
}

impl Jacket {
    /// The water at the volume flow `q`, m3/s, with inlet temperature `inlet` and housing temperature `surface`, K.
    pub fn coolant(&self, q: f64, inlet: f64, surface: f64) -> Coolant {
        let (d, q) = (self.hydraulic_diameter, q.max(0.0));
        let speed = q / (f64::from(self.channels) * FRAC_PI_4 * d * d);
        let mass_flow = Water::at(inlet).rho * q;
        let mut bulk = inlet;
        let mut coolant = Coolant { conductance: 0.0, m_flow_cp: 0.0, pressure_drop: 0.0, pump_power: 0.0 };
        for _ in 0..3 {
            let water = Water::at(bulk);
            let re = water.rho * speed * d / water.mu;
            let nu = tube_flow::nusselt(re, water.pr, d / self.channel_length);
            coolant.conductance = nu * water.k / d * self.wetted_area;
            coolant.m_flow_cp = mass_flow * water.c_p;
            // Laminar friction as f Re, which is finite at rest.
            let friction =
                tube_flow::friction_times_re(re) * water.mu * speed * self.channel_length / (2.0 * d * d);
            coolant.pressure_drop = friction + 0.5 * self.loss_coefficient * water.rho * speed * speed;
            let ntu = coolant.conductance / coolant.m_flow_cp.max(1e-12);
            bulk = inlet + (surface - inlet) * (1.0 + (-ntu).exp_m1() / ntu);
        }
        coolant.pump_power = coolant.pressure_drop * q;
        coolant
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlations::checks::close;
    use crate::correlations::{RE_LAMINAR, RE_TURBULENT};

    /// By hand: 8 channels of 3 mm by 64 mm, 20 mL/s at 293.15 K, housing at 293.15 K. u = 2e-5/(8 7.0686e-6) = 0.35368 m/s; water
    /// 998.2 kg/m3, 1.0016e-3 Pa.s, 0.5985 W/(m.K), 4184.5 J/(kg.K), Pr 7.003: Re = 1057.4, Gz = 347.1: 1.615 7.0278 - 0.7 = 10.650,
    /// (2/155.07)^(1/6) 18.63 = 9.022: cube root of 49.37 + 1207.9 + 734.4 = 12.582; G = 12.582 0.5985/0.003 4.8e-3 = 12.05 W/K.
    /// dp = 64 1.0016e-3 0.35368 0.064/(2 9e-6) + 0.75 998.2 0.35368^2 = 80.6 + 93.6 Pa.
    #[test]
    fn a_jacket_by_hand() {
        let coolant = Jacket::default().coolant(2e-5, 293.15, 293.15);
        close(coolant.conductance, 12.05, 2e-3);
        close(coolant.m_flow_cp, 2e-5 * 998.2 * 4184.5, 1e-3);
        close(coolant.pressure_drop, 174.2, 2e-3);
        close(coolant.pump_power, 2e-5 * 174.2, 2e-3);
    }

    /// At zero flow all values are finite and the heat flow is zero; a small flow changes little.
    #[test]
    fn at_rest() {
        let jacket = Jacket::default();
        for surface in [280.0, 300.0, 360.0, 600.0] {
            let (rest, slow) = (jacket.coolant(0.0, 300.0, surface), jacket.coolant(1e-12, 300.0, surface));
            assert_eq!([rest.m_flow_cp, rest.pressure_drop, rest.pump_power], [0.0; 3]);
            assert!(rest.conductance > 1.0 && (slow.conductance / rest.conductance - 1.0).abs() < 1e-3);
            assert!(slow.m_flow_cp < 1e-5);
        }
    }

    /// Water heated by tens of kelvins has the properties at its bulk temperature: the jacket equals one without a temperature
    /// difference at that temperature.
    #[test]
    fn properties_are_those_at_the_bulk_temperature() {
        let jacket = Jacket::default();
        let (inlet, surface) = (283.15, 353.15);
        for q in [1e-7, 1e-6, 1e-5] {
            let coolant = jacket.coolant(q, inlet, surface);
            let ntu = coolant.conductance / coolant.m_flow_cp;
            let mean_effectiveness = 1.0 + (-ntu).exp_m1() / ntu;
            let bulk = inlet + (surface - inlet) * mean_effectiveness;
            let isothermal = jacket.coolant(q, bulk, bulk);
            close(coolant.conductance, isothermal.conductance, 2e-3);
            close(coolant.pressure_drop, isothermal.pressure_drop, 2e-2);
            let cold = jacket.coolant(q, inlet, inlet);
            assert!(coolant.pressure_drop < 0.97 * cold.pressure_drop, "{coolant:?} {cold:?}");
        }
    }

    /// Conductance and pressure are continuous at the transition to turbulent flow.
    #[test]
    fn through_the_transition() {
        let jacket = Jacket::default();
        let water = Water::at(300.0);
        let section = 8.0 * FRAC_PI_4 * 9e-6;
        for re in [RE_LAMINAR, RE_TURBULENT] {
            let q = re * water.mu / water.rho / 3e-3 * section;
            let [less, more] = [1.0 - 1e-7, 1.0 + 1e-7].map(|x| jacket.coolant(x * q, 300.0, 300.0));
            close(less.conductance, more.conductance, 1e-5);
            close(less.pressure_drop, more.pressure_drop, 1e-5);
        }
    }
}
