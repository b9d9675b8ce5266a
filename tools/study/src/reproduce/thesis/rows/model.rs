//! Chapter 5: the model of the annulus.

use crate::numeric::{linspace, root};
use crate::reproduce::Verdict::*;
use crate::reproduce::thesis::measured::*;
use crate::reproduce::thesis::native::Native;
use crate::reproduce::thesis::projection::torque_at_5_a;
use crate::reproduce::thesis::published::*;
use crate::reproduce::{Basis, Row, significant};

/// Conductivity of a steel housing, W/(m.K), which eqs. (11) and (18) would take if read as published.
const K_HOUSING: f64 = 16.0;
/// The optimum of chapters 6 and 7.
const OPTIMUM: f64 = 0.63;

/// The rows.
pub fn rows(native: &Native) -> Vec<Row> {
    let mut rows = equations();
    rows.extend(figures(native));
    rows.extend(promises());
    rows
}

fn equations() -> Vec<Row> {
    let wide = Annulus::new(WIDE);
    let re = wide.reynolds();
    let ke_laminar = k_c(0.0, 1.2);
    let ke_turbulent = k_c(0.0, 1.0);
    vec![
        Row::new("T27", "ch. 5 eq. (7)", "heat flux", "q' = −I²R/A = h(T_a − T_h)", "")
            .but(SignError, "two sign errors that cancel in the product"),
        Row::new("T28", "ch. 5 eq. (8)", "housing temperature", "−T_h = T_∞ + …", "")
            .but(SignError, "T_h = T_∞ + …"),
        Row::new("T29", "eq. (9)", "winding over housing, 10 W", "T_w − T_h = q' R_wh", "K")
            .right(POWER * R_WH)
            .but(UnitError, "q' is a flux, W/m²; it needs the power"),
        Row::new("T30", "eq. (10)", "winding temperature, 40 mm", "1/(A h) − R_wh", "K")
            .published(wide.winding_temperature_by(LAMINAR))
            .right(wide.winding_temperature_right_sign(LAMINAR))
            .but(SignError, format!("+ R_wh: the sign moves T_w by {} K", significant(2.0 * POWER * R_WH))),
        Row::new("T31", "eqs. (11)-(12)", "constant of the laminar plate", 0.332, "")
            .published(LAMINAR.0)
            .note("a local correlation, correct with x in Re; the mean is twice the value at the end"),
        Row::new("T32", "eqs. (11), (18), (19)", "1/(A h), 40 mm", "k of the housing", "K/W")
            .published(resistance_with(re, LAMINAR, K_HOUSING))
            .right(resistance(re, LAMINAR))
            .but(PhysicsError, "the conductivity of air is required; the figures are consistent with it"),
        Row::new("T33", "eq. (13)", "speed, 40 mm, rated flow", "V̇/(60 A)", "m/s")
            .published(wide.reynolds_at(FAN_FLOW) * 15.89e-6 / (MOTOR_DIAMETER * (1.0 / WIDE - 1.0)))
            .note("with V̇ in m³/min"),
        Row::new("T34", "eqs. (14), (17)", "Reynolds number, 40 mm, rated flow", "Re_x", "")
            .published(wide.reynolds_at(FAN_FLOW))
            .but(
                HoldsWithNote,
                "correct for the hydraulic diameter; the flat-plate correlation requires u x/ν",
            ),
        Row::new("T35", "eq. (15)", "pressure drop, 40 mm", "eq. (15)", "Pa")
            .published(wide.pressure_drop(wide.flow()))
            .but(
                HoldsWithNote,
                "omits the dynamic pressure at the exit; A/A_c = 4 L/D_h only if both walls count",
            ),
        Row::new("T36", "ch. 5", "K_c at σ = 0, laminar", 0.785, "").published(ke_laminar).but(
            HoldsWithNote,
            "read from the figure; the stepwise rule is discontinuous at Re 2000 and 10 000",
        ),
        Row::new("T36-turbulent", "ch. 5", "K_c at σ = 0, Re = ∞", 0.385, "")
            .published(ke_turbulent)
            .but(HoldsWithNote, "read from the figure, as above"),
        Row::new("T37", "eq. (18)", "laminar constant", "0.332³√0.7", "")
            .published(0.332f64.powi(3) * 0.7f64.sqrt())
            .right(0.332 * 0.7f64.cbrt())
            .but(Garbled, "a cube root that lost its place"),
        Row::new("T38", "eq. (19)", "turbulent constant", "0.332³√0.7", "")
            .published(TURBULENT_AS_PUBLISHED.0 * 0.7f64.cbrt())
            .right(TURBULENT.0 * 0.7f64.cbrt())
            .but(
                Inconsistent,
                format!("{:.1} times the constant of eq. (12)", TURBULENT_AS_PUBLISHED.0 / TURBULENT.0),
            ),
    ]
}

