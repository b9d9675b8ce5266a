//! The abstract's fan and the data sheets of the appendices.

use crate::reproduce::Row;
use crate::reproduce::Verdict::*;
use crate::reproduce::thesis::measured::*;
use crate::reproduce::thesis::projection::specimen_resistance;
use std::f64::consts::PI;

/// A cubic foot, m3.
const CUBIC_FOOT: f64 = 0.028_316_846_592;
/// An inch, m.
const INCH: f64 = 0.0254;
/// Nominal voltage, V; no-load speed, rpm; no-load current, A; inertia, kg.m2 (appendix 2).
const NO_LOAD: (f64, f64, f64, f64) = (48.0, 16_500.0, 0.356, 33.3e-7);
/// Time constants of the winding and of the motor, s (appendix 2).
const TAU: (f64, f64) = (2.11, 1180.0);

/// The rows.
pub fn rows() -> Vec<Row> {
    let (v, n_0, i_0, j) = NO_LOAD;
    let stall = v / R_DATASHEET;
    let per_second = 30.0 / PI;
    let gradient = R_DATASHEET / (K_T * K_T) * per_second / 1e3;
    let efficiency = (1.0 - (i_0 * R_DATASHEET / v).sqrt()).powi(2);
    let (u_t, u_r, leads) = uncertainty();
    vec![
        Row::new("T01", "abstract", "flow of 10 cfm", 4.72e-3, "m3/s")
            .published(10.0 * CUBIC_FOOT / 60.0)
            .right(FAN_FLOW)
            .note("corrected: the data sheet's 0.28 m³/min"),
        Row::new("T55", "app. 4", "free flow", 10.0, "cfm")
            .published(FAN_FLOW * 60.0 / CUBIC_FOOT)
            .but(HoldsWithNote, "9.89, rounded; the header row is lost"),
        Row::new("T55-head", "app. 4", "shut-off pressure", 0.29, "inH2O")
            .published(7.24e-3 / INCH)
            .but(HoldsWithNote, "0.285, rounded"),
        Row::new("T55-power", "app. 4", "fan power", 1.2, "W").published(12.0 * 0.10),
        Row::new("T55-affinity", "app. 4", "shut-off pressure of the slow fan", 4.29, "mmH2O")
            .published(7.24 * (6400.0f64 / 8300.0).powi(2))
            .note("by the affinity law from the fast one"),
        Row::new("T56", "app. 2", "stall current", 124.0, "A").published(stall),
        Row::new("T56-torque", "app. 2", "stall torque", 3430.0, "mN.m").published(1e3 * K_T * stall),
        Row::new("T56-speed", "app. 2", "speed constant", 346.0, "rpm/V").published(per_second / K_T),
        Row::new("T56-gradient", "app. 2", "speed over torque", 4.83, "rpm/mNm").published(gradient),
        Row::new("T56-tau", "app. 2", "mechanical time constant", 1.69, "ms").published(1e3 * R_DATASHEET * j / (K_T * K_T)),
        Row::new("T56-eta", "app. 2", "greatest efficiency", 89.8, "%").published(100.0 * efficiency),
        Row::new("T56-no-load", "app. 2", "no-load speed", n_0, "rpm").published((v - i_0 * R_DATASHEET) / K_T * per_second),
        Row::new("T57", "app. 2", "heat capacity of the winding", "τ_w/R_wh", "J/K")
            .published(TAU.0 / R_WH)
            .but(HoldsWithNote, "lumped heat capacity: time constant divided by resistance"),
        Row::new("T57-motor", "app. 2", "heat capacity of the motor", "τ_m/R_ha", "J/K")
            .published(TAU.1 / R_HA_DATASHEET)
            .but(HoldsWithNote, "300 g of steel with 0.45 J/(g.K) have 135 J/K"),
        Row::new("T58", "app. 1", "uncertainty of T_w", "±(0.02 % + 3 mV), ±(0.05 % + 10 mA)", "K")
            .right(u_t)
            .but(
                Remark,
                format!("and {:.2} K/W in R_ha; 10 mΩ of lead resistance corresponds to {:.1} K; the effects of distance and flow direction are 3 to 4 standard deviations", u_r, leads),
            ),
    ]
}

/// Standard uncertainty of T_w, K, and of R_ha, K/W, by the supply's accuracy (a rectangular distribution), and
/// the error of T_w by 10 milliohm of leads, K; for a cooled motor at 5 A and 2 V.
fn uncertainty() -> (f64, f64, f64) {
    let (voltage, current) = (2.0, CURRENT);
    let u_v = (2e-4 * voltage + 3e-3) / 3f64.sqrt();
    let u_i = (5e-4 * current + 10e-3) / 3f64.sqrt();
    let relative = ((u_v / voltage).powi(2) + (u_i / current).powi(2)).sqrt();
    let resistance = voltage / current;
    let per_ohm = 1.0 / (ALPHA * specimen_resistance());
    let u_t = relative * resistance * per_ohm;
    (u_t, u_t / POWER, 10e-3 * per_ohm)
}
