//! Every published number of the paper, in the order of the audit (P01 to P36): its text from `rows.toml`, its values from here.

use super::native::{BOX_CAPACITY, Run};
use super::published::*;
use super::{
    Compared, I_R2, I_SLOPE, PLATEAUS, Parts, Temperatures, V_R2, V_SLOPE, WORK_THERMAL, WORK_TOTAL,
};
use crate::reproduce::{Basis, Row, Rows, significant};

/// Total voltage at full duty as published, V (section 3.2.1).
const V_TOTAL: f64 = 9.7876;
/// Magnetic voltage as published, V.
const V_MAGNETIC: f64 = 48.67e-6;
/// Total and mechanical power as published, W (section 3.1).
const P_TOTAL: f64 = 1.7649;
const P_MECHANICAL: f64 = 1.4669;
/// Copper's rise of resistance by eq. (8), 1/K at 20 degC (Incropera, and IEC 60034-1: 1/(234.5 + 20)).
const ALPHA_20: f64 = 1.0 / (234.5 + 20.0);
/// Torque that a millinewton-metre slope gives at full duty at the output shaft, N.m.
pub const TORQUE: f64 = 0.18;
/// Catalogue of the 37D 131:1 gearmotor at 12 V: stall current, A, speed, rpm, and current without load, A.
const CATALOGUE: (f64, f64, f64) = (5.5, 76.0, 0.2);

/// The rows.
pub fn rows(
    voltage: &Parts,
    power: &Parts,
    work: &Parts,
    t: &Temperatures,
    runs: &[Run],
    compared: &[Compared],
) -> Vec<Row> {
    let mut rows = Rows::read(include_str!("rows.toml"));
    equations(&mut rows);
    full_duty(&mut rows, voltage, power, work, runs);
    derivatives(&mut rows);
    machine(&mut rows, voltage, power);
    over_duty(&mut rows, t, compared);
    rows.all()
}

/// The charge that the published magnetic term implies, C: L I^2/(2 V).
fn implied_charge() -> f64 {
    L_A * CURRENT * CURRENT / (2.0 * V_MAGNETIC)
}

fn equations(rows: &mut Rows) {
    let warm = PLATEAUS.1;
    rows.of("P03").published(ALPHA * R_0).right(ALPHA * R_A).fill([format!("{:.1}", R_0 / R_A)]);
    rows.of("P04").printed(R_0).published(R_A / (ALPHA * T_ROOM)).right(R_A).measured(R_A);
    rows.of("P05").published(resistance(warm)).right(right_resistance(warm));
}

fn full_duty(rows: &mut Rows, voltage: &Parts, power: &Parts, work: &Parts, runs: &[Run]) {
    let simulated = runs.last().map_or(String::new(), |run| {
        format!("; simulated with a warming winding {:.1} J", run.end.work.total)
    });
    let q = implied_charge();
    let p = Point { i: CURRENT, t: T_ROOM, torque: TORQUE, theta: voltage.mechanical * q / TORQUE, q };
    let [v_el, v_mag, v_mec] = super::published::voltage(&p);
    let [w_el, w_mag, _] = super::published::work(&Point { q: CURRENT * DURATION, ..p });
    rows.of("P06").published(v_el).right(voltage.electrical).fill([CURRENT.to_string()]);
    rows.of("P07").published(v_mec).right(V_TOTAL - v_el - v_mag);
    rows.of("P07-total").printed(V_TOTAL).published(v_el + v_mag + v_mec).right(voltage.total);
    rows.of("P08")
        .printed(V_MAGNETIC)
        .published(v_mag)
        .fill([format!("{q:.3}"), format!("{:.2}", q / CURRENT)]);
    rows.of("P09")
        .printed(P_TOTAL)
        .published(V_TOTAL * CURRENT)
        .right(power.total)
        .fill([format!("{:.2}", 100.0 * (P_TOTAL / power.total - 1.0))]);
    rows.of("P10").published(super::published::power(&p)[0]).right(power.electrical);
    rows.of("P10-magnetic").published(super::published::power(&p)[1]).right(power.magnetic);
    rows.of("P11").printed(P_MECHANICAL).published(v_mec * CURRENT).right(power.mechanical);
    rows.of("P12")
        .published(P_TOTAL * DURATION)
        .right(work.total)
        .measured(WORK_TOTAL)
        .fill([format!("{:.2}", 100.0 * (1.0 - WORK_TOTAL / (P_TOTAL * DURATION))), simulated.to_string()]);
    rows.of("P13")
        .published(w_el)
        .right(work.electrical)
        .measured(WORK_THERMAL)
        .fill([significant(WORK_THERMAL / DURATION)]);
    rows.of("P13-magnetic").published(w_mag).right(work.magnetic);
    rows.of("P13-mechanical")
        .published(P_MECHANICAL * DURATION)
        .right(work.mechanical)
        .fill([significant(1315.0 / DURATION)]);
}

