//! Chapters 2 to 4, 5.3 and 6: the motor, its tests and their discussion.

use crate::reproduce::Verdict::*;
use crate::reproduce::thesis::CaseResult;
use crate::reproduce::thesis::measured::*;
use crate::reproduce::thesis::projection::*;
use crate::reproduce::{Basis, Row, significant};

/// Audit numbers of the columns of tables 1 to 3: winding temperature, torque, density, R_ha, ambient.
const COLUMNS: [(&str, [&str; 5]); 7] = [
    ("fan-5mm", ["T24-5mm-T", "T24-5mm-torque", "T24-5mm-density", "T24-5mm-R", "T24-5mm-ambient"]),
    ("fan-15mm", ["T24-15mm-T", "T24-15mm-torque", "T24-15mm-density", "T24-15mm-R", "T24-15mm-ambient"]),
    ("fan-30mm", ["T24-30mm-T", "T24-30mm-torque", "T24-30mm-density", "T24-30mm-R", "T24-30mm-ambient"]),
    (
        "annulus-40-push",
        [
            "T25-40-push-T",
            "T25-40-push-torque",
            "T25-40-push-density",
            "T25-40-push-R",
            "T25-40-push-ambient",
        ],
    ),
    (
        "annulus-35-push",
        [
            "T25-35-push-T",
            "T25-35-push-torque",
            "T25-35-push-density",
            "T25-35-push-R",
            "T25-35-push-ambient",
        ],
    ),
    (
        "annulus-40-pull",
        [
            "T25-40-pull-T",
            "T25-40-pull-torque",
            "T25-40-pull-density",
            "T25-40-pull-R",
            "T25-40-pull-ambient",
        ],
    ),
    (
        "annulus-35-pull",
        [
            "T25-35-pull-T",
            "T25-35-pull-torque",
            "T25-35-pull-density",
            "T25-35-pull-R",
            "T25-35-pull-ambient",
        ],
    ),
];

/// Fall of the housing's resistance to ambient between two cases, percent.
fn fall(from: f64, to: f64) -> f64 {
    100.0 * (1.0 - to / from)
}

