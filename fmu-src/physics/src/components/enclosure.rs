//! A gearmotor in an insulated box: winding, housing, gear, and the box's air and walls.
//!
//! C_w dT_w/dt = Q_w - (T_w - T_h)/R_wh                                                     (1)
//! C_h dT_h/dt = Q_h + (T_w - T_h)/R_wh + (T_g - T_h)/R_gh - G_hb (T_h - T_b)               (2)
//! C_b dT_b/dt = G_hb (T_h - T_b) - G_ba (T_b - T_a)                                        (3)
//! C_g dT_g/dt = Q_g - (T_g - T_h)/R_gh                                                     (4)
//!
//! Q_g is the fraction friction_to_gear of the friction losses, Q_h the rest. Below C_g = 1e-3 J/K the gear is part of the housing:
//! its capacity is in C_h, its temperature is T_h, and all friction heats the housing.
//! *Assumes* each node at one temperature. *Neglects* radiation, leads and heat from gear to box as separate paths (all included in G_hb).
//! *Sign*: heat flow is positive from the winding outwards.
//! *Source*: estimates. 95 J/K in total for the motor of about 210 g of steel and copper, 10 J/K of it the armature's
//! copper and teeth; 5 K/W across the air gap, as catalogues give for brushed motors of this size (3 to 8 K/W);
//! 60 J/K and 0.15 W/K for a box of expanded polystyrene; 120 degC for the winding (insulation class E).

use declare::{Unit, Variable, variables};

variables! {
    /// Thermal data of motor and box.
    pub struct Enclosure {
        /// Thermal resistance from winding to housing
        R_wh: f64 = Variable::tunable(0, 5.0, Unit::KelvinPerWatt, 1e-4, 1e3).log()
            .source("estimate: catalogues of brushed motors, 3 to 8 K/W"),
        /// Heat capacity of the winding
        C_w: f64 = Variable::tunable(1, 10.0, Unit::JoulePerKelvin, 1e-3, 1e6).log()
            .source("estimate: copper and teeth of the armature"),
        /// Heat capacity of the housing, with magnets and gear
        C_h: f64 = Variable::tunable(2, 85.0, Unit::JoulePerKelvin, 1e-3, 1e7).log()
            .source("estimate: 95 J/K for 210 g of motor, less C_w"),
        /// Maximum winding temperature (maker's limit); sets over_temperature
        T_w_max: f64 = Variable::tunable(3, 393.15, Unit::Kelvin, 273.15, 573.15)
            .source("estimate: insulation class E, 120 degC"),
        /// Heat capacity of the box, air and walls
        C_b: f64 = Variable::tunable(4, 60.0, Unit::JoulePerKelvin, 1e-3, 1e7).log()
            .source("estimate: box of expanded polystyrene"),
        /// Conductance from the housing to the box
        G_hb: f64 = Variable::tunable(5, 0.15, Unit::WattPerKelvin, 1e-6, 1e4).log()
            .source("estimate: box of expanded polystyrene"),
        /// Conductance from the box to ambient
        G_ba: f64 = Variable::tunable(6, 0.15, Unit::WattPerKelvin, 1e-6, 1e4).log()
            .source("estimate: box of expanded polystyrene"),
        /// Heat capacity of the gear; below 0.001 J/K the gear is part of the housing
        C_g: f64 = Variable::tunable(7, 0.0, Unit::JoulePerKelvin, 0.0, 1e7).nominal(10.0),
        /// Thermal resistance from gear to housing (not without C_g)
        R_gh: f64 = Variable::tunable(8, 2.0, Unit::KelvinPerWatt, 1e-4, 1e3).log()
            .source("estimate: flange of a gear of 37 mm, 1e3 mm2 with 500 W/(m2.K)"),
        /// Fraction of the friction losses that heats the gear; the rest heats the housing (not without C_g)
        friction_to_gear: f64 = Variable::tunable(9, 1.0, Unit::One, 0.0, 1.0)
            .source("neutral: all friction is in the gear"),
    }
}

/// Smallest heat capacity of a node that can be part of another one, J/K.
pub const LEAST_CAPACITY: f64 = 1e-3;
