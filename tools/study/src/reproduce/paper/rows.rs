//! Every published number of the paper, in the order of the audit (P01 to P36).

use super::native::{BOX_CAPACITY, Run};
use super::published::*;
use super::{
    Compared, I_R2, I_SLOPE, PLATEAUS, Parts, Temperatures, V_R2, V_SLOPE, WORK_THERMAL, WORK_TOTAL, basis,
};
use crate::reproduce::Verdict::*;
use crate::reproduce::{Row, significant};

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
    runs: Option<&[Run]>,
    compared: &[Compared],
) -> Vec<Row> {
    let mut rows = equations();
    rows.extend(full_duty(voltage, power, work, runs));
    rows.extend(derivatives());
    rows.extend(machine(voltage, power));
    rows.extend(over_duty(t, runs, compared));
    rows
}

/// The charge that the published magnetic term implies, C: L I^2/(2 V).
fn implied_charge() -> f64 {
    L_A * CURRENT * CURRENT / (2.0 * V_MAGNETIC)
}

fn equations() -> Vec<Row> {
    let warm = PLATEAUS.1;
    vec![
        Row::new("P01", "eqs. (2)-(6)", "Kirchhoff's law, K_a and K_b", "V = R I + L dI/dt + K ω, T = K I", "")
            .note("in SI units K_a = K_b always, not only in steady state"),
        Row::new("P02", "eq. (7)", "counter-electromotive force", "V_a = T_m θ/I_a", "").but(
            UnitError,
            "with the angle the unit is N.m/A = V.s instead of V; the speed is required: V_a = T_m ω/I_a",
        ),
        Row::new("P03", "eqs. (8)-(10)", "slope of resistance over temperature", "R = α R₀ T", "Ohm/K")
            .published(ALPHA * R_0)
            .right(ALPHA * R_A)
            .but(
                PhysicsError,
                format!(
                    "the constant of integration is omitted: zero resistance at 0 degC, and a temperature coefficient {:.1} times that of copper",
                    R_0 / R_A
                ),
            ),
        Row::new("P04", "§2.3", "resistance at 20 degC", R_0, "Ohm")
            .published(R_A / (ALPHA * T_ROOM))
            .right(R_A)
            .measured(R_A)
            .but(Inconsistent, "115 is 9.2/(0.004·20), chosen so that eq. (10) gives the measured 9.20 at 20 degC"),
        Row::new("P05", "eq. (10)", format!("resistance at {warm} degC"), "not published", "Ohm")
            .published(resistance(warm))
            .right(right_resistance(warm))
            .but(Inconsistent, "all published values at 100 % are for 20 degC, not for the measured temperature"),
    ]
}

fn full_duty(voltage: &Parts, power: &Parts, work: &Parts, runs: Option<&[Run]>) -> Vec<Row> {
    let simulated = runs
        .and_then(|runs| runs.last())
        .map_or(String::new(), |run| format!("; simulated with a warming winding {:.1} J", run.work.total));
    let q = implied_charge();
    let p = Point {
        v: V_TOTAL,
        i: CURRENT,
        t: T_ROOM,
        torque: TORQUE,
        theta: voltage.mechanical * q / TORQUE,
        q,
    };
    let [v_el, v_mag, v_mec] = super::published::voltage(&p);
    let [w_el, w_mag, _] = super::published::work(&Point { q: CURRENT * DURATION, ..p });
    vec![
        Row::new("P06", "§3.2.1", "electrical voltage at 100 %", 1.656, "V")
            .published(v_el)
            .right(voltage.electrical)
            .note(format!("fixes the current at {CURRENT} A")),
        Row::new("P07", "§3.2.1", "mechanical voltage at 100 %", 8.132, "V")
            .published(v_mec)
            .right(V_TOTAL - v_el - v_mag),
        Row::new("P07-total", "§3.2.1", "voltage at 100 %", V_TOTAL, "V")
            .published(v_el + v_mag + v_mec)
            .right(voltage.total),
        Row::new("P08", "§3.2.1", "magnetic voltage at 100 %", V_MAGNETIC, "V").published(v_mag).right(0.0).but(
            Inconsistent,
            format!(
                "requires a charge of {q:.3} C, {:.2} s of the current instead of 900 s; in steady state L dI/dt is 0, as is the published power",
                q / CURRENT
            ),
        ),
        Row::new("P09", "§3.1", "power at 100 %", P_TOTAL, "W")
            .published(V_TOTAL * CURRENT)
            .right(power.total)
            .but(
                Inconsistent,
                format!("{:.2} % above V I of the published voltage and current", 100.0 * (P_TOTAL / power.total - 1.0)),
            ),
        Row::new("P10", "§3.1", "thermal power at 100 %", 0.2981, "W")
            .published(super::published::power(&p)[0])
            .right(power.electrical),
        Row::new("P10-magnetic", "§3.1", "magnetic power at 100 %", 0.0, "W")
            .published(super::published::power(&p)[1])
            .right(power.magnetic),
        Row::new("P11", "§3.1", "mechanical power at 100 %", P_MECHANICAL, "W")
            .published(v_mec * CURRENT)
            .right(power.mechanical)
            .but(Inconsistent, "error 0.2 %; without a load this is friction heat, not output power"),
        Row::new("P12", "§3.1", "work in 900 s at 100 %", "1582.7 kW", "J")
            .published(P_TOTAL * DURATION)
            .right(work.total)
            .measured(WORK_TOTAL)
            .but(
                UnitError,
                format!(
                    "the unit is J; {:.2} % below the published power times 900 s, which is consistent with a warming winding{simulated}",
                    100.0 * (1.0 - WORK_TOTAL / (P_TOTAL * DURATION))
                ),
            ),
        Row::new("P13", "§3.1", "thermal work", "267.79 W", "J").published(w_el).right(work.electrical).measured(WORK_THERMAL).but(
            UnitError,
            format!("the unit is J; over 900 s the mean power is {} W", significant(WORK_THERMAL / DURATION)),
        ),
        Row::new("P13-magnetic", "§3.1", "magnetic work", "29.2 µW", "J")
            .published(w_mag)
            .right(work.magnetic)
            .measured(29.2e-6)
            .but(UnitError, "the unit is J: L I²/2"),
        Row::new("P13-mechanical", "§3.1", "mechanical work", "1,315 kW", "J")
            .published(P_MECHANICAL * DURATION)
            .right(work.mechanical)
            .measured(1315.0)
            .but(UnitError, format!("the unit is J, with a comma as thousands separator; over 900 s the mean power is {} W", significant(1315.0 / DURATION))),
        Row::new("P14", "eq. (14)", "state function of the voltage", "V = αTR₀I + LI²/2q + T_mθ/q", "").but(
            PhysicsError,
            "units are correct, but q and θ are path-dependent: equal to Kirchhoff's law only for constant current and speed from t = 0",
        ),
        Row::new("P15", "eq. (15)", "mechanical term of the power", "T_m θ", "")
            .but(UnitError, "the unit is J instead of W; the power is T_m ω"),
        Row::new("P16", "eq. (16)", "work", "W = αTR₀Iq + LI²/2 + T_mθ", "")
            .but(HoldsWithNote, "for constant current and temperature only"),
    ]
}