/// Chapters 2 and 3, and the abstract.
pub fn bare() -> Vec<Row> {
    let bare = &CASES[0];
    let fan = &CASES[1];
    let hot = resistance(bare.t_w, specimen_resistance(), T_25);
    let cold = T_25;
    let right_torque = torque_at_true_10_w(bare);
    vec![
        Row::new("T02", "abstract", "R_ha, lowest", "4.03 K W⁻³", "K/W")
            .published(r_ha(fan.t_w, T_AMBIENT, POWER))
            .measured(fan.r_ha)
            .but(Garbled, "the unit is K/W; the value is that of the fan alone at 5 mm, not of an annulus"),
        Row::new("T03", "abstract, ch. 6", "fall of R_ha", 68.0, "%").published(fall(bare.r_ha, fan.r_ha)).but(
            Inconsistent,
            "no pair of published resistances gives 68 %; chapter 6 attributes it to r* = 0.63, for which chapter 7 gives 89 %",
        ),
        Row::new("T04", "abstract", "best torque density", 0.393, "N.m/kg")
            .published(torque_at_5_a(bare.t_w) / bare.mass)
            .right(torque_at_5_a(fan.t_w) / fan.mass)
            .but(
                Inconsistent,
                format!(
                    "0.393 is the value of the unmodified motor and 0.382 that of the fan at 30 mm at another current; at 5 A the fan at 5 mm has the highest density, {:+.1} %",
                    100.0 * (torque_at_5_a(fan.t_w) / fan.mass / (torque_at_5_a(bare.t_w) / bare.mass) - 1.0)
                ),
            ),
        Row::new("T05", "§2.1", "losses without copper at no load", "negligible", "W")
            .right(sheet_no_load_loss())
            .but(PhysicsError, "valid at standstill only: by the datasheet the no-load loss exceeds the applied 10 W"),
        Row::new("T06", "eqs. (1)-(2)", "resistance at the bare test's temperature", "R_ref [1 + α(T − T_ref)]", "Ohm")
            .published(resistance(bare.t_w, R_DATASHEET, T_REF))
            .right(hot)
            .note("standard; maxon quotes R at 25 degC, the thesis takes 20 degC: 2 % in R"),
        Row::new("T07", "§2.1", "eq. (3)", "missing", "").but(Garbled, "referred to but missing; 'equation (3) becomes' in chapter 3 refers to (4)"),
        Row::new("T08", "§3.1", "torque at the continuous current", 0.1, "N.m")
            .published(K_T * 3.68)
            .right(K_T * 3.63)
            .but(Inconsistent, "the data sheet's nominal current is 3.63 A and its nominal torque 92.9 mN.m after subtraction of friction"),
        Row::new("T09", "eqs. (5)-(6)", "torque at 10 W and 293.15 K", "eq. (6)", "N.m")
            .published(torque_at_10_w(T_REF, R_DATASHEET))
            .right(torque_at_10_w(T_REF, resistance(T_REF, specimen_resistance(), T_25)))
            .but(HoldsWithNote, "the magnet is on the rotor and colder than the winding; the specimen has a lower resistance"),
        Row::new("T10", "§3.2", "power of 5 A and 2 V", 10.0, "W").published(CURRENT * 2.0),
        Row::new("T11", "§3.2.5", "power of 5 A and 2.5 V", 10.0, "W").published(CURRENT * 2.5).but(
            Inconsistent,
            format!(
                "2.5 V at 5 A is 0.5 ohm, the resistance of the hot bare motor; at 12.5 W R_ha is {}",
                significant(r_ha(bare.t_w, T_AMBIENT_BARE, CURRENT * 2.5))
            ),
        ),
        Row::new("T12", "§3.2.1", "upper torque, 298.15 K", 0.1383, "N.m").published(torque_at_10_w(cold, R_DATASHEET)),
        Row::new("T13", "§3.2.1", "lower torque, 423.15 K", 0.0844, "N.m")
            .published(torque_at_10_w(423.15, R_DATASHEET))
            .right(torque_at_10_w(T_W_MAX, R_DATASHEET))
            .but(
                Inconsistent,
                format!(
                    "evaluated at 473.15 K, which gives {}; the data sheet's limit is 155 degC",
                    significant(torque_at_10_w(473.15, R_DATASHEET))
                ),
            ),
        Row::new("T14", "eq. (7)", "winding temperature of the bare test's 0.5 ohm", "eq. (7)", "K")
            .published(winding_temperature(bare.resistance, R_DATASHEET, T_REF))
            .note("correct; the equation number is used again in chapter 5"),
        Row::new("T15", "eqs. (8), (11)", "R_ha of the bare test", "eq. (11)", "K/W")
            .published(r_ha(bare.t_w, T_AMBIENT_BARE, POWER))
            .measured(bare.r_ha)
            .note("this definition includes the contact between stator and housing, leads and mount"),
        Row::new("T16", "§3.2.4.2", "rise after one time constant", 63.2, "%").published(100.0 * (1.0 - (-1.0f64).exp())),
        Row::new("T16-rest", "§3.2.4.2", "rest after one time constant", 36.8, "%").published(100.0 * (-1.0f64).exp()),
        Row::new("T17", "§3.2.4.2", "motor time constant", 19.0, "min")
            .published(1180.0 / 60.0)
            .but(HoldsWithNote, "19.7 min, truncated; 1180 s applies to 7.4 K/W"),
        Row::new("T18", "§3.2.4.2", "rise seen after one time constant", "63.2 %", "%")
            .right(100.0 * (1.0 - (-1180.0 / time_constant(bare.r_ha)).exp()))
            .but(
                HoldsWithNote,
                format!(
                    "with the measured R_ha the bare motor's time constant is {:.0} s: the steady value is extrapolated",
                    time_constant(bare.r_ha)
                ),
            ),
        Row::new("T19", "§3.3", "steady winding temperature, bare", bare.t_w, "K")
            .published(winding_temperature(bare.resistance, R_DATASHEET, T_REF))
            .right(winding_temperature(bare.resistance, specimen_resistance(), T_25))
            .measured(bare.t_w)
            .but(
                Inconsistent,
                format!("0.5 ohm is rounded: with the cold resistance of the other tests it is {hot:.4} ohm"),
            ),
        Row::new("T20", "tables 1-3", "cold resistance at 25 degC", R_DATASHEET, "Ohm").right(specimen_resistance()).but(
            Inconsistent,
            "all pairs of R and T_w except that of the bare motor imply the same cold resistance, 10 % below the datasheet value",
        ),
        Row::new("T21", "§3.3", "torque, bare", bare.torque, "N.m")
            .published(torque_at_10_w(bare.t_w, R_DATASHEET))
            .right(right_torque)
            .but(
                Inconsistent,
                format!("computed with 5 A ({}) and not with eq. (6) as stated; 5 A through 0.5 ohm is 12.5 W", significant(torque_at_5_a(bare.t_w))),
            ),
        Row::new("T22", "§3.3", "torque density, bare", bare.density, "N.m/kg").published(bare.torque / bare.mass),
        Row::new("T23", "§3.3", "R_ha, bare", bare.r_ha, "K/W").published(r_ha(bare.t_w, 296.0, POWER)).but(
            HoldsWithNote,
            format!("implies an ambient of {:.2} K, the other seven tests 297.8 to 297.9 K", bare.implied_ambient()),
        ),
    ]
}

