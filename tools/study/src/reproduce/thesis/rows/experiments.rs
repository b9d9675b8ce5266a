//! Chapters 2 to 4, 5.3 and 6: the motor, its tests and their discussion.

use crate::reproduce::thesis::CaseResult;
use crate::reproduce::thesis::measured::*;
use crate::reproduce::thesis::projection::*;
use crate::reproduce::{Basis, Row, Rows, significant};

/// Fall of the housing's resistance to ambient between two cases, percent.
fn fall(from: f64, to: f64) -> f64 {
    100.0 * (1.0 - to / from)
}

/// Chapters 2 and 3, and the abstract.
pub fn bare(rows: &mut Rows) {
    let bare = &CASES[0];
    let fan = &CASES[1];
    let hot = resistance(bare.t_w, specimen_resistance(), T_25);
    let cold = T_25;
    let right_torque = torque_at_true_10_w(bare);
    rows.of("T02").published(r_ha(fan.t_w, T_AMBIENT, POWER)).measured(fan.r_ha);
    rows.of("T03").published(fall(bare.r_ha, fan.r_ha));
    rows.of("T04")
        .published(torque_at_5_a(bare.t_w) / bare.mass)
        .right(torque_at_5_a(fan.t_w) / fan.mass)
        .fill([format!(
            "{:+.1}",
            100.0 * (torque_at_5_a(fan.t_w) / fan.mass / (torque_at_5_a(bare.t_w) / bare.mass) - 1.0)
        )]);
    rows.of("T05").right(sheet_no_load_loss());
    rows.of("T06").published(resistance(bare.t_w, R_DATASHEET, T_REF)).right(hot);
    rows.of("T08").published(K_T * 3.68).right(K_T * 3.63);
    rows.of("T09")
        .published(torque_at_10_w(T_REF, R_DATASHEET))
        .right(torque_at_10_w(T_REF, resistance(T_REF, specimen_resistance(), T_25)));
    rows.of("T10").published(CURRENT * 2.0);
    rows.of("T11").published(CURRENT * 2.5).fill([significant(r_ha(
        bare.t_w,
        T_AMBIENT_BARE,
        CURRENT * 2.5,
    ))]);
    rows.of("T12").published(torque_at_10_w(cold, R_DATASHEET));
    rows.of("T13")
        .published(torque_at_10_w(423.15, R_DATASHEET))
        .right(torque_at_10_w(T_W_MAX, R_DATASHEET))
        .fill([significant(torque_at_10_w(473.15, R_DATASHEET))]);
    rows.of("T14").published(winding_temperature(bare.resistance, R_DATASHEET, T_REF));
    rows.of("T15").published(r_ha(bare.t_w, T_AMBIENT_BARE, POWER)).measured(bare.r_ha);
    rows.of("T16").published(100.0 * (1.0 - (-1.0f64).exp()));
    rows.of("T16-rest").published(100.0 * (-1.0f64).exp());
    rows.of("T17").published(1180.0 / 60.0);
    rows.of("T18")
        .right(100.0 * (1.0 - (-1180.0 / time_constant(bare.r_ha)).exp()))
        .fill([format!("{:.0}", time_constant(bare.r_ha))]);
    rows.of("T19")
        .printed(bare.t_w)
        .published(winding_temperature(bare.resistance, R_DATASHEET, T_REF))
        .right(winding_temperature(bare.resistance, specimen_resistance(), T_25))
        .measured(bare.t_w)
        .fill([format!("{hot:.4}")]);
    rows.of("T20").printed(R_DATASHEET).right(specimen_resistance());
    rows.of("T21")
        .printed(bare.torque)
        .published(torque_at_10_w(bare.t_w, R_DATASHEET))
        .right(right_torque)
        .fill([significant(torque_at_5_a(bare.t_w))]);
    rows.of("T22").printed(bare.density).published(bare.torque / bare.mass);
    rows.of("T23")
        .printed(bare.r_ha)
        .published(r_ha(bare.t_w, 296.0, POWER))
        .fill([format!("{:.2}", bare.implied_ambient())]);
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
pub fn tables(rows: &mut Rows, cases: &[CaseResult]) {
    let mut columns = Rows::read(include_str!("columns.toml"));
    for (case, found) in CASES.iter().zip(cases).skip(1) {
        let by_fan = case.r_star().is_none();
        let published = if by_fan { torque_at_10_w(case.t_w, R_DATASHEET) } else { torque_at_5_a(case.t_w) };
        let id = case.name.replace("fan", "T24").replace("annulus", "T25");
        let mut row = |column: &str, what: &str| {
            let column = columns.of(column).clone();
            let (id, quantity) = (format!("{id}-{what}"), format!("{}, {}", column.quantity, case.name));
            Row { id, quantity, location: case.location.to_owned(), ..column }
        };
        let [torque, density] = if by_fan { ["fan-torque", "fan-density"] } else { ["torque", "density"] };
        rows.add(row("T", "T"))
            .printed(case.t_w)
            .published(winding_temperature(case.resistance, specimen_resistance(), T_25))
            .right(found.T_w_model_K)
            .by(Basis::Fitted)
            .predictions(Some(found.T_w_untuned_K), found.T_w_leave_one_out_K)
            .measured(case.t_w);
        rows.add(row(torque, "torque"))
            .printed(case.torque)
            .published(published)
            .right(torque_at_5_a(case.t_w));
        rows.add(row(density, "density"))
            .printed(case.density)
            .published(published / case.mass)
            .right(torque_at_5_a(case.t_w) / case.mass);
        rows.add(row("R", "R"))
            .printed(case.r_ha)
            .published(r_ha(case.t_w, T_AMBIENT, POWER))
            .right(found.R_ha_model)
            .by(Basis::Fitted)
            .predictions(
                Some(found.r_ha(found.T_w_untuned_K)),
                found.T_w_leave_one_out_K.map(|t_w| found.r_ha(t_w)),
            )
            .measured(case.r_ha);
        rows.add(row("ambient", "ambient")).printed(T_AMBIENT).published(case.implied_ambient());
    }
}

/// Statements of chapter 6 and of the order of the tables.
pub fn discussion(rows: &mut Rows) {
    let (bare, fan, wide) = (&CASES[0], &CASES[1], &CASES[4]);
    let density = |case: &Case| torque_at_5_a(case.t_w) / case.mass;
    let at_limit = |case: &Case| torque_at_limit(case.r_ha);
    rows.of("T26").published(100.0 * (density(wide) / density(fan) - 1.0));
    rows.of("T44").published(bare.t_w - fan.t_w);
    rows.of("T45").published(bare.implied_ambient()).right(fan.implied_ambient());
    rows.of("T46").published(current_at_limit(R_HA_DATASHEET, R_DATASHEET, T_25)).right(current_at_limit(
        bare.r_ha,
        R_DATASHEET,
        T_25,
    ));
    rows.of("T47").published(torque_at_5_a(T_REF));
    rows.of("T48").right(T_W_MAX);
    rows.of("T49").published(bare.r_ha - R_HA_DATASHEET);
    rows.of("T50-bare").right(at_limit(bare));
    rows.of("T50-fan")
        .right(at_limit(fan))
        .fill([format!("{:+.0}", 100.0 * (at_limit(fan) / at_limit(bare) - 1.0))]);
    rows.of("T50-annulus")
        .right(at_limit(wide))
        .fill([format!("{:+.0}", 100.0 * (at_limit(wide) / at_limit(bare) - 1.0))]);
    rows.of("T51").right(30.0 / 31.0);
    rows.of("T54").published(WIDE);
    rows.of("T54-narrow").published(NARROW);
}