fn derivatives() -> Vec<Row> {
    let p = Point { v: V_TOTAL, i: CURRENT, t: T_ROOM, torque: TORQUE, theta: 1.0, q: implied_charge() };
    let warmer = Point { t: T_ROOM + 1.0, ..p };
    vec![
        Row::new("P17", "eq. (21)", "voltage per kelvin", "αR₀T ΔT", "V/K")
            .published(voltage_change(&p, &warmer))
            .right(right_voltage_change(&p, &warmer))
            .but(
                UnitError,
                format!(
                    "unit Ohm.K instead of V: I is missing, a factor of {:.0}",
                    voltage_change(&p, &warmer) / right_voltage_change(&p, &warmer)
                ),
            ),
        Row::new("P18", "eq. (22)", "current per volt", "q/(IL + αR₀T)", "A/V")
            .published(current_per_volt(&p))
            .right(right_current_per_volt(&p))
            .but(
                UnitError,
                format!(
                    "q is missing before αR₀T in all three terms: a factor of {:.2}",
                    current_per_volt(&p) / right_current_per_volt(&p)
                ),
            ),
        Row::new("P19", "eq. (23)", "temperature per volt", "1/(αR₀J_a)", "K/V")
            .published(temperature_per_volt(&p))
            .right(1.0 / right_voltage_change(&p, &warmer))
            .note("J_a is I_a; the temperature before the logarithm is taken as constant"),
        Row::new("P20", "eq. (24)", "torque per volt", "q/θ", "N.m/V")
            .published(torque_per_volt(&p))
            .right(p.q / p.theta)
            .note("per radian turned; J_a is I_a"),
        Row::new("P21", "§3.2", "name of the relations", "Maxwell's equations", "").but(
            Garbled,
            "cyclic relation of partial derivatives; q and θ are taken as constant although V and I determine them",
        ),
        Row::new("P22", "figs. 6-7", "error of the model", "0.2 %", "%").but(
            NotAValidation,
            "the torque was not measured but computed from the same identity, so the agreement is trivial",
        ),
    ]
}