/// Time constant of the motor with another resistance to ambient, s: the data sheet's 1180 s at 7.4 K/W.
fn time_constant(r_ha: f64) -> f64 {
    1180.0 * (r_ha + R_WH) / (R_HA_DATASHEET + R_WH)
}

/// V I of the data sheet at no load less the copper loss, W.
fn sheet_no_load_loss() -> f64 {
    let (voltage, current) = (48.0, 0.356);
    voltage * current - current * current * R_DATASHEET
}

/// Tables 1 to 3, column by column.
pub fn tables(cases: &[CaseResult]) -> Vec<Row> {
    let mut rows = Vec::new();
    for (name, [t, torque, density, r, ambient]) in COLUMNS {
        let Some(case) = Case::named(name) else { continue };
        let Some(found) = cases.iter().find(|c| c.name == name) else { continue };
        let by_fan = case.r_star.is_none();
        let published = if by_fan { torque_at_10_w(case.t_w, R_DATASHEET) } else { torque_at_5_a(case.t_w) };
        let row = |id, what: &str, printed, unit| {
            Row::new(id, case.location, format!("{what}, {name}"), printed, unit)
        };
        rows.push(
            row(t, "winding temperature", case.t_w, "K")
                .published(winding_temperature(case.resistance, specimen_resistance(), T_25))
                .right(found.T_w_model_K)
                .by(Basis::Fitted)
                .predictions(found.T_w_untuned_K, found.T_w_leave_one_out_K)
                .measured(case.t_w)
                .note("as published: from the published resistance and the specimen's cold resistance; corrected: preset thesis-rig, which is fitted to this temperature"),
        );
        let mut projected =
            row(torque, "torque", case.torque, "N.m").published(published).right(torque_at_5_a(case.t_w));
        let mut dense = row(density, "torque density", case.density, "N.m/kg")
            .published(published / case.mass)
            .right(torque_at_5_a(case.t_w) / case.mass);
        if by_fan {
            let why = "eq. (6) with 0.386 ohm; not comparable with tables 2 and 3 and the bare motor, which are at 5 A";
            projected = projected.but(Inconsistent, why);
            dense = dense.but(Inconsistent, format!("{why}; 'added mass' is the total"));
        }
        rows.push(projected);
        rows.push(dense);
        rows.push(
            row(r, "R_ha", case.r_ha, "K/W")
                .published(r_ha(case.t_w, T_AMBIENT, POWER))
                .right(found.R_ha_model)
                .by(Basis::Fitted)
                .predictions(found.r_ha_untuned(), found.r_ha_leave_one_out())
                .measured(case.r_ha)
                .note("corrected: thesis-rig, which is fitted to this test's temperature"),
        );
        rows.push(
            row(ambient, "implied ambient", T_AMBIENT, "K")
                .published(case.implied_ambient())
                .note("not published: T_w - 10 W (R_ha + R_wh)"),
        );
    }
    rows
}