fn figures(native: &Native) -> Vec<Row> {
    let (wide, narrow) = (Annulus::new(WIDE), Annulus::new(NARROW));
    let (argmax, re_max) = summit();
    let jumps_at = |re: f64| jumps(re).map_or("none".to_owned(), |(a, b)| format!("{a:.2} and {b:.2}"));
    let (left, right) = jumps(RE_SWITCH).unwrap_or((f64::NAN, f64::NAN));
    let coldest = coldest_native(native);
    vec![
        Row::new("T39", "fig. 15, ch. 7", "optimum r*", OPTIMUM, "").published(argmax).right(coldest).by(Basis::Predicted).note(
            "h increases with Re at fixed x, so the published optimum is the maximum of Re; corrected: lowest winding temperature of the untuned native model",
        ),
        Row::new("T40", "ch. 6", "greatest Re", "two discontinuities", "").published(re_max).note(format!(
            "with the switch at {RE_SWITCH:.0} they are at r* = {}, at 2300 {}; both tested annuli are laminar only for a switch between {:.0} and {re_max:.0}",
            jumps_at(RE_SWITCH),
            jumps_at(2300.0),
            wide.reynolds()
        )),
        Row::new("T40-left", "fig. 15", "first jump, r*", "not published", "").published(left),
        Row::new("T40-right", "fig. 15", "second jump, r*", "not published", "").published(right),
        Row::new("T41", "fig. 17", "winding temperature, 40 mm", "a curve", "K")
            .published(wide.winding_temperature())
            .right(native.winding_at(0.040, false))
            .by(Basis::Predicted)
            .measured(343.8)
            .but(
                HoldsWithNote,
                format!(
                    "with the mean of L/x on a grid of 1 mm, {:.2}, which diverges with grid refinement; the grid is chosen to reproduce the figure",
                    mean_of_l_over_x()
                ),
            ),
        Row::new("T41-narrow", "fig. 17", "winding temperature, 35 mm", "a curve", "K")
            .published(narrow.winding_temperature())
            .right(native.winding_at(0.035, false))
            .by(Basis::Predicted)
            .measured(346.4)
            .but(HoldsWithNote, "the published model depends more strongly on r* than the measurements, as the thesis states; corrected: untuned"),
    ]
}

/// The ratio of radii with the coldest winding in the native model, if it is there.
fn coldest_native(native: &Native) -> Option<f64> {
    let at = |r: f64| native.winding_at(MOTOR_DIAMETER / r, false);
    let all: Option<Vec<(f64, f64)>> =
        linspace(0.5, 0.97, 48).into_iter().map(|r| Some((r, at(r)?))).collect();
    all?.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(r, _)| r)
}

fn promises() -> Vec<Row> {
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
    vec![
        Row::new("T42", "ch. 7", "fall of R_ha at r* = 0.63", 89.0, "%")
            .published(100.0 * (1.0 - r_of(right) / bare))
            .but(
                Inconsistent,
                format!(
                    "as published eq. (19) gives T_w = {printed:.1} K and R_ha = {:.2}, with the constant of eq. (12) {right:.1} K; 89 % corresponds to {t_promised:.1} K and a constant of {needed:.3}, which is neither of the two",
                    r_of(printed)
                ),
            ),
        Row::new("T42-density", "ch. 7", "torque density at r* = 0.63", 0.414, "N.m/kg")
            .published(torque_at_5_a(t_promised) / CASES[4].mass)
            .right(torque_at_5_a(right) / CASES[4].mass)
            .but(
                Inconsistent,
                format!(
                    "with the mass of the 40 mm annulus; at equal conditions the fan alone at 5 mm has {}",
                    significant(torque_at_5_a(CASES[1].t_w) / CASES[1].mass)
                ),
            ),
        Row::new("T43", "ch. 6", "laminar entrance over motor length, 40 mm", "< 8 %", "%")
            .right(entrance(Annulus::new(WIDE).reynolds()))
            .but(PhysicsError, "0.05 Re D_h: the flow develops over the whole motor"),
        Row::new("T59", "eq. (15), chs. 5-6", "references", "fig. 8, 16, 17, 18", "")
            .but(Garbled, "12; 15, 17; equations (7) to (11) and sections 4.2 and 4.3 are numbered twice"),
    ]
}