fn derivatives(rows: &mut Rows) {
    let p = Point { i: CURRENT, t: T_ROOM, torque: TORQUE, theta: 1.0, q: implied_charge() };
    let warmer = Point { t: T_ROOM + 1.0, ..p };
    rows.of("P17")
        .published(voltage_change(&p, &warmer))
        .right(right_voltage_change(&p, &warmer))
        .fill([format!("{:.0}", voltage_change(&p, &warmer) / right_voltage_change(&p, &warmer))]);
    rows.of("P18")
        .published(current_per_volt(&p))
        .right(right_current_per_volt(&p))
        .fill([format!("{:.2}", current_per_volt(&p) / right_current_per_volt(&p))]);
    rows.of("P19").published(temperature_per_volt(&p)).right(1.0 / right_voltage_change(&p, &warmer));
    rows.of("P20").published(torque_per_volt(&p)).right(p.q / p.theta);
}

fn machine(rows: &mut Rows, voltage: &Parts, power: &Parts) {
    let speed = power.mechanical / TORQUE;
    let rpm = 30.0 / std::f64::consts::PI;
    let (stall, catalogue_rpm, idle) = CATALOGUE;
    let terminal = SUPPLY / stall;
    let k = (SUPPLY - idle * terminal) * rpm / catalogue_rpm;
    rows.of("P23").published(speed * rpm * 1e3).right(speed * rpm);
    rows.of("P24").published(voltage.mechanical / speed).right(k).fill([
        format!("{:.0}", (voltage.total - CURRENT * terminal) / k * rpm),
        significant(voltage.total),
        format!("{:.0}", speed * rpm),
    ]);
    rows.of("P25").printed(R_A).right(terminal).measured(R_A).fill([format!("{:.1}", SUPPLY / R_A)]);
    rows.of("P29").printed(SUPPLY).right(SUPPLY - voltage.total);
    rows.of("P33").printed(ALPHA).published(ALPHA).right(ALPHA_20);
    rows.of("P34").right(131.25 * 64.0);
}

fn over_duty(rows: &mut Rows, t: &Temperatures, compared: &[Compared]) {
    let power: Vec<(f64, f64)> = DUTIES.iter().copied().zip(t.power_W.iter().copied()).collect();
    let straight = crate::numeric::Line::through(&power).map_or(f64::NAN, |l| l.r2);
    let worst = t.residuals_K.iter().map(|r| r.abs()).fold(0.0, f64::max);
    rows.of("P26").printed(1e3 * V_SLOPE).published(10.0 * V_TOTAL);
    rows.of("P26-r2").printed(V_R2);
    rows.of("P27").printed(1e3 * I_SLOPE);
    rows.of("P27-r2").printed(I_R2);
    rows.of("P28").right(straight);
    rows.of("P30-low").printed(PLATEAUS.0).measured(PLATEAUS.0).fill([format!("{worst:.1}")]);
    rows.of("P30-high").printed(PLATEAUS.1).measured(PLATEAUS.1);
    rows.of("P31").published(T_ROOM + t.adiabatic_rise_K).fill([BOX_CAPACITY.to_string()]);
    for (id, quantity) in [
        ("P26", "slope of voltage over duty"),
        ("P26-r2", "r² of voltage over duty"),
        ("P27", "slope of current over duty"),
        ("P27-r2", "r² of current over duty"),
        ("P30-low", "winding temperature at 40 %"),
        ("P30-high", "winding temperature at 100 %"),
        ("P31", "winding temperature at 100 %"),
    ] {
        if let Some(c) = compared.iter().find(|c| c.quantity == quantity) {
            rows.of(id).right(c.simulated).by(if c.used_in_fit { Basis::Fitted } else { Basis::Predicted });
        }
    }
}
