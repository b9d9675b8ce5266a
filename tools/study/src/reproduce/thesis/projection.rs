//! Quantities computed from a winding temperature: resistance, torque, thermal resistance, continuous torque.
//!
//! R = R_ref [1 + alpha (T_w - T_ref)]                                                      eqs. (2), (7)
//! tau = k_t [1 + alpha_mag (T - T_ref)] I                                                  eqs. (4), (5)
//! I = sqrt(P/R)                                                                            eq. (6)
//! R_ha = (T_w - T_a)/P - R_wh                                                              eq. (11)

use super::measured::{
    ALPHA, ALPHA_MAG, CASES, CURRENT, Case, K_T, POWER, R_WH, T_25, T_AMBIENT, T_REF, T_W_MAX,
};

/// Resistance, ohm, at `t_w`, of a winding with `r_ref` at `t_ref`, eq. (2).
pub fn resistance(t_w: f64, r_ref: f64, t_ref: f64) -> f64 {
    r_ref * (1.0 + ALPHA * (t_w - t_ref))
}

/// Winding temperature, K, of a resistance, eq. (7).
pub fn winding_temperature(r: f64, r_ref: f64, t_ref: f64) -> f64 {
    (r / r_ref - 1.0) / ALPHA + t_ref
}

/// Resistance, ohm, that the winding had at `t_ref` if it had `r` at `t_w`: eq. (2) solved for R_ref.
pub fn cold_resistance(r: f64, t_w: f64, t_ref: f64) -> f64 {
    r / (1.0 + ALPHA * (t_w - t_ref))
}

/// Resistance of the specimen at 25 degC, ohm: mean of what the tables' pairs of R and T_w imply. The bare
/// test is left out; its R is rounded.
pub fn specimen_resistance() -> f64 {
    let cold: Vec<f64> = CASES[1..].iter().map(|c| cold_resistance(c.resistance, c.t_w, T_25)).collect();
    cold.iter().sum::<f64>() / cold.len() as f64
}

/// Torque constant, N.m/A, with the magnet at `t`, eq. (5) with the thesis's reference of 293.15 K.
pub fn torque_constant(t: f64) -> f64 {
    K_T * (1.0 + ALPHA_MAG * (t - T_REF))
}

/// Torque, N.m, at 5 A with the magnet at the winding's temperature: method of tables 2 and 3.
pub fn torque_at_5_a(t_w: f64) -> f64 {
    CURRENT * torque_constant(t_w)
}

/// Torque, N.m, at 10 W, eq. (6), with `r_ref` at the thesis's reference: method of table 1.
pub fn torque_at_10_w(t_w: f64, r_ref: f64) -> f64 {
    torque_constant(t_w) * (POWER / resistance(t_w, r_ref, T_REF)).sqrt()
}

/// Torque, N.m, at 10 W through the resistance that was measured.
pub fn torque_at_true_10_w(case: &Case) -> f64 {
    torque_constant(case.t_w) * (POWER / case.resistance).sqrt()
}

/// Housing to ambient, K/W, eq. (11), at a heat flow of `power` W.
pub fn r_ha(t_w: f64, t_a: f64, power: f64) -> f64 {
    (t_w - t_a) / power - R_WH
}

/// Continuous current at stall, A, with the winding at its limit: T_w - T_a = I^2 R(T_w) (R_ha + R_wh).
pub fn current_at_limit(r_ha: f64, r_25: f64, t_a: f64) -> f64 {
    let heat = (T_W_MAX - t_a) / (r_ha + R_WH);
    (heat / resistance(T_W_MAX, r_25, T_25)).sqrt()
}

/// Continuous torque at stall, N.m, with the winding at 155 degC and the magnet as warm as the housing; k_t
/// is the data sheet's at 25 degC, R_ha is held at the measured value.
pub fn torque_at_limit(r_ha: f64) -> f64 {
    let current = current_at_limit(r_ha, specimen_resistance(), T_AMBIENT);
    let heat = (T_W_MAX - T_AMBIENT) / (r_ha + R_WH);
    let housing = T_W_MAX - heat * R_WH;
    K_T * (1.0 + ALPHA_MAG * (housing - T_25)) * current
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::near;

    /// T20: 0.3474 ohm at 25 degC, with a spread of 0.08 milliohm over all tests but the bare one.
    #[test]
    fn all_pairs_imply_one_cold_resistance() {
        near(specimen_resistance(), 0.3474, 5e-5);
        for case in &CASES[1..] {
            near(cold_resistance(case.resistance, case.t_w, T_25), specimen_resistance(), 8e-5);
        }
    }

    /// The audit's table of like-for-like densities at 5 A and at a true 10 W.
    #[test]
    fn densities_like_for_like() {
        let at_5_a = [0.394, 0.414, 0.413, 0.412, 0.393, 0.389, 0.391, 0.386];
        let at_10_w = [0.352, 0.412, 0.410, 0.407, 0.388, 0.383, 0.385, 0.378];
        for ((case, a), w) in CASES.iter().zip(at_5_a).zip(at_10_w) {
            near(torque_at_5_a(case.t_w) / case.mass, a, 6e-4);
            near(torque_at_true_10_w(case) / case.mass, w, 6e-4);
        }
    }

    /// T50: bare 0.108, fan 0.180, annulus 40 push 0.173 N.m.
    #[test]
    fn cooling_buys_torque_at_the_limit() {
        for (name, torque) in [("bare", 0.108), ("fan-5mm", 0.180), ("annulus-40-push", 0.173)] {
            near(torque_at_limit(Case::named(name).unwrap().r_ha), torque, 5e-4);
        }
    }

    /// T13, T19, T24: 0.0844 N.m belongs to 473.15 K; 0.5 ohm to 368.9 or 410.8 K; 0.1218 N.m to eq. (6).
    #[test]
    fn published_numbers_and_their_origin() {
        near(torque_at_10_w(473.15, 0.386), 0.0844, 5e-5);
        near(torque_at_10_w(423.15, 0.386), 0.0966, 5e-5);
        near(winding_temperature(0.5, 0.386, T_REF), 368.9, 0.05);
        near(winding_temperature(0.5, specimen_resistance(), T_25), 410.8, 0.1);
        near(torque_at_10_w(340.3, 0.386), 0.1218, 5e-5);
        near(r_ha(413.17, 296.07, 10.0), 11.5, 1e-9);
    }
}