fn machine(voltage: &Parts, power: &Parts) -> Vec<Row> {
    let speed = power.mechanical / TORQUE;
    let rpm = 30.0 / std::f64::consts::PI;
    let (stall, catalogue_rpm, idle) = CATALOGUE;
    let terminal = SUPPLY / stall;
    let k = (SUPPLY - idle * terminal) * rpm / catalogue_rpm;
    vec![
        Row::new("P23", "§3.2.4", "slope of torque over duty", "1.04 µN m/%", "rpm")
            .published(speed * rpm * 1e3)
            .right(speed * rpm)
            .but(
                UnitError,
                "mN.m at the output shaft; with µN.m the power of the mechanical term requires the as-published speed",
            ),
        Row::new("P24", "catalogue", "torque constant at the output shaft", "not published", "V.s/rad")
            .published(voltage.mechanical / speed)
            .right(k)
            .but(
                Inconsistent,
                format!(
                    "the catalogue's constant gives {:.0} rpm at {} V instead of {:.0}",
                    (voltage.total - CURRENT * terminal) / k * rpm,
                    significant(voltage.total),
                    speed * rpm
                ),
            ),
        Row::new("P25", "§2.5", "armature resistance", R_A, "Ohm").right(terminal).measured(R_A).but(
            Inconsistent,
            format!(
                "12 V divided by the catalogue's stall current; 9.20 ohm gives {:.1} A: an AC measurement, brush resistance or another motor",
                SUPPLY / R_A
            ),
        ),
        Row::new("P29", "§2.5", "supply", SUPPLY, "V").right(SUPPLY - voltage.total).but(
            HoldsWithNote,
            "corrected: voltage drop between supply and terminals, typical of a bridge with bipolar transistors",
        ),
        Row::new("P32", "conclusions", "efficiency", "operates efficiently", "")
            .right(0.0)
            .but(PhysicsError, "the shaft had no load: the efficiency is 0"),
        Row::new("P33", "§2.3", "temperature coefficient", ALPHA, "1/K").published(ALPHA).right(ALPHA_20),
        Row::new("P34", "§2.5", "encoder counts per turn of the output", "131:1, 64 CPR", "").right(131.25 * 64.0),
        Row::new("P35", "§3.2.4", "r² of the torque", 0.9579, "").but(
            Garbled,
            "r² of the current is 0.9991 although T = K I; the paragraph on torque discusses the current",
        ),
    ]
}

fn over_duty(t: &Temperatures, runs: Option<&[Run]>, compared: &[Compared]) -> Vec<Row> {
    let by = |quantity: &str| basis(compared, quantity);
    let line = |f: &dyn Fn(&Run) -> f64| {
        crate::numeric::Line::through(&runs?.iter().map(|r| (r.duty_percent, f(r))).collect::<Vec<_>>())
    };
    let (voltage, current) = (line(&|r| r.voltage.total), line(&|r| r.current_A));
    let power: Vec<(f64, f64)> = DUTIES.iter().copied().zip(t.power_W.iter().copied()).collect();
    let straight = crate::numeric::Line::through(&power).map_or(f64::NAN, |l| l.r2);
    let worst = t.residuals_K.iter().map(|r| r.abs()).fold(0.0, f64::max);
    let end = T_ROOM + t.adiabatic_rise_K;
    let simulated = |k: usize| t.simulated_degC.as_ref().and_then(|all| all.get(k).copied());
    vec![
        Row::new("P26", "§3.2.1", "slope of voltage over duty", 1e3 * V_SLOPE, "mV/%")
            .published(10.0 * V_TOTAL)
            .right(voltage.map(|l| 1e3 * l.slope))
            .by(by("slope of voltage over duty"))
            .but(
                HoldsWithNote,
                "recomputed: line through the origin; the published slope implies an intercept, as continuous conduction with a voltage drop does",
            ),
        Row::new("P26-r2", "§3.2.1", "r² of voltage over duty", V_R2, "").right(voltage.map(|l| l.r2)).by(by("r² of voltage over duty")),
        Row::new("P27", "§3.2.2", "slope of current over duty", 1e3 * I_SLOPE, "mA/%")
            .right(current.map(|l| 1e3 * l.slope))
            .by(by("slope of current over duty"))
            .but(HoldsWithNote, "dry and viscous friction; below the resolution of the Hall sensor, 35 to 50 mA"),
        Row::new("P27-r2", "§3.2.2", "r² of current over duty", I_R2, "").right(current.map(|l| l.r2)).by(by("r² of current over duty")),
        Row::new("P28", "§3.1", "r² of a straight line of power over duty", "first-order", "")
            .right(straight)
            .but(Inconsistent, "voltage and current are both linear in the duty, so their product is quadratic"),
        Row::new("P30-low", "§3.2.3", "winding at 20 and 40 %", PLATEAUS.0, "degC").right(simulated(1)).by(by("winding temperature at 40 %")).measured(PLATEAUS.0).but(
            Inconsistent,
            format!("their heating power differs by a factor of two; the best line over power has an error of up to {worst:.1} K; corrected: simulated at 40 %"),
        ),
        Row::new("P30-high", "§3.2.3", "winding at 60, 80 and 100 %", PLATEAUS.1, "degC")
            .right(simulated(4))
            .by(by("winding temperature at 100 %"))
            .measured(PLATEAUS.1)
            .but(Inconsistent, "as above; corrected: simulated at 100 % from the ambient temperature"),
        Row::new("P31", "§2.5", "end of a run in a box", "adiabatic", "degC").published(end).right(simulated(4)).by(by("winding temperature at 100 %")).but(
            Inconsistent,
            format!("without heat loss a capacity of {BOX_CAPACITY} J/K reaches this value and no steady state; a plateau requires a conductance of 0.1 to 0.2 W/K"),
        ),
        Row::new("P36", "fig. 10", "groups of duty", "low < 40, high > 60", "")
            .but(Garbled, "the groups are 20, 40 and 60, 80, 100"),
    ]
}
