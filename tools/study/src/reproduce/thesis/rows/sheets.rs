//! The abstract's fan and the data sheets of the appendices.

use crate::reproduce::Rows;
use crate::reproduce::thesis::measured::*;
use crate::reproduce::thesis::projection::specimen_resistance;
use std::f64::consts::PI;

/// A cubic foot, m3.
const CUBIC_FOOT: f64 = 0.028_316_846_592;
const INCH: f64 = 0.0254;
/// Nominal voltage, V; no-load speed, rpm; no-load current, A; inertia, kg.m2 (appendix 2).
const NO_LOAD: (f64, f64, f64, f64) = (48.0, 16_500.0, 0.356, 33.3e-7);
/// Time constants of the winding and of the motor, s (appendix 2).
const TAU: (f64, f64) = (2.11, 1180.0);

/// The rows.
pub fn rows(rows: &mut Rows) {
    let (v, n_0, i_0, j) = NO_LOAD;
    let stall = v / R_DATASHEET;
    let per_second = 30.0 / PI;
    let gradient = R_DATASHEET / (K_T * K_T) * per_second / 1e3;
    let efficiency = (1.0 - (i_0 * R_DATASHEET / v).sqrt()).powi(2);
    let (u_t, u_r, leads) = uncertainty();
    rows.of("T01").published(10.0 * CUBIC_FOOT / 60.0).right(FAN_FLOW);
    rows.of("T55").published(FAN_FLOW * 60.0 / CUBIC_FOOT);
    rows.of("T55-head").published(7.24e-3 / INCH);
    rows.of("T55-power").published(12.0 * 0.10);
    rows.of("T55-affinity").published(7.24 * (6400.0f64 / 8300.0).powi(2));
    rows.of("T56").published(stall);
    rows.of("T56-torque").published(1e3 * K_T * stall);
    rows.of("T56-speed").published(per_second / K_T);
    rows.of("T56-gradient").published(gradient);
    rows.of("T56-tau").published(1e3 * R_DATASHEET * j / (K_T * K_T));
    rows.of("T56-eta").published(100.0 * efficiency);
    rows.of("T56-no-load").printed(n_0).published((v - i_0 * R_DATASHEET) / K_T * per_second);
    rows.of("T57").published(TAU.0 / R_WH);
    rows.of("T57-motor").published(TAU.1 / R_HA_DATASHEET);
    rows.of("T58").right(u_t).fill([format!("{u_r:.2}"), format!("{leads:.1}")]);
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
