//! Chapter 5: the model of the annulus.

use crate::numeric::{linspace, root};
use crate::reproduce::thesis::measured::*;
use crate::reproduce::thesis::native::winding_at;
use crate::reproduce::thesis::projection::torque_at_5_a;
use crate::reproduce::thesis::published::*;
use crate::reproduce::{Basis, Rows, significant};

/// Conductivity of a steel housing, W/(m.K), which eqs. (11) and (18) would take if read as published.
const K_HOUSING: f64 = 16.0;
/// The optimum of chapters 6 and 7.
const OPTIMUM: f64 = 0.63;

/// The rows.
pub fn rows(rows: &mut Rows) {
    equations(rows);
    figures(rows);
    promises(rows);
}

fn equations(rows: &mut Rows) {
    let wide = Annulus::new(WIDE);
    let re = wide.reynolds();
    let ke_laminar = k_c(0.0, 1.2);
    let ke_turbulent = k_c(0.0, 1.0);
    rows.of("T29").right(POWER * R_WH);
    rows.of("T30")
        .published(wide.winding_temperature_by(LAMINAR))
        .right(wide.winding_temperature_right_sign(LAMINAR))
        .fill([significant(2.0 * POWER * R_WH)]);
    rows.of("T31").published(LAMINAR.0);
    rows.of("T32").published(resistance_with(re, LAMINAR, K_HOUSING)).right(resistance(re, LAMINAR));
    rows.of("T33").published(wide.reynolds_at(FAN_FLOW) * 15.89e-6 / (MOTOR_DIAMETER * (1.0 / WIDE - 1.0)));
    rows.of("T34").published(wide.reynolds_at(FAN_FLOW));
    rows.of("T35").published(wide.pressure_drop(wide.flow()));
    rows.of("T36").published(ke_laminar);
    rows.of("T36-turbulent").published(ke_turbulent);
    rows.of("T37").published(0.332f64.powi(3) * 0.7f64.sqrt()).right(0.332 * 0.7f64.cbrt());
    rows.of("T38")
        .published(TURBULENT_AS_PUBLISHED.0 * 0.7f64.cbrt())
        .right(TURBULENT.0 * 0.7f64.cbrt())
        .fill([format!("{:.1}", TURBULENT_AS_PUBLISHED.0 / TURBULENT.0)]);
}

fn figures(rows: &mut Rows) {
    let (wide, narrow) = (Annulus::new(WIDE), Annulus::new(NARROW));
    let (argmax, re_max) = summit();
    let jumps_at = |re: f64| jumps(re).map_or("none".to_owned(), |(a, b)| format!("{a:.2} and {b:.2}"));
    let (left, right) = jumps(RE_SWITCH).unwrap_or((f64::NAN, f64::NAN));
    rows.of("T39").printed(OPTIMUM).published(argmax).right(coldest_native()).by(Basis::Predicted);
    rows.of("T40").published(re_max).fill([
        format!("{RE_SWITCH:.0}"),
        jumps_at(RE_SWITCH),
        jumps_at(2300.0),
        format!("{:.0}", wide.reynolds()),
        format!("{re_max:.0}"),
    ]);
    rows.of("T40-left").published(left);
    rows.of("T40-right").published(right);
    rows.of("T41")
        .published(wide.winding_temperature())
        .right(winding_at(0.040, false))
        .by(Basis::Predicted)
        .fill([format!("{:.2}", mean_of_l_over_x())]);
    rows.of("T41-narrow")
        .published(narrow.winding_temperature())
        .right(winding_at(0.035, false))
        .by(Basis::Predicted);
}

/// The ratio of radii with the coldest winding in the native model, if it is there.
fn coldest_native() -> Option<f64> {
    let at = |r: f64| Some((r, winding_at(MOTOR_DIAMETER / r, false)?));
    let all: Option<Vec<(f64, f64)>> = linspace(0.5, 0.97, 48).into_iter().map(at).collect();
    all?.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(r, _)| r)
}

fn promises(rows: &mut Rows) {
    let best = Annulus::new(OPTIMUM);
    let printed = best.winding_temperature_by(TURBULENT_AS_PUBLISHED);
    let right = best.winding_temperature_by(TURBULENT);
    let bare = CASES[0].r_ha;
    let promised = bare * (1.0 - 0.89);
    let r_of = |t_w: f64| (t_w - T_AMBIENT) / POWER - R_WH;
    // The constant of the turbulent law that would bring the promised resistance.
    let excess = |c: f64| resistance(best.reynolds(), (c, TURBULENT.1)) - promised - 2.0 * R_WH;
    let needed = root(excess, TURBULENT.0, TURBULENT_AS_PUBLISHED.0, 1e-6).unwrap_or(f64::NAN);
    let t_promised = T_AMBIENT + POWER * (promised + R_WH);
    let entrance = |re: f64| 100.0 * 0.05 * re * MOTOR_DIAMETER * (1.0 / WIDE - 1.0) / MOTOR_LENGTH;
    rows.of("T42").published(100.0 * (1.0 - r_of(right) / bare)).fill([
        format!("{printed:.1}"),
        format!("{:.2}", r_of(printed)),
        format!("{right:.1}"),
        format!("{t_promised:.1}"),
        format!("{needed:.3}"),
    ]);
    rows.of("T42-density")
        .published(torque_at_5_a(t_promised) / CASES[4].mass)
        .right(torque_at_5_a(right) / CASES[4].mass)
        .fill([significant(torque_at_5_a(CASES[1].t_w) / CASES[1].mass)]);
    rows.of("T43").right(entrance(Annulus::new(WIDE).reynolds()));
}