/// Statements of chapter 6 and of the order of the tables.
pub fn discussion() -> Vec<Row> {
    let (bare, fan, wide) = (&CASES[0], &CASES[1], &CASES[4]);
    let density = |case: &Case| torque_at_5_a(case.t_w) / case.mass;
    let at_limit = |case: &Case| torque_at_limit(case.r_ha);
    vec![
        Row::new("T26", "tables 1-3", "best annulus over best fan, density at 5 A", "annulus better", "%")
            .published(100.0 * (density(wide) / density(fan) - 1.0))
            .but(
                Inconsistent,
                "the fan alone has the lower resistance and, at equal current, the higher density; the data contradict the hypothesis, which error T24 conceals",
            ),
        Row::new("T44", "ch. 6", "fall of the winding temperature by the fan", 73.0, "K").published(bare.t_w - fan.t_w),
        Row::new("T45", "ch. 6", "ambient", 296.0, "K")
            .published(bare.implied_ambient())
            .right(fan.implied_ambient())
            .but(Inconsistent, "value of the bare test; the other tests imply the corrected value"),
        Row::new("T46", "ch. 6", "5 A over the continuous current", "exceeds", "A")
            .published(current_at_limit(R_HA_DATASHEET, R_DATASHEET, T_25))
            .right(current_at_limit(bare.r_ha, R_DATASHEET, T_25))
            .but(
                Inconsistent,
                "3.63 A is the limit at 16 000 rpm with speed-dependent losses; at standstill 7.4 K/W gives the as-published value, 11.5 K/W the corrected one",
            ),
        Row::new("T47", "ch. 6", "torque at 5 A, cold", 0.138, "N.m").published(torque_at_5_a(T_REF)),
        Row::new("T48", "ch. 6", "winding limit", 423.15, "K").right(T_W_MAX).but(Inconsistent, "155 degC by the data sheet"),
        Row::new("T49", "ch. 6", "R_ha above the data sheet's", 4.0, "K/W")
            .published(bare.r_ha - R_HA_DATASHEET)
            .but(HoldsWithNote, "4.1; both are plausible: the value depends on emissivity, leads and mount"),
        Row::new("T50-bare", "ch. 6-7", "continuous stall torque, bare", "not considered", "N.m").right(at_limit(bare)).but(
            PhysicsError,
            "at constant current the torque hardly depends on cooling; this is the torque at the limit of 155 degC",
        ),
        Row::new("T50-fan", "ch. 6-7", "continuous stall torque, fan at 5 mm", "no appreciable improvement", "N.m")
            .right(at_limit(fan))
            .but(PhysicsError, format!("{:+.0} % of the bare motor's", 100.0 * (at_limit(fan) / at_limit(bare) - 1.0))),
        Row::new("T50-annulus", "ch. 6-7", "continuous stall torque, 40 mm push", "no appreciable improvement", "N.m")
            .right(at_limit(wide))
            .but(PhysicsError, format!("{:+.0} % of the bare motor's", 100.0 * (at_limit(wide) / at_limit(bare) - 1.0))),
        Row::new("T51", "§5.2.2", "annuli", "40, 35, 31 mm", "")
            .right(30.0 / 31.0)
            .but(Inconsistent, "31 mm (corrected r*, gap 0.5 mm) is not reported"),
        Row::new("T52", "§5.2.3", "fan with annulus", "in cross flow, 5 mm away", "")
            .but(Garbled, "copied from chapter 4; taken literally, a large bypass"),
        Row::new("T53", "§4.3, app. 3", "supply of the fan", "6282A / 6286A", "")
            .but(Inconsistent, "the 6282A is a 10 V supply, so a 12 V fan runs at 83 % of its rated speed at most"),
        Row::new("T54", "tables 2-3", "r* of 40 mm", 0.75, "").published(WIDE),
        Row::new("T54-narrow", "tables 2-3", "r* of 35 mm", 0.86, "").published(NARROW),
    ]
}
