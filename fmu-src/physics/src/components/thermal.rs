//! The two-node thermal network: winding and housing.
//!
//! C_w dT_w/dt = Q_w - (T_w - T_h)/R_wh                                                     (1)
//! C_h dT_h/dt = Q_h + (T_w - T_h)/R_wh - Q_ambient                                         (2)
//!
//! *Assumes* each node at one temperature; stator and magnets at the housing's, without capacity of their own.
//! *Neglects* the leads, the mount and radiation (all inside the conductance to ambient here).
//! *Sign*: a flow counts positive from the winding to the housing and from the housing to ambient.
//! *Source*: datasheet of maxon 305015: R_wh 0.21 K/W and tau_w 2.11 s give C_w = 10.05 J/K; tau_m 1180 s at
//! 7.4 K/W gives 159.5 J/K for the whole, so C_h = 149.4 J/K. Winding limit 155 degC.

use declare::{Unit, Variable, variables};

variables! {
    /// Thermal data of the motor.
    pub struct Thermal {
        /// Thermal resistance from winding to housing
        R_wh: f64 = Variable::tunable(0, 0.21, Unit::KelvinPerWatt, 1e-4, 1e3).log(),
        /// Heat capacity of the winding
        C_w: f64 = Variable::tunable(1, 10.05, Unit::JoulePerKelvin, 1e-3, 1e6).log(),
        /// Heat capacity of the housing, with stator and magnets
        C_h: f64 = Variable::tunable(2, 149.4, Unit::JoulePerKelvin, 1e-3, 1e7).log(),
        /// Highest temperature allowed in the winding
        T_w_max: f64 = Variable::tunable(3, 428.15, Unit::Kelvin, 273.15, 573.15),
    }
}

impl Thermal {
    /// Heat flow from the winding at `t_w` to the housing at `t_h`, W.
    #[inline]
    pub fn winding_to_housing(&self, t_w: f64, t_h: f64) -> f64 {
        (t_w - t_h) / self.R_wh
    }
}
