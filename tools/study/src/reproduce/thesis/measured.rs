//! Measurements of the thesis and values of its datasheets, as published.

use serde::Deserialize;
use std::sync::LazyLock;

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
/// Ambient in all tests but the bare one, K, as the tables' R_ha imply it (audit, T23).
pub const T_AMBIENT: f64 = 297.9;
/// Ambient in the bare test, K, implied in the same way.
pub const T_AMBIENT_BARE: f64 = 296.07;
/// Ratio of radii of the wide annulus, 40 mm.
pub const WIDE: f64 = 30.0 / 40.0;
/// Ratio of radii of the narrow annulus, 35 mm.
pub const NARROW: f64 = 30.0 / 35.0;

/// A test of the thesis: one column of its tables.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Name in the reports.
    pub name: &'static str,
    /// Where it is published.
    pub location: &'static str,
    /// Item of the model's `cooling_mode`.
    pub cooling_mode: &'static str,
    /// The parameter that distinguishes the case from others of its mode, and its value in m.
    pub setting: Option<(&'static str, f64)>,
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
pub static CASES: LazyLock<Vec<Case>> =
    LazyLock::new(|| serde_json::from_str(include_str!("cases.json")).expect("the tests read the cases"));

impl Case {
    /// The case of this name.
    pub fn named(name: &str) -> Option<&'static Case> {
        CASES.iter().find(|c| c.name == name)
    }

    /// Ratio of radii of the annulus.
    pub fn r_star(&self) -> Option<f64> {
        let outer = self.setting.filter(|(name, _)| *name == "annulus.outer_diameter");
        outer.map(|(_, outer)| if outer > 0.0375 { WIDE } else { NARROW })
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
