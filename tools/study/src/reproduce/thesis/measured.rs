//! Measurements of the thesis and values of its datasheets, as published.

/// Fan: free flow, m3/s (0.28 m3/min; appendix 4).
pub const FAN_FLOW: f64 = 0.28 / 60.0;
/// Pressure of a millimetre of water, Pa.
pub const MM_WATER: f64 = 9.806_65;
/// Fan: shut-off pressure, Pa (7.24 mm of water; appendix 4).
pub const FAN_PRESSURE: f64 = 7.24 * MM_WATER;
/// Motor diameter, m (appendix 2).
pub const MOTOR_DIAMETER: f64 = 0.030;
/// Motor length, m. Not in the text: the maxon catalogue's (audit).
pub const MOTOR_LENGTH: f64 = 0.064;
/// Power put into the winding in every test, W.
pub const POWER: f64 = 10.0;
/// Current at which the thesis projects its torques, A.
pub const CURRENT: f64 = 5.0;
/// Winding to housing, K/W (appendix 2).
pub const R_WH: f64 = 0.21;
/// Housing to ambient, K/W (appendix 2).
pub const R_HA_DATASHEET: f64 = 7.4;
/// Terminal resistance of the catalogue's motor, ohm (appendix 2).
pub const R_DATASHEET: f64 = 0.386;
/// Temperature coefficient of copper, 1/K (section 2.1).
pub const ALPHA: f64 = 0.0039;
/// Torque constant, N.m/A (appendix 2).
pub const K_T: f64 = 0.0276;
/// Temperature coefficient of the torque constant, 1/K (section 3.1).
pub const ALPHA_MAG: f64 = -0.0012;
/// Reference temperature of the thesis for both, K.
pub const T_REF: f64 = 293.15;
/// Reference temperature of the data sheet, K.
pub const T_25: f64 = 298.15;
/// Limit of the winding, K (155 degC; appendix 2).
pub const T_W_MAX: f64 = 428.15;
/// Mass of the motor, kg (appendix 2).
pub const MOTOR_MASS: f64 = 0.300;
/// Ambient in all tests but the bare one, K, as the tables' R_ha imply it (audit, T23).
pub const T_AMBIENT: f64 = 297.9;
/// Ambient in the bare test, K, implied in the same way.
pub const T_AMBIENT_BARE: f64 = 296.07;
/// Ratio of radii of the wide annulus, 40 mm.
pub const WIDE: f64 = 30.0 / 40.0;
/// Ratio of radii of the narrow annulus, 35 mm.
pub const NARROW: f64 = 30.0 / 35.0;

/// A test of the thesis: one column of its tables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Name in the reports.
    pub name: &'static str,
    /// Where it is published.
    pub location: &'static str,
    /// Item of the model's `cooling_mode`.
    pub cooling_mode: &'static str,
    /// The parameter that distinguishes the case from others of its mode, and its value in m.
    pub setting: Option<(&'static str, f64)>,
    /// Ratio of radii of the annulus.
    pub r_star: Option<f64>,
    /// Steady resistance, ohm.
    pub resistance: f64,
    /// Steady winding temperature, K.
    pub t_w: f64,
    /// Projected torque, N.m.
    pub torque: f64,
    /// Total mass, kg.
    pub mass: f64,
    /// Projected torque density, N.m/kg.
    pub density: f64,
    /// Housing to ambient, K/W.
    pub r_ha: f64,
}

/// Section 3.3 and tables 1, 2 and 3.
pub const CASES: [Case; 8] = [
    Case {
        name: "bare",
        location: "§3.3",
        cooling_mode: "bare",
        setting: None,
        r_star: None,
        resistance: 0.5,
        t_w: 413.17,
        torque: 0.1181,
        mass: MOTOR_MASS,
        density: 0.393,
        r_ha: 11.5,
    },
    fan("fan-5mm", 0.005, [0.4045, 340.3, 0.1218, 0.3874, 4.03]),
    fan("fan-15mm", 0.015, [0.4068, 342.0, 0.1212, 0.3855, 4.20]),
    fan("fan-30mm", 0.030, [0.4101, 344.5, 0.1203, 0.3826, 4.45]),
    annulus("annulus-40-push", PUSH, 0.040, [0.4092, 343.8, 0.1296, 0.3928, 4.38]),
    annulus("annulus-35-push", PUSH, 0.035, [0.4127, 346.4, 0.1292, 0.3887, 4.65]),
    annulus("annulus-40-pull", PULL, 0.040, [0.4133, 346.8, 0.1291, 0.3913, 4.69]),
    annulus("annulus-35-pull", PULL, 0.035, [0.4184, 350.6, 0.1285, 0.3866, 5.07]),
];

/// Table of the pushed flow, and the item of `cooling_mode`.
const PUSH: (&str, &str) = ("Table 2", "annulus_push");
/// Table of the pulled flow, and the item of `cooling_mode`.
const PULL: (&str, &str) = ("Table 3", "annulus_pull");

const fn fan(name: &'static str, distance: f64, column: [f64; 5]) -> Case {
    let [resistance, t_w, torque, density, r_ha] = column;
    Case {
        name,
        location: "Table 1",
        cooling_mode: "fan_crossflow",
        setting: Some(("fan.distance", distance)),
        r_star: None,
        resistance,
        t_w,
        torque,
        mass: 0.3144,
        density,
        r_ha,
    }
}

const fn annulus(
    name: &'static str,
    (location, mode): (&'static str, &'static str),
    outer: f64,
    column: [f64; 5],
) -> Case {
    let [resistance, t_w, torque, density, r_ha] = column;
    let wide = outer > 0.0375;
    Case {
        name,
        location,
        cooling_mode: mode,
        setting: Some(("annulus.outer_diameter", outer)),
        r_star: Some(if wide { WIDE } else { NARROW }),
        resistance,
        t_w,
        torque,
        mass: if wide { 0.3299 } else { 0.3324 },
        density,
        r_ha,
    }
}

impl Case {
    /// The case of this name.
    pub fn named(name: &str) -> Option<&'static Case> {
        CASES.iter().find(|c| c.name == name)
    }

    /// Ambient temperature that the model is given, K.
    pub fn ambient(&self) -> f64 {
        if self.cooling_mode == "bare" { T_AMBIENT_BARE } else { T_AMBIENT }
    }

    /// Ambient temperature that the published T_w and R_ha imply by eq. (11), K.
    pub fn implied_ambient(&self) -> f64 {
        self.t_w - POWER * (self.r_ha + R_WH)
    }
}
