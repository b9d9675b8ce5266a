//! Heat flow within the motor: two nodes, or the network with stator, rotor and a segmented housing.
//!
//! Two nodes (cooling_mode conductance):
//!
//! C_w dT_w/dt = Q_w - (T_w - T_h)/R_wh                                                     (1)
//! C_h dT_h/dt = Q_h + (T_w - T_h)/R_wh - Q_ambient                                         (2)
//!
//! *Assumes* isothermal nodes; stator and magnets at the housing's temperature, without own heat capacity.
//! *Neglects* the leads, the mount and radiation as separate paths (included in the conductance to ambient).
//! Network (the other cooling modes): the datasheet's R_wh lies between winding and stator, as its maker
//! defines it; C_h is divided among rotor (C_r), stator and housing; see
//! `models/annulus_cooled_motor/network.rs`. C_r, G_wr, G_rh, R_sh, the fractions and the leads are estimates
//! (`seeds` audit, default parameters).
//! *Sign*: heat flow is positive from the winding to the housing and from the housing to ambient.
//! *Source*: datasheet of maxon 305015: R_wh 0.21 K/W and tau_w 2.11 s give C_w = 10.05 J/K; tau_m 1180 s at
//! 7.4 K/W gives 159.5 J/K for the whole motor, so C_h = 149.4 J/K. Winding limit 155 degC.

use declare::{Unit, Variable, variables};

variables! {
    /// Thermal data of the motor.
    pub struct Thermal {
        /// Thermal resistance from winding to housing
        R_wh: f64 = Variable::tunable(0, 0.21, Unit::KelvinPerWatt, 1e-4, 1e3).log()
            .source("maxon datasheet 305015"),
        /// Heat capacity of the winding
        C_w: f64 = Variable::tunable(1, 10.05, Unit::JoulePerKelvin, 1e-3, 1e6).log()
            .source("maxon datasheet 305015: winding time constant 2.11 s over R_wh"),
        /// Heat capacity of the housing, with stator and magnets
        C_h: f64 = Variable::tunable(2, 149.4, Unit::JoulePerKelvin, 1e-3, 1e7).log()
            .source("maxon datasheet 305015: motor time constant 1180 s at 7.4 K/W, less C_w"),
        /// Maximum winding temperature (maker's limit); sets over_temperature
        T_w_max: f64 = Variable::tunable(3, 428.15, Unit::Kelvin, 273.15, 573.15)
            .source("maxon datasheet 305015: 155 degC"),
        /// Heat capacity of the rotor with its magnets, part of C_h (not in cooling_mode conductance)
        C_r: f64 = Variable::tunable(4, 37.0, Unit::JoulePerKelvin, 1e-3, 1e6).log()
            .source("estimate from rotor size"),
        /// Conductance from winding to rotor, across the air gap (not in cooling_mode conductance)
        G_wr: f64 = Variable::tunable(5, 0.14, Unit::WattPerKelvin, 0.0, 1e3)
            .source("estimate: conduction across the air gap"),
        /// Conductance from rotor to housing, through the bearings (not in cooling_mode conductance)
        G_rh: f64 = Variable::tunable(6, 0.10, Unit::WattPerKelvin, 0.0, 1e3)
            .source("estimate: bearings"),
        /// Thermal resistance between stator and housing (not in cooling_mode conductance)
        R_sh: f64 = Variable::tunable(7, 0.05, Unit::KelvinPerWatt, 1e-3, 1e3).log()
            .source("estimate: press fit"),
        /// Fraction of the heat capacity of stator and housing that is the stator's (not in cooling_mode conductance)
        stator_share: f64 = Variable::tunable(8, 0.5, Unit::One, 0.01, 0.99)
            .source("estimate"),
        /// Conductance of the leads from winding to ambient (not in cooling_mode conductance)
        G_leads: f64 = Variable::tunable(9, 0.010, Unit::WattPerKelvin, 0.0, 1e3)
            .source("estimate: three copper leads"),
        /// Conductance of the mount from housing to ambient (not in cooling_mode conductance)
        G_mount: f64 = Variable::tunable(10, 0.0, Unit::WattPerKelvin, 0.0, 1e3).nominal(0.1),
        /// Fraction of bearing friction and windage that heats the rotor; the rest heats the housing (not in
        /// cooling_mode conductance)
        friction_to_rotor: f64 = Variable::tunable(11, 0.5, Unit::One, 0.0, 1.0)
            .source("estimate"),
    }
}

impl Thermal {
    /// Heat flow from the winding at `t_w` to the housing at `t_h`, W.
    #[inline]
    pub fn winding_to_housing(&self, t_w: f64, t_h: f64) -> f64 {
        (t_w - t_h) / self.R_wh
    }
}
